// SPDX-License-Identifier: BSD-2-Clause
// What is on the buses of a description, granted or not.
#include <gtest/gtest.h>

#include <vector>

#include "tests/core/design/inspected.hpp"

namespace mlcca::core::testing {
namespace {

constexpr Value kFrame = 1'280'000;  // 8 bytes and 29 bits at 125 kbit/s

/// The robot's buses at 125 kbit/s, and a third that no gateway leads to.
System two_buses() {
  System system = described(0);
  system.networks.push_back(can_network("apart"));
  for (Network& n : system.networks) {
    n.bus.bitrate = 125'000;
    n.provision = AttributeSet{}.set(Attribute::omission, 0).set(Attribute::max_payload, 8);
  }
  system.gateways[kBridge].provision.set(Attribute::jitter, kMs);
  return system;
}

std::vector<BusMessage> messages_of(const System& system) {
  InspectedBuses buses;
  static_cast<void>(inspect(system, {}, {}, &buses));
  return buses.messages;
}

TEST(BusMessagesTest, AGrantedEventIsOnEachBusOfItsWayAndInheritsJitter) {
  const System system = two_buses();
  const auto messages = messages_of(system);
  ASSERT_EQ(messages.size(), 2U);
  const BusMessage& near = messages[1];
  const BusMessage& far = messages[0];
  EXPECT_EQ(near.network, kSecondCan);
  EXPECT_EQ(near.from, Flow::kOwn);
  EXPECT_FALSE(near.before);
  EXPECT_EQ(near.granted_response, kFrame);
  EXPECT_EQ(near.granted_jitter, 0U);
  EXPECT_EQ(far.network, kRobotCan);
  EXPECT_EQ(far.from, system.resource_of(gateway(kBridge)));
  ASSERT_TRUE(far.before);
  EXPECT_EQ(far.before->network, kSecondCan);
  EXPECT_EQ(far.before->from, Flow::kOwn);
  EXPECT_EQ(far.before->added, kMs) << "of the bridge";
  for (const BusMessage& m : messages) {
    EXPECT_TRUE(m.held);
    EXPECT_EQ(m.outcome, Outcome::fit);
    EXPECT_FALSE(m.in_vain);
    EXPECT_TRUE(m.unknown.empty());
    ASSERT_TRUE(m.message);
    EXPECT_EQ(m.message->transmission, kFrame);
  }
  EXPECT_GT(far.granted_jitter, kMs) << "whatever the first bus promises, and the bridge";
  EXPECT_EQ(far.message->jitter, far.granted_jitter);
  EXPECT_EQ(far.granted_response, far.granted_jitter + kFrame);
}

TEST(BusMessagesTest, WhatLeadsNowhereIsOnThePublishersBusAllTheSame) {
  System system = two_buses();
  system.subscribers[0].place = network(2);
  const auto messages = messages_of(system);
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].network, kSecondCan);
  EXPECT_EQ(messages[0].from, Flow::kOwn);
  EXPECT_FALSE(messages[0].held);
  EXPECT_FALSE(messages[0].in_vain);
  EXPECT_FALSE(messages[0].granted_response);
  ASSERT_TRUE(messages[0].message);
  EXPECT_EQ(messages[0].message->transmission, kFrame);
}

TEST(BusMessagesTest, OfAProgramWhoseEventsLeadNowhereThereIsNothingOnAnyBus) {
  System system = two_buses();
  system.publishers[0].place = gateway(kBridge);
  system.publishers[0].uid = 1000;
  system.subscribers[0].place = network(2);
  EXPECT_TRUE(messages_of(system).empty());
}

TEST(BusMessagesTest, WhatIsRefusedOnTheFarBusIsOnTheNearOneToo) {
  System system = two_buses();
  system.subscribers[0].attributes.set(Attribute::deadline, 2 * kMs);
  const auto messages = messages_of(system);
  ASSERT_EQ(messages.size(), 2U);
  for (const BusMessage& m : messages) EXPECT_FALSE(m.held);
  EXPECT_TRUE(messages[0].in_vain || messages[1].in_vain) << "the response times decided it";
  ASSERT_TRUE(messages[0].message);
  EXPECT_EQ(messages[0].message->jitter, kFrame + kMs) << "of the first bus, and of the bridge";
}

TEST(BusMessagesTest, WhatIsNotSaidOfAHopIsNamed) {
  System system = two_buses();
  system.gateways[kBridge].provision.clear(Attribute::latency);
  system.gateways[kBridge].provision.clear(Attribute::jitter);
  const auto messages = messages_of(system);
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(messages[0].unknown, std::vector{gateway(kBridge)});
  EXPECT_TRUE(messages[1].unknown.empty());
  EXPECT_FALSE(messages[0].held);
}

TEST(BusMessagesTest, WhoStatesNoPeriodIsOnTheBusWithoutAMessage) {
  System system = two_buses();
  system.publishers[0].attributes.clear(Attribute::period);
  system.subscribers[0].attributes.clear(Attribute::period);
  const auto messages = messages_of(system);
  ASSERT_EQ(messages.size(), 2U) << "on both buses of its way";
  for (const BusMessage& m : messages) {
    EXPECT_FALSE(m.held);
    EXPECT_FALSE(m.message);
  }
}

/// Each place behind a bus has a verdict; the message is one, and has to suit all of them.
TEST(BusMessagesTest, ForSeveralPlacesBehindABusTheMessageIsTheStrictest) {
  System system = two_buses();
  system.subscribers.push_back(subscriber("near", network(kSecondCan), heart_beat()));
  system.subscribers[1].attributes.set(Attribute::deadline, 20 * kMs);
  const auto messages = messages_of(system);
  ASSERT_EQ(messages.size(), 2U);
  ASSERT_TRUE(messages[1].message);
  EXPECT_TRUE(messages[1].held);
  EXPECT_EQ(messages[1].message->deadline, 20 * kMs);
}

}  // namespace
}  // namespace mlcca::core::testing
