// SPDX-License-Identifier: BSD-2-Clause
// Policing by the real gate programs. No test waits: how much may have passed follows from the
// time that went by, whatever that was.
#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <thread>
#include <vector>

#include "base/clock.hpp"
#include "daemon/gates/counters.hpp"
#include "tests/bpf/one_slot.hpp"

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::SlotSpec;

constexpr std::uint64_t kHour = 3'600'000'000'000;  // ns

SlotSpec policed(std::uint64_t per_frame, std::uint64_t tolerance, std::uint64_t per_byte = 0) {
  SlotSpec s = one_slot();
  s.per_frame = per_frame;
  s.per_byte = per_byte;
  s.tolerance = tolerance;
  return s;
}

class Police : public OneSlot {
 protected:
  [[nodiscard]] gates::SlotCounters counted() const {
    return gates::slot_counters(gate_.table(), gate_.cpus(), slot_);
  }
};

TEST_F(Police, WhatComesBeforeItsTurnIsDroppedAndCounted) {
  admit(policed(kHour, kHour));
  EXPECT_TRUE(passes());
  EXPECT_TRUE(passes()) << "one may be early";
  EXPECT_FALSE(passes());
  EXPECT_FALSE(passes());
  EXPECT_EQ(counted().passed, 2U);
  EXPECT_EQ(counted().dropped, 2U);
  EXPECT_EQ(counted().excess, 2U);
  EXPECT_EQ(counted().last_reason, core::FrameReason::excess);
  EXPECT_EQ(gates::reason_counters(gate_.cpus(), Direction::ingress)[GATE_R_EXCESS], 2U);
}

TEST_F(Police, AnEventOfSeveralFramesComesAtOnce) {
  // Three frames to the event and one event early: 2 * 3 frames of a third of the period each.
  const std::uint64_t third = kHour / 3;
  admit(policed(third, 2 * kHour - third));
  for (int i = 0; i < 6; ++i) EXPECT_TRUE(passes()) << i;
  EXPECT_FALSE(passes());
}

TEST_F(Police, ExcessMayPassAndIsCountedAllTheSame) {
  SlotSpec s = policed(kHour, 0);
  s.excess_passes = true;
  admit(s);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(passes());
  EXPECT_EQ(counted().passed, 3U);
  EXPECT_EQ(counted().dropped, 0U);
  EXPECT_EQ(counted().excess, 2U);
}

TEST_F(Police, AuditDropsNothing) {
  admit(policed(kHour, 0));
  gate_.control().mode = GATE_AUDIT;
  EXPECT_TRUE(passes());
  EXPECT_TRUE(passes());
  EXPECT_EQ(counted().would_drop, 1U);
  EXPECT_EQ(counted().would_exceed, 1U);
  EXPECT_EQ(counted().excess, 0U);
  EXPECT_EQ(counted().dropped, 0U);
  EXPECT_EQ(gates::would_drop_counters(gate_.table(), Direction::ingress)[GATE_R_EXCESS], 1U);
}

TEST_F(Police, BytesHaveTheirPrice) {
  constexpr std::uint64_t hour_per_byte = kHour * 256;
  admit(policed(0, 12 * kHour, hour_per_byte));
  EXPECT_TRUE(passes(8));
  EXPECT_TRUE(passes(5)) << "8 hours later, and 12 early is early enough";
  EXPECT_FALSE(passes(0)) << "13 hours";
  admit(policed(0, 0, hour_per_byte));
  EXPECT_TRUE(passes(0));
  EXPECT_FALSE(passes(0)) << "an empty frame costs as much as one of a byte";
}

TEST_F(Police, WhatIsNotPolicedPasses) {
  admit(policed(0, 0));
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(passes());
  EXPECT_EQ(counted().excess, 0U);
}

TEST_F(Police, ARefusedFrameCostsNoAllowance) {
  SlotSpec s = policed(kHour, 0);
  s.max_len = 4;
  admit(s);
  EXPECT_FALSE(passes(8)) << "too long";
  EXPECT_TRUE(passes(4));
}

TEST_F(Police, AnotherRateHoldsFromTheNextFrameOn) {
  admit(policed(kHour, 0));
  EXPECT_TRUE(passes());
  EXPECT_FALSE(passes());
  gates::SlotChanges changes;
  changes.police = {policed(kHour, kHour)};
  ASSERT_TRUE(gate_.slots().apply(changes));
  EXPECT_EQ(gate_.slots().present().front(), changes.police.front());
  // All that the new one admits at once: turns at the former rate do not count.
  EXPECT_TRUE(passes());
  EXPECT_TRUE(passes());
  EXPECT_FALSE(passes());
  changes.police = {policed(0, 0)};
  ASSERT_TRUE(gate_.slots().apply(changes));
  EXPECT_TRUE(passes());
}

/// Frames without a pause, until one is dropped after a while: nothing more was due by then.
struct Flood {
  std::uint64_t passed = 0;
  std::uint64_t sent = 0;
  std::uint64_t shortest = 0;  ///< ns from the first frame to the last, at least
  std::uint64_t longest = 0;   ///< the same, at most
};

class Flooding {
 public:
  Flooding(const LoadedGate& gate, std::uint64_t length) : gate_(gate), length_(length) {}

  Flood on(unsigned cpus) {
    const std::uint64_t before = monotonic_ns();
    std::vector<std::thread> senders;
    for (unsigned cpu = 0; cpu < cpus; ++cpu) senders.emplace_back([this, cpu] { send(cpu); });
    for (std::thread& sender : senders) sender.join();
    return {passed_, sent_, last_ - first_, monotonic_ns() - before};
  }

 private:
  bool passes() {
    const bool passed = !gate_.run(Direction::ingress, frame(kId, 8)).dropped;
    ++sent_;
    if (passed) ++passed_;
    return passed;
  }
  void send(unsigned cpu) {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(cpu, &one);
    ::sched_setaffinity(0, sizeof one, &one);
    passes();
    std::uint64_t time = monotonic_ns();
    for (std::uint64_t first = first_;
         time < first && !first_.compare_exchange_weak(first, time);) {
    }
    const std::uint64_t end = time + length_;
    do {
      time = monotonic_ns();
    } while (passes() || time < end);
    for (std::uint64_t last = last_; last < time && !last_.compare_exchange_weak(last, time);) {
    }
  }

  const LoadedGate& gate_;
  std::uint64_t length_;
  std::atomic<std::uint64_t> passed_ = 0;
  std::atomic<std::uint64_t> sent_ = 0;
  std::atomic<std::uint64_t> first_ = ~std::uint64_t{0};  ///< after the first frame
  std::atomic<std::uint64_t> last_ = 0;                   ///< before the last one
};

class PoliceFlood : public Police, public ::testing::WithParamInterface<unsigned> {};

TEST_P(PoliceFlood, PassesAtTheAdmittedRateToTheFrame) {
  constexpr std::uint64_t millisecond = 1'000'000;
  // So much may be early that a sender which others keep from its CPU for a while loses no turn.
  constexpr std::uint64_t early = 2'000 * millisecond;
  admit(policed(millisecond, early));
  const Flood flood = Flooding(gate_, 1'000 * millisecond).on(GetParam());
  EXPECT_GE(flood.passed, (flood.shortest + early) / millisecond);
  EXPECT_LE(flood.passed, (flood.longest + early) / millisecond + 1);
  EXPECT_EQ(counted().passed, flood.passed);
  EXPECT_EQ(counted().excess, flood.sent - flood.passed);
  EXPECT_GT(flood.sent, 2 * flood.passed) << "no flood";
}
INSTANTIATE_TEST_SUITE_P(OnCpus, PoliceFlood, ::testing::Values(1U, 2U));

}  // namespace
}  // namespace mlcca::test
