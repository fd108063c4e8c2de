// SPDX-License-Identifier: BSD-2-Clause
// Attribute sets at run time: which one a channel is in, what it reserves, what its gates hold.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "core/admission/state.hpp"
#include "core/gates/plan.hpp"
#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

constexpr Value kHighRate = 400'000;
constexpr Value kLowRate = 100'000;

AttributeSet video(Value rate) {
  return AttributeSet{}.set(Attribute::bandwidth, rate).set(Attribute::max_payload, 8);
}

/// The paper's video over the bridge: preferred with the high rate, else with the low one.
System with_video(Value rate_of_second_can) {
  System system = robot(0);
  system.networks[kRobotCan].provision.set(Attribute::bandwidth, 2 * kHighRate);
  system.networks[kSecondCan].provision.set(Attribute::bandwidth, rate_of_second_can);
  EventChannel& channel = system.channels[0];
  channel.priority = 2;
  channel.attributes = video(kHighRate);
  channel.lower = {{1, video(kLowRate), {}}};
  system.publishers[0].attributes = video(kHighRate);
  system.publishers[0].lower = channel.lower;
  system.subscribers[0].attributes = video(kHighRate);
  system.subscribers[0].lower = channel.lower;
  return system;
}

TEST(SetsTest, ThePreferredSetIsUsedWhereItFits) {
  const State state(with_video(kHighRate));
  EXPECT_TRUE(only_verdict(state).granted);
  EXPECT_EQ(only_verdict(state).set, 0U);
  EXPECT_EQ(state.ledger().reserved(kSecondCan), kHighRate);
}

TEST(SetsTest, TheLowerSetIsUsedAndReservedWhereOnlyThatFits) {
  const State state(with_video(kHighRate - 1));
  EXPECT_TRUE(only_verdict(state).granted);
  EXPECT_EQ(only_verdict(state).set, 1U);
  EXPECT_EQ(state.ledger().reserved(kRobotCan), kLowRate);
  EXPECT_EQ(state.ledger().reserved(kSecondCan), kLowRate);
}

TEST(SetsTest, WhereNoSetFitsThePreferredOneSaysWhyAndNothingIsReserved) {
  const State state(with_video(kLowRate - 1));
  EXPECT_FALSE(only_verdict(state).granted);
  EXPECT_EQ(only_verdict(state).set, 0U);
  EXPECT_EQ(state.ledger().reserved(kRobotCan), 0U);
  EXPECT_EQ(state.ledger().reserved(kSecondCan), 0U);
}

TEST(SetsTest, OneListenerThatNoSetServesDoesNotPullTheOthersDown) {
  System system = with_video(kHighRate);
  Subscriber strict =
      subscriber("strict", network(kSecondCan), video(kHighRate).set(Attribute::latency, 1));
  strict.lower = {{1, video(kLowRate).set(Attribute::latency, 1), {}}};
  system.subscribers.push_back(strict);
  const State state(std::move(system));
  const auto& verdicts = state.decisions()[0].verdicts;
  ASSERT_EQ(verdicts.size(), 2U);
  EXPECT_EQ(std::ranges::count_if(verdicts, &Verdict::granted), 1);
  for (const Verdict& v : verdicts) EXPECT_EQ(v.set, 0U);
  // What was tried in the lower set has left no trace.
  EXPECT_EQ(state.ledger().reserved(kRobotCan), kHighRate);
}

TEST(SetsTest, TheGateHoldsTheLengthOfTheSetThatIsUsed) {
  System system = with_video(kLowRate);
  for (auto* lower : {&system.publishers[0].lower, &system.subscribers[0].lower})
    lower->front().attributes.set(Attribute::max_payload, 3);
  const State state(std::move(system));
  ASSERT_EQ(only_verdict(state).set, 1U);
  const GateState gates = state.gate_state(kBridge);
  ASSERT_FALSE(gates.empty());
  for (const GateRule& rule : gates) EXPECT_EQ(rule.entry.max_length, 3);
}

TEST(SetsTest, ANewcomerMayBringTheChannelToALowerSet) {
  System system = with_video(kHighRate);
  const Publisher publisher = std::exchange(system.publishers, {}).front();
  system.networks[kRobotCan].provision.set(Attribute::bandwidth, kLowRate);
  State state(std::move(system));
  Admission admission;
  admission.id = 7;
  admission.publisher = publisher;
  auto proposal = state.propose(admission);
  EXPECT_TRUE(proposal.fit());
  EXPECT_EQ(proposal.verdicts().at(0)->set, 1U);
  std::move(proposal).accept();
  EXPECT_EQ(state.ledger().reserved(kRobotCan), kLowRate);
  EXPECT_TRUE(state.remove(7));
  state.settle();
  EXPECT_EQ(state.ledger().reserved(kRobotCan), 0U);
}

TEST(SetsTest, ADeclaredRouteIsTheOnlyOne) {
  System system = robot(0);
  Gateway slow = system.gateways[kBridge];
  slow.name = "slow";
  slow.provision.set(Attribute::omission, 5);
  system.gateways.push_back(slow);
  system.routes.push_back({{network(kRobotCan), gateway(1), network(kSecondCan)}, {}});
  const State state(std::move(system));
  EXPECT_FALSE(only_verdict(state).granted);
  EXPECT_EQ(only_verdict(state).route,
            (Route{network(kSecondCan), gateway(1), network(kRobotCan)}));
}

}  // namespace
}  // namespace mlcca::core::testing
