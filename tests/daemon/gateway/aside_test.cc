// SPDX-License-Identifier: BSD-2-Clause
// Reports that a child process makes, over a real loop and real pipes.
#include "daemon/gateway/aside.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <set>
#include <utility>

#include "control/codec.hpp"
#include "control/slices.hpp"

namespace mlcca {
namespace {

using ReplyBody = Aside::Body;

constexpr uid_t kAnna = 1000;
constexpr uid_t kBert = 1001;
constexpr uid_t kCleo = 1002;
constexpr uid_t kRoot = 0;
constexpr std::uint64_t kPatience = 60'000'000;  // µs

/// So many rows of a KiB.
control::Networks rows_of_a_kibibyte(std::size_t count) {
  control::Networks rows;
  rows.networks.resize(count);
  for (auto& row : rows.networks) row.problem = std::string(1024, 'p');
  return rows;
}

/// A pipe whose reader a child waits for.
class Barrier {
 public:
  Barrier() { EXPECT_EQ(::pipe2(ends_.data(), O_CLOEXEC), 0); }
  Barrier(const Barrier&) = delete;
  Barrier(Barrier&&) = delete;
  Barrier& operator=(const Barrier&) = delete;
  Barrier& operator=(Barrier&&) = delete;
  ~Barrier() {
    ::close(ends_[0]);
    ::close(ends_[1]);
  }
  void wait() const {
    char word = 0;
    while (::read(ends_[0], &word, 1) < 0) {
    }
  }
  void open() const { EXPECT_EQ(::write(ends_[1], "x", 1), 1); }

 private:
  std::array<int, 2> ends_{-1, -1};
};

/// Forks of this process, and whether one was made while there was a child already.
struct Forks {
  int made = 0;
  int beside_another = 0;
};
Forks forks;

bool has_child() {
  siginfo_t who{};
  return ::waitid(P_ALL, 0, &who, WEXITED | WNOHANG | WNOWAIT) == 0;
}

class AsideTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const auto before = [] {
      ++forks.made;
      if (has_child()) ++forks.beside_another;
    };
    ASSERT_EQ(::pthread_atfork(before, nullptr, nullptr), 0);
  }
  void SetUp() override {
    while (::waitpid(-1, nullptr, 0) > 0) {
    }
    forks = {};
    sd_event* raw = nullptr;
    ASSERT_GE(sd_event_new(&raw), 0);
    loop_.reset(raw);
    aside_.emplace(raw);
    aside_->on_ready([this](std::uint64_t session) { ready_.insert(session); });
  }

  serve::NextSlice ask(uid_t uid, std::uint64_t session, Aside::Make make, bool member = false) {
    return aside_->ask({.pid = 1, .uid = uid, .may_change = member, .session = session},
                       std::move(make));
  }
  void turn() { ASSERT_GT(sd_event_run(loop_.get(), kPatience), 0) << "nothing happens any more"; }

  /// Everything that comes, joined, as the server takes it.
  ReplyBody whole(const serve::NextSlice& next, std::uint64_t session) {
    std::optional<control::Reply> whole;
    while (!HasFatalFailure()) {
      auto slice = next();
      if (!slice) {
        turn_until_ready(session);
        continue;
      }
      const bool more = slice->more;
      EXPECT_TRUE(control::join(whole, {0, body_of(std::move(*slice)), more}));
      if (!more) return std::move(whole->body);
    }
    return {};
  }
  /// The first slice is taken and nothing more.
  void begin_to_read(const serve::NextSlice& next, std::uint64_t session) {
    turn_until_ready(session);
    const auto slice = next();
    ASSERT_TRUE(slice);
    EXPECT_TRUE(slice->more);
  }
  void turn_until_ready(std::uint64_t session) {
    while (ready_.erase(session) == 0 && !HasFatalFailure()) turn();
  }
  void turn_until_forks(int made) {
    while (forks.made < made && !HasFatalFailure()) turn();
  }
  /// As its client reads it.
  static ReplyBody body_of(serve::Slice slice) {
    if (slice.encoded.empty()) return std::move(slice.body);
    control::Buffer wire;
    wire.append(control::with_id(1, slice.encoded));
    auto reply = control::decode_reply(wire);
    EXPECT_TRUE(reply && *reply && wire.content().empty());
    if (!reply || !*reply) return {};
    EXPECT_EQ((*reply)->more, slice.more);
    return std::move((*reply)->body);
  }
  static std::string text(const ReplyBody& body) {
    if (const auto* done = std::get_if<control::Done>(&body)) return done->message;
    if (const auto* error = std::get_if<control::Error>(&body)) return "error: " + error->message;
    return "neither";
  }

  std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop_;
  std::optional<Aside> aside_;
  std::set<std::uint64_t> ready_;
};

TEST_F(AsideTest, AnotherProcessMakesItOfWhatIsKnownWhenItBegins) {
  int known = 1;
  const auto next = ask(kAnna, 7, [&] {
    const int seen = known;
    known = 100;  // in the child
    return control::Done{std::to_string(seen)};
  });
  known = 2;
  EXPECT_EQ(text(whole(next, 7)), "2");
  EXPECT_EQ(known, 2);
}

TEST_F(AsideTest, WhoeverStartsNextFindsNoLockHeldByAReport) {
  std::array<char, 32> path{"/tmp/mlcca-aside-XXXXXX"};
  Fd lock(::mkstemp(path.data()));
  ASSERT_EQ(::flock(lock.get(), LOCK_EX | LOCK_NB), 0);
  const Barrier begun;
  const Barrier end;
  const auto next = ask(kAnna, 7, [&] {
    begun.open();
    end.wait();
    return control::Done{"late"};
  });
  turn_until_forks(1);
  begun.wait();
  lock.reset();  // as when the daemon dies
  const Fd later(::open(path.data(), O_RDWR | O_CLOEXEC));
  EXPECT_EQ(::flock(later.get(), LOCK_EX | LOCK_NB), 0);
  end.open();
  EXPECT_EQ(text(whole(next, 7)), "late");
  ::unlink(path.data());
}

TEST_F(AsideTest, ALongReportComesWholeAndInSlices) {
  control::Networks rows;
  for (std::uint64_t n = 0; n < 1000; ++n) {
    rows.networks.emplace_back();
    rows.networks.back().name = std::to_string(n);
    rows.networks.back().problem = std::string(500, 'p');
  }
  const auto next = ask(kAnna, 7, [rows] { return rows; });
  std::size_t slices = 0;
  const auto counted = [&] {
    auto slice = next();
    if (slice) ++slices;
    return slice;
  };
  EXPECT_EQ(std::get<control::Networks>(whole(counted, 7)), rows);
  EXPECT_GT(slices, 1U);
}

TEST_F(AsideTest, WhatMayNotBeSlicedComesInOnePiece) {
  const auto ask_whole = [this](std::uint64_t session, Aside::Make make) {
    return aside_->ask({.pid = 1, .uid = kAnna, .session = session}, std::move(make), false);
  };
  const auto next = ask_whole(1, [] { return rows_of_a_kibibyte(1000); });
  std::size_t slices = 0;
  const auto counted = [&] {
    auto slice = next();
    if (slice) ++slices;
    return slice;
  };
  EXPECT_EQ(std::get<control::Networks>(whole(counted, 1)), rows_of_a_kibibyte(1000));
  EXPECT_EQ(slices, 1U);
  const auto large = ask_whole(2, [] { return rows_of_a_kibibyte(1100); });
  EXPECT_NE(text(whole(large, 2)).find("at most 1048576 are possible; ask for less"),
            std::string::npos);
}

TEST_F(AsideTest, NoSliceHasMoreThanTheLoopPassesOnAtOnce) {
  const auto next = ask(kAnna, 1, [] { return control::Done{std::string(2UL << 20, 'x')}; });
  EXPECT_NE(text(whole(next, 1)).find("at most 1048576 are possible"), std::string::npos);
}

TEST_F(AsideTest, AUserHasOneAndAllOfThemTwoAtOnce) {
  const Barrier barrier;
  const auto make = [&barrier] {
    barrier.wait();
    return control::Done{"made"};
  };
  const auto first = ask(kAnna, 1, make);
  const auto second = ask(kAnna, 2, [] { return control::Done{"second"}; });
  const auto third = ask(kBert, 3, make);
  const auto fourth = ask(kCleo, 4, [] { return control::Done{"fourth"}; });
  for (const auto* waits : {&first, &second, &third, &fourth}) EXPECT_FALSE((*waits)());
  barrier.open();
  barrier.open();
  EXPECT_EQ(text(whole(first, 1)), "made");
  EXPECT_EQ(text(whole(third, 3)), "made");
  EXPECT_EQ(text(whole(fourth, 4)), "fourth");
  EXPECT_EQ(text(whole(second, 2)), "second");
}

TEST_F(AsideTest, AReportThatIsReadSlowlyHoldsNoPlace) {
  const auto large = [] { return rows_of_a_kibibyte(1000); };
  const auto anna = ask(kAnna, 1, large);
  const auto bert = ask(kBert, 2, large);
  begin_to_read(anna, 1);
  begin_to_read(bert, 2);
  EXPECT_EQ(text(whole(ask(kCleo, 3, [] { return control::Done{"made"}; }), 3)), "made");
  EXPECT_EQ(text(whole(ask(kAnna, 4, [] { return control::Done{"hers"}; }), 4)), "hers")
      << "nor does it keep its own user waiting";
  std::size_t rows = 64;
  for (auto slice = anna(); slice; slice = slice->more ? anna() : std::nullopt)
    rows += std::get<control::Networks>(body_of(std::move(*slice))).networks.size();
  EXPECT_EQ(rows, 1000U);
}

TEST_F(AsideTest, WhoeverHasNoRightsKeepsNoMemberWaiting) {
  const Barrier never;
  const auto make = [&never] {
    never.wait();
    return control::Done{};
  };
  const auto anna = ask(kAnna, 1, make);
  const auto bert = ask(kBert, 2, make);
  turn_until_forks(2);
  EXPECT_EQ(text(whole(ask(kRoot, 3, [] { return control::Done{"root's"}; }, true), 3)), "root's");
}

TEST_F(AsideTest, OfTwoWhoWaitTheMemberIsFirst) {
  std::array<int, 2> letters{-1, -1};
  ASSERT_EQ(::pipe2(letters.data(), O_CLOEXEC), 0);
  const auto says = [&](const char* letter) {
    return [&letters, letter] {
      EXPECT_EQ(::write(letters[1], letter, 1), 1);
      return control::Done{letter};
    };
  };
  const auto berts = ask(kBert, 1, says("B"));
  const auto annas = ask(kAnna, 2, says("A"), true);
  const auto cleos = ask(kCleo, 3, says("C"));
  turn_until_forks(1);
  char first = 0;
  ASSERT_EQ(::read(letters[0], &first, 1), 1);
  EXPECT_EQ(first, 'A');
  EXPECT_EQ(text(whole(annas, 2)), "A");
  EXPECT_EQ(text(whole(berts, 1)), "B");
  EXPECT_EQ(text(whole(cleos, 3)), "C");
  ::close(letters[0]);
  ::close(letters[1]);
}

TEST_F(AsideTest, MembersTogetherKeepNoOtherUserWaiting) {
  const Barrier never;
  const auto make = [&never] {
    never.wait();
    return control::Done{};
  };
  const auto anna = ask(kAnna, 1, make, true);
  const auto bert = ask(kBert, 2, make, true);
  turn_until_forks(2);
  EXPECT_EQ(text(whole(ask(kCleo, 3, [] { return control::Done{"hers"}; }), 3)), "hers");
}

TEST_F(AsideTest, WhatIsNotReadIsGivenUpForTheNextReportsOfItsUser) {
  const auto large = [] { return rows_of_a_kibibyte(40UL << 10); };
  const auto first = ask(kAnna, 1, large);
  begin_to_read(first, 1);
  const auto other = ask(kBert, 2, large);
  begin_to_read(other, 2);
  const auto second = ask(kAnna, 3, large);
  begin_to_read(second, 3);
  const auto why = first();
  ASSERT_TRUE(why);
  EXPECT_EQ(
      text(why->body),
      "error: the report cannot be made: it is read so slowly that the next ones have no room");
  EXPECT_TRUE(other()->more);
  EXPECT_TRUE(second()->more);
}

TEST_F(AsideTest, AReportHasAtMostSoManyBytes) {
  const auto next = ask(kAnna, 1, [] { return rows_of_a_kibibyte(66UL << 10); });
  EXPECT_EQ(text(whole(next, 1)), "error: the report cannot be made: it has more than 64 MiB");
}

TEST_F(AsideTest, WhoHasWaitedLongestForAnythingIsNext) {
  const Barrier barrier;
  const auto make = [&barrier] {
    barrier.wait();
    return control::Done{"made"};
  };
  const auto anna = ask(kAnna, 1, make);
  const auto bert = ask(kBert, 2, make);
  auto annas_next = ask(kAnna, 3, make);
  const auto cleo = ask(kCleo, 4, make);
  barrier.open();
  // Whichever it was that ended, Cleo has had nothing yet.
  while (!ready_.contains(1) && !ready_.contains(2)) turn();
  const bool was_anna = ready_.contains(1);
  EXPECT_EQ(text(whole(was_anna ? anna : bert, was_anna ? 1 : 2)), "made");
  annas_next = nullptr;  // she hangs up
  barrier.open();
  barrier.open();
  EXPECT_EQ(text(whole(was_anna ? bert : anna, was_anna ? 2 : 1)), "made");
  EXPECT_EQ(text(whole(cleo, 4)), "made");
}

TEST_F(AsideTest, WhoHangsUpMakesRoom) {
  const Barrier never;
  auto first = ask(kAnna, 1, [&never] {
    never.wait();
    return control::Done{};
  });
  const auto second = ask(kAnna, 2, [] { return control::Done{"second"}; });
  EXPECT_FALSE(second());
  first = nullptr;
  EXPECT_EQ(text(whole(second, 2)), "second");
}

TEST_F(AsideTest, WhoHangsUpBeforeItBeginsCostsNoFork) {
  for (std::uint64_t session = 1; session <= 20; ++session) {
    const auto next = ask(kAnna, session, [] { return control::Done{}; });
  }
  EXPECT_EQ(forks.made, 0);
  const auto last = ask(kBert, 21, [] { return control::Done{"last"}; });
  EXPECT_EQ(text(whole(last, 21)), "last");
  EXPECT_EQ(forks.made, 1);
}

TEST_F(AsideTest, AClientThatHungUpUnnoticedCostsNoForkEither) {
  std::set<std::uint64_t> gone{1, 2};
  aside_->on_begin([&](std::uint64_t session) { return gone.contains(session); });
  const auto make = [] { return control::Done{"made"}; };
  const auto first = ask(kAnna, 1, make);
  const auto second = ask(kAnna, 2, make);
  const auto third = ask(kBert, 3, make);
  EXPECT_EQ(text(whole(third, 3)), "made");
  EXPECT_EQ(forks.made, 1);
}

TEST_F(AsideTest, WhatWaitsInTheLoopIsDoneBeforeAFork) {
  const Fd always(::eventfd(1, EFD_CLOEXEC | EFD_NONBLOCK));
  unsigned turns = 0;
  sd_event_source* raw = nullptr;
  const auto count = [](sd_event_source*, int, std::uint32_t, void* turns_of) {
    ++*static_cast<unsigned*>(turns_of);
    return 0;
  };
  ASSERT_GE(sd_event_add_io(loop_.get(), &raw, always.get(), EPOLLIN, count, &turns), 0);
  const std::unique_ptr<sd_event_source, FreeWith<sd_event_source_unref>> other(raw);
  const auto next = ask(kAnna, 1, [] { return control::Done{"made"}; });
  turn_until_forks(1);
  EXPECT_GE(turns, Aside::kPasses);
  EXPECT_EQ(text(whole(next, 1)), "made");
}

TEST_F(AsideTest, AReportWithoutAClientCountsUntilItsProcessHasEnded) {
  const Barrier never;
  for (int i = 1; i <= 3; ++i) {
    const auto next = ask(kAnna, static_cast<std::uint64_t>(i), [&never] {
      never.wait();
      return control::Done{};
    });
    turn_until_forks(i);
  }
  EXPECT_EQ(forks.beside_another, 0);
}

TEST_F(AsideTest, OnlyAUserWhoseBudgetIsUsedUpWaits) {
  aside_->set_rates({{3, 0}, {3, 0}, 0});
  const auto make = [] { return control::Done{"made"}; };
  for (std::uint64_t session = 1; session <= 3; ++session)
    EXPECT_EQ(text(whole(ask(kAnna, session, make), session)), "made");
  const auto fourth = ask(kAnna, 4, make);
  const auto other = ask(kBert, 5, make);
  EXPECT_EQ(text(whole(other, 5)), "made");
  EXPECT_FALSE(fourth());
  EXPECT_EQ(forks.made, 4);
}

TEST_F(AsideTest, AChildThatDiesIsAnError) {
  const auto next = ask(kAnna, 1, []() -> ReplyBody { std::_Exit(3); });
  EXPECT_EQ(text(whole(next, 1)),
            "error: the report cannot be made: the process that makes it has ended");
  const auto killed = ask(kAnna, 2, []() -> ReplyBody {
    ::kill(::getpid(), SIGKILL);
    return control::Done{};
  });
  EXPECT_EQ(text(whole(killed, 2)),
            "error: the report cannot be made: the process that makes it has ended");
}

TEST_F(AsideTest, TheChildIsTheFirstToGoAndHasNoSocketOfTheDaemon) {
  std::array<int, 2> sockets{-1, -1};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, sockets.data()), 0);
  const auto next = ask(kAnna, 1, [sockets] {
    std::string adjusted;
    std::ifstream("/proc/self/oom_score_adj") >> adjusted;
    struct stat is{};
    const bool closed = ::fstat(sockets[0], &is) < 0 && ::fstat(sockets[1], &is) < 0;
    return control::Done{adjusted + (closed ? " closed" : " open")};
  });
  EXPECT_EQ(text(whole(next, 1)), "1000 closed");
  EXPECT_EQ(::write(sockets[0], "x", 1), 1) << "the daemon has it as before";
  ::close(sockets[0]);
  ::close(sockets[1]);
}

}  // namespace
}  // namespace mlcca
