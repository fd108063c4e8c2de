// SPDX-License-Identifier: BSD-2-Clause
// Tests of admissions that another gateway refuses: the answer is a refusal with the gateway and
// the hop, and no error of the surroundings.
#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

/// g2 has own2, and the bus that it shares with g0 and g1.
core::System with_a_third_gateway() {
  core::System system = two_gateways();
  core::Network bus = some_bus("own2");
  bus.bindings = system.networks.back().bindings;
  system.networks.push_back(bus);
  core::Gateway gateway = system.gateways[1];
  gateway.name = "g2";
  gateway.ports.back().network = system.networks.size() - 1;
  gateway.ports.back().identity.name = "own2";
  system.gateways.push_back(gateway);
  return system;
}

class MembersRefused : public MembershipBench {
 protected:
  MembersRefused() : MembershipBench(with_a_third_gateway()) {
    nodes.push_back(std::make_unique<Node>(store, 2, with_a_third_gateway()));
  }
  void start_all() {
    for (std::size_t g = 0; g < 3; ++g) start(g);
    pass(6 * kSecondNs);
  }
  void unplug(std::size_t g, const std::string& network) {
    at(g).kernel.unplug(network);
    at(g).daemon().links_changed();
    pass(kSecondNs);
  }
  void drain(std::size_t g) {
    const auto body = at(g).ask(control::DrainRequest{}).reply.body;
    EXPECT_TRUE(std::holds_alternative<control::Done>(body));
  }
  static control::Admit subscriber_on(const std::string& to) {
    control::Admit request;
    request.channel = "c3";
    request.from = "own0";
    request.to = to;
    request.subscriber = request.key = "also";
    return request;
  }
  /// The answer in the end.
  serve::Slice answered(std::size_t g, control::Admit request) {
    auto answer = at(g).ask(std::move(request));
    run();
    pass(6 * kSecondNs);
    if (!answer.slices) return serve::Slice{answer.reply.body};
    return answer.slices().value_or(serve::Slice{control::Done{"nothing yet"}});
  }
  /// The one delivery of an answer; with an empty name if it is something else.
  control::Channel delivery_in(std::size_t g, control::Admit request) {
    const auto slice = answered(g, std::move(request));
    if (const auto* error = std::get_if<control::Error>(&slice.body))
      ADD_FAILURE() << "an error: " << error->message;
    const auto* channels = std::get_if<control::Channels>(&slice.body);
    return channels == nullptr || channels->channels.size() != 1 ? control::Channel()
                                                                 : channels->channels.front();
  }
  static void expect_refused(const control::Channel& delivery, const std::string& by,
                             const std::string& hop) {
    EXPECT_FALSE(delivery.granted);
    EXPECT_EQ(delivery.admission, 0U);
    ASSERT_TRUE(delivery.refused_by) << delivery.reason;
    EXPECT_EQ(delivery.refused_by->gateway, by) << delivery.reason;
    EXPECT_EQ(delivery.refused_by->hop, hop) << delivery.reason;
    EXPECT_NE(delivery.reason.find(by), std::string::npos) << delivery.reason;
  }
};

TEST_F(MembersRefused, WhatTheNextGatewayDoesNotCarryIsRefusedWithItsNameAndTheNetwork) {
  start_all();
  unplug(1, "own1");
  const auto delivery = delivery_in(0, wanted("c3", "own0", "own1"));
  expect_refused(delivery, "g1", "own1");
  EXPECT_EQ(delivery.name, "c3");
  EXPECT_EQ(delivery.subject, 4U);
  EXPECT_EQ(delivery.publisher, "new");
  EXPECT_EQ(delivery.from, "own0");
  EXPECT_EQ(delivery.to, "own1");
  ASSERT_EQ(delivery.subscribers.size(), 1U);
  EXPECT_EQ(delivery.subscribers.front(), "late");
  EXPECT_EQ(delivery.route.size(), 5U);
}

TEST_F(MembersRefused, TheLogSaysThatItWasRefused) {
  start_all();
  unplug(1, "own1");
  const auto delivery = delivery_in(0, wanted("c3", "own0", "own1"));
  std::size_t said = 0;
  for (const auto& event : at(0).published)
    if (event.kind == "refused" && event.channel == "c3") {
      ++said;
      EXPECT_TRUE(event.message.starts_with("c3 (0x0000000000000004) refused from own0 to own1: " +
                                            delivery.reason))
          << event.message;
    }
  EXPECT_EQ(said, 1U);
}

/// g0 has the publisher, and decides for g1.
TEST_F(MembersRefused, WhatTheGatewayOfThePublisherDoesNotAdmitIsRefusedByIt) {
  start_all();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  auto request = subscriber_on("own1");
  request.required = {attribute_of("Deadline", 1000)};
  const auto delivery = delivery_in(1, request);
  expect_refused(delivery, "g0", "own0");
  EXPECT_EQ(delivery.name, "c3");
  EXPECT_EQ(delivery.from, "own0");
  EXPECT_EQ(delivery.to, "own1");
}

/// g1 asks g0, which has the publisher and asks g2, which refuses.
TEST_F(MembersRefused, OfAChainTheLastGatewayIsTheOneThatRefuses) {
  start_all();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  unplug(2, "own2");
  const auto delivery = delivery_in(1, subscriber_on("own2"));
  expect_refused(delivery, "g2", "own2");
  EXPECT_TRUE(delivery.reason.starts_with("g0: g2: ")) << delivery.reason;
}

TEST_F(MembersRefused, AGatewayThatIsDrainedIsNamed) {
  start_all();
  drain(1);
  pass(6 * kSecondNs);
  expect_refused(delivery_in(0, wanted("c3", "own0", "own1")), "g1", "");
}

/// What is shown of a delivery that was granted, for as long as a gateway on its way is not there.
class MembersObjected : public MembersRefused {
 protected:
  void admit() {
    start_all();
    ASSERT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
  }
  void expect_shown(const std::string& part) {
    const std::string shown = asked(0, wanted("c3", "own0", "own1"));
    EXPECT_TRUE(shown.starts_with("waits for gateway g1: ")) << shown;
    EXPECT_NE(shown.find(part), std::string::npos) << shown;
    EXPECT_EQ(shown.find("store"), std::string::npos) << shown;
  }
  void end(std::size_t g) {
    at(g).end();
    link(g).up = false;
  }
};

TEST_F(MembersObjected, ADeadGatewayIsNamedAndNotTheStore) {
  admit();
  end(1);
  pass(30 * kSecondNs);
  expect_shown("g1 is not there: it is dead");
}

TEST_F(MembersObjected, ADrainedGatewayIsNamedAndNotTheStore) {
  admit();
  drain(1);
  pass(30 * kSecondNs);
  expect_shown("g1 is not there: it is drained");
}

TEST_F(MembersObjected, WhatAGatewayHasAnsweredLastIsKept) {
  admit();
  at(1).end();
  at(1).kernel.unplug("own1");
  start(1);
  pass(30 * kSecondNs);
  expect_shown("own1 is not available");
}

/// The objection of a gateway is no reason while nothing of others is known.
TEST_F(MembersObjected, WithoutTheStoreTheStoreIsTheReason) {
  admit();
  end(1);
  pass(30 * kSecondNs);
  link(0).up = link(0).answers = false;
  pass(11 * kSecondNs);
  const std::string shown = asked(0, wanted("c3", "own0", "own1"));
  EXPECT_NE(shown.find("waits for the store"), std::string::npos) << shown;
}

TEST_F(MembersObjected, WhenTheGatewayIsBackItIsGranted) {
  admit();
  end(1);
  pass(30 * kSecondNs);
  link(1).up = true;
  start(1);
  pass(60 * kSecondNs);
  EXPECT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
}

/// No gateway has decided it.
TEST_F(MembersRefused, AStoreThatDoesNotAnswerIsAnErrorOfTheSurroundings) {
  start_all();
  link(0).answers = false;
  const auto slice = answered(0, wanted("c3", "own0", "own1"));
  const auto* error = std::get_if<control::Error>(&slice.body);
  ASSERT_NE(error, nullptr);
  EXPECT_EQ(error->kind, control::ErrorKind::world);
}

}  // namespace
}  // namespace mlcca::test
