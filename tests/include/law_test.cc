// SPDX-License-Identifier: BSD-2-Clause
// Laws of the checks on random worlds: better provisions and milder requirements never turn an
// answer for the worse, nothing unknown is granted, a best case never grants.
#include <gtest/gtest.h>

#include <vector>

#include "mlcca/mlcca.hpp"
#include "random_world.hpp"

namespace mlcca {
namespace {

using testing::RandomWorld;

constexpr int kRounds = 20000;

/// unfit < run_time < fit.
int rank(Outcome outcome) {
  if (outcome == Outcome::unfit) return 0;
  return outcome == Outcome::run_time ? 1 : 2;
}

Outcome outcome_of(const AttributeSet& requirement, const std::vector<Hop>& hops, Value jitter) {
  return check_route(requirement, hops.data(), hops.size(), jitter).outcome;
}

/// A requirement that the route meets exactly in many attributes, so that answers are close.
AttributeSet near(RandomWorld& world, const std::vector<Hop>& hops, Value jitter) {
  const AttributeSet provision = compose(hops.data(), hops.size(), jitter);
  AttributeSet requirement;
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    const Attribute source = held_against(a);
    if (!provision.has(source) || world.one_in(3)) continue;
    requirement.set(a, provision[source]);
    if (world.one_in(9)) requirement.set(a, world.better(a, provision[source]));
  }
  return requirement;
}

std::size_t improve(RandomWorld& world, std::vector<Hop>& hops) {
  Hop& hop = hops[world.below(hops.size())];
  const Attribute a = attribute_at(world.below(kAttributes));
  if (hop.provision.has(a))
    hop.provision.set(a, world.better(a, hop.provision[a]),
                      hop.provision.is_dynamic(a) && world.one_in(2));
  if (hop.frames > 1 && world.one_in(4)) hop.frames = 1;
  return index_of(a);
}

TEST(LawTest, BetterProvisionNeverTurnsAnAnswerForTheWorse) {
  RandomWorld world(11);
  int granted = 0;
  int turned = 0;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Hop> hops = world.route(1 + world.below(4), 30, 20);
    const Value jitter = world.small();
    const AttributeSet requirement = near(world, hops, jitter);
    const Outcome before = outcome_of(requirement, hops, jitter);
    for (std::uint64_t steps = 1 + world.below(4); steps != 0; --steps) improve(world, hops);
    const Outcome after = outcome_of(requirement, hops, jitter);
    ASSERT_GE(rank(after), rank(before)) << "round " << round;
    granted += before == Outcome::fit ? 1 : 0;
    turned += after != before ? 1 : 0;
  }
  EXPECT_GT(granted, kRounds / 20);
  EXPECT_GT(turned, kRounds / 100);
}

TEST(LawTest, HarderRequirementNeverTurnsAnAnswerForTheBetter) {
  RandomWorld world(12);
  int turned = 0;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Hop> hops = world.route(1 + world.below(4), 30, 20);
    const AttributeSet requirement = near(world, hops, 0);
    const AttributeSet other = world.one_in(2) ? world.set(2, 3) : near(world, hops, 0);
    const Outcome before = outcome_of(requirement, hops, 0);
    const Outcome after = outcome_of(strictest(requirement, other), hops, 0);
    ASSERT_LE(rank(after), rank(before)) << "round " << round;
    ASSERT_LE(rank(after), rank(outcome_of(other, hops, 0))) << "round " << round;
    turned += after != before ? 1 : 0;
  }
  EXPECT_GT(turned, kRounds / 100);
}

TEST(LawTest, EachHarderValueNeverTurnsAnAnswerForTheBetter) {
  RandomWorld world(13);
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Hop> hops = world.route(1 + world.below(3), 30, 20);
    AttributeSet requirement = near(world, hops, 0);
    const Outcome before = outcome_of(requirement, hops, 0);
    const Attribute a = attribute_at(world.below(kAttributes));
    if (!requirement.has(a)) continue;
    requirement.set(a, world.better(a, requirement[a]));
    ASSERT_LE(rank(outcome_of(requirement, hops, 0)), rank(before)) << "round " << round;
  }
}

TEST(LawTest, StrictestIsAUnionWhateverTheOrder) {
  RandomWorld world(14);
  for (int round = 0; round < kRounds; ++round) {
    const AttributeSet sets[] = {world.set(2, 3), world.set(2, 3), world.set(2, 3)};
    const AttributeSet& a = sets[0];
    const AttributeSet& b = sets[1];
    ASSERT_EQ(strictest(a, b), strictest(b, a));
    ASSERT_EQ(strictest(a, a), normalised_requirement(a));
    ASSERT_EQ(strictest(strictest(a, b), sets[2]), strictest(a, strictest(b, sets[2])));
    ASSERT_EQ(strictest_of(sets, 3), strictest(strictest(a, b), sets[2]));
  }
}

TEST(LawTest, OneMoreListenerNeverOpensANetwork) {
  RandomWorld world(15);
  for (int round = 0; round < kRounds; ++round) {
    const AttributeSet listeners[] = {world.set(3, 3), world.set(3, 3), world.set(3, 3)};
    const AttributeSet provision = world.set(12, 8);
    for (std::size_t n = 1; n <= 3; ++n) {
      const int all = rank(check_subscribers(listeners, n, provision).outcome);
      ASSERT_LE(all, rank(check_subscribers(listeners, n - 1, provision).outcome));
      for (std::size_t i = 0; i < n; ++i)
        ASSERT_LE(all, rank(check_layer(listeners[i], provision).outcome)) << "round " << round;
    }
  }
}

TEST(LawTest, OneMoreHopNeverHelps) {
  RandomWorld world(16);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Hop> hops = world.route(1 + world.below(4), 30, 20);
    const AttributeSet requirement = near(world, hops, 0);
    const Outcome before = outcome_of(requirement, hops, 0);
    hops.push_back(world.route(1, 30, 20).front());
    ASSERT_LE(rank(outcome_of(requirement, hops, 0)), rank(before)) << "round " << round;
  }
}

TEST(LawTest, MissingProvisionOfOneHopRefusesWhatIsRequired) {
  RandomWorld world(17);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Hop> hops = world.route(1 + world.below(4), RandomWorld::kNever, 4);
    const Attribute a = attribute_at(world.below(kAttributes));
    AttributeSet requirement = world.set(2, 4);
    requirement.set(a, world.value());
    AttributeSet& provision = hops[world.below(hops.size())].provision;
    provision.clear(held_against(a));
    if (held_against(a) == Attribute::latency) provision.clear(Attribute::period);
    ASSERT_EQ(outcome_of(requirement, hops, 0), Outcome::unfit) << "round " << round;
    ASSERT_EQ(check_layer(requirement, provision).outcome, Outcome::unfit) << "round " << round;
  }
}

TEST(LawTest, BestCaseOfOneHopNeverGrantsWhatIsRequired) {
  RandomWorld world(18);
  int open = 0;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Hop> hops =
        world.route(1 + world.below(4), RandomWorld::kNever, RandomWorld::kNever);
    const AttributeSet requirement = near(world, hops, 0);
    const Attribute a = attribute_at(world.below(kAttributes));
    if (!requirement.has(a)) continue;
    const Outcome before = outcome_of(requirement, hops, 0);
    AttributeSet& provision = hops[world.below(hops.size())].provision;
    const Attribute source = held_against(a);
    provision.set(source, provision[source], true);
    const Outcome after = outcome_of(requirement, hops, 0);
    ASSERT_EQ(after, before == Outcome::fit ? Outcome::run_time : Outcome::unfit);
    ASSERT_EQ(at_run_time(after), Outcome::unfit);
    open += after == Outcome::run_time ? 1 : 0;
  }
  EXPECT_GT(open, kRounds / 100);
}

TEST(LawTest, LayerCheckIsTheRouteCheckOfOneHop) {
  RandomWorld world(19);
  for (int round = 0; round < kRounds; ++round) {
    const AttributeSet requirement = world.set(3, 5);
    const Hop hop = {world.set(8, 5), 0, 1};
    const CheckResult layer = check_layer(requirement, hop.provision);
    const CheckResult route = check_route(requirement, &hop, 1);
    ASSERT_EQ(layer.outcome, route.outcome);
    ASSERT_EQ(layer.count, route.count);
    for (std::size_t i = 0; i < layer.count; ++i) {
      ASSERT_EQ(layer.rows[i].provided, route.rows[i].provided);
      ASSERT_EQ(layer.rows[i].outcome, route.rows[i].outcome);
    }
  }
}

TEST(LawTest, MoreCapacityOrLessLoadNeverTurnsAGrantIntoARefusal) {
  RandomWorld world(20);
  for (int round = 0; round < kRounds; ++round) {
    const Value capacity = world.value();
    const Value reserved = world.value() >> world.below(3);
    const Value demand = world.value() >> world.below(3);
    const auto outcome = [](Value c, Value r, Value d) {
      return rank(check_capacity(AttributeSet().set(Attribute::bandwidth, c), r, d).outcome);
    };
    const int before = outcome(capacity, reserved, demand);
    ASSERT_GE(outcome(world.better(Attribute::bandwidth, capacity), reserved, demand), before);
    ASSERT_GE(outcome(capacity, world.better(Attribute::latency, reserved), demand), before);
    ASSERT_GE(outcome(capacity, reserved, world.better(Attribute::latency, demand)), before);
  }
}

}  // namespace
}  // namespace mlcca
