// SPDX-License-Identifier: BSD-2-Clause
// Channels that are not described: what a network does not allow is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "core/model/text.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
#include "tests/core/robot.hpp"

namespace mlcca {
namespace {

using core::testing::kBridge;
using core::testing::kEtag;
using core::testing::kMs;
using core::testing::kRobotCan;
using core::testing::kSecondCan;
using core::testing::robot;

constexpr core::Subject kPrefix = 0x5600000000000000;

core::System allowing(std::uint32_t most = 16) {
  core::System system = robot(0);
  for (core::Network& network : system.networks)
    network.unlisted = {.allowed = true, .subject = kPrefix, .bits = 8, .most = most};
  return system;
}

/// From the second bus to the robot's.
control::ChannelRequest wanted(const std::string& subject = "0x5600000000000001",
                               std::uint32_t etag = 0x70) {
  control::ChannelRequest request;
  request.channel = subject;
  request.unlisted = true;
  request.from = "second-can";
  request.to = "robot-can";
  request.node = 9;
  request.offered = {{.name = "Period", .value = 50 * kMs, .unit = "ns", .dynamic = false},
                     {.name = "MaxPayload", .value = 8, .unit = "bytes", .dynamic = false}};
  request.identifiers = {{.network = "second-can", .id = etag, .extended = false},
                         {.network = "robot-can", .id = etag + 1, .extended = false}};
  return request;
}

/// One more subscriber of that channel.
control::ChannelRequest a_logger() {
  control::ChannelRequest request;
  request.channel = "0x5600000000000001";
  request.unlisted = true;
  request.to = "robot-can";
  request.subscriber = "logger";
  return request;
}

/// "granted", or why not.
std::string admit(core::State& state, const control::ChannelRequest& request,
                  core::AdmissionId id = 1) {
  if (const auto listed = list(state, request); !listed) return listed.error().text;
  const auto asked = understand(state, request, id);
  if (!asked) return asked.error().text;
  core::Proposal proposal = state.propose(*asked->admission);
  if (proposal.verdicts().empty()) return "no endpoint is there";
  const std::string why =
      core::reason(state.system(), state.members(), *proposal.verdicts().front(), {});
  if (!proposal.fit()) return why;
  std::move(proposal).accept();
  return "granted";
}

std::string answer_to(core::System system, const control::ChannelRequest& request) {
  core::State state(std::move(system));
  return admit(state, request);
}

TEST(Unlisted, IsRefusedWhereNothingIsSaid) {
  EXPECT_EQ(answer_to(robot(0), wanted()),
            "second-can admits no channel 0x5600000000000001 that is not described: its Unlisted "
            "would have to allow it");
}

TEST(Unlisted, IsGrantedWhereEveryNetworkAllowsItAndHasAnIdentifier) {
  core::State state(allowing());
  EXPECT_EQ(admit(state, wanted()), "granted");
  const auto channel = state.find_channel("0x5600000000000001");
  ASSERT_TRUE(channel);
  const auto rules = state.gate_state(kBridge, *channel);
  ASSERT_EQ(rules.size(), 2U);
  for (const core::GateRule& rule : rules) {
    EXPECT_TRUE(rule.pass);
    EXPECT_EQ(rule.entry.id & 0x3fffU,
              rule.entry.direction == core::Direction::ingress ? 0x70U : 0x71U);
    const bool policed = rule.policing.per_frame + rule.policing.per_byte != 0;
    EXPECT_EQ(policed, rule.entry.direction == core::Direction::ingress) << "no sender sends more";
  }
}

TEST(Unlisted, EveryNetworkIsAsked) {
  for (const std::size_t n : {kRobotCan, kSecondCan}) {
    core::System system = allowing();
    system.networks[n].unlisted = {};
    EXPECT_EQ(answer_to(system, wanted()),
              system.networks[n].name +
                  " admits no channel 0x5600000000000001 that is not described: its Unlisted "
                  "would have to allow it");
  }
}

/// A network in the middle has no say in the request.
TEST(Unlisted, AWayThroughANetworkThatDoesNotAllowItIsRefused) {
  core::System system = allowing();
  core::Network middle = core::testing::can_network("middle");
  middle.bindings.clear();
  system.networks.push_back(middle);
  core::Gateway other = system.gateways[0];
  system.gateways[0].ports[kRobotCan].network = 2;
  other.name = "other";
  other.ports[kSecondCan].network = 2;
  system.gateways.push_back(other);
  EXPECT_EQ(answer_to(system, wanted()),
            "middle admits no channel 0x5600000000000001 that is not described: its Unlisted "
            "would have to allow it");
}

TEST(Unlisted, OtherSubjectsAreRefused) {
  EXPECT_NE(answer_to(allowing(), wanted("0x5700000000000001")), "granted");
  EXPECT_EQ(answer_to(allowing(), wanted("0x56ffffffffffffff")), "granted");
  EXPECT_EQ(answer_to(allowing(), wanted("0x0")),
            "subject 0 is not valid: a channel has another one");
  EXPECT_EQ(answer_to(allowing(), wanted("sonar")),
            "'sonar' is no subject: 0x and up to 16 hexadecimal digits");
  core::System any = robot(0);
  for (core::Network& network : any.networks) network.unlisted.allowed = true;
  EXPECT_EQ(answer_to(any, wanted("0x1")), "granted");
  EXPECT_EQ(answer_to(any, wanted(core::format_subject(core::testing::kEmergency))),
            core::format_subject(core::testing::kEmergency) +
                " is described as channel emergency-switch: name that");
}

TEST(Unlisted, AnIdentifierIsGivenAndIsItsOwn) {
  auto request = wanted();
  request.identifiers.pop_back();
  EXPECT_EQ(answer_to(allowing(), request), "the channel has no identifier on robot-can");
  EXPECT_EQ(answer_to(allowing(), wanted("0x5600000000000001", kEtag - 1)),
            "identifier 0x63 is not right on second-can: 0x64 to 0x3fff");
  request = wanted();
  request.identifiers[0].id = kEtag;
  EXPECT_EQ(answer_to(allowing(), request),
            "identifier 0x64 on second-can is channel emergency-switch's: choose another");
  core::System subscribing = allowing();
  subscribing.networks[kSecondCan].subscribe_tag = 0x70;
  EXPECT_EQ(answer_to(subscribing, wanted()),
            "identifier 0x70 on second-can is that of SUBSCRIB: choose another");
  core::State state(allowing());
  EXPECT_EQ(admit(state, wanted()), "granted");
  EXPECT_EQ(admit(state, wanted("0x5600000000000002"), 2),
            "identifier 0x70 on second-can is channel 0x5600000000000001's: choose another");
  EXPECT_EQ(admit(state, wanted("0x5600000000000002", 0x72), 2), "granted");
  request = wanted("0x5600000000000002", 0x80);
  request.publisher = "other";
  EXPECT_EQ(admit(state, request, 3),
            "channel 0x5600000000000002 is admitted on second-can with another identifier");
}

TEST(Unlisted, ItsTrafficIsStated) {
  auto request = wanted();
  request.offered.pop_back();
  EXPECT_EQ(answer_to(allowing(), request),
            "a channel that is not described needs the traffic of its publisher: offer Period and "
            "MaxPayload, or Bandwidth");
}

TEST(Unlisted, CapacityCountsAsForEveryChannel) {
  auto request = wanted();
  request.offered[0].value = kMs / 2;
  EXPECT_NE(answer_to(allowing(), request), "granted");
}

TEST(Unlisted, ThereAreNoMoreThanANetworkAllows) {
  core::State state(allowing(1));
  EXPECT_EQ(admit(state, wanted()), "granted");
  const auto other = wanted("0x5600000000000002", 0x80);
  EXPECT_EQ(admit(state, other, 2),
            "robot-can has 1 channel that is not described, and its Unlisted allows no more");
  ASSERT_TRUE(state.remove(1));
  state.settle();
  EXPECT_EQ(admit(state, other, 2), "granted");
  EXPECT_EQ(admit(state, wanted(), 3),
            "robot-can has 1 channel that is not described, and its Unlisted allows no more");
  EXPECT_EQ(state.granted(), 2U) << "and the one that is described";
}

TEST(Unlisted, WhatIsLeftIsFreeForOthers) {
  core::State state(allowing());
  for (core::AdmissionId id = 1; id <= 100; ++id) {
    const auto subject = core::format_subject(kPrefix + id);
    ASSERT_EQ(admit(state, wanted(subject), id), "granted") << id;
    ASSERT_TRUE(state.remove(id));
    state.settle();
  }
  EXPECT_EQ(admit(state, wanted("0x56000000000000ff"), 101), "granted") << "the same identifiers";
  for (const core::Network& network : state.system().networks)
    EXPECT_LE(network.bindings.size(), 17U) << "and unused ones go";
}

TEST(Unlisted, AnIdentifierIsFreeOnceNoChannelUsesIt) {
  core::State state(allowing());
  EXPECT_EQ(admit(state, wanted("0x5600000000000001", 0x80), 1), "granted");
  EXPECT_EQ(admit(state, wanted("0x5600000000000002", 0x70), 2), "granted");
  for (const core::AdmissionId id : {1, 2}) {
    ASSERT_TRUE(state.remove(id));
    state.settle();
  }
  EXPECT_EQ(admit(state, wanted("0x5600000000000003", 0x70), 3), "granted");
}

TEST(Unlisted, ASecondSubscriberJoins) {
  core::State state(allowing());
  EXPECT_EQ(admit(state, wanted()), "granted");
  EXPECT_EQ(admit(state, a_logger(), 2), "granted");
}

/// Whom its publisher has left waits for another one.
TEST(Unlisted, AChannelThatOnlyASubscriberIsLeftOfIsKept) {
  core::State state(allowing());
  ASSERT_EQ(admit(state, wanted(), 1), "granted");
  ASSERT_EQ(admit(state, a_logger(), 2), "granted");
  ASSERT_TRUE(state.remove(1));
  state.settle();
  ASSERT_EQ(admit(state, wanted("0x5600000000000002", 0x90), 3), "granted");
  EXPECT_TRUE(state.find_channel("0x5600000000000001"));
}

TEST(Unlisted, IdentifiersBelongToSuchChannelsOnly) {
  auto request = wanted("emergency-switch");
  request.unlisted = false;
  EXPECT_EQ(answer_to(allowing(), request),
            "identifiers of a channel are described, except for one that is not described");
}

}  // namespace
}  // namespace mlcca
