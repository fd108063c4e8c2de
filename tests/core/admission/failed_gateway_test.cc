// SPDX-License-Identifier: BSD-2-Clause
// Gateways that announce themselves and fail: others take their place where there is another way.
#include <gtest/gtest.h>

#include <optional>
#include <utility>

#include "core/admission/state.hpp"
#include "core/model/presence.hpp"
#include "tests/core/design/inspected.hpp"

namespace mlcca::core::testing {
namespace {

constexpr std::size_t kFirst = 0;
constexpr std::size_t kNext = 1;

/// From the second bus to the robot's over either of two gateways, which announce themselves.
System announced() {
  System system = described(0);
  system.gateways[kFirst].presence = 500 * kMs;
  system.gateways.push_back(system.gateways[kFirst]);
  system.gateways[kNext].name = "next";
  return system;
}

/// The gateway of the one delivery that is granted; none: nothing is.
std::optional<std::size_t> granted_over(const State& state) {
  for (const Verdict& v : state.decisions()[0].verdicts)
    if (v.granted)
      for (const Place place : hops_of(v.route))
        if (place.kind == Place::Kind::gateway) return place.index;
  return std::nullopt;
}

void set_failed(State& state, std::size_t gateway, bool failed) {
  state.set_failed(gateway, failed);
  static_cast<void>(state.settle());
}

TEST(FailedGatewayTest, TheNextWayIsTakenUntilTheFirstOneIsBack) {
  State state(announced());
  EXPECT_EQ(granted_over(state), kFirst);
  set_failed(state, kFirst, true);
  EXPECT_EQ(granted_over(state), kNext);
  set_failed(state, kFirst, false);
  EXPECT_EQ(granted_over(state), kFirst) << "all gateways decide alike, whatever was before";
}

TEST(FailedGatewayTest, WhereAllHaveFailedTheFirstWayStays) {
  State state(announced());
  set_failed(state, kNext, true);
  EXPECT_EQ(granted_over(state), kFirst);
  set_failed(state, kFirst, true);
  EXPECT_EQ(granted_over(state), kFirst);
}

TEST(FailedGatewayTest, TheOnlyWayStays) {
  System system = described(0);
  system.gateways[kFirst].presence = 500 * kMs;
  State state(std::move(system));
  set_failed(state, kFirst, true);
  EXPECT_EQ(granted_over(state), kFirst);
}

TEST(FailedGatewayTest, ADescribedRouteStays) {
  System system = announced();
  system.routes = {{{network(kSecondCan), gateway(kNext), network(kRobotCan)}, {}}};
  State state(std::move(system));
  set_failed(state, kNext, true);
  EXPECT_EQ(granted_over(state), kNext);
}

TEST(FailedGatewayTest, WhatIsAdmittedMeanwhileTakesTheNextWay) {
  System system = announced();
  const Subscriber there = system.subscribers.front();
  system.subscribers.clear();
  State state(std::move(system));
  set_failed(state, kFirst, true);
  Admission a;
  a.id = 1;
  a.channel = 0;
  a.subscriber = there;
  Proposal proposal = state.propose(std::move(a));
  std::move(proposal).accept();
  EXPECT_EQ(granted_over(state), kNext);
  set_failed(state, kFirst, false);
  EXPECT_EQ(granted_over(state), kFirst);
}

TEST(FailedGatewayTest, ReservationsAreThoseOfTheWayThatIsTaken) {
  State state(announced());
  const auto used = [&](std::size_t g) {
    return state.ledger().reserved(state.system().resource_of(gateway(g)));
  };
  const Value before = used(kFirst);
  set_failed(state, kFirst, true);
  EXPECT_EQ(used(kFirst), 0U);
  EXPECT_EQ(used(kNext), before);
}

TEST(PresenceTest, IsKnownOverNetworksOfBothThatHaveSubscriptions) {
  System system = announced();
  EXPECT_TRUE(presence_networks(system, kFirst, kNext).empty());
  system.networks[kRobotCan].subscriptions.accept = Subscribing::gateways;
  EXPECT_EQ(presence_networks(system, kFirst, kNext), std::vector<std::size_t>{kRobotCan});
  system.gateways[kNext].presence = 0;
  EXPECT_TRUE(presence_networks(system, kFirst, kNext).empty());
}

TEST(PresenceTest, LastsForThreeIntervalsAndTheGrace) {
  EXPECT_EQ(presence_lasts(500 * kMs, 2'000 * kMs), 3'500 * kMs);
  EXPECT_EQ(presence_lasts(500 * kMs, ~Value{0}), 1'500 * kMs + kLongestPresenceGrace);
}

}  // namespace
}  // namespace mlcca::core::testing
