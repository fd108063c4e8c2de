// SPDX-License-Identifier: BSD-2-Clause
// User-defined attributes as part of a decision: which hops are asked, for whom, and what they give
// together.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

constexpr std::size_t kFar = 2;
constexpr std::size_t kBehind = 1;
constexpr Value kPercent = 10'000'000;  // of a loss, in 1e-9

UserAttribute attribute(const char* name, Composition composition, Better better) {
  UserAttribute a;
  a.name = name;
  a.composition = composition;
  a.better = better;
  return a;
}

/// From the second bus over the bridge to the robot's, and over another gateway to a far one.
System three_buses() {
  System system = robot(0);
  system.user_attributes = {attribute("Own", Composition::sum, Better::smaller)};
  system.networks.push_back(can_network("far-can"));
  Gateway behind = system.gateways[kBridge];
  behind.name = "behind";
  behind.ports[0].network = kRobotCan;
  behind.ports[1].network = kFar;
  system.gateways.push_back(behind);
  system.networks[kSecondCan].user = {{0, false, 3}};
  system.gateways[kBridge].user = {{0, false, 4}};
  system.networks[kRobotCan].user = {{0, false, 5}};
  system.gateways[kBehind].user = {{0, false, 10}};
  system.networks[kFar].user = {{0, false, 20}};
  return system;
}

const Verdict& towards(const State& state, Place place) {
  return *std::ranges::find(state.decisions()[0].verdicts, place, &Verdict::to);
}

std::vector<Row> user_rows(const Verdict& v, Against against) {
  std::vector<Row> rows;
  std::ranges::copy_if(v.rows, std::back_inserter(rows), [&](const Row& row) {
    return row.user != Row::kBuiltIn && row.against == against;
  });
  return rows;
}

TEST(UserAttributesTest, EachHopAndTheWholeWayAreHeldAgainstWhatIsAsked) {
  for (const Value asked : {12, 11}) {
    System system = three_buses();
    system.subscribers[0].user = {{0, false, asked}};
    const State state(std::move(system));
    const Verdict& v = only_verdict(state);
    EXPECT_EQ(v.granted, asked == 12);
    const auto hops = user_rows(v, Against::hop);
    ASSERT_EQ(hops.size(), 3U);
    const std::vector<std::pair<Place, Value>> expected = {
        {network(kSecondCan), 3}, {gateway(kBridge), 4}, {network(kRobotCan), 5}};
    for (std::size_t i = 0; i < hops.size(); ++i) {
      EXPECT_EQ(hops[i].place, expected[i].first);
      EXPECT_EQ(hops[i].comparison.provided, expected[i].second);
      EXPECT_EQ(hops[i].comparison.required, asked);
      EXPECT_EQ(hops[i].comparison.outcome, Outcome::fit);
    }
    const auto whole = user_rows(v, Against::end_to_end);
    ASSERT_EQ(whole.size(), 1U);
    EXPECT_EQ(whole[0].comparison.provided, 12U);
    EXPECT_EQ(whole[0].comparison.outcome, asked == 12 ? Outcome::fit : Outcome::unfit);
  }
}

TEST(UserAttributesTest, WhoAsksForNoneGetsNoRowsOfThem) {
  const State state(three_buses());
  EXPECT_TRUE(only_verdict(state).granted);
  EXPECT_TRUE(std::ranges::all_of(only_verdict(state).rows,
                                  [](const Row& row) { return row.user == Row::kBuiltIn; }));
}

/// Who asks on the robot's bus receives what goes on to the far one; who asks on the publisher's
/// own bus receives it whatever is decided.
TEST(UserAttributesTest, AnOverhearingSubscriberAsksForTheWayToItsNetwork) {
  for (const Value asked : {12, 11}) {
    System system = three_buses();
    system.subscribers.push_back(subscriber("far", network(kFar), heart_beat()));
    system.subscribers.push_back(subscriber("at home", network(kSecondCan), heart_beat()));
    system.subscribers[0].user = {{0, false, asked}};
    system.subscribers[2].user = {{0, false, 3}};
    const State state(std::move(system));
    const Verdict& far = towards(state, network(kFar));
    EXPECT_EQ(far.granted, asked == 12) << asked;
    const auto rows = user_rows(far, Against::overhearing);
    ASSERT_EQ(rows.size(), 1U);
    EXPECT_EQ(rows[0].place, network(kRobotCan));
    EXPECT_EQ(rows[0].comparison.provided, 12U) << "3 + 4 + 5, and nothing of what is behind";
    EXPECT_TRUE(user_rows(far, Against::end_to_end).empty()) << "it asks for nothing itself";
    EXPECT_TRUE(towards(state, network(kSecondCan)).granted);
  }
}

TEST(UserAttributesTest, AGatewayIsAskedForWhatItLimitsAndForWhatAddsUp) {
  System system = three_buses();
  system.user_attributes = {attribute("Limited", Composition::smallest, Better::larger),
                            attribute("Silent", Composition::smallest, Better::larger),
                            attribute("Sum", Composition::sum, Better::smaller)};
  const UserValues all = {{0, false, 9}, {1, false, 9}, {2, false, 1}};
  for (Network& n : system.networks) n.user = all;
  system.gateways[kBridge].user = {{0, false, 7}, {2, false, 1}};
  system.subscribers[0].user = {{0, false, 7}, {1, false, 9}, {2, false, 3}};
  const State state(system);
  EXPECT_TRUE(only_verdict(state).granted);
  const auto asked_of_bridge = [](const State& decided) {
    std::vector<std::uint32_t> asked;
    for (const Row& row : user_rows(only_verdict(decided), Against::hop))
      if (row.place == gateway(kBridge)) asked.push_back(row.user);
    return asked;
  };
  EXPECT_EQ(asked_of_bridge(state), (std::vector<std::uint32_t>{0, 2}));
  System silent = system;
  silent.networks[kRobotCan].user = {{0, false, 9}, {2, false, 1}};
  const State refused(std::move(silent));
  EXPECT_FALSE(only_verdict(refused).granted) << "the network states it not, either";
  EXPECT_EQ(asked_of_bridge(refused), (std::vector<std::uint32_t>{0, 2}))
      << "which is its own lack";

  system.subscribers[0].user[0].value = 8;
  EXPECT_FALSE(only_verdict(State(system)).granted) << "the gateway gives 7";
  system.subscribers[0].user[0].value = 7;
  system.gateways[kBridge].user = {{0, false, 7}};
  const State lacking(system);
  EXPECT_FALSE(only_verdict(lacking).granted) << "it states nothing that could be added";
}

/// Each frame may be lost: of an event of three frames with 10 % each, 27.1 % are.
TEST(UserAttributesTest, TheFramesOfAnEventCountOnTheHopThatFragmentsIt) {
  System system = three_buses();
  system.user_attributes = {attribute("Loss", Composition::survival, Better::smaller)};
  for (Network& n : system.networks) n.user = {{0, false, 0}};
  for (Gateway& g : system.gateways) g.user = {{0, false, 0}};
  system.networks[kRobotCan].user = {{0, false, 10 * kPercent}};
  system.publishers[0].attributes.set(Attribute::max_payload, 20);
  for (Network& n : system.networks) n.provision.set(Attribute::max_payload, 20);
  system.subscribers[0].user = {{0, false, 28 * kPercent}};
  const State state(std::move(system));
  const auto rows = user_rows(only_verdict(state), Against::hop);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].comparison.provided, 0U);
  EXPECT_EQ(rows[1].comparison.provided, 0U);
  EXPECT_EQ(rows[2].comparison.provided, 271'000'000U);
  EXPECT_EQ(rows[2].comparison.outcome, Outcome::fit);
}

TEST(UserAttributesTest, OfSeveralSubscribersInOnePlaceTheStricterCounts) {
  System system = three_buses();
  system.user_attributes.push_back(attribute("More", Composition::smallest, Better::larger));
  for (Network& n : system.networks) n.user.push_back({1, false, 6});
  system.subscribers.push_back(subscriber("second", network(kRobotCan), heart_beat()));
  system.subscribers.push_back(subscriber("third", network(kRobotCan), heart_beat()));
  system.publishers[0].user = {{0, false, 40}};
  system.subscribers[0].user = {{0, false, 30}};
  system.subscribers[1].user = {{0, false, 12}, {1, false, 5}};
  system.subscribers[2].user = {{1, false, 6}};
  const State state(system);
  EXPECT_EQ(only_verdict(state).user_requirement, (UserValues{{0, false, 12}, {1, false, 6}}));
  EXPECT_TRUE(only_verdict(state).granted);
  system.subscribers[2].user[0].value = 7;
  EXPECT_FALSE(only_verdict(State(system)).granted);
}

}  // namespace
}  // namespace mlcca::core::testing
