// SPDX-License-Identifier: BSD-2-Clause
// The control word across restarts, and the kernel's dead-man timer on a real clock.
#include "daemon/gates/control.hpp"

#include <bpf/bpf.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "bpf/gate.h"
#include "daemon/gates/mapped.hpp"
#include "tests/daemon/gates/sandbox.hpp"
#include "tests/support/becomes.hpp"

namespace mlcca::gates {
namespace {

using test::becomes;
using test::new_bpf_root;

constexpr std::uint64_t kMillisecond = 1'000'000;

std::uint64_t now() {
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch() /
                                    std::chrono::nanoseconds(1));
}

Control create(const std::string& root) {
  auto control = Control::create(root);
  EXPECT_TRUE(control) << control.error().text;
  return std::move(*control);
}

/// Armed, open, with the shortest grace.
Control watched(const std::string& root) {
  auto control = create(root);
  EXPECT_TRUE(control.set_grace(0));
  control.beat(now());
  const auto armed = control.arm();
  EXPECT_TRUE(armed) << armed.error().text;
  control.open();
  return control;
}

TEST(Control, StartsClosedEnforcingWithTheDefaultGrace) {
  const auto control = create(new_bpf_root());
  EXPECT_FALSE(control.reused());
  EXPECT_FALSE(control.is_open());
  EXPECT_EQ(control.mode(), Mode::enforce);
  EXPECT_EQ(control.grace(), kDefaultGrace);
  EXPECT_FALSE(control.lapsed());
}

TEST(Control, RestartFindsEverythingAsItWas) {
  const auto root = new_bpf_root();
  std::uint32_t token = 0;
  {
    auto control = create(root);
    control.open();
    control.set_mode(Mode::audit);
    ASSERT_TRUE(control.set_grace(kForEver));
    token = Mapped<gate_control>(control.map_fd(), 1)[0].token;
  }
  const auto control = create(root);
  EXPECT_TRUE(control.reused());
  EXPECT_TRUE(control.is_open());
  EXPECT_EQ(control.mode(), Mode::audit);
  EXPECT_EQ(control.grace(), kForEver);
  const auto again = Mapped<gate_control>(control.map_fd(), 1)[0].token;
  EXPECT_EQ(again, token);
  EXPECT_NE(token & 0x80000000U, 0U);
  EXPECT_NE(token, 0xffffffffU);
}

TEST(Control, OrdinaryDirectoryIsRefusedInWords) {
  const auto plain = std::filesystem::temp_directory_path() / "mlcca-no-bpffs";
  const auto control = Control::create(plain);
  std::filesystem::remove_all(plain);
  ASSERT_FALSE(control);
  EXPECT_NE(control.error().text.find("is on no bpffs"), std::string::npos);
}

TEST(Control, GraceIsKeptWithinItsBounds) {
  auto control = create(new_bpf_root());
  const Mapped<gate_control> word(control.map_fd(), 1);
  const auto with = [&](std::uint64_t grace) {
    EXPECT_TRUE(control.set_grace(grace));
    return std::pair{control.grace(), std::uint64_t{word[0].check_ns}};
  };
  EXPECT_EQ(with(0), std::pair(kShortestGrace, 20 * kMillisecond));
  EXPECT_EQ(with(kShortestGrace - 1), std::pair(kShortestGrace, 20 * kMillisecond));
  EXPECT_EQ(with(160 * kMillisecond), std::pair(160 * kMillisecond, 20 * kMillisecond));
  EXPECT_EQ(with(800 * kMillisecond), std::pair(800 * kMillisecond, 100 * kMillisecond));
  EXPECT_EQ(control.beat_interval(), 200 * kMillisecond);
  EXPECT_EQ(with(kForEver), std::pair(kForEver, 1000 * kMillisecond));
  EXPECT_EQ(control.beat_interval(), 1000 * kMillisecond);
}

TEST(DeadMan, ClosesTheGatesOfASilentDaemon) {
  auto control = watched(new_bpf_root());
  ASSERT_TRUE(becomes([&] { return control.lapsed(); }));
  EXPECT_EQ(control.lapses(), 1U);
  EXPECT_TRUE(control.is_open()) << "the daemon's own word stays";
}

TEST(DeadMan, ClosesTheGatesOfADeadDaemon) {
  const auto root = new_bpf_root();
  {
    const auto control = watched(root);
  }
  const auto control = create(root);
  EXPECT_TRUE(becomes([&] { return control.lapsed(); }));
}

TEST(DeadMan, LeavesABeatingDaemonAlone) {
  // A round in which this process itself was held up proves nothing: beat on.
  auto control = watched(new_bpf_root());
  ASSERT_TRUE(control.set_grace(300 * kMillisecond));
  std::uint64_t longest = 0;
  do {
    control.clear_lapse(now());
    const auto before = control.lapses();
    longest = 0;
    const auto start = now();
    for (auto last = start; last - start < 900 * kMillisecond;) {
      poll(nullptr, 0, 1);
      longest = std::max(longest, now() - last);
      last = now();
      control.beat(last);
    }
    if (longest < 200 * kMillisecond) {
      EXPECT_EQ(control.lapses(), before);
    }
  } while (longest >= 200 * kMillisecond);
}

TEST(DeadMan, OutlivesTheDaemonThoughItsPinWasRemoved) {
  const auto root = new_bpf_root();
  Fd word;
  {
    auto control = watched(root);
    EXPECT_FALSE(control.keep_pinned().value());
    for (const char* name : {"/deadman", "/control", "/events", "/grace"})
      ASSERT_TRUE(std::filesystem::remove(control.directory() + name));
    EXPECT_TRUE(control.keep_pinned().value());
    EXPECT_FALSE(control.keep_pinned().value());
    word = Fd(bpf_obj_get((control.directory() + "/control").c_str()));
    control.clear_lapse(now());
  }
  const Mapped<gate_control> left(word.get(), 1);
  EXPECT_TRUE(becomes([&] { return left[0].lapsed != 0; }));
}

TEST(DeadMan, ClosesAgainAfterAClearedLapse) {
  auto control = watched(new_bpf_root());
  ASSERT_TRUE(becomes([&] { return control.lapsed(); }));
  control.clear_lapse(now());
  ASSERT_TRUE(becomes([&] { return control.lapses() == 2; }));
  EXPECT_TRUE(control.lapsed());
}

TEST(DeadMan, CountsALapseOnce) {
  const auto root = new_bpf_root();
  auto control = watched(root);
  ASSERT_TRUE(becomes([&] { return control.lapsed(); }));
  // Another timer of the same kind has checked many times meanwhile.
  auto other = watched(new_bpf_root());
  ASSERT_TRUE(becomes([&] { return other.lapsed(); }));
  EXPECT_EQ(control.lapses(), 1U);
}

TEST(DeadMan, LeavesClosedGatesAndEndlessGraceAlone) {
  auto endless = watched(new_bpf_root());
  ASSERT_TRUE(endless.set_grace(kForEver));
  endless.clear_lapse(now());
  const auto lapses = endless.lapses();
  auto closed = watched(new_bpf_root());
  closed.close_all();
  closed.clear_lapse(now());
  const auto closed_lapses = closed.lapses();
  auto other = watched(new_bpf_root());
  ASSERT_TRUE(becomes([&] { return other.lapsed(); }));
  EXPECT_EQ(endless.lapses(), lapses);
  EXPECT_EQ(closed.lapses(), closed_lapses);
}

TEST(DeadMan, ShorterGraceTakesEffectAtOnce) {
  auto control = create(new_bpf_root());
  control.beat(now());
  ASSERT_TRUE(control.set_grace(3'600'000 * kMillisecond));
  ASSERT_TRUE(control.arm());
  control.open();
  ASSERT_TRUE(control.set_grace(0));
  EXPECT_TRUE(becomes([&] { return control.lapsed(); }));
}

/// The control word, as anyone with the right to it can write there.
class Word {
 public:
  explicit Word(const Control& control)
      : map_(bpf_obj_get((control.directory() + "/control").c_str())) {}
  gate_control* operator->() const { return memory_.span().data(); }

 private:
  Fd map_;
  Mapped<gate_control> memory_{map_.get(), 1};
};

TEST(DeadMan, WhichDaemonHoldsTheGatesIsWrittenAgainWhereAnotherProgramHasAlteredIt) {
  auto control = watched(new_bpf_root());
  const Word word(control);
  EXPECT_FALSE(control.keep_epoch()) << "it has not taken over";
  control.take_over();
  const auto held = word->epoch;
  EXPECT_FALSE(control.keep_epoch());
  ++word->epoch;
  EXPECT_TRUE(control.keep_epoch());
  EXPECT_EQ(word->epoch, held);
  EXPECT_EQ(control.shared().epoch, held);
}

TEST(DeadMan, AGraceThatAnotherProgramAltersIsSetAgainWithTheDeadlineThatFollows) {
  auto control = watched(new_bpf_root());
  const auto left = [&] { return time_left(control.map_fd()).value(); };
  ASSERT_TRUE(control.set_grace(3'600'000 * kMillisecond));
  ASSERT_TRUE(control.clear_lapse(now()));
  EXPECT_FALSE(control.keep_grace().value());
  const Word word(control);
  for (__u64* altered : {&word->grace_ns, &word->grace_ticks, &word->check_ns}) {
    const __u64 before = *altered;
    *altered *= 1000;
    ASSERT_TRUE(control.beat(now()));
    EXPECT_TRUE(control.keep_grace().value());
    EXPECT_EQ(*altered, before);
    EXPECT_FALSE(control.keep_grace().value());
    EXPECT_LE(left(), 3'601'000 * kMillisecond);
  }
  word->deadline = ~__u64{0};
  EXPECT_GT(left(), 3'601'000 * kMillisecond);
  ASSERT_TRUE(control.beat(now()));
  EXPECT_LE(left(), 3'601'000 * kMillisecond);
}

TEST(Control, NoProgramCanWriteToTheGraceThatIsNoted) {
  auto control = create(new_bpf_root());
  EXPECT_FALSE(noted_grace(control.directory()));
  for (const std::uint64_t grace : {7'000 * kMillisecond, kForEver}) {
    ASSERT_TRUE(control.set_grace(grace));
    EXPECT_EQ(noted_grace(control.directory()), grace);
  }
  const Fd note(bpf_obj_get((control.directory() + "/grace").c_str()));
  const std::uint32_t key = 0;
  const std::uint64_t other = 1;
  EXPECT_NE(bpf_map_update_elem(note.get(), &key, &other, BPF_ANY), 0);
  EXPECT_EQ(noted_grace(control.directory()), kForEver);
}

TEST(DeadMan, IsTakenOverByARestartedDaemon) {
  const auto root = new_bpf_root();
  {
    const auto control = watched(root);
  }
  auto control = create(root);
  control.clear_lapse(now());
  const auto armed = control.arm();
  ASSERT_TRUE(armed) << armed.error().text;
  const auto before = control.lapses();
  EXPECT_TRUE(becomes([&] { return control.lapses() > before; }));
}

}  // namespace
}  // namespace mlcca::gates
