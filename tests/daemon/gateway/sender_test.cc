// SPDX-License-Identifier: BSD-2-Clause
#include <gtest/gtest.h>

#include <string>

#include "daemon/gateway/requests/parsed_request.hpp"
#include "tests/core/robot.hpp"

namespace mlcca {
namespace {

using core::testing::gateway;
using core::testing::kBridge;
using core::testing::kSecondCan;
using core::testing::robot;

/// A second publisher of the emergency switch, on the bus of the first one.
control::ChannelRequest twin() {
  control::ChannelRequest request;
  request.channel = "emergency-switch";
  request.from = "second-can";
  request.publisher = "twin";
  return request;
}

core::System raw_robot() {
  core::System system = robot(0);
  for (core::Network& network : system.networks) network.profile = core::Profile::raw;
  return system;
}

std::string answer_to(const core::System& system, const control::ChannelRequest& request) {
  const core::State state(system);
  const auto asked = understand(state, request, 1);
  return asked ? "understood" : asked.error().text;
}

TEST(SenderTest, RefusesAPublisherWhoseIdentifierIsTaken) {
  EXPECT_EQ(
      answer_to(raw_robot(), twin()),
      "nothing distinguishes it from publisher switch of channel emergency-switch: an identifier "
      "has one sender on a bus: describe one of them, or give its events a channel of their "
      "own");
}

TEST(SenderTest, ANodeDoesNotDistinguishPublishersWhereNoFrameNamesIt) {
  auto request = twin();
  request.node = 0x21;
  EXPECT_NE(answer_to(raw_robot(), request), "understood");
}

TEST(SenderTest, DistinguishesPublishersByTheirNodeWhereFramesNameIt) {
  auto request = twin();
  request.node = core::testing::kSwitchNode;
  EXPECT_EQ(answer_to(robot(0), request),
            "nothing distinguishes it from publisher switch of channel emergency-switch: give it a "
            "node of its own");
  request.node = core::testing::kSwitchNode + 1;
  EXPECT_EQ(answer_to(robot(0), request), "understood");
}

/// As it the gateway asks the broker for tags: two would send one identifier.
TEST(SenderTest, RefusesTheNodeOfAGatewayOnTheBus) {
  core::System system = robot(0);
  for (core::Port& port : system.gateways[kBridge].ports)
    if (port.network == kSecondCan) port.node = 9;
  auto request = twin();
  request.node = 9;
  EXPECT_EQ(answer_to(system, request), "node 9 on second-can is gateway bridge's: choose another");
  request.node = 10;
  EXPECT_EQ(answer_to(system, request), "understood");
}

TEST(SenderTest, AdmitsProgramsOfOneUserOneByOne) {
  core::System system = robot(0);
  core::Publisher panel;
  panel.name = "panel";
  panel.place = gateway(kBridge);
  panel.uid = 0;
  panel.node = 7;
  system.publishers.push_back(panel);
  auto request = twin();
  request.from = "bridge";
  request.user = "0";
  request.node = 7;
  EXPECT_EQ(answer_to(system, request), "understood");
}

/// Also against what was admitted before, not only against what is described.
TEST(SenderTest, RefusesATwinOfWhoWasAdmitted) {
  auto request = twin();
  request.node = core::testing::kSwitchNode + 1;
  core::State state(robot(0));
  const auto first = understand(state, request, 1);
  ASSERT_TRUE(first) << first.error().text;
  state.propose(*first->admission).accept();
  EXPECT_FALSE(understand(state, request, 2));
}

}  // namespace
}  // namespace mlcca
