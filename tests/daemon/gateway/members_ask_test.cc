// SPDX-License-Identifier: BSD-2-Clause
// What waits for the store, and what is given back to it: keys, users, numbers, gates.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "daemon/gateway/outlook.hpp"
#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

constexpr uid_t kRelayUser = 990;

/// The shared bus accepts one subscription, and its relay carries the messages for it.
core::System with_a_publisher() {
  core::System system = with_a_described_publisher();
  system.networks[kSharedBus].subscriptions = {
      .accept = core::Subscribing::all, .most = 1, .origin = {}};
  for (core::Gateway& gateway : system.gateways) gateway.relay = kRelayUser;
  for (core::Port& port : system.gateways[0].ports)
    if (port.network == kSharedBus) port.control_uid = kRelayUser;
  return system;
}

class MembersAsk : public MembershipBench {
 protected:
  MembersAsk() : MembershipBench(with_a_publisher()) {}

  static control::Admit subscriber(const std::string& name) {
    control::Admit request;
    request.channel = "c2";
    request.to = "shared";
    request.subscriber = name;
    request.key = name;
    return request;
  }
  static control::SubscribeRequest subscription(const std::string& source) {
    control::SubscribeRequest out;
    out.subject = 3;
    out.network = "shared";
    out.source = source;
    return out;
  }
  static serve::Peer relay() { return {.pid = 9, .uid = kRelayUser, .session = 7}; }
  static serve::Peer user(uid_t uid) {
    return {.pid = 2, .uid = uid, .may_change = true, .session = uid};
  }
  std::string done_or_not(control::ReleaseRequest request) {
    const auto body = at(0).ask(std::move(request)).reply.body;
    const auto* error = std::get_if<control::Error>(&body);
    return error != nullptr ? error->message : "done";
  }
};

TEST_F(MembersAsk, AKeyThatWaitsIsNotAskedForTwice) {
  start_both();
  link(0).answers = false;
  auto first = at(0).ask(wanted("c3", "own0", "shared"));
  run();
  auto again = at(0).ask(wanted("c3", "own0", "shared"));
  run();
  link(0).answers = true;
  pass(kSecondNs);
  EXPECT_EQ(text_of(first), "granted");
  EXPECT_NE(text_of(again).find("waits for the store"), std::string::npos) << text_of(again);
  EXPECT_EQ(at(0).state().admissions().size(), 1U);
  EXPECT_EQ(entries("r/"), 1U);
  EXPECT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted") << "the same one";
  EXPECT_EQ(at(0).state().admissions().size(), 1U);
}

TEST_F(MembersAsk, AKeyThatWaitsIsNotAdmittedPastIt) {
  start_both();
  link(0).answers = false;
  auto first = at(0).ask(wanted("c3", "own0", "shared"));
  run();
  auto local = wanted("c3", "own0", "own0");
  EXPECT_NE(asked(0, local), "granted") << "it has the same key";
  link(0).answers = true;
  pass(kSecondNs);
  EXPECT_EQ(text_of(first), "granted");
  EXPECT_EQ(at(0).state().admissions().size(), 1U);
}

TEST_F(MembersAsk, WhoReleasesAKeyThatWaitsIsNotGrantedIt) {
  start_both();
  link(0).answers = false;
  auto first = at(0).ask(wanted("c3", "own0", "shared"));
  run();
  EXPECT_EQ(done_or_not({.channel = {}, .admission = 0, .key = "c3own0"}), "done");
  link(0).answers = true;
  pass(3 * kSecondNs);
  EXPECT_NE(text_of(first).find("released"), std::string::npos) << text_of(first);
  EXPECT_TRUE(at(0).state().admissions().empty());
  EXPECT_EQ(entries("r/"), 0U);
}

TEST_F(MembersAsk, SubscriptionsThatWaitCountAsWell) {
  start_both();
  link(0).answers = false;
  auto first = at(0).ask(subscription("0x12"), relay());
  auto other = at(0).ask(subscription("0x13"), relay());
  run();
  link(0).answers = true;
  pass(kSecondNs);
  EXPECT_EQ(text_of(first), "granted");
  EXPECT_NE(text_of(other).find("allow no more"), std::string::npos) << text_of(other);
  EXPECT_EQ(at(0).state().admissions().size(), 1U);
}

TEST_F(MembersAsk, ASubscriptionThatWaitsCanBeEnded) {
  start_both();
  link(0).answers = false;
  auto first = at(0).ask(subscription("0x12"), relay());
  run();
  auto end = subscription("0x12");
  end.end = true;
  at(0).ask(end, relay());
  link(0).answers = true;
  pass(3 * kSecondNs);
  EXPECT_NE(text_of(first), "granted");
  EXPECT_TRUE(at(0).state().admissions().empty());
}

TEST_F(MembersAsk, OneUserCannotTakeAllPlacesOfThoseWhoWait) {
  start_both();
  link(0).answers = false;
  std::vector<serve::Answer> all;
  std::string last;
  const auto ask = [&](uid_t uid, std::size_t n) {
    auto request = wanted("c3", "own0", "shared");
    request.key = std::to_string(uid) + "-" + std::to_string(n);
    all.push_back(at(0).ask(request, user(uid)));
    return text_of(all.back());
  };
  std::size_t waiting = 0;
  for (std::size_t n = 0; n < 300; ++n)
    if (last = ask(1000, n); last == "nothing yet") ++waiting;
  EXPECT_LE(waiting, 64U);
  EXPECT_NE(last.find("user 1000"), std::string::npos) << last;
  EXPECT_EQ(ask(1002, 0), "nothing yet");
  // It does not wait until all of the other one's were decided.
  link(0).answers = true;
  run();
  const auto& ready = nodes[0]->ready;
  const auto turn = std::ranges::find(ready, std::uint64_t{1002});
  ASSERT_NE(turn, ready.end());
  EXPECT_LE(turn - ready.begin(), 2);
}

TEST_F(MembersAsk, NobodyButRootTakesTheLastPlaces) {
  start_both();
  link(0).answers = false;
  std::vector<serve::Answer> all;
  std::string last;
  for (uid_t uid = 1000; uid < 1010; ++uid)
    for (std::size_t n = 0; n < 64; ++n) {
      auto request = wanted("c3", "own0", "shared");
      request.key = std::to_string(uid) + "-" + std::to_string(n);
      all.push_back(at(0).ask(request, user(uid)));
      last = text_of(all.back());
    }
  EXPECT_NE(last, "nothing yet");
  auto request = wanted("c3", "own0", "shared");
  request.key = "root";
  auto of_root = at(0).ask(request, user(0));
  EXPECT_EQ(text_of(of_root), "nothing yet");
}

TEST_F(MembersAsk, WhatAnotherAdmissionUsesIsNotGivenBackWithTheFirst) {
  start_both();
  ASSERT_EQ(asked(0, subscriber("first")), "granted");
  ASSERT_EQ(entries("r/"), 1U);
  ASSERT_EQ(asked(0, subscriber("second")), "granted");
  EXPECT_EQ(entries("r/"), 1U) << "the same frames";
  EXPECT_EQ(done_or_not({.channel = {}, .admission = 0, .key = "first"}), "done");
  for (int n = 0; n < 30; ++n) {
    pass(kStepNs);
    EXPECT_TRUE(passes(0, 2)) << n;
    EXPECT_GE(entries("x/"), 1U) << "not for a moment";
    EXPECT_LE(entries("x/"), 2U) << "that of both, and what takes its place";
  }
  EXPECT_EQ(entries("x/"), 1U);
  EXPECT_EQ(entries("r/"), 1U);
  EXPECT_EQ(done_or_not({.channel = {}, .admission = 0, .key = "second"}), "done");
  EXPECT_FALSE(passes(0, 2));
  pass(4 * kSecondNs);
  EXPECT_EQ(entries("r/"), 0U);
}

TEST_F(MembersAsk, NothingIsGivenBackBeforeTheGatesHaveClosed) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  at(0).kernel.calls.refuse(1, 1'000'000);
  EXPECT_EQ(done_or_not({.channel = {}, .admission = 0, .key = "c3own0"}), "done");
  pass(3 * kSecondNs);
  EXPECT_EQ(entries("r/"), 1U) << "the kernel has refused";
  at(0).kernel.calls.relent();
  pass(8 * kSecondNs);
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_FALSE(passes(0, 3));
}

TEST_F(MembersAsk, TheNumberOfAnAdmissionOfAnotherGatewayIsNotUsedAgain) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
  ASSERT_EQ(at(1).state().admissions().size(), 1U);
  const auto adopted = at(1).state().admissions().begin()->first;
  EXPECT_EQ(done_or_not({.channel = {}, .admission = 0, .key = "c3own0"}), "done");
  pass(3 * kSecondNs);
  ASSERT_TRUE(at(1).state().admissions().empty());
  at(1).end();
  start(1);
  pass(4 * kSecondNs);
  ASSERT_EQ(asked(1, wanted("c4", "own1", "own1")), "granted");
  EXPECT_GT(at(1).state().admissions().begin()->first, adopted);
}

TEST_F(MembersAsk, ChannelsThatAreNotDescribedLeaveNothingAtOtherGateways) {
  for (std::size_t g = 0; g < 2; ++g)
    for (core::Network& n : at(g).system.networks)
      n.unlisted = {.allowed = true, .subject = kUnlistedSubjects, .bits = 8, .most = 1};
  start_both();
  for (const std::string channel : {"0x5600000000000001", "0x5600000000000002"}) {
    auto request = wanted(channel, "own0", "own1");
    request.unlisted = true;
    request.identifiers = {{"own0", 0x41}, {"shared", 0x42}, {"own1", 0x43}};
    request.offered = {attribute_of("Period", 50 * kMs), attribute_of("MaxPayload", 8)};
    ASSERT_EQ(asked(0, request), "granted") << channel;
    EXPECT_EQ(done_or_not({.channel = {}, .admission = 0, .key = channel + "own0"}), "done");
    pass(3 * kSecondNs);
    EXPECT_FALSE(at(1).state().find_channel(channel));
  }
}

TEST_F(MembersAsk, WhatComesBackAfterAFailedReloadIsNobodysOrIsKnown) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
  ASSERT_EQ(at(1).state().admissions().size(), 1U);
  const auto described = at(1).daemon().scene().description;
  at(1).digest = 2;
  for (std::size_t n = 1; n < 40 && at(1).daemon().scene().description < described + 2; ++n) {
    at(1).kernel.calls.refuse(n);
    at(1).daemon().reload();
    at(1).reading().finish();
    at(1).kernel.calls.relent();
    if (at(1).daemon().scene().digest == Sha256::Digest{2}) {
      at(1).digest = 1;
      at(1).daemon().reload();
      at(1).reading().finish();
      at(1).digest = 2;
    }
    pass(5 * kSecondNs);
  }
  pass(15 * kSecondNs);
  EXPECT_EQ(done_or_not({.channel = {}, .admission = 0, .key = "c3own0"}), "done");
  pass(4 * kSecondNs);
  EXPECT_TRUE(at(1).state().admissions().empty());
}

TEST_F(MembersAsk, ARefusalOfTheKernelIsSaidOnce) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  at(0).kernel.calls.refuse(1, 1'000'000);
  const auto said = [this] {
    return std::ranges::count_if(at(0).published, [](const control::Event& event) {
      return event.message.find("until when") != std::string::npos;
    });
  };
  const auto before = said();
  pass(9 * kSecondNs);
  EXPECT_LE(said() - before, 1);
  at(0).kernel.calls.relent();
  pass(8 * kSecondNs);
  EXPECT_TRUE(passes(0, 3));
}

TEST_F(MembersAsk, AClusterOfAnotherNameIsJoinedAsANewOne) {
  finish_reading = true;
  start_both();
  for (std::size_t g = 0; g < 2; ++g) {
    at(g).end();
    at(g).system.name = "renamed";
    at(g).digest = 3;
  }
  start_both();
  pass(40 * kSecondNs);
  EXPECT_TRUE(passes(0, 0));
}

TEST_F(MembersAsk, WhatIfKnowsWhatMayBeUsedOfSharedNetworks) {
  link(0).up = false;
  start(0);
  run();
  ASSERT_FALSE(granted(0, 0));
  const auto then = suppose(at(0).state(), {});
  ASSERT_TRUE(then);
  EXPECT_EQ((*then)->decisions()[0].granted, 0U);
}

}  // namespace
}  // namespace mlcca::test
