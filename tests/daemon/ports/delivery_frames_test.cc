// SPDX-License-Identifier: BSD-2-Clause
// Where the frames of a delivery are counted.
#include "daemon/ports/delivery_frames.hpp"

#include <gtest/gtest.h>

namespace mlcca {
namespace {

core::GateRule rule(std::size_t port, core::Direction direction) {
  core::GateRule rule;
  rule.entry.port = port;
  rule.entry.direction = direction;
  return rule;
}

/// Each slot counts its port, from 1.
std::optional<gates::SlotCounters> by_port(const core::GateRule& rule) {
  gates::SlotCounters counters;
  counters.passed = rule.entry.port + 1;
  return counters;
}

const core::GateState kThrough = {rule(0, core::Direction::ingress),
                                  rule(1, core::Direction::egress)};

TEST(DeliveryFramesTest, AFrameThatLeavesIsCountedOnceWhereItLeaves) {
  EXPECT_EQ(delivery_frames(kThrough, {}, by_port).passed, 2U);
}

TEST(DeliveryFramesTest, WhereTheWayOutIsSharedItIsCountedWhereItCameIn) {
  EXPECT_EQ(delivery_frames(kThrough, {kThrough[1].entry}, by_port).passed, 1U);
}

TEST(DeliveryFramesTest, WhereAllIsSharedItIsCountedWhereItLeaves) {
  EXPECT_EQ(delivery_frames(kThrough, {kThrough[0].entry, kThrough[1].entry}, by_port).passed, 2U);
}

TEST(DeliveryFramesTest, WhatOnlyComesInIsCountedThere) {
  EXPECT_EQ(delivery_frames({kThrough[0]}, {}, by_port).passed, 1U);
}

TEST(DeliveryFramesTest, ASlotThatIsNotThereCountsNothing) {
  EXPECT_EQ(delivery_frames(kThrough, {}, [](const auto&) { return std::nullopt; }).passed, 0U);
}

TEST(DeliveryFramesTest, WhatIsCountedOnlyIsNotDroppedForItsExcess) {
  const auto counters = [](const core::GateRule&) {
    gates::SlotCounters out;
    out.excess = 3;
    out.would_exceed = 4;
    out.last_reason = core::FrameReason::excess;
    return std::optional(out);
  };
  core::GateState rules = {rule(0, core::Direction::ingress)};
  EXPECT_EQ(delivery_frames(rules, {}, counters).excess, 7U);
  EXPECT_EQ(delivery_frames(rules, {}, counters).excess_dropped, 3U);
  EXPECT_TRUE(delivery_frames(rules, {}, counters).last_reason.has_value());
  rules[0].policing.counts_only = true;
  EXPECT_EQ(delivery_frames(rules, {}, counters).excess_dropped, 0U);
}

}  // namespace
}  // namespace mlcca
