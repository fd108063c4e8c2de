// SPDX-License-Identifier: BSD-2-Clause
// Bindings whose tag the broker of a FAMOUSO bus deals at run time, and tags that it contradicts.
#include <gtest/gtest.h>

#include "core/admission/state.hpp"
#include "core/can/of_system.hpp"
#include "core/design/inspect.hpp"
#include "core/gates/control_traffic.hpp"
#include "core/model/text.hpp"
#include "tests/core/robot.hpp"

namespace mlcca::core {
namespace {

using namespace testing;

constexpr std::uint32_t kDealt = 0x3ffe;

/// The switch on the second bus, whose tag is unknown yet.
System untagged() {
  System system = robot(0);
  Binding& binding = system.networks[kSecondCan].bindings.at(0);
  binding.dynamic = true;
  binding.id = 0;
  return system;
}

Condition contradicted(const State& state) {
  Condition condition = state.world().conditions[kSecondCan];
  condition.contradicted = {{0, "the broker has dealt its tag to another"}};
  return condition;
}

TEST(Tags, NothingIsGrantedBeforeTheTagIsKnown) {
  const State state(untagged());
  EXPECT_EQ(only_verdict(state).obstacle, Obstacle::untagged);
  EXPECT_EQ(only_verdict(state).obstacle_at, network(kSecondCan));
  EXPECT_EQ(reason(state.system(), state.members(), only_verdict(state)),
            "waiting for its tag on second-can: the broker has not dealt it yet");
  for (const GateRule& rule : state.gate_state(kBridge)) {
    EXPECT_EQ(rule.entry.port, kRobotCan) << "no frame has no tag";
    EXPECT_FALSE(rule.pass);
  }
}

TEST(Tags, OnceItIsKnownTheChannelIsDecidedWithIt) {
  State state(untagged());
  FormerRules left{{0, state.gate_state(kBridge, 0)}};
  state.set_tag(kSecondCan, 0, kDealt);
  const auto changes = state.settle();
  ASSERT_TRUE(only_verdict(state).granted);
  const GateChanges gates = state.gate_changes(changes, kBridge, left);
  EXPECT_TRUE(gates.close.empty());
  ASSERT_EQ(gates.add.size(), 2U) << "what leaves says as what it came in";
  EXPECT_EQ(gates.add[1].entry.port, kSecondCan);
  EXPECT_EQ(gates.add[1].entry.id & 0x3fffU, kDealt);
}

TEST(Tags, OneThatMovesIsClosedBeforeTheOtherOpens) {
  State state(untagged());
  state.set_tag(kSecondCan, 0, kDealt);
  state.settle();
  const Condition usual = state.world().conditions[kSecondCan];
  state.set_condition(kSecondCan, contradicted(state));
  auto changes = state.settle();
  EXPECT_EQ(only_verdict(state).obstacle, Obstacle::contradicted);
  EXPECT_FALSE(state.gate_changes(changes, kBridge).close.empty());

  const FormerRules left{{0, state.gate_state(kBridge, 0)}};
  state.set_condition(kSecondCan, usual);
  state.set_tag(kSecondCan, 0, kDealt - 1);
  changes = state.settle();
  EXPECT_TRUE(only_verdict(state).granted);
  const GateChanges gates = state.gate_changes(changes, kBridge, left);
  EXPECT_EQ(gates.remove.at(1).id & 0x3fffU, kDealt);
  EXPECT_EQ(gates.add.at(1).entry.id & 0x3fffU, kDealt - 1);
}

TEST(Tags, AContradictionTakesAStatedTagsGrantAndItsEndGivesItBack) {
  State state(robot(0));
  const State before(robot(0));
  ASSERT_TRUE(only_verdict(state).granted);
  const Condition usual = state.world().conditions[kSecondCan];
  state.set_condition(kSecondCan, contradicted(state));
  state.settle();
  EXPECT_EQ(only_verdict(state).obstacle, Obstacle::contradicted);
  EXPECT_EQ(reason(state.system(), state.members(), only_verdict(state), "as it is"), "as it is");
  state.set_condition(kSecondCan, usual);
  state.settle();
  EXPECT_TRUE(only_verdict(state).granted);
  EXPECT_TRUE(state.ledger().same_promises(before.ledger()));
}

/// It disturbs others with the first identifier that it may have and waits with the last.
TEST(Tags, TheAnalysisTakesTheWorseOfAllThatItMayBe) {
  System system = untagged();
  Network& bus = system.networks[kSecondCan];
  const auto open = can::identifier_of(system.publishers[0], bus, bus.bindings[0], false);
  ASSERT_TRUE(open);
  EXPECT_EQ(open->last - open->id, 0x3fffU);
  bus.bindings[0].id = kDealt;
  const auto known = can::identifier_of(system.publishers[0], bus, bus.bindings[0], false);
  EXPECT_EQ(known->id, known->last);
  EXPECT_EQ(known->id & 0x3fffU, kDealt);
}

TEST(Tags, AtDesignTimeOneThatIsDealtIsDecidedAtRunTime) {
  const auto result = inspect(untagged());
  ASSERT_EQ(result.findings.size(), 1U);
  EXPECT_EQ(result.findings[0].id, FindingId::run_time);
  EXPECT_NE(result.findings[0].text.find("the tag on second-can"), std::string::npos)
      << result.findings[0].text;
}

TEST(Tags, WhoAsksForThemMaySendRequestsAndNothingElse) {
  System system = robot(0);
  const auto count = [&](std::optional<std::uint32_t> asker) {
    return control_rules(system, kBridge, asker).size();
  };
  const auto without = count({});
  EXPECT_EQ(count(4711), without) << "the gateway has no number";
  system.gateways[kBridge].ports[kSecondCan].node = 0x10;
  EXPECT_EQ(count(0), without) << "the control user may";
  ASSERT_EQ(count(4711), without + 1);
  for (const GateRule& rule : control_rules(system, kBridge, 4711))
    if (rule.entry.uid == 4711) {
      EXPECT_EQ(rule.entry.id & 0x3fffU, 2U);
      EXPECT_EQ(rule.entry.direction, Direction::egress);
    }
}

}  // namespace
}  // namespace mlcca::core
