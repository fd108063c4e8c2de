// SPDX-License-Identifier: BSD-2-Clause
// User-defined attributes over routes.
#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <vector>

#include "tests/core/design/inspected.hpp"

namespace mlcca::core::testing {
namespace {

struct UserCase {
  const char* name;
  Composition composition;
  Better better;
  std::vector<Value> networks;   ///< robot-can, second-can
  std::vector<Value> of_bridge;  ///< empty: it states nothing
  Value fits;                    ///< the hardest requirement that is fulfilled
  Value does_not;
  FindingId id;  ///< of that
};
void PrintTo(const UserCase& row, std::ostream* out) { *out << row.name; }

System with_user_attribute(const UserCase& row, Value required) {
  System system = described(0);
  UserAttribute attribute;
  attribute.name = "Own";
  attribute.composition = row.composition;
  attribute.better = row.better;
  system.user_attributes = {attribute};
  for (std::size_t n = 0; n < 2; ++n) system.networks[n].user = {{0, false, row.networks[n]}};
  for (const Value v : row.of_bridge) system.gateways[kBridge].user = {{0, false, v}};
  system.subscribers[0].user = {{0, false, required}};
  return system;
}

class UserAttributeTest : public ::testing::TestWithParam<UserCase> {};

TEST_P(UserAttributeTest, ComposesOverTheRoute) {
  const auto& row = GetParam();
  EXPECT_EQ(ids_of(inspect(with_user_attribute(row, row.fits))), Ids{});
  const Inspection result = inspect(with_user_attribute(row, row.does_not));
  EXPECT_EQ(ids_of(result), Ids{row.id});
  EXPECT_EQ(only(result).attribute, "Own");
  EXPECT_EQ(result.channels[0].outcome, Outcome::unfit);
}

INSTANTIATE_TEST_SUITE_P(
    Compositions, UserAttributeTest,
    ::testing::Values(
        UserCase{"Sum", Composition::sum, Better::smaller, {3, 4}, {5}, 12, 11, Id::route_unfit},
        UserCase{
            "Maximum", Composition::slowest, Better::smaller, {3, 7}, {2}, 7, 6, Id::hop_unfit},
        UserCase{"MaximumSilentGateway",
                 Composition::slowest,
                 Better::smaller,
                 {3, 7},
                 {},
                 7,
                 6,
                 Id::hop_unfit},
        UserCase{
            "Minimum", Composition::smallest, Better::larger, {9, 5}, {8}, 5, 6, Id::hop_unfit},
        UserCase{"MinimumSilentGateway",
                 Composition::smallest,
                 Better::larger,
                 {9, 5},
                 {},
                 5,
                 6,
                 Id::hop_unfit},
        // 1 - 0.9 * 0.9 = 0.19
        UserCase{"Survival",
                 Composition::survival,
                 Better::smaller,
                 {10 * kPercent, 10 * kPercent},
                 {0},
                 19 * kPercent,
                 19 * kPercent - 1,
                 Id::route_unfit}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(InspectTest, AGatewayThatStatesNothingGivesNothingThatAddsUp) {
  for (const auto composition : {Composition::sum, Composition::survival}) {
    const UserCase row{"", composition, Better::smaller, {1, 1}, {}, 0, 0, Id::hop_unfit};
    const Inspection result = inspect(with_user_attribute(row, 100));
    EXPECT_EQ(only(result).id, Id::hop_unfit);
    EXPECT_EQ(only(result).place, gateway(kBridge));
    EXPECT_EQ(only(result).provided, "not provided");
  }
}

TEST(InspectTest, ABestCaseOfAUserAttributeIsDecidedAtRunTime) {
  const UserCase row{"", Composition::sum, Better::smaller, {3, 4}, {5}, 0, 0, Id::hop_unfit};
  System system = with_user_attribute(row, 12);
  system.networks[kRobotCan].user[0].dynamic = true;
  EXPECT_EQ(ids_of(inspect(system)), Ids{Id::run_time});
  system.subscribers[0].user[0].value = 11;
  EXPECT_EQ(ids_of(inspect(system)), Ids{Id::route_unfit}) << "a best case can refute";
}

TEST(InspectTest, ThePublisherMayAskForAUserAttributeToo) {
  const UserCase row{"", Composition::sum, Better::smaller, {3, 4}, {5}, 0, 0, Id::hop_unfit};
  System system = with_user_attribute(row, 20);
  system.publishers[0].user = {{0, false, 11}};
  EXPECT_NE(only(inspect(system)).text.find("Own 11 required end to end by switch"),
            std::string::npos)
      << only(inspect(system)).text;
}

}  // namespace
}  // namespace mlcca::core::testing
