// SPDX-License-Identifier: BSD-2-Clause
// The provision of a route: tables for each attribute, never better than exact arithmetic, and
// independent of the order of the hops.
#include "mlcca/compose.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "mlcca/attribute_list.hpp"
#include "natural.hpp"
#include "random_world.hpp"

namespace mlcca {
namespace {

using testing::Natural;
using testing::power;
using testing::quotient;
using testing::RandomWorld;

AttributeSet composed(const std::vector<Hop>& hops, Value source_jitter = 0) {
  return compose(hops.data(), hops.size(), source_jitter);
}

std::vector<Hop> with_values(Attribute a, const std::vector<Value>& values) {
  std::vector<Hop> hops;
  hops.reserve(values.size());
  for (const Value v : values) hops.push_back({AttributeSet().set(a, v), 1, 1});
  return hops;
}

Value composed_of(Attribute a, const std::vector<Value>& values) {
  return composed(with_values(a, values))[a];
}

TEST(ComposeTest, DelaysAddUpAndSaturate) {
  EXPECT_EQ(composed_of(Attribute::latency, {1, 2, 3}), 6U);
  EXPECT_EQ(composed_of(Attribute::latency, {kUnbounded - 3, 2}), kUnbounded - 1);
  EXPECT_EQ(composed_of(Attribute::latency, {kUnbounded - 3, 4}), kUnbounded);
  EXPECT_EQ(composed_of(Attribute::latency, {kUnbounded, 1, kUnbounded}), kUnbounded);
}

TEST(ComposeTest, SourceJitterIsAddedToJitterOnly) {
  const std::vector<Hop> hops = {{make_set<Latency<10_ns>, Jitter<3_ns>>(), 1, 1},
                                 {make_set<Latency<20_ns>, Jitter<4_ns>>(), 2, 1}};
  EXPECT_EQ(composed(hops, 5)[Attribute::jitter], 12U);
  EXPECT_EQ(composed(hops, 5)[Attribute::latency], 30U);
  EXPECT_EQ(composed(hops, kUnbounded)[Attribute::jitter], kUnbounded);
  EXPECT_FALSE(composed({{make_set<Latency<10_ns>>(), 1, 1}}, 5).has(Attribute::jitter));
}

TEST(ComposeTest, SlowestPeriodAndSmallestPayloadCount) {
  EXPECT_EQ(composed_of(Attribute::period, {10, 50, 20}), 50U);
  EXPECT_EQ(composed_of(Attribute::max_payload, {64, 8, 1400}), 8U);
}

TEST(ComposeTest, PeriodWithoutLatencyPromisesLatency) {
  const std::vector<Hop> hops = {{make_set<Period<10_ms>>(), 1, 1},
                                 {make_set<Period<20_ms>, Latency<3_ms>>(), 2, 1}};
  EXPECT_EQ(composed(hops)[Attribute::latency], count(13_ms));
  EXPECT_EQ(normalised_provision(make_set<Period<10_ms>>())[Attribute::latency], count(10_ms));
  EXPECT_EQ(normalised_provision(make_set<Period<10_ms>, Latency<3_ms>>())[Attribute::latency],
            count(3_ms));
}

TEST(ComposeTest, PeriodOfABestCasePromisesABestCaseOfLatency) {
  AttributeSet provision;
  provision.set(Attribute::period, count(10_ms), true);
  EXPECT_TRUE(normalised_provision(provision).is_dynamic(Attribute::latency));
  EXPECT_TRUE(composed({{provision, 1, 1}}).is_dynamic(Attribute::latency));
}

TEST(ComposeTest, PeriodicRequirementWithoutDeadlineImpliesIt) {
  EXPECT_EQ(normalised_requirement(make_set<Period<50_ms>>())[Attribute::deadline], count(50_ms));
  EXPECT_EQ(normalised_requirement(make_set<Period<50_ms>, Deadline<9_ms>>())[Attribute::deadline],
            count(9_ms));
  EXPECT_TRUE(normalised_requirement(AttributeSet()).empty());
  const AttributeSet marked = AttributeSet().set(Attribute::omission, 2, true);
  EXPECT_EQ(normalised_requirement(marked), make_set<Omission<2>>());
}

TEST(ComposeTest, NoHopProvidesADeadline) {
  EXPECT_TRUE(composed({{make_set<Deadline<1_ms>>(), 1, 1}}).empty());
  EXPECT_TRUE(normalised_provision(make_set<Deadline<1_ms>>()).empty());
}

TEST(ComposeTest, LinksOfOneMediumShareItsTime) {
  EXPECT_EQ(composed_of(Attribute::bandwidth, {3000000, 1375000}), 942857U);
  EXPECT_EQ(composed_of(Attribute::bandwidth, {100, 100}), 50U);
  EXPECT_EQ(composed_of(Attribute::bandwidth, {100, 0, 100}), 0U);
  EXPECT_EQ(composed_of(Attribute::bandwidth, {kUnbounded}), kUnbounded);
  EXPECT_EQ(composed_of(Attribute::bandwidth, {kUnbounded, kUnbounded}), kUnbounded / 2);
  EXPECT_EQ(composed_of(Attribute::bandwidth, {1, kUnbounded}), 0U);
}

TEST(ComposeTest, SlowestMediumLimitsTheRoute) {
  std::vector<Hop> hops = with_values(Attribute::bandwidth, {100, 60, 100});
  hops[1].medium = 2;
  EXPECT_EQ(composed(hops)[Attribute::bandwidth], 50U);
  hops[1].provision.set(Attribute::bandwidth, 40);
  EXPECT_EQ(composed(hops)[Attribute::bandwidth], 40U);
  hops[1].provision.set(Attribute::bandwidth, 0);
  EXPECT_EQ(composed(hops)[Attribute::bandwidth], 0U);
}

TEST(ComposeTest, RunsOfOmissionsMultiply) {
  EXPECT_EQ(composed_of(Attribute::omission, {2}), 2U);
  EXPECT_EQ(composed_of(Attribute::omission, {0, 2, 0}), 2U);
  EXPECT_EQ(composed_of(Attribute::omission, {1, 2, 3}), 23U);
  EXPECT_EQ(composed_of(Attribute::omission, {0, kUnbounded}), kUnbounded);
  // 4294967295 * 4294967297 = 2^64 - 1 runs of one event more: the largest result that fits.
  EXPECT_EQ(composed_of(Attribute::omission, {4294967294, 4294967296}), kUnbounded - 1);
  EXPECT_EQ(composed_of(Attribute::omission, {4294967295, 4294967295}), kUnbounded);
  EXPECT_EQ(composed_of(Attribute::omission, {4294967295, 4294967296}), kUnbounded);
}

TEST(ComposeTest, LostFramesBoundNoEventsOfSeveralFrames) {
  std::vector<Hop> hops = with_values(Attribute::omission, {1, 0});
  hops[1].frames = 2;
  EXPECT_EQ(composed(hops)[Attribute::omission], 1U);
  hops[0].frames = 2;
  EXPECT_EQ(composed(hops)[Attribute::omission], kUnbounded);
}

TEST(ComposeTest, UnknownNumberOfFramesIsTheWorst) {
  const Hop hop = {make_set<Omission<1>, PacketLoss<1_ppb>>(), 1, 0};
  EXPECT_EQ(composed({hop})[Attribute::omission], kUnbounded);
  EXPECT_EQ(composed({hop})[Attribute::packet_loss], kCertainLoss);
}

TEST(ComposeTest, LossIsRoundedUpOnce) {
  EXPECT_EQ(composed_of(Attribute::packet_loss, {100000000, 100000000}), 190000000U);
  EXPECT_EQ(composed_of(Attribute::packet_loss, {1, 1}), 2U);
  // Exact: 500000000.9999999995. Rounding after each hop would give 500000002.
  EXPECT_EQ(composed_of(Attribute::packet_loss, {1, 500000000, 1}), 500000001U);
  EXPECT_EQ(composed_of(Attribute::packet_loss, {500000000, 1, 1}), 500000001U);
}

TEST(ComposeTest, LossIsNeverMoreThanCertain) {
  EXPECT_EQ(composed_of(Attribute::packet_loss, {kCertainLoss}), kCertainLoss);
  EXPECT_EQ(composed_of(Attribute::packet_loss, {kCertainLoss + 1}), kCertainLoss);
  EXPECT_EQ(composed_of(Attribute::packet_loss, {kUnbounded, 0}), kCertainLoss);
  EXPECT_EQ(composed_of(Attribute::packet_loss, {kCertainLoss - 1}), kCertainLoss - 1);
  EXPECT_EQ(composed_of(Attribute::packet_loss, {kCertainLoss - 1, 1}), kCertainLoss);
  EXPECT_EQ(composed_of(Attribute::packet_loss, {0, 0}), 0U);
  EXPECT_EQ(normalised_provision(AttributeSet().set(Attribute::packet_loss, kUnbounded, true)),
            AttributeSet().set(Attribute::packet_loss, kCertainLoss, true));
}

TEST(ComposeTest, AttributeThatOneHopDoesNotStateIsNotStated) {
  RandomWorld world(4);
  for (int i = 0; i < 300; ++i) {
    std::vector<Hop> hops = world.route(1 + world.below(5), RandomWorld::kNever, 5);
    const Attribute a = attribute_at(world.below(kAttributes));
    ASSERT_EQ(composed(hops).has(a), a != Attribute::deadline);
    AttributeSet& provision = hops[world.below(hops.size())].provision;
    provision.clear(a);
    if (a == Attribute::latency) provision.clear(Attribute::period);
    ASSERT_FALSE(composed(hops).has(a));
  }
}

TEST(ComposeTest, BestCaseOfOneHopIsABestCaseOfTheRoute) {
  for (std::size_t dynamic = 0; dynamic < 3; ++dynamic) {
    std::vector<Hop> hops = with_values(Attribute::max_payload, {8, 64, 16});
    EXPECT_FALSE(composed(hops).is_dynamic(Attribute::max_payload));
    hops[dynamic].provision.set(Attribute::max_payload, 32, true);
    EXPECT_TRUE(composed(hops).is_dynamic(Attribute::max_payload));
  }
}

TEST(ComposeTest, RouteWithoutHopsOrWithTooManyProvidesNothing) {
  const std::vector<Hop> hops(kMaxComposedHops + 1, Hop{make_set<Latency<1_ns>>(), 1, 1});
  EXPECT_TRUE(compose(nullptr, 0).empty());
  EXPECT_TRUE(compose(hops.data(), kMaxComposedHops + 1).empty());
  EXPECT_EQ(compose(hops.data(), kMaxComposedHops)[Attribute::latency], kMaxComposedHops);
}

TEST(ComposeLawTest, OrderOfHopsDoesNotMatterBitForBit) {
  RandomWorld world(5);
  for (int round = 0; round < 400; ++round) {
    const std::vector<Hop> hops = world.route(1 + world.below(5), 20, 10);
    const AttributeSet expected = composed(hops, 7);
    std::vector<std::size_t> order(hops.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    do {
      std::vector<Hop> permuted;
      permuted.reserve(hops.size());
      for (const std::size_t i : order) permuted.push_back(hops[i]);
      ASSERT_EQ(composed(permuted, 7), expected) << "round " << round;
    } while (std::ranges::next_permutation(order).found);
  }
}

TEST(ComposeLawTest, SharedRateIsTheExactReciprocalSumRoundedDown) {
  RandomWorld world(6);
  for (int round = 0; round < 3000; ++round) {
    std::vector<Value> rates(1 + world.below(round % 10 == 0 ? kMaxComposedHops : 5));
    for (Value& rate : rates) rate = std::max<Value>(world.value(), 1);
    Natural product = 1;
    Natural sum = 0;
    for (const Value rate : rates) {
      sum = sum * rate + product;
      product = product * rate;
    }
    ASSERT_EQ(composed_of(Attribute::bandwidth, rates), quotient(product, sum))
        << ::testing::PrintToString(rates);
  }
}

TEST(ComposeLawTest, SharedRateOfTheLargestAndMostHopsIsExact) {
  for (std::size_t n = 1; n <= kMaxComposedHops; ++n) {
    EXPECT_EQ(composed_of(Attribute::bandwidth, std::vector<Value>(n, kUnbounded)), kUnbounded / n);
    EXPECT_EQ(composed_of(Attribute::bandwidth, std::vector<Value>(n, n)), 1U);
    EXPECT_EQ(composed_of(Attribute::bandwidth, std::vector<Value>(n, n - 1)), 0U);
  }
}

/// The loss of a route of single frames, exact and rounded up, in units of 1e-9.
Value exact_loss(const std::vector<Hop>& hops) {
  Natural survival = 1;
  Natural one = 1;
  for (const Hop& hop : hops) {
    const Value loss = std::min(hop.provision[Attribute::packet_loss], kCertainLoss);
    survival = survival * power(kCertainLoss - loss, hop.frames);
    one = one * power(kCertainLoss, hop.frames);
  }
  return kCertainLoss - quotient(survival * kCertainLoss, one);
}

TEST(ComposeLawTest, LossOfSingleFramesIsTheExactOneRoundedUp) {
  RandomWorld world(7);
  for (int round = 0; round < 3000; ++round) {
    std::vector<Hop> hops(1 + world.below(round % 10 == 0 ? kMaxComposedHops : 5));
    for (Hop& hop : hops) hop.provision.set(Attribute::packet_loss, world.loss());
    ASSERT_EQ(composed(hops)[Attribute::packet_loss], exact_loss(hops)) << "round " << round;
  }
}

TEST(ComposeLawTest, LossOfSeveralFramesIsNeverBelowTheExactOneAndAtMostOneUnitAbove) {
  RandomWorld world(8);
  for (int round = 0; round < 1000; ++round) {
    std::vector<Hop> hops(1 + world.below(round % 20 == 0 ? kMaxComposedHops : 4));
    for (Hop& hop : hops) {
      hop.frames = static_cast<std::uint16_t>(1 + world.below(12));
      hop.provision.set(Attribute::packet_loss, world.loss());
    }
    const Value exact = exact_loss(hops);
    ASSERT_GE(composed(hops)[Attribute::packet_loss], exact) << "round " << round;
    ASSERT_LE(composed(hops)[Attribute::packet_loss], exact + 1) << "round " << round;
  }
}

TEST(ComposeLawTest, LossOfTheMostFramesIsNeverBelowTheExactOne) {
  for (const Value loss : {Value{1}, Value{1000}, Value{15259}, Value{1000000}}) {
    const std::vector<Hop> hops = {{AttributeSet().set(Attribute::packet_loss, loss), 1, 4096}};
    const Value exact = exact_loss(hops);
    EXPECT_GE(composed(hops)[Attribute::packet_loss], exact);
    EXPECT_LE(composed(hops)[Attribute::packet_loss], exact + 1);
  }
}

TEST(ComposeTest, EventOfWhichHardlyAnythingSurvivesIsCertainlyLost) {
  // 0.5^29 = 1.86e-9 and 0.5^30 = 0.93e-9 lie on both sides of the smallest survival.
  EXPECT_EQ(composed({{make_set<PacketLoss<50_percent>>(), 1, 29}})[Attribute::packet_loss],
            kCertainLoss - 1);
  for (const unsigned frames : {30U, 40U, 59U, 60U, 65535U}) {
    const Hop most = {make_set<PacketLoss<50_percent>>(), 1, static_cast<std::uint16_t>(frames)};
    const Hop other = {make_set<PacketLoss<1_ppb>>(), 1, 1};
    EXPECT_EQ(composed({most})[Attribute::packet_loss], kCertainLoss) << frames;
    EXPECT_EQ(composed({most, other})[Attribute::packet_loss], kCertainLoss) << frames;
    EXPECT_EQ(composed({other, most})[Attribute::packet_loss], kCertainLoss) << frames;
  }
}

TEST(ComposeLawTest, SumsMaximaMinimaAndRunsAreExactOrSaturated) {
  RandomWorld world(9);
  for (int round = 0; round < 3000; ++round) {
    std::vector<Value> values(1 + world.below(5));
    for (Value& v : values) v = world.one_in(2) ? world.small() : world.value();
    Natural sum = 0;
    Natural runs = 1;
    for (const Value v : values) {
      sum = sum + v;
      runs = runs * (Natural(v) + 1);
    }
    ASSERT_EQ(composed_of(Attribute::latency, values), quotient(sum, 1));
    ASSERT_EQ(composed_of(Attribute::jitter, values), quotient(sum, 1));
    ASSERT_EQ(composed_of(Attribute::period, values), *std::ranges::max_element(values));
    ASSERT_EQ(composed_of(Attribute::max_payload, values), *std::ranges::min_element(values));
    const bool fits = runs <= Natural(kUnbounded);
    ASSERT_EQ(composed_of(Attribute::omission, values), fits ? quotient(runs, 1) - 1 : kUnbounded)
        << ::testing::PrintToString(values);
  }
}

TEST(ComposeGatewayTest, AGatewayLimitsWhatItSaysAndNothingElse) {
  const Hop network = {make_set<Bandwidth<9_kB_per_s>, MaxPayload<8_bytes>, Period<10_ms>>(), 1, 1};
  const AttributeSet through =
      composed({network, {make_set<Latency<1_ms>, Bandwidth<8_kB_per_s>>(), 2, 1, true}});
  EXPECT_EQ(through[Attribute::bandwidth], 8000U);
  EXPECT_EQ(through[Attribute::max_payload], 8U);
  EXPECT_EQ(through[Attribute::period], count(10_ms));
  EXPECT_EQ(through[Attribute::latency], count(11_ms));
  EXPECT_FALSE(through.has(Attribute::omission));
}

TEST(ComposeGatewayTest, NothingBoundsTheDelayOfAGatewayThatStatesNone) {
  const Hop network = {make_set<Latency<1_ms>>(), 1, 1};
  EXPECT_EQ(composed({network, {AttributeSet(), 2, 1, true}})[Attribute::latency], kUnbounded);
}

// The same folds serve what users define themselves.
TEST(ComposeValuesTest, EachCompositionFoldsTheValuesOfTheHops) {
  const HopValue hops[] = {{30, 1, 1}, {20, 1, 1}, {60, 2, 1}};
  EXPECT_EQ(compose_values(Composition::sum, hops, 3), 110U);
  EXPECT_EQ(compose_values(Composition::slowest, hops, 3), 60U);
  EXPECT_EQ(compose_values(Composition::smallest, hops, 3), 20U);
  EXPECT_EQ(compose_values(Composition::shared_medium, hops, 3), 12U);  // 1/(1/30 + 1/20) and 60
  EXPECT_EQ(compose_values(Composition::consecutive, hops, 3), 31U * 21U * 61U - 1U);
  EXPECT_EQ(compose_values(Composition::survival, hops, 3), 110U);  // rounded up once
  EXPECT_EQ(compose_values(Composition::not_provided, hops, 3), 0U);
}

}  // namespace
}  // namespace mlcca
