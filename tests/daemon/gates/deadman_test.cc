// SPDX-License-Identifier: BSD-2-Clause
// Gates that close by themselves when no heart-beat comes: no timer runs here, and nothing is
// pinned.
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>

#include "base/clock.hpp"
#include "tests/daemon/gates/attach_fixture.hpp"
#include "tests/support/becomes.hpp"

namespace mlcca::gates {
namespace {

using test::becomes;

std::uint64_t refused_as_closed(const Gate& gate) {
  return gate.reasons(Direction::ingress).at(GATE_R_CLOSED);
}

/// Frames of the bus meet a closed gate, soon.
bool closes(const Bus& bus, const Gate& gate) {
  const auto before = refused_as_closed(gate);
  return becomes([&] {
    bus.inject(frame(0x123));
    return refused_as_closed(gate) > before;
  });
}

TEST_P(Attach, ClosesItselfWithoutTimerAndPins) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  bus.inject(frame(0x123));
  expect_passed(gate, in(0x123), 1);
  std::filesystem::remove_all(control_.directory());
  ASSERT_TRUE(control_.set_grace(0));
  EXPECT_TRUE(closes(bus, gate));
}

TEST_P(Attach, ABeatThatComesTooLateFindsALapseAndOpensNothing) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  ASSERT_TRUE(control_.set_grace(0));
  ASSERT_TRUE(closes(bus, gate));
  EXPECT_FALSE(control_.lapsed()) << "it was not counted yet";
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(control_.beat(0));
    EXPECT_TRUE(control_.lapsed());
    EXPECT_EQ(control_.lapses(), 1U);
  }
  ASSERT_TRUE(control_.set_grace(kForEver));
  ASSERT_TRUE(control_.beat(0));
  EXPECT_TRUE(closes(bus, gate)) << "a longer grace opens nothing either";
  ASSERT_TRUE(control_.clear_lapse(0));
  EXPECT_FALSE(control_.lapsed());
  // Those before it, injected while it was closed, are counted first.
  const auto passed = gate.counters(in(0x123)).value().passed;
  EXPECT_TRUE(becomes([&] {
    bus.inject(frame(0x123));
    return gate.counters(in(0x123)).value().passed > passed;
  }));
}

TEST_P(Attach, BeforeTheFirstHeartBeat) {
  const Bus bus("bus0");
  root_ = test::new_bpf_root();
  control_ = create(root_);
  control_.open();
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  EXPECT_TRUE(closes(bus, gate)) << "closed from the beginning";
  ASSERT_TRUE(control_.set_grace(kForEver));
  EXPECT_TRUE(closes(bus, gate)) << "a grace is no heart-beat";
  ASSERT_TRUE(control_.beat(0));
  EXPECT_EQ(control_.lapses(), 0U) << "the first one is not late";
  EXPECT_TRUE(becomes([&] {
    bus.inject(frame(0x123));
    return gate.counters(in(0x123)).value().passed > 0;
  }));
}

TEST_P(Attach, AShorterGraceHoldsForTheBeatBeforeIt) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  const Mapped<gate_control> word(control_.map_fd(), 1);
  EXPECT_EQ(word[0].deadline, kForEver);
  ASSERT_TRUE(control_.set_grace(3'600'000'000'000));
  const std::uint64_t hour = word[0].deadline;
  EXPECT_LT(hour, kForEver);
  ASSERT_TRUE(control_.set_grace(kForEver));
  EXPECT_EQ(word[0].deadline, hour) << "a longer one from the next beat on";
  ASSERT_TRUE(control_.beat(0));
  EXPECT_EQ(word[0].deadline, kForEver);
}

TEST_P(Attach, GraceInTicksIsNeverShorter) {
  const Mapped<gate_control> word(control_.map_fd(), 1);
  timespec resolution{};
  ASSERT_EQ(clock_getres(CLOCK_MONOTONIC_COARSE, &resolution), 0);
  const auto tick = static_cast<std::uint64_t>(resolution.tv_nsec);
  for (const std::uint64_t grace : {kShortestGrace, kShortestGrace + 1, kDefaultGrace}) {
    ASSERT_TRUE(control_.set_grace(grace));
    EXPECT_GE(word[0].grace_ticks * tick, grace);
    EXPECT_LT((word[0].grace_ticks - 1) * tick, grace);
  }
  ASSERT_TRUE(control_.set_grace(kForEver));
  EXPECT_EQ(word[0].grace_ticks, kForEver);
}

constexpr std::uint64_t kHour = 3'600'000'000'000;

/// ns that the gates stay open without another heart-beat.
std::uint64_t left(const Control& control) {
  return time_left(control.map_fd()).value_or(kForEver);
}

TEST_P(Attach, StaysOpenNoLongerThanItMay) {
  const auto now = monotonic_ns();
  ASSERT_TRUE(control_.set_until(now + kHour));
  EXPECT_EQ(control_.until(), now + kHour);
  EXPECT_LE(left(control_), kHour) << "at once";
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(control_.beat(0));
    EXPECT_LE(left(control_), now + kHour - monotonic_ns() + kHour / 1000);
  }
  ASSERT_TRUE(control_.set_until(now + kHour / 2));
  EXPECT_LE(left(control_), kHour / 2) << "an earlier end holds at once";
  ASSERT_TRUE(control_.set_until(0));
  ASSERT_TRUE(control_.beat(0));
  EXPECT_GT(left(control_), kHour) << "the fixture's grace has no end";
}

TEST_P(Attach, ClosesWhenItsTimeIsOverWhateverBeatsCome) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  bus.inject(frame(0x123));
  expect_passed(gate, in(0x123), 1);
  ASSERT_TRUE(control_.set_until(1));
  EXPECT_TRUE(closes(bus, gate));
  ASSERT_TRUE(control_.beat(0));
  EXPECT_TRUE(control_.lapsed()) << "it is a silence like another one";
  ASSERT_TRUE(control_.clear_lapse(0));
  EXPECT_EQ(left(control_), 0U) << "nothing opens before a later end is set";
  EXPECT_TRUE(closes(bus, gate));
  ASSERT_TRUE(control_.set_until(monotonic_ns() + kHour));
  ASSERT_TRUE(control_.beat(0));
  ASSERT_TRUE(control_.clear_lapse(0));
  EXPECT_GT(left(control_), 0U);
}

TEST_P(Attach, TheNextDaemonKeepsHowLongTheGatesMayBeOpen) {
  const auto is_pinned = [&] { return std::filesystem::exists(control_.directory() + "/until"); };
  EXPECT_FALSE(is_pinned()) << "nobody has set anything";
  ASSERT_TRUE(control_.set_until(0));
  EXPECT_FALSE(is_pinned());
  const auto end = monotonic_ns() + kHour;
  ASSERT_TRUE(control_.set_until(end));
  EXPECT_TRUE(is_pinned());
  Control next = create(root_);
  EXPECT_EQ(next.until(), end);
  ASSERT_TRUE(next.beat(0));
  EXPECT_LE(left(next), kHour);
  ASSERT_TRUE(next.set_until(1));
  EXPECT_EQ(left(next), 0U);
  EXPECT_EQ(control_.until(), 1U) << "they are one";
}

}  // namespace
}  // namespace mlcca::gates
