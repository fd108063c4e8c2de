// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/onward.hpp"

#include <gtest/gtest.h>

#include <random>
#include <utility>
#include <vector>

#include "mlcca/check.hpp"
#include "mlcca/compose.hpp"
#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

TEST(OnwardTest, LeavesWhatTheHopsBehindDoNotUse) {
  const AttributeSet required = AttributeSet{}
                                    .set(Attribute::latency, 10 * kMs)
                                    .set(Attribute::jitter, 4 * kMs)
                                    .set(Attribute::deadline, 20 * kMs)
                                    .set(Attribute::omission, 5)
                                    .set(Attribute::packet_loss, 500'000'000)
                                    .set(Attribute::period, 50 * kMs)
                                    .set(Attribute::bandwidth, 1'000)
                                    .set(Attribute::max_payload, 8);
  const AttributeSet used = AttributeSet{}
                                .set(Attribute::latency, 3 * kMs)
                                .set(Attribute::jitter, 1 * kMs)
                                .set(Attribute::omission, 1)
                                .set(Attribute::packet_loss, 200'000'000)
                                .set(Attribute::period, 1 * kMs)
                                .set(Attribute::bandwidth, 9'000)
                                .set(Attribute::max_payload, 64);
  const AttributeSet left = requirement_before(required, used);
  EXPECT_EQ(left[Attribute::latency], 7 * kMs);
  EXPECT_EQ(left[Attribute::jitter], 3 * kMs);
  EXPECT_EQ(left[Attribute::deadline], 17 * kMs);
  EXPECT_EQ(left[Attribute::omission], 2U);              // (2 + 1)(1 + 1) - 1 = 5
  EXPECT_EQ(left[Attribute::packet_loss], 375'000'000);  // 1 - 0.625 * 0.8 = 0.5
  EXPECT_EQ(left[Attribute::period], 50 * kMs);
  EXPECT_EQ(left[Attribute::bandwidth], 1'000U);
  EXPECT_EQ(left[Attribute::max_payload], 8U);
}

TEST(OnwardTest, LeavesNothingOfWhatTheHopsBehindDoNotState) {
  const AttributeSet left = requirement_before(AttributeSet{}
                                                   .set(Attribute::latency, 10 * kMs)
                                                   .set(Attribute::omission, 3)
                                                   .set(Attribute::packet_loss, 1'000),
                                               AttributeSet{});
  EXPECT_EQ(left[Attribute::latency], 0U);
  EXPECT_EQ(left[Attribute::omission], 0U);
  EXPECT_EQ(left[Attribute::packet_loss], 0U);
}

class RandomHops {
 public:
  AttributeSet provision() {
    return AttributeSet{}
        .set(Attribute::latency, value(5'000))
        .set(Attribute::jitter, value(3'000))
        .set(Attribute::omission, value(3))
        .set(Attribute::packet_loss, value(kCertainLoss / 8))
        .set(Attribute::period, 1 + value(1'000))
        .set(Attribute::bandwidth, 1 + value(10'000))
        .set(Attribute::max_payload, 1 + value(64));
  }
  AttributeSet requirement() {
    AttributeSet out;
    const auto may_set = [&](Attribute a, Value most) {
      if (value(3) != 0) out.set(a, value(most));
    };
    may_set(Attribute::latency, 20'000);
    may_set(Attribute::deadline, 20'000);
    may_set(Attribute::jitter, 12'000);
    may_set(Attribute::omission, 40);
    may_set(Attribute::packet_loss, kCertainLoss / 2);
    may_set(Attribute::period, 2'000);
    may_set(Attribute::bandwidth, 1'000);
    may_set(Attribute::max_payload, 8);
    return normalised_requirement(out);
  }
  Value value(Value most) { return std::uniform_int_distribution<Value>(0, most)(random_); }

 private:
  std::mt19937_64 random_{2026};
};

bool fits(const AttributeSet& requirement, const AttributeSet& provision) {
  return check_normalised_layer(requirement, provision).outcome == Outcome::fit;
}

/// Whoever checks a part of the way against what is left of the requirement grants nothing that the
/// whole way does not fulfil.
TEST(OnwardTest, WhatFulfilsTheRestFulfilsTheWholeWithTheHopsBehind) {
  RandomHops random;
  unsigned granted = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::vector<Hop> hops(2 + random.value(3));
    for (std::size_t h = 0; h < hops.size(); ++h) {
      hops[h].provision = random.provision();
      hops[h].medium = static_cast<std::uint16_t>(h);
    }
    const AttributeSet required = random.requirement();
    const std::size_t before = 1 + random.value(hops.size() - 2);
    const AttributeSet used = compose(hops.data() + before, hops.size() - before);
    if (!fits(required, used)) continue;  // it is refused where it was asked
    const AttributeSet left = requirement_before(required, used);
    if (!fits(left, compose(hops.data(), before))) continue;
    ++granted;
    EXPECT_TRUE(fits(required, compose(hops.data(), hops.size()))) << "system " << i;
  }
  EXPECT_GT(granted, 1'000U);
}

Admission subscription(AdmissionId id, AttributeSet attributes) {
  Admission a;
  a.id = id;
  a.subscriber = subscriber("peer", network(kRobotCan), attributes);
  return a;
}

System accepting(Value bridge_omission) {
  System system = robot(bridge_omission);
  system.subscribers.clear();
  system.networks[kSecondCan].subscriptions.accept = Subscribing::with_attributes;
  return system;
}

TEST(OnwardTest, AGatewaySubscribesWhereTheEventsComeFrom) {
  State state(accepting(1));
  EXPECT_TRUE(onward_of(state, kBridge, 0).empty());
  state.propose(subscription(1, heart_beat())).accept();
  const auto onward = onward_of(state, kBridge, 0);
  ASSERT_EQ(onward.size(), 1U);
  EXPECT_EQ(onward[0].channel, 0U);
  EXPECT_EQ(onward[0].network, kSecondCan);
  // Omission 2 over a bridge of 1 and a bus of 0; 50 ms less the 2 ms and 5 ms behind the first
  // bus.
  EXPECT_EQ(onward[0].required[Attribute::omission], 0U);
  EXPECT_EQ(onward[0].required[Attribute::deadline], 43 * kMs);
  EXPECT_EQ(onward[0].required[Attribute::period], 50 * kMs);
  EXPECT_TRUE(state.remove(1));
  state.settle();
  EXPECT_TRUE(onward_of(state, kBridge, 0).empty());
}

TEST(OnwardTest, TheStricterOfTwoSubscribersIsPassedOn) {
  State state(accepting(0));
  state.propose(subscription(1, heart_beat().set(Attribute::omission, 9))).accept();
  Admission strict = subscription(2, heart_beat().set(Attribute::omission, 4));
  strict.subscriber->place = gateway(kBridge);
  state.propose(std::move(strict)).accept();
  const auto onward = onward_of(state, kBridge, 0);
  ASSERT_EQ(onward.size(), 1U);
  EXPECT_EQ(onward[0].required[Attribute::omission], 2U);  // of the publisher
}

TEST(OnwardTest, ADescribedSubscriberIsPassedOnLikeOneThatWasAdmitted) {
  System system = accepting(0);
  system.subscribers.push_back(subscriber("motors", network(kRobotCan), heart_beat()));
  State state(std::move(system));
  const auto onward = onward_of(state, kBridge, 0);
  ASSERT_EQ(onward.size(), 1U);
  EXPECT_EQ(onward[0].network, kSecondCan);
  EXPECT_EQ(onward[0].required[Attribute::deadline], 43 * kMs);
  EXPECT_TRUE(onward[0].described);
  EXPECT_TRUE(onward[0].admitted.empty());
}

TEST(OnwardTest, ADescribedSubscriberOnTheGatewayItselfIsPassedOn) {
  System system = accepting(0);
  system.subscribers.push_back(subscriber("logger", gateway(kBridge), heart_beat()));
  State state(std::move(system));
  const auto onward = onward_of(state, kBridge, 0);
  ASSERT_EQ(onward.size(), 1U);
  EXPECT_EQ(onward[0].network, kSecondCan);
  EXPECT_EQ(onward[0].required[Attribute::deadline], 50 * kMs);  // there is nothing behind
}

/// A gateway of the same description that the events come by knows the described ones itself.
TEST(OnwardTest, ADescribedSubscriberIsNotPassedOnToAGatewayOfTheSameDescription) {
  System system = accepting(0);
  system.networks.push_back(can_network("third-can"));
  system.networks.back().subscriptions.accept = Subscribing::with_attributes;
  const std::size_t third = system.networks.size() - 1;
  Gateway before = system.gateways[kBridge];
  before.name = "before";
  before.ports[0].network = kSecondCan;
  before.ports[1].network = third;
  system.gateways.push_back(before);
  system.publishers[0].place = network(third);
  system.subscribers.push_back(subscriber("motors", network(kRobotCan), heart_beat()));
  State state(std::move(system));
  ASSERT_EQ(state.granted(), 1U);
  EXPECT_TRUE(onward_of(state, kBridge, 0).empty());
  const auto first = onward_of(state, 1, 0);
  ASSERT_EQ(first.size(), 1U) << "the first gateway of the way begins";
  EXPECT_EQ(first[0].network, third);
  // Who was admitted at one gateway alone is not known to the other one.
  state.propose(subscription(1, heart_beat())).accept();
  const auto onward = onward_of(state, kBridge, 0);
  ASSERT_EQ(onward.size(), 1U);
  EXPECT_EQ(onward[0].network, kSecondCan);
  EXPECT_FALSE(onward[0].described);
  EXPECT_EQ(onward[0].admitted, std::vector<AdmissionId>{1});
}

TEST(OnwardTest, NothingIsPassedOnToANetworkThatAcceptsNoSubscriptions) {
  System system = accepting(0);
  system.networks[kSecondCan].subscriptions.accept = Subscribing::nobody;
  State state(std::move(system));
  state.propose(subscription(1, heart_beat())).accept();
  EXPECT_TRUE(onward_of(state, kBridge, 0).empty());
}

/// What is asked leaves nothing behind in the ledger.
TEST(OnwardTest, AnAdmittedPublisherCanLeaveAfterIt) {
  System system = accepting(0);
  system.subscribers.push_back(subscriber("motors", network(kRobotCan), heart_beat()));
  State state(std::move(system));
  Admission spare;
  spare.id = 1;
  spare.publisher = state.system().publishers[0];
  spare.publisher->name = "spare";
  state.restore(std::move(spare));
  ASSERT_EQ(onward_of(state, kBridge, 0).size(), 1U);
  EXPECT_TRUE(state.remove(1));
  state.settle();
  EXPECT_EQ(state.granted(), 1U);
}

}  // namespace
}  // namespace mlcca::core::testing
