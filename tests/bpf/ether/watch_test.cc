// SPDX-License-Identifier: BSD-2-Clause
// What the real Ethernet programs find about the events of a slot. As in tests/bpf/watch_test.cc
// without waiting: a test puts back the time of the latest event.
#include <gtest/gtest.h>
#include <sched.h>

#include <numeric>
#include <thread>

#include "base/clock.hpp"
#include "tests/bpf/ether/events.hpp"

namespace mlcca::test {
namespace {

constexpr std::uint64_t kPeriod = 8'000'000'000;  // ns
constexpr std::uint64_t kEighth = kPeriod / 8;
constexpr std::uint64_t kSoon = 500'000'000;  // ns; longer than a packet takes

SlotSpec watched(const SlotSpec& spec, std::uint64_t period = kPeriod) {
  return with(spec, [=](SlotSpec& s) { s.period = period; });
}

class EtherWatch : public ::testing::TestWithParam<std::size_t> {
 protected:
  void admit(const SlotSpec& s) {
    gate_.admit({s});
    watch_ = gate_.table().watch_of(gate_.table().find(s).value());
  }
  bool passes(const Bytes& bytes = packet()) { return !gate_.run(kIn, bytes).dropped; }
  void passes_after(std::uint64_t gap) {
    watch().last = monotonic_ns() - gap;
    ASSERT_TRUE(passes());
  }
  gate_watch& watch() { return gate_.memory().watches[watch_]; }
  std::uint64_t gaps() {
    return std::accumulate(std::begin(watch().gaps), std::end(watch().gaps), std::uint64_t{0});
  }

  LoadedEther& gate_ = LoadedEther::with({.slots = GetParam()});
  std::uint16_t watch_ = 0;
};

TEST_P(EtherWatch, CountsGapsByEighthsOfThePeriod) {
  admit(watched(in()));
  ASSERT_TRUE(passes());
  EXPECT_EQ(gaps(), 0U) << "the first event has none";
  for (unsigned eighth = 0; eighth < 20; ++eighth) {
    const unsigned bin = std::min(eighth, GATE_GAPS - 1U);
    const std::uint64_t before = watch().gaps[bin];
    passes_after(eighth * kEighth);
    EXPECT_EQ(watch().gaps[bin], before + 1) << eighth;
    passes_after((eighth + 1) * kEighth - kSoon);
    EXPECT_EQ(watch().gaps[bin], before + 2) << eighth;
  }
}

TEST_P(EtherWatch, CountsWhatIsMissingAndHowFarOffItCame) {
  admit(watched(in()));
  passes_after(kPeriod + 3 * kEighth);
  EXPECT_EQ(watch().missing, 0U) << "late, not missing";
  EXPECT_GE(watch().deviation, 3 * kEighth);
  EXPECT_LT(watch().deviation, 3 * kEighth + kSoon);
  passes_after(10 * kPeriod);
  EXPECT_EQ(watch().missing, 9U);
  EXPECT_LT(watch().deviation, 3 * kEighth + kSoon) << "on time, after nine";
}

TEST_P(EtherWatch, RestartsAfterASilence) {
  admit(watched(in()));
  ASSERT_TRUE(passes());
  passes_after(3 * kPeriod);
  EXPECT_EQ(watch().missing, 2U);
  passes_after(GATE_SILENT_PERIODS * kPeriod);
  EXPECT_EQ(watch().missing, 0U);
  EXPECT_EQ(gaps(), 0U);
}

TEST_P(EtherWatch, PartsOfOneEventAreOneEvent) {
  auto s = fragmented(watched(in()));
  s.together = kPeriod / 2;
  admit(s);
  const Bytes part = packet([](Datagram& d) { d.flag = 1; });
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(passes(part));
  EXPECT_EQ(gaps(), 0U);
  passes_after(kPeriod);
  EXPECT_EQ(gaps(), 1U);
}

TEST_P(EtherWatch, IpFragmentsAreOneEvent) {
  admit(sized(watched(in()), 1000));
  const Datagram d = event([](Datagram& e) { e.payload = 800; });
  const std::size_t size = d.content().size();
  ASSERT_TRUE(passes(frame(d.fragment(0, 400))));
  ASSERT_TRUE(passes(frame(d.fragment(400, size))));
  EXPECT_NE(watch().last, 0U);
  EXPECT_EQ(gaps(), 0U) << "the second fragment is none";
}

TEST_P(EtherWatch, WhatIsDroppedIsNoEvent) {
  admit(with(watched(in()), [](SlotSpec& s) { s.per_frame = kPeriod; }));
  ASSERT_TRUE(passes());
  ASSERT_FALSE(passes()) << "more than was admitted";
  ASSERT_FALSE(passes(packet([](Datagram& d) { d.payload = 101; }))) << "too long";
  EXPECT_EQ(gaps(), 0U);
}

TEST_P(EtherWatch, WhatIsMoreAndPassesAllTheSameIsAnEvent) {
  admit(with(watched(in()), [](SlotSpec& s) {
    s.per_frame = kPeriod;
    s.excess_passes = true;
  }));
  ASSERT_TRUE(passes());
  ASSERT_TRUE(passes());
  EXPECT_EQ(gaps(), 1U) << "too early, but it came";
}

TEST_P(EtherWatch, WithoutAPeriodASlotIsNotSupervised) {
  admit(in());
  EXPECT_EQ(watch_, 0U);
  ASSERT_TRUE(passes());
  ASSERT_TRUE(passes());
  EXPECT_EQ(watch().last, 0U);
}

TEST_P(EtherWatch, RestartsWithAnotherPeriod) {
  admit(watched(in()));
  passes_after(3 * kPeriod);
  gates::SlotChanges changes;
  changes.police = {watched(in(), kPeriod / 2)};
  ASSERT_TRUE(gate_.table().apply(changes));
  EXPECT_EQ(gate_.table().present(), changes.police);
  EXPECT_EQ(watch().missing, 0U);
  EXPECT_EQ(gaps(), 0U);
  passes_after(kPeriod);
  EXPECT_EQ(watch().missing, 1U);
}

TEST_P(EtherWatch, EveryEventOfTwoCpusIsCountedOnce) {
  constexpr unsigned events = 20'000;
  admit(watched(in()));
  const Bytes bytes = packet();
  const auto send = [&](int cpu) {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(cpu, &one);
    ::sched_setaffinity(0, sizeof one, &one);
    for (unsigned i = 0; i < events; ++i) gate_.run(kIn, bytes);
  };
  std::thread other(send, 1);
  std::thread one(send, 0);
  one.join();
  other.join();
  EXPECT_EQ(gaps(), 2 * events - 1);
  EXPECT_EQ(watch().missing, 0U);
  EXPECT_EQ(gate_.counted(watched(in())).passed, 2 * events);
}

/// Of a bank of counters for each CPU, and of one for all.
INSTANTIATE_TEST_SUITE_P(Tables, EtherWatch, ::testing::Values(0, ETHER_BANKED_SLOTS));

}  // namespace
}  // namespace mlcca::test
