// SPDX-License-Identifier: BSD-2-Clause
// The five checks on the cases that they are for, each bound from both sides.
#include "mlcca/check.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "mlcca/attribute_list.hpp"

namespace mlcca {
namespace {

const AttributeSet kSwitch = make_set<Period<50_ms>, Omission<2>>();

TEST(CheckLayerTest, EmergencySwitchPassesItsOwnBus) {
  const CheckResult check = check_layer(kSwitch, make_set<Period<10_ms>, Omission<2>>());
  EXPECT_EQ(check.outcome, Outcome::fit);
  EXPECT_EQ(check.count, 3);
}

TEST(CheckLayerTest, EmergencySwitchIsRefusedBehindTheBridgeWithItsMargin) {
  const CheckResult check = check_layer(kSwitch, make_set<Period<10_ms>, Omission<5>>());
  EXPECT_EQ(check.outcome, Outcome::unfit);
  const Comparison& row = check.rows[2];
  EXPECT_EQ(row.attribute, Attribute::omission);
  EXPECT_EQ(row.outcome, Outcome::unfit);
  EXPECT_EQ(row.required, 2U);
  EXPECT_EQ(row.provided, 5U);
  EXPECT_EQ(row.margin(), 3U);
}

TEST(CheckLayerTest, ImpliedDeadlineIsHeldAgainstTheLatency) {
  const AttributeSet required = make_set<Period<50_ms>>();
  EXPECT_EQ(check_layer(required, make_set<Period<50_ms>>()).outcome, Outcome::fit);
  EXPECT_EQ(check_layer(required, make_set<Period<50_ms>, Latency<50_ms>>()).outcome, Outcome::fit);
  const CheckResult late = check_layer(required, make_set<Period<10_ms>, Latency<51_ms>>());
  EXPECT_EQ(late.outcome, Outcome::unfit);
  EXPECT_EQ(late.rows[0].attribute, Attribute::deadline);
  EXPECT_EQ(late.rows[0].provided, count(51_ms));
  EXPECT_EQ(late.rows[0].margin(), count(1_ms));
}

TEST(CheckLayerTest, MaxPayloadIsTheSizeToBeCarried) {
  const AttributeSet required = make_set<MaxPayload<9_bytes>>();
  EXPECT_EQ(check_layer(required, make_set<MaxPayload<9_bytes>>()).outcome, Outcome::fit);
  EXPECT_EQ(check_layer(required, make_set<MaxPayload<8_bytes>>()).outcome, Outcome::unfit);
}

TEST(CheckLayerTest, DynamicProvisionIsDecidedAtRunTimeUnlessItRefutes) {
  AttributeSet mesh = make_set<Latency<1_ms>>();
  mesh.set(Attribute::bandwidth, count(24_Mbit_per_s), true);
  EXPECT_EQ(check_layer(make_set<Bandwidth<24_Mbit_per_s>, Latency<1_ms>>(), mesh).outcome,
            Outcome::run_time);
  EXPECT_EQ(check_layer(make_set<Bandwidth<25_Mbit_per_s>>(), mesh).outcome, Outcome::unfit);
  EXPECT_EQ(check_layer(make_set<Latency<1_ms>>(), mesh).outcome, Outcome::fit);
}

TEST(CheckLayerTest, DynamicMarksInARequirementMeanNothing) {
  const AttributeSet marked = AttributeSet().set(Attribute::omission, 2, true);
  EXPECT_EQ(check_layer(marked, make_set<Omission<2>>()).outcome, Outcome::fit);
  EXPECT_EQ(check_layer(marked, make_set<Omission<3>>()).outcome, Outcome::unfit);
}

TEST(CheckLayerTest, NothingRequiredIsFulfilledByAnything) {
  EXPECT_EQ(check_layer(AttributeSet(), AttributeSet()).outcome, Outcome::fit);
  EXPECT_EQ(check_layer(AttributeSet(), AttributeSet()).count, 0);
}

TEST(CheckRouteTest, EachHopFitsButTheRouteDoesNot) {
  const AttributeSet hop = make_set<Period<10_ms>, Latency<20_ms>, Omission<1>>();
  const std::array<Hop, 3> hops = {{{hop, 1, 1}, {hop, 2, 1}, {hop, 3, 1}}};
  EXPECT_EQ(check_layer(kSwitch, hop).outcome, Outcome::fit);
  EXPECT_EQ(check_route(kSwitch, hops.data(), 1).outcome, Outcome::fit);
  const CheckResult check = check_route(kSwitch, hops.data(), 3);
  EXPECT_EQ(check.outcome, Outcome::unfit);
  EXPECT_EQ(check.rows[0].provided, count(60_ms));
  EXPECT_EQ(check.rows[2].provided, 7U);
}

TEST(CheckRouteTest, SourceJitterCountsAgainstTheRequirement) {
  const Hop hop = {make_set<Jitter<3_ms>>(), 1, 1};
  const AttributeSet required = make_set<Jitter<5_ms>>();
  EXPECT_EQ(check_route(required, &hop, 1, count(2_ms)).outcome, Outcome::fit);
  EXPECT_EQ(check_route(required, &hop, 1, count(2_ms) + 1).outcome, Outcome::unfit);
}

TEST(CheckRouteTest, NoRouteOrOneTooLongIsUnfitEvenWhenNothingIsRequired) {
  const std::vector<Hop> hops(kMaxComposedHops + 1, Hop{make_set<Latency<1_ns>>(), 1, 1});
  EXPECT_EQ(check_route(AttributeSet(), hops.data(), 0).outcome, Outcome::unfit);
  EXPECT_EQ(check_route(AttributeSet(), hops.data(), kMaxComposedHops + 1).outcome, Outcome::unfit);
  EXPECT_EQ(check_route(AttributeSet(), hops.data(), kMaxComposedHops).outcome, Outcome::fit);
}

struct TrafficCase {
  const char* name;
  AttributeSet traffic;
  AttributeSet subscriber;
  Outcome outcome;
};

class CheckTrafficTest : public ::testing::TestWithParam<TrafficCase> {};

TEST_P(CheckTrafficTest, HoldsTheOfferAgainstTheSubscriber) {
  EXPECT_EQ(check_traffic(GetParam().traffic, GetParam().subscriber).outcome, GetParam().outcome);
}

// 8 bytes in 3 ns are 2666666666.67 bytes/s.
const AttributeSet kEightInThree = make_set<Period<3_ns>, MaxPayload<8_bytes>>();

INSTANTIATE_TEST_SUITE_P(
    Table, CheckTrafficTest,
    ::testing::Values(
        TrafficCase{"PeriodAsAsked", kSwitch, make_set<Period<50_ms>>(), Outcome::fit},
        TrafficCase{"PeriodTooLong", make_set<Period<51_ms>>(), kSwitch, Outcome::unfit},
        TrafficCase{"PeriodNotStated", make_set<MaxPayload<1_bytes>>(), kSwitch, Outcome::unfit},
        TrafficCase{"PayloadAccepted", make_set<MaxPayload<8_bytes>>(),
                    make_set<MaxPayload<8_bytes>>(), Outcome::fit},
        TrafficCase{"PayloadTooLarge", make_set<MaxPayload<9_bytes>>(),
                    make_set<MaxPayload<8_bytes>>(), Outcome::unfit},
        TrafficCase{"PayloadNotStated", kSwitch, make_set<MaxPayload<8_bytes>>(), Outcome::unfit},
        TrafficCase{"JitterAsAsked", make_set<Jitter<1_ms>>(), make_set<Jitter<1_ms>>(),
                    Outcome::fit},
        TrafficCase{"JitterTooLarge", make_set<Jitter<2_ms>>(), make_set<Jitter<1_ms>>(),
                    Outcome::unfit},
        TrafficCase{"JitterNotStatedIsUnknown", kSwitch, make_set<Jitter<1_ms>>(), Outcome::unfit},
        TrafficCase{"RateStated", make_set<Bandwidth<100_kB_per_s>>(),
                    make_set<Bandwidth<100_kB_per_s>>(), Outcome::fit},
        TrafficCase{"RateTooLow", make_set<Bandwidth<99_kB_per_s>>(),
                    make_set<Bandwidth<100_kB_per_s>>(), Outcome::unfit},
        TrafficCase{"RateOfPayloadAndPeriod", kEightInThree,
                    make_set<Bandwidth<2666666666_bytes_per_s>>(), Outcome::fit},
        TrafficCase{"RateIsRoundedDown", kEightInThree,
                    make_set<Bandwidth<2666666667_bytes_per_s>>(), Outcome::unfit},
        TrafficCase{"RateUnknown", make_set<MaxPayload<8_bytes>>(),
                    make_set<Bandwidth<1_bytes_per_s>>(), Outcome::unfit},
        TrafficCase{"PeriodOfZeroSaysNothingOfTheRate",
                    make_set<Period<0_ns>, MaxPayload<8_bytes>>(),
                    make_set<Bandwidth<1_bytes_per_s>>(), Outcome::unfit},
        TrafficCase{"BestCaseOfAnOffer", AttributeSet().set(Attribute::period, 1, true), kSwitch,
                    Outcome::run_time},
        TrafficCase{"BestCaseOfAPayload", AttributeSet().set(Attribute::max_payload, 8, true),
                    make_set<MaxPayload<8_bytes>>(), Outcome::run_time},
        TrafficCase{"WhatTheNetworkOwesIsNotAskedOfThePublisher", AttributeSet(),
                    make_set<Latency<1_ns>, Deadline<1_ns>, PacketLoss<0_ppb>, Omission<0>>(),
                    Outcome::fit}),
    [](const auto& row) { return row.param.name; });

TEST(CheckHopTest, AGatewayIsAskedForRatePeriodAndSizeOnlyIfItLimitsThem) {
  const AttributeSet required =
      make_set<Period<50_ms>, Bandwidth<1_kB_per_s>, MaxPayload<8_bytes>, Omission<2>>();
  Hop gateway = {make_set<Latency<1_ms>, Omission<0>>(), 0, 1, true};
  EXPECT_EQ(check_hop(required, gateway).outcome, Outcome::fit);
  gateway.provision.set(Attribute::max_payload, 7);
  EXPECT_EQ(check_hop(required, gateway).outcome, Outcome::unfit);
  gateway.gateway = false;
  gateway.provision.set(Attribute::max_payload, 8);
  EXPECT_EQ(check_hop(required, gateway).outcome, Outcome::unfit);
}

TEST(CheckHopTest, AGatewayThatDelaysTooLongIsUnfitWhateverItLimits) {
  const Hop slow = {make_set<Latency<51_ms>, Omission<0>>(), 0, 1, true};
  const CheckResult check = check_hop(kSwitch, slow);
  ASSERT_EQ(check.count, 2);
  EXPECT_EQ(check.rows[0].attribute, Attribute::deadline);
  EXPECT_EQ(check.rows[0].outcome, Outcome::unfit);
  const Hop silent = {make_set<Omission<0>>(), 0, 1, true};
  EXPECT_EQ(check_hop(kSwitch, silent).outcome, Outcome::unfit);
}

TEST(CheckHopTest, AHopOfSeveralFramesLosesMoreThanItsFrames) {
  const AttributeSet required = make_set<PacketLoss<10_percent>>();
  EXPECT_EQ(check_hop(required, {make_set<PacketLoss<10_percent>>(), 0, 1}).outcome, Outcome::fit);
  EXPECT_EQ(check_hop(required, {make_set<PacketLoss<10_percent>>(), 0, 2}).outcome,
            Outcome::unfit);
}

TEST(StrictestTest, TakesTheHarderValueOfEachAttribute) {
  const AttributeSet a = make_set<Latency<5_ms>, Bandwidth<1_kB_per_s>, Omission<1>>();
  const AttributeSet b = make_set<Latency<4_ms>, Bandwidth<2_kB_per_s>, MaxPayload<8_bytes>>();
  const AttributeSet both =
      make_set<Latency<4_ms>, Bandwidth<2_kB_per_s>, Omission<1>, MaxPayload<8_bytes>>();
  EXPECT_EQ(strictest(a, b), both);
  EXPECT_EQ(strictest(b, a), both);
}

TEST(StrictestTest, LenientDeadlineDoesNotReplaceTheOneThatAPeriodImplies) {
  const AttributeSet logger = make_set<Deadline<1_s>>();
  EXPECT_EQ(strictest(kSwitch, logger)[Attribute::deadline], count(50_ms));
  EXPECT_EQ(strictest(logger, kSwitch)[Attribute::deadline], count(50_ms));
}

TEST(StrictestTest, RequirementBetweenLeavesTheSourceOutOfWhatIsAsked) {
  const AttributeSet publisher =
      make_set<Jitter<1_ms>, MaxPayload<8_bytes>, Period<10_ms>, Omission<3>>();
  const AttributeSet subscriber =
      make_set<Jitter<5_ms>, MaxPayload<64_bytes>, Latency<20_ms>, Omission<4>>();
  EXPECT_EQ(requirement_between(publisher, subscriber),
            (make_set<Jitter<5_ms>, MaxPayload<8_bytes>, Period<10_ms>, Deadline<10_ms>,
                      Omission<3>, Latency<20_ms>>()));
  EXPECT_EQ(requirement_between(kSwitch, subscriber)[Attribute::max_payload], 64U);
  EXPECT_FALSE(requirement_between(publisher, AttributeSet()).has(Attribute::jitter));
}

TEST(CheckAllSubscribersTest, LenientLoggerDoesNotOpenTheWayThatTheMotorIsRefused) {
  const AttributeSet logger;
  const AttributeSet bridge = make_set<Period<10_ms>, Omission<5>>();
  const std::array<AttributeSet, 3> listeners = {logger, kSwitch, logger};
  EXPECT_EQ(check_subscribers(listeners.data(), 1, bridge).outcome, Outcome::fit);
  EXPECT_EQ(check_subscribers(listeners.data(), 2, bridge).outcome, Outcome::unfit);
  EXPECT_EQ(check_subscribers(listeners.data(), 3, bridge).outcome, Outcome::unfit);
  EXPECT_EQ(check_subscribers(listeners.data() + 2, 1, bridge).outcome, Outcome::fit);
}

TEST(CheckCapacityTest, LastByteFitsAndOneMoreDoesNot) {
  const AttributeSet provision = make_set<Bandwidth<1000_bytes_per_s>>();
  EXPECT_EQ(check_capacity(provision, 600, 400).outcome, Outcome::fit);
  EXPECT_EQ(check_capacity(provision, 600, 400).margin(), 0U);
  EXPECT_EQ(check_capacity(provision, 600, 401).outcome, Outcome::unfit);
  EXPECT_EQ(check_capacity(provision, 600, 403).margin(), 3U);
  EXPECT_EQ(check_capacity(provision, 1001, 0).outcome, Outcome::unfit);
  EXPECT_EQ(check_capacity(provision, 600, 390).margin(), 10U);
}

TEST(CheckCapacityTest, SumsThatOverflowDoNotFit) {
  const AttributeSet most = AttributeSet().set(Attribute::bandwidth, kUnbounded);
  EXPECT_EQ(check_capacity(most, kUnbounded - 1, 1).outcome, Outcome::fit);
  EXPECT_EQ(check_capacity(most, kUnbounded - 1, 2).outcome, Outcome::unfit);
  EXPECT_EQ(check_capacity(most, 0, kUnbounded - 1).outcome, Outcome::fit);
  EXPECT_EQ(check_capacity(most, 0, kUnbounded).outcome, Outcome::unfit);
}

TEST(CheckCapacityTest, BestCaseCanOnlyRefute) {
  const AttributeSet best = AttributeSet().set(Attribute::bandwidth, 1000, true);
  EXPECT_EQ(check_capacity(best, 600, 400).outcome, Outcome::run_time);
  EXPECT_EQ(check_capacity(best, 600, 401).outcome, Outcome::unfit);
}

TEST(CheckCapacityTest, NetworkWithoutBandwidthHasNoLedger) {
  const CapacityCheck check = check_capacity(make_set<Latency<1_ms>>(), 5, 7);
  EXPECT_FALSE(check.known);
  EXPECT_EQ(check.outcome, Outcome::fit);
  EXPECT_EQ(check.margin(), 0U);
}

TEST(DemandTest, IsTheLargerOfBandwidthAndPayloadPerPeriodRoundedUp) {
  Value demand = 4711;
  EXPECT_FALSE(demand_of(make_set<Period<1_ms>>(), &demand));
  EXPECT_FALSE(demand_of(make_set<MaxPayload<8_bytes>>(), &demand));
  EXPECT_EQ(demand, 4711U);
  EXPECT_TRUE(demand_of(make_set<Bandwidth<7_bytes_per_s>>(), &demand));
  EXPECT_EQ(demand, 7U);
  EXPECT_TRUE(demand_of(kEightInThree, &demand));
  EXPECT_EQ(demand, 2666666667U);
  AttributeSet both = kEightInThree;
  EXPECT_TRUE(demand_of(both.set(Attribute::bandwidth, count(2666666668_bytes_per_s)), &demand));
  EXPECT_EQ(demand, 2666666668U);
  EXPECT_TRUE(demand_of(both.set(Attribute::bandwidth, count(2666666666_bytes_per_s)), &demand));
  EXPECT_EQ(demand, 2666666667U);
}

TEST(DemandTest, HasNoBoundWithoutAPeriodOrOutsideTheRange) {
  Value demand = 0;
  EXPECT_TRUE(demand_of(make_set<MaxPayload<8_bytes>, Period<0_ns>>(), &demand));
  EXPECT_EQ(demand, kUnbounded);
  EXPECT_TRUE(demand_of(make_set<MaxPayload<Bytes(kUnbounded)>, Period<1_ms>>(), &demand));
  EXPECT_EQ(demand, kUnbounded);
}

TEST(ReactionTest, IsTheWholeSum) {
  AttributeSet route = make_set<Period<50_ms>, Omission<2>, Latency<4_ms>, Jitter<1_ms>>();
  EXPECT_EQ(worst_case_reaction(route), count(155_ms));
  EXPECT_EQ(worst_case_reaction(route.set(Attribute::omission, 0)), count(55_ms));
}

TEST(ReactionTest, TakesTheSafeSideForWhatIsNotStated) {
  const AttributeSet route = make_set<Period<50_ms>, Omission<2>, Latency<4_ms>>();
  EXPECT_EQ(worst_case_reaction(route), count(158_ms));
  EXPECT_EQ(worst_case_reaction(normalised_requirement(kSwitch)), count(250_ms));
  EXPECT_EQ(worst_case_reaction(kSwitch), kUnbounded);
  EXPECT_EQ(worst_case_reaction(AttributeSet(route).clear(Attribute::omission)), kUnbounded);
  EXPECT_EQ(worst_case_reaction(AttributeSet(route).clear(Attribute::period)), kUnbounded);
}

TEST(ReactionTest, Saturates) {
  AttributeSet silent = make_set<Period<1_ns>, Latency<0_ns>, Jitter<0_ns>>();
  EXPECT_EQ(worst_case_reaction(silent.set(Attribute::omission, kUnbounded)), kUnbounded);
  EXPECT_EQ(worst_case_reaction(silent.set(Attribute::omission, kUnbounded - 2)), kUnbounded - 1);
  EXPECT_EQ(worst_case_reaction(make_set<Period<1_ns>, Omission<0>,
                                         Latency<Nanoseconds(kUnbounded - 1)>, Jitter<9_ns>>()),
            kUnbounded);
}

}  // namespace
}  // namespace mlcca
