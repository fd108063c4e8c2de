// SPDX-License-Identifier: BSD-2-Clause
// What several admissions of one channel take of a medium counts once, at every gateway.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>

#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

/// own0 - g0 - shared - g1 - far - g2 - own2, and own1 at g1.
core::System in_a_row() {
  core::System system = two_gateways();
  for (const char* name : {"far", "own2"}) {
    system.networks.push_back(some_bus(name));
    system.networks.back().bindings = system.networks[0].bindings;
  }
  const std::size_t far = system.networks.size() - 2;
  core::Port port = system.gateways[1].ports.front();
  port.network = far;
  port.identity.name = "far";
  system.gateways[1].ports.push_back(port);
  core::Gateway last = system.gateways[1];
  last.name = "g2";
  last.ports = {port, port};
  last.ports[1].network = far + 1;
  last.ports[1].identity.name = "own2";
  system.gateways.push_back(last);
  return system;
}

class MembersCount : public MembershipBench {
 protected:
  MembersCount() : MembershipBench(in_a_row()) {
    nodes.push_back(std::make_unique<Node>(store, 2, in_a_row()));
  }
  void SetUp() override {
    for (std::size_t g = 0; g < 3; ++g) start(g);
    pass(4 * kSecondNs);
    ASSERT_EQ(messages(2), 0U);
  }
  /// One more who receives what is published already.
  static control::Admit also(const std::string& to, const std::string& from = "own0") {
    control::Admit request;
    request.channel = "c3";
    request.from = from;
    request.to = to;
    request.subscriber = "also";
    request.key = "also-" + to;
    return request;
  }
  /// On the bus that the first two share: c0, which is described, and what is admitted.
  std::size_t messages(std::size_t g) {
    const std::size_t network = g == 2 ? 3 : kSharedBus;
    return at(g).state().ledger().schedule(network)->messages().size();
  }
  Value reserved(std::size_t g) { return at(g).state().ledger().reserved(kSharedBus); }
  void expect_once() {
    for (std::size_t g = 0; g < 2; ++g) EXPECT_EQ(messages(g), 2U) << g;
    EXPECT_EQ(reserved(0), reserved(1));
  }
  void release(const std::string& key) {
    const auto body =
        at(0).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = key}).reply.body;
    EXPECT_EQ(std::get_if<control::Error>(&body), nullptr);
  }
};

/// The publisher's gateway, the one between and the one that is asked decide together.
TEST_F(MembersCount, ASubscriberThatIsAskedForAtTheLastGateway) {
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  ASSERT_EQ(asked(2, also("own2", {})), "granted");
  pass(kSecondNs);
  expect_once();
  EXPECT_EQ(messages(2), 1U);
  EXPECT_EQ(at(1).state().admissions().size(), 2U) << "the one between carries it";
  EXPECT_EQ(entries("a/g1/g0/"), 1U);
  EXPECT_EQ(entries("a/g2/g0/"), 1U);
  EXPECT_EQ(entries("a/g0/g2/"), 1U);
  release("c3own0");
  pass(6 * kSecondNs);
  for (std::size_t g = 0; g < 3; ++g) EXPECT_TRUE(at(g).state().admissions().empty()) << g;
  EXPECT_EQ(messages(2), 0U);
  EXPECT_EQ(entries("x/"), 0U);
}

TEST_F(MembersCount, ASecondSubscriberBehindAnotherGateway) {
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  expect_once();
  ASSERT_EQ(asked(0, also("own1")), "granted");
  pass(kSecondNs);
  EXPECT_EQ(at(1).state().admissions().size(), 2U) << "it carries it";
  expect_once();
  release("also-own1");
  for (int n = 0; n < 30; ++n) {
    pass(kStepNs);
    expect_once();
  }
  EXPECT_TRUE(at(1).state().admissions().empty());
  release("c3own0");
  pass(3 * kSecondNs);
  for (std::size_t g = 0; g < 2; ++g) EXPECT_EQ(messages(g), 1U) << g;
  EXPECT_EQ(entries("r/"), 0U);
}

TEST_F(MembersCount, ASecondSubscriberTwoGatewaysFurther) {
  ASSERT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
  expect_once();
  ASSERT_EQ(asked(0, also("own2")), "granted");
  for (int n = 0; n < 10; ++n) {
    pass(kStepNs);
    expect_once();
  }
  EXPECT_EQ(messages(2), 1U);
  release("also-own2");
  for (int n = 0; n < 40; ++n) {
    pass(kStepNs);
    expect_once();
  }
  EXPECT_EQ(messages(2), 0U);
}

/// The gateway that carries it admits somebody itself.
TEST_F(MembersCount, ASubscriberOfWhatAnotherGatewayHasReserved) {
  auto request = wanted("c3", "shared", "own1");
  request.key = "first";
  ASSERT_EQ(asked(0, request), "granted");
  expect_once();
  ASSERT_EQ(asked(1, also("far", "")), "granted");
  pass(kSecondNs);
  expect_once();
  EXPECT_EQ(messages(2), 1U);
  EXPECT_EQ(entries("r/shared/g1"), 0U) << "the other one has it";
  release("first");
  pass(4 * kSecondNs);
  for (std::size_t g = 0; g < 2; ++g) EXPECT_EQ(messages(g), 1U) << g;
}

/// What was lost is asked for again for the channel, with all who were admitted.
TEST_F(MembersCount, WhatIsAskedForAgain) {
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  ASSERT_EQ(asked(0, also("own1")), "granted");
  pass(kSecondNs);
  store.write({{.key = "/mlcca/pair/f/g0", .value = "g1"}});
  pass(20 * kSecondNs);
  EXPECT_TRUE(passes(0, 3));
  EXPECT_EQ(at(1).state().admissions().size(), 2U);
  expect_once();
}

/// Nothing is given back while what is leased is closed: what needs it cannot be known then.
TEST_F(MembersCount, WhatIsReleasedCountsUntilItIsGivenBack) {
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  expect_once();
  link(0).answers = false;
  for (int n = 0; n < 100 && passes(0, 3); ++n) pass(kStepNs);
  ASSERT_FALSE(passes(0, 3));
  release("c3own0");
  run();
  EXPECT_EQ(entries("r/shared/g0"), 1U);
  EXPECT_EQ(messages(0), 2U) << "its last frames, and what the store has";
  link(0).answers = true;
  for (int n = 0; n < 60; ++n) {
    pass(kStepNs);
    EXPECT_GE(messages(0), 1U + entries("r/shared/g0")) << n;
  }
  EXPECT_EQ(entries("r/shared/g0"), 0U);
  EXPECT_EQ(messages(0), 1U);
}

TEST_F(MembersCount, TheReportOfMembersHasItOnce) {
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  const auto share = [this] {
    const auto members = std::get<control::ClusterMembers>(
        at(0).ask(control::ClusterRequest{.part = "members"}).reply.body);
    return members.members.front().shares.front();
  };
  const auto once = share();
  ASSERT_EQ(asked(0, also("own1")), "granted");
  EXPECT_EQ(entries("r/shared/"), 2U);
  EXPECT_EQ(share().reservations, 2U);
  EXPECT_EQ(share().bytes_per_second, once.bytes_per_second);
  EXPECT_EQ(share().messages, once.messages);
}

}  // namespace
}  // namespace mlcca::test
