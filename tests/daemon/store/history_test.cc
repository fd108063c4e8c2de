// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/store/history.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/daemon/store/worlds.hpp"

namespace {
/// How often anything in this program has slept: SQLite's library calls the function below.
int sleeps = 0;
}  // namespace

extern "C" int usleep(useconds_t /*time*/) {
  ++sleeps;
  return 0;
}

namespace mlcca::store::test {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr std::uint64_t kStart = 1'700'000'000 * kSecond;

Decision decision(std::uint64_t number, const std::string& kind = "granted",
                  const std::string& channel = "video") {
  return {kStart + number * kSecond,
          kind,
          0xffff'ffff'0000'0000U + number,
          channel,
          "robot",
          "base",
          "mesh",
          "decision " + std::to_string(number)};
}

std::vector<Decision> found(History& history, const HistoryFilter& filter = {}) {
  auto rows = history.query(filter);
  EXPECT_TRUE(rows) << rows.error().text;
  return rows ? std::move(*rows) : std::vector<Decision>();
}

HistoryFilter newest(std::size_t limit) {
  HistoryFilter filter;
  filter.limit = limit;
  return filter;
}
HistoryFilter of_channel(const std::string& channel, std::size_t limit = 100) {
  HistoryFilter filter = newest(limit);
  filter.channel = channel;
  return filter;
}
HistoryFilter of_kind(const std::string& kind, std::size_t limit = 100) {
  HistoryFilter filter = newest(limit);
  filter.kind = kind;
  return filter;
}
HistoryFilter until(std::uint64_t unix_ns, HistoryFilter filter) {
  filter.until_ns = unix_ns;
  return filter;
}

TEST(History, GivesBackWhatHappenedTheNewestFirst) {
  const Folder folder;
  {
    History history = History::open(folder.path());
    for (const std::uint64_t n : {1U, 2U, 3U}) history.append(decision(n));
    EXPECT_EQ(found(history), (std::vector{decision(3), decision(2), decision(1)})) << "waiting";
    history.flush(kStart);
    EXPECT_EQ(history.pending(), 0U);
    history.append(decision(4));
    EXPECT_EQ(found(history), (std::vector{decision(4), decision(3), decision(2), decision(1)}));
    EXPECT_EQ(found(history, newest(2)), (std::vector{decision(4), decision(3)}));
    EXPECT_EQ(found(history, newest(0)), std::vector<Decision>());
    history.flush(kStart);
    EXPECT_TRUE(history.take_troubles().empty());
  }
  History again = History::open(folder.path());
  EXPECT_EQ(found(again, newest(1)), std::vector{decision(4)});
}

TEST(History, KnowsWhoAskedForIt) {
  const Folder folder;
  Decision asked = decision(1);
  asked.by = control::Actor{.uid = 1000, .user = "alice", .pid = 4242};
  Decision nameless = decision(2);
  nameless.by = control::Actor{.uid = 4'294'967'294, .user = "", .pid = 1};
  const std::vector<Decision> newest_first{decision(3), nameless, asked};
  auto history = History::open(folder.path());
  for (const Decision& d : {asked, nameless, decision(3)}) history.append(d);
  EXPECT_EQ(found(history), newest_first) << "in memory";
  history.flush(kStart);
  EXPECT_EQ(found(history), newest_first) << "on disk";
}

TEST(AHistoryFromBeforeThereWereActors, IsKeptAndGoesOn) {
  const Folder folder;
  {
    auto history = History::open(folder.path());
    history.append(decision(1));
    history.flush(kStart);
  }
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder.path() + "/history.db").c_str(), &database), SQLITE_OK);
  for (const char* column : {"uid", "user", "pid"})
    ASSERT_EQ(
        sqlite3_exec(database, (std::string("ALTER TABLE decision DROP COLUMN ") + column).c_str(),
                     nullptr, nullptr, nullptr),
        SQLITE_OK);
  sqlite3_close(database);
  auto history = History::open(folder.path());
  EXPECT_TRUE(history.take_troubles().empty());
  Decision asked = decision(2);
  asked.by = control::Actor{.uid = 0, .user = "root", .pid = 7};
  history.append(asked);
  history.flush(kStart);
  EXPECT_EQ(found(history), (std::vector<Decision>{asked, decision(1)}));
}

TEST(History, FindsWhatAFilterSaysAndNothingElse) {
  const Folder folder;
  History history = History::open(folder.path());
  const std::array<std::string, 3> kinds{"granted", "refused", "withdrawn"};
  const std::array<std::string, 3> channels{"video", "motor", "it's; \"x\" -- %"};
  std::mt19937 random(51);
  std::vector<Decision> all;
  for (std::uint64_t n = 0; n < 600; ++n) {
    all.push_back(decision(n, kinds[random() % 3], channels[random() % 3]));
    history.append(all.back());
    if (n % 100 == 50) history.flush(kStart);
  }
  ASSERT_GT(history.pending(), 0U);
  for (int round = 0; round < 400; ++round) {
    HistoryFilter filter;
    if (random() % 2 == 0) filter.kind = kinds[random() % 3];
    if (random() % 2 == 0) filter.channel = channels[random() % 3];
    if (random() % 2 == 0) filter.since_ns = kStart + (random() % 600) * kSecond;
    if (random() % 2 == 0) filter.until_ns = kStart + (random() % 600) * kSecond;
    filter.limit = random() % 300;
    std::vector<Decision> expected;
    for (auto d = all.rbegin(); d != all.rend() && expected.size() < filter.limit; ++d)
      if ((filter.kind.empty() || d->kind == filter.kind) &&
          (filter.channel.empty() || d->channel == filter.channel) &&
          d->unix_ns >= filter.since_ns && d->unix_ns <= filter.until_ns)
        expected.push_back(*d);
    ASSERT_EQ(found(history, filter), expected) << round;
  }
}

TEST(History, TakesTextsForTextsAndNeverForSql) {
  const Folder folder;
  History history = History::open(folder.path());
  const std::string nul("a\0b", 3);
  for (const std::string& text : {std::string("'; DROP TABLE decision; --"), std::string("?1"), nul,
                                  std::string("\xff\xfe"), std::string("' OR '1'='1")}) {
    Decision d{kStart, text, 1, text, text, text, text, text};
    history.append(decision(1));
    history.append(d);
    history.flush(kStart);
    EXPECT_EQ(found(history, of_channel(text)), std::vector{d});
    EXPECT_EQ(found(history, of_kind(text)), std::vector{d});
    HistoryFilter both = of_channel(text);
    both.kind = text;
    EXPECT_EQ(found(history, both), std::vector{d});
  }
  EXPECT_EQ(found(history).size(), 10U);
}

TEST(History, KeepsExtremeNumbers) {
  const Folder folder;
  History history = History::open(folder.path());
  Decision d = decision(1);
  d.subject = ~std::uint64_t{0};
  d.unix_ns = std::numeric_limits<std::int64_t>::max();
  history.append(d);
  history.flush(kStart);
  EXPECT_EQ(found(history), std::vector{d});
  EXPECT_EQ(found(history, until(~std::uint64_t{0}, newest(~std::size_t{0}))), std::vector{d});
}

// --- bounds --------------------------------------------------------------------------------------

TEST(HistoryBounds, SomeOfItIsAStep) {
  const Folder folder;
  History history = History::open(folder.path());
  EXPECT_FALSE(history.flush_some(kStart)) << "there is nothing";
  for (std::uint64_t n = 0; n < History::kFlushStep + 1; ++n) history.append(decision(n));
  EXPECT_TRUE(history.flush_some(kStart));
  EXPECT_EQ(history.pending(), 1U);
  EXPECT_EQ(found(history, newest(2)),
            (std::vector{decision(History::kFlushStep), decision(History::kFlushStep - 1)}))
      << "those that wait are newer than those that were written";
  EXPECT_FALSE(history.flush_some(kStart));
  EXPECT_EQ(history.pending(), 0U);
}

TEST(HistoryBounds, HoldInRowsOnceTheFlushesHaveCaughtUp) {
  const Folder folder;
  for (std::uint64_t n = 0; n < 5'000; n += 1'000) {
    History large = History::open(folder.path());
    for (std::uint64_t i = n; i < n + 1'000; ++i) large.append(decision(i));
    large.flush(kStart);
  }
  History history = History::open(folder.path(), {.rows = 100});
  for (std::uint64_t n = 5'000; n < 5'100; ++n) {
    const std::size_t before = found(history, newest(10'000)).size();
    history.append(decision(n));
    history.flush(kStart);
    const std::size_t after = found(history, newest(10'000)).size();
    EXPECT_LE(before - after, History::kPruneStep) << "in small steps";
    EXPECT_EQ(after, before > History::kPruneStep + 100 ? before - History::kPruneStep : 100);
  }
  const auto left = found(history, newest(10'000));
  ASSERT_EQ(left.size(), 100U);
  EXPECT_EQ(left.front(), decision(5'099));
  EXPECT_EQ(left.back(), decision(5'000));
}

TEST(HistoryBounds, HoldInAge) {
  const Folder folder;
  History history = History::open(folder.path(), {.age_ns = 100 * kSecond});
  for (std::uint64_t n = 0; n < 500; ++n) {
    history.append(decision(n));
    history.flush(kStart + n * kSecond);
    const auto left = found(history, newest(1'000));
    ASSERT_EQ(left.size(), std::min<std::uint64_t>(n, 100) + 1);
    ASSERT_EQ(left.back(), decision(n - std::min<std::uint64_t>(n, 100)));
  }
}

TEST(HistoryBounds, HoldForWhatWaits) {
  const Folder folder;
  History history = History::open(folder.path());
  for (std::uint64_t n = 0; n < History::kMaxPending + 7; ++n) history.append(decision(n));
  EXPECT_EQ(history.pending(), History::kMaxPending);
  EXPECT_EQ(history.lost(), 7U);
  history.flush(kStart);
  EXPECT_EQ(found(history, newest(History::kMaxPending + 100)).back(), decision(7));
}

// --- trouble -------------------------------------------------------------------------------------

std::vector<std::string> names_in(const Folder& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    names.push_back(entry.path().filename());
  std::ranges::sort(names);
  return names;
}

void fill(const Folder& folder, std::uint64_t rows) {
  History history = History::open(folder.path());
  for (std::uint64_t n = 0; n < rows; ++n) history.append(decision(n));
  history.flush(kStart);
}

TEST(ADamagedHistory, IsSetAsideAndANewOneBegun) {
  const Folder folder;
  for (int round = 1; round <= 2; ++round) {
    write_file(folder.file("history.db"), std::string(8192, 'x'));
    History history = History::open(folder.path());
    const auto troubles = history.take_troubles();
    const std::string kept = folder.file("history.db.damaged-") + std::to_string(round);
    ASSERT_EQ(troubles.size(), 1U);
    EXPECT_NE(troubles[0].find("kept as " + kept), std::string::npos) << troubles[0];
    EXPECT_EQ(read_file(kept), std::string(8192, 'x'));
    EXPECT_TRUE(history.take_troubles().empty());
    history.append(decision(1));
    history.flush(kStart);
    EXPECT_EQ(found(history), std::vector{decision(1)});
  }
}

TEST(ADamagedHistory, IsNoticedWhenItIsRead) {
  const Folder folder;
  fill(folder, 5'000);
  // The first page, which opening needs, stays; one row in ten is not what it was.
  std::string bytes = read_file(folder.file("history.db"));
  for (std::size_t at = 8192; at < bytes.size(); ++at) bytes[at] = '\x55';
  write_file(folder.file("history.db"), bytes);
  History history = History::open(folder.path());
  EXPECT_EQ(found(history), std::vector<Decision>());
  ASSERT_EQ(history.take_troubles().size(), 1U);
  history.append(decision(1));
  history.flush(kStart);
  EXPECT_EQ(found(history), std::vector{decision(1)});
  EXPECT_TRUE(history.take_troubles().empty());
}

TEST(ADamagedHistory, IsNoticedWhenItIsWrittenAndNothingThatWaitedIsLost) {
  const Folder folder;
  fill(folder, 5'000);
  std::string bytes = read_file(folder.file("history.db"));
  for (std::size_t at = 8192; at < bytes.size(); ++at) bytes[at] = '\x55';
  write_file(folder.file("history.db"), bytes);
  History history = History::open(folder.path());
  history.append(decision(6'000));
  history.flush(kStart);
  EXPECT_EQ(history.take_troubles().size(), 1U);
  EXPECT_EQ(history.pending(), 0U);
  EXPECT_EQ(found(history), std::vector{decision(6'000)});
}

TEST(ADamagedHistory, NeverStopsTheDaemonWhateverItsBytesAre) {
  std::mt19937 random(52);
  const Folder origin;
  fill(origin, 300);
  const std::string good = read_file(origin.file("history.db"));
  for (int round = 0; round < 60; ++round) {
    const Folder folder;
    std::string bytes = good.substr(0, round % 3 == 0 ? random() % good.size() : good.size());
    for (std::size_t flips = random() % 200; flips > 0 && !bytes.empty(); --flips)
      bytes[random() % (round % 2 == 0 ? std::min<std::size_t>(bytes.size(), 600) : bytes.size())] =
          static_cast<char>(random());
    write_file(folder.file("history.db"), bytes);
    History history = History::open(folder.path());
    history.append(decision(1'000));
    history.flush(kStart + 1'000 * kSecond);
    ASSERT_EQ(history.pending(), 0U) << round;
    const auto rows = history.query(newest(1));
    ASSERT_TRUE(rows) << rows.error().text;
    history.append(decision(1'001));
    history.flush(kStart + 1'001 * kSecond);
    ASSERT_EQ(history.pending(), 0U);
  }
}

TEST(AHistoryOfAnotherProgram, IsSetAsideToo) {
  const Folder folder;
  {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(folder.file("history.db").c_str(), &database), SQLITE_OK);
    ASSERT_EQ(sqlite3_exec(database, "CREATE TABLE decision (id INTEGER PRIMARY KEY, other TEXT)",
                           nullptr, nullptr, nullptr),
              SQLITE_OK);
    sqlite3_close(database);
  }
  History history = History::open(folder.path());
  EXPECT_EQ(history.take_troubles().size(), 1U);
  history.append(decision(1));
  EXPECT_EQ(found(history), std::vector{decision(1)});
}

TEST(AHistoryThatCannotBeOpened, IsSaidOnceAndTriedAgain) {
  const Folder folder;
  const std::string later = folder.file("later");
  History history = History::open(later);
  ASSERT_EQ(history.take_troubles().size(), 1U);
  for (std::uint64_t n = 0; n < 10; ++n) {
    history.append(decision(n));
    history.flush(kStart + n * History::kRetryNs);
  }
  EXPECT_TRUE(history.take_troubles().empty());
  EXPECT_EQ(history.pending(), 10U);
  EXPECT_FALSE(history.query(of_kind("refused")));
  std::filesystem::create_directory(later);
  history.flush(kStart + 9 * History::kRetryNs + 1);
  EXPECT_EQ(history.pending(), 10U) << "not tried all the time";
  history.flush(kStart + 10 * History::kRetryNs);
  EXPECT_EQ(history.pending(), 0U);
  EXPECT_EQ(history.take_troubles().size(), 1U) << "written again";
  EXPECT_EQ(found(history).front(), decision(9));
}

TEST(AHistoryInUseByAnotherProgram, IsWrittenLater) {
  const Folder folder;
  History history = History::open(folder.path());
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open(history.path().c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  history.append(decision(1));
  history.flush(kStart);
  EXPECT_EQ(history.pending(), 1U);
  EXPECT_EQ(history.take_troubles().size(), 1U);
  ASSERT_EQ(sqlite3_exec(other, "ROLLBACK", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(other);
  history.flush(kStart + History::kRetryNs);
  EXPECT_EQ(history.pending(), 0U);
  EXPECT_EQ(names_in(folder).front(), "history.db") << "nothing was set aside";
  EXPECT_EQ(found(history), std::vector{decision(1)});
}

/// As on a file system that grants no locks, while it lives.
class WithoutLocks {
 public:
  WithoutLocks() : vfs_(sqlite3_vfs_find(nullptr)) {
    const auto refuse = +[](int fd, int command, long argument) {
      if (command == F_SETLK) {
        errno = ENOLCK;
        return -1;
      }
      return ::fcntl(fd, command, argument);
    };
    EXPECT_EQ(vfs_->xSetSystemCall(vfs_, "fcntl", reinterpret_cast<sqlite3_syscall_ptr>(refuse)),
              SQLITE_OK);
  }
  WithoutLocks(const WithoutLocks&) = delete;
  WithoutLocks& operator=(const WithoutLocks&) = delete;
  WithoutLocks(WithoutLocks&&) = delete;
  WithoutLocks& operator=(WithoutLocks&&) = delete;
  ~WithoutLocks() { vfs_->xSetSystemCall(vfs_, "fcntl", nullptr); }

 private:
  sqlite3_vfs* vfs_;
};

TEST(AFileSystemThatGrantsNoLocks, IsReportedAndNeverWaitedFor) {
  const Folder folder;
  History history = History::open(folder.path());
  history.append(decision(1));
  history.flush(kStart);
  EXPECT_EQ(history.pending(), 0U);
  const int before = sleeps;
  {
    const WithoutLocks no_locks;
    history.append(decision(2));
    history.flush(kStart);
    EXPECT_EQ(history.pending(), 1U);
    EXPECT_EQ(history.take_troubles().size(), 1U);
    EXPECT_FALSE(history.query(of_kind("refused")));
    EXPECT_EQ(History::open(folder.path()).take_troubles().size(), 1U);
  }
  EXPECT_EQ(sleeps, before) << "the heart-beat waits";
  history.flush(kStart + History::kRetryNs);
  EXPECT_EQ(history.pending(), 0U);
}

// --- cost ----------------------------------------------------------------------------------------

/// Steps of the database's machine in the statements that have ended: a measure that no other load
/// disturbs. Counts on connections that are opened after the first call.
std::uint64_t& steps() {
  static std::uint64_t count = 0;
  static const int once = sqlite3_auto_extension(reinterpret_cast<void (*)()>(
      +[](sqlite3* database, const char**, const sqlite3_api_routines*) {
        const auto ended = [](unsigned, void*, void* statement, void*) {
          count += static_cast<std::uint64_t>(sqlite3_stmt_status(
              static_cast<sqlite3_stmt*>(statement), SQLITE_STMTSTATUS_VM_STEP, 1));
          return 0;
        };
        return sqlite3_trace_v2(database, SQLITE_TRACE_PROFILE, ended, nullptr);
      }));
  EXPECT_EQ(once, SQLITE_OK);
  return count;
}

TEST(AQueryOf100000Rows, ReadsOnlyTheRowsThatItGives) {
  steps() = 0;
  const Folder folder;
  History history = History::open(folder.path());
  for (std::uint64_t n = 0; n < 100'000; ++n) {
    history.append(
        decision(n, n % 1'000 == 0 ? "withdrawn" : "granted", n % 500 == 0 ? "rare" : "often"));
    if (history.pending() == History::kMaxPending) history.flush(kStart);
  }
  history.flush(kStart);
  EXPECT_GT(steps(), 100'000U) << "the measure does not measure";
  const auto cost = [&](const HistoryFilter& filter) {
    const std::uint64_t before = steps();
    EXPECT_EQ(found(history, filter).size(), 10U);
    return steps() - before;
  };
  const std::uint64_t few = 1'000;  // ten rows of nine columns each; a row is some twenty steps
  EXPECT_LT(cost(newest(10)), few);
  EXPECT_LT(cost(of_channel("rare", 10)), few);
  EXPECT_LT(cost(of_kind("withdrawn", 10)), few);
  EXPECT_LT(cost(until(kStart + 50'000 * kSecond, newest(10))), few);
  EXPECT_LT(cost(until(kStart + 100 * kSecond, of_channel("often", 10))), few);
  HistoryFilter never = of_channel("often", 10);
  never.kind = "removed";
  const std::uint64_t before = steps();
  EXPECT_TRUE(found(history, never).empty());
  EXPECT_LT(steps() - before, few) << "of a kind that the channel has never seen";
}

}  // namespace
}  // namespace mlcca::store::test
