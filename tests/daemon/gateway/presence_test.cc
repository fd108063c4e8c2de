// SPDX-License-Identifier: BSD-2-Clause
// Tests that one of several gateways that can replace each other forwards, whatever fails.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tests/daemon/gateway/presence_bench.hpp"

namespace mlcca::test::presence {
namespace {

TEST_F(PresenceTest, TheFirstOneForwardsWhileAllAreThere) {
  set_up(3);
  run(10'000 * kMs);
  EXPECT_EQ(forwarders(), "a");
  EXPECT_EQ(longest_several_, 0U);
  EXPECT_EQ(longest_none_, 0U);
}

TEST_F(PresenceTest, TheNextOneTakesOverWithinThreeIntervalsAndTheGraceAndGivesBack) {
  set_up(3);
  run(3'000 * kMs);
  nodes_[0]->kill();
  run(kGrace - 2 * kStep);
  EXPECT_EQ(forwarders(), "a") << "its gates are as they were, and nobody else forwards";
  run(kLasts - kGrace + 3 * kStep);
  EXPECT_EQ(forwarders(), "b");
  EXPECT_LE(longest_none_, 3 * kInterval + kStep);
  nodes_[0]->start();
  run(2 * kInterval);
  EXPECT_EQ(forwarders(), "a");
  EXPECT_LE(longest_several_, kInterval + kStep);
}

TEST_F(PresenceTest, WhoDoesNotAnnounceItselfLeavesForwardingToOthersBeforeTheyTakeIt) {
  set_up(2);
  run(3'000 * kMs);
  nodes_[0]->program = false;
  run(2 * kInterval + 10 * kStep);
  EXPECT_EQ(forwarders(), "");
  ASSERT_EQ(nodes_[0]->presence->problems().size(), 1U);
  EXPECT_EQ(nodes_[0]->presence->problems().front(),
            "gateway a leaves to others what they can forward: mlcca-famouso --subscriptions does "
            "not ask what to announce, so others may take its place");
  run(kLasts);
  EXPECT_EQ(forwarders(), "b");
  EXPECT_EQ(longest_several_, 0U);
  nodes_[0]->program = true;
  run(2 * kInterval);
  EXPECT_EQ(forwarders(), "a");
}

TEST_F(PresenceTest, TheLastOneForwardsAlsoWhenAllOthersAreGone) {
  set_up(2);
  run(3'000 * kMs);
  nodes_[0]->kill();
  run(2 * kLasts);
  EXPECT_EQ(forwarders(), "b");
  nodes_[1]->kill();
  nodes_[0]->start();
  run(2 * kLasts);
  EXPECT_EQ(forwarders(), "a");
}

TEST_F(PresenceTest, OneNetworkIsEnoughToBeThere) {
  set_up(2);
  run(3'000 * kMs);
  cut_[0][kEthernet] = true;
  run(2 * kLasts);
  EXPECT_EQ(forwarders(), "a") << "the buses still have its announcements";
  EXPECT_TRUE(nodes_[1]->presence->problems().empty());
}

TEST_F(PresenceTest, GatewaysThatAreCutOffFromEachOtherBothForward) {
  set_up(2);
  run(3'000 * kMs);
  cut_[0].assign(cut_[0].size(), true);
  run(2 * kLasts);
  EXPECT_EQ(forwarders(), "ab");
  cut_[0].assign(cut_[0].size(), false);
  run(kInterval + kStep);
  EXPECT_EQ(forwarders(), "a");
}

TEST_F(PresenceTest, WhoIsNotReceivedAnywhereGivesWay) {
  set_up(2);
  run(3'000 * kMs);
  // Messages of the first gateway do not reach the second one; those of the second one arrive.
  control::PresenceRequest from_b{.network = system_.networks[0].name,
                                  .gateway = "b",
                                  .lasts_ns = kLasts,
                                  .forwards = true,
                                  .not_received = {"a"}};
  ASSERT_TRUE(nodes_[0]->presence->receive(from_b));
  EXPECT_TRUE(nodes_[0]->presence->announce().forwards) << "it may not have received it yet";
  EXPECT_FALSE(nodes_[0]->presence->announce().forwards);
  nodes_[0]->act();
  EXPECT_FALSE(nodes_[0]->forwards());
  EXPECT_EQ(nodes_[0]->presence->problems().front(),
            "gateway a leaves to others what they can forward: b receives nothing of it, and "
            "forwards instead");
  EXPECT_FALSE(nodes_[0]->presence->announce().forwards);
  from_b.not_received.clear();
  ASSERT_TRUE(nodes_[0]->presence->receive(from_b));
  nodes_[0]->act();
  EXPECT_TRUE(nodes_[0]->forwards());
}

TEST_F(PresenceTest, WhoCannotForwardSaysSoAndTheNextOneDoesAtOnce) {
  set_up(2);
  run(3'000 * kMs);
  nodes_[0]->plug(1, false);
  run(kInterval + kStep);
  EXPECT_EQ(forwarders(), "b");
  EXPECT_EQ(nodes_[0]->presence->problems().front(),
            "gateway a leaves to others what they can forward: " + system_.networks[1].name +
                " is not available here");
  EXPECT_EQ(nodes_[1]->presence->problems().front(),
            "gateway a has failed: it says that it cannot forward");
  nodes_[0]->plug(1, true);
  run(kInterval + kStep);
  EXPECT_EQ(forwarders(), "a");
  // No gateway can forward, as it would be without a second gateway.
  nodes_[0]->plug(1, false);
  nodes_[1]->plug(1, false);
  run(kInterval + kStep);
  EXPECT_EQ(forwarders(), "");
  nodes_[0]->control().close_all();
  EXPECT_FALSE(nodes_[0]->presence->announce().forwards);
}

TEST_F(PresenceTest, WithoutItsRelayAGatewayLeavesWhatThatWouldCarry) {
  set_up(2);
  run(3'000 * kMs);
  nodes_[0]->relay(false);
  run(3'000 * kMs);
  EXPECT_EQ(forwarders(), "a") << "c0 goes from bus to bus, by can-gw";
  nodes_.clear();
  system_.subscribers[0].place = {core::Place::Kind::network, kEthernet};
  for (std::size_t g = 0; g < 2; ++g) nodes_.push_back(std::make_unique<Node>(system_, g, clock_));
  run(3'000 * kMs);
  EXPECT_EQ(forwarders(), "a");
  nodes_[0]->relay(false);
  run(2 * kInterval - kStep);
  EXPECT_EQ(forwarders(), "a") << "it may be starting again";
  run(3 * kInterval);
  EXPECT_EQ(forwarders(), "b");
  EXPECT_EQ(nodes_[0]->presence->problems().front(),
            "gateway a leaves to others what they can forward: mlcca-relay is not connected");
  nodes_[0]->relay(true);
  run(kInterval + kStep);
  EXPECT_EQ(forwarders(), "a");
}

TEST_F(PresenceTest, WhatWasKnownCountsWhileNothingIsAnnounced) {
  set_up(2);
  run(3'000 * kMs);
  nodes_[1]->kill();
  run(2 * kLasts);
  EXPECT_EQ(forwarders(), "a");
  nodes_[0]->program = false;
  run(2 * kLasts);
  EXPECT_EQ(forwarders(), "a") << "the other one was gone before";
}

TEST_F(PresenceTest, ANetworkThatComesBackHasATimeOfItsOwn) {
  set_up(2);
  run(3'000 * kMs);
  for (std::size_t n = 0; n < system_.networks.size(); ++n) nodes_[1]->plug(n, false);
  run(3 * kLasts);
  for (std::size_t n = 0; n < system_.networks.size(); ++n) nodes_[1]->plug(n, true);
  EXPECT_TRUE(nodes_[1]->presence->announce().not_received.empty());
  run(2 * kInterval);
  EXPECT_EQ(forwarders(), "a");
  EXPECT_EQ(longest_several_, 0U);
}

TEST_F(PresenceTest, OnlyGatewaysThatAnnounceThemselvesThereAreTaken) {
  set_up(2);
  const std::string bus = system_.networks[0].name;
  const auto receive = [&](const std::string& network, const std::string& gateway) {
    const auto taken = nodes_[0]->presence->receive(
        {.network = network, .gateway = gateway, .lasts_ns = kLasts, .forwards = true});
    return taken ? std::string() : taken.error().text;
  };
  EXPECT_EQ(receive(bus, "b"), "");
  EXPECT_EQ(receive(bus, "a"), "'a' is not described as another gateway");
  EXPECT_EQ(receive(bus, "z"), "'z' is not described as another gateway");
  EXPECT_EQ(receive("nowhere", "b"), "b does not announce itself to this gateway on 'nowhere'");
}

TEST_F(PresenceTest, TimesThatNoGatewayCanStateAreRefused) {
  set_up(2);
  const auto receive = [&](Value lasts) {
    return nodes_[0]
        ->presence
        ->receive({.network = system_.networks[0].name,
                   .gateway = "b",
                   .lasts_ns = lasts,
                   .forwards = true})
        .has_value();
  };
  EXPECT_FALSE(receive(0));
  EXPECT_FALSE(receive(3 * kInterval - 1));
  EXPECT_TRUE(receive(3 * kInterval));
  EXPECT_TRUE(receive(3 * kInterval + core::kLongestPresenceGrace));
  EXPECT_FALSE(receive(3 * kInterval + core::kLongestPresenceGrace + 1));
  EXPECT_FALSE(receive(~Value{0}));
}

/// A complete daemon reports deliveries whose route has changed, so that programs ask where to
/// send.
TEST(PresenceOfADaemon, ReportsWhatTakesAnotherWay) {
  core::System system = side_by_side(2);
  for (core::Port& port : system.gateways[0].ports) port.control_uid = 991;
  system.gateways[0].name = "g";
  Bench bench(std::move(system));
  ASSERT_FALSE(bench.start());
  const serve::Peer program{.pid = 9, .uid = 991, .session = 7};
  const auto ask = [&](const serve::Peer& peer) {
    return bench.ask(control::PresenceRequest{}, peer).reply.body;
  };
  EXPECT_TRUE(std::holds_alternative<control::Error>(ask(member())));
  const auto own = ask(program);
  ASSERT_TRUE(std::holds_alternative<control::Presence>(own));
  EXPECT_TRUE(std::get<control::Presence>(own).forwards);
  EXPECT_EQ(std::get<control::Presence>(own).others, std::vector<std::string>{"b"});
  bench.events.clear();
  bench.clock.monotonic += 2 * kInterval + 1;
  bench.act();
  EXPECT_EQ(bench.events, (std::vector<std::string>{"gateway", "rerouted"}));
  bench.events.clear();
  ask(program);
  bench.act();
  EXPECT_EQ(bench.events, (std::vector<std::string>{"gateway", "rerouted"}));
}

}  // namespace
}  // namespace mlcca::test::presence
