// SPDX-License-Identifier: BSD-2-Clause
// Tests of subscribers whose publisher another gateway has admitted, and to which that gateway does
// not agree for a while.
#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tests/daemon/gateway/members_forged.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

constexpr std::size_t kC3 = 3;
constexpr const char* kBusy = "it is busy";

/// g1 has another bus of its own, own2.
core::System with_a_third_bus() {
  core::System system = with_a_described_publisher();
  core::Network bus = some_bus("own2");
  bus.bindings = system.networks.back().bindings;
  system.networks.push_back(bus);
  core::Port port;
  port.network = system.networks.size() - 1;
  port.identity.name = bus.name;
  port.queue_length = 40;
  system.gateways[1].ports.push_back(port);
  return system;
}

class MembersPassing : public MembershipBench {
 protected:
  MembersPassing() : MembershipBench(with_a_third_bus()) {}

  static control::Admit subscriber(const std::string& to) {
    control::Admit request = subscriber_on_own1("c3", "on-" + to);
    request.to = to;
    request.key = to;
    return request;
  }
  /// Frames of c3 pass out on that network of g1.
  bool passes_on(const std::string& network) {
    const auto found = at(1).kernel.interfaces.find(network);
    if (found == at(1).kernel.interfaces.end() || !at(1).kernel.passes()) return false;
    return std::ranges::any_of(
        at(1).kernel.gates.at(found->second.ifindex).rules, [](const auto& one) {
          return one.first.subject == kC3 + 1 && one.first.direction == core::Direction::egress &&
                 one.second.pass;
        });
  }
  /// The entries by which g1 has asked g0 for the subscriber on that network.
  std::vector<std::string> entries_for(const std::string& network) {
    std::vector<std::string> all;
    for (const auto& [name, entry] : store.entries) {
      if (!name.starts_with("/mlcca/pair/x/g1/")) continue;
      const auto asked = codec.asked(entry.value);
      const auto text = asked ? cluster::asked_in(asked->admission) : std::nullopt;
      if (text && std::get<control::Admit>(text->requests.front().body).to == network)
        all.push_back(name);
    }
    return all;
  }
  /// g0 does not agree any more to what g1 has asked for.
  void refuse(const std::string& network, bool final = false) {
    for (const std::string& name : entries_for(network))
      store.write({{.key = "/mlcca/pair/a/g0/g1/" + name.substr(name.rfind('/') + 1),
                    .value = codec.write(cc::VoteOf{
                        .asked = store.entries.at(name).create,
                        .vote = {.ok = false, .hop = {}, .reason = kBusy, .final = final}})}});
    run();
  }
  std::size_t journalled(std::size_t g) { return at(g).recorded(random_).admissions.size(); }
  std::size_t said(std::size_t g, const std::string& text) {
    return static_cast<std::size_t>(
        std::ranges::count_if(at(g).published, [&](const control::Event& event) {
          return event.message.find(text) != std::string::npos;
        }));
  }
  std::string all_said(std::size_t g) {
    std::string all;
    for (const control::Event& event : at(g).published) all += event.message + '\n';
    return all;
  }
  void admit_publisher() {
    start_both();
    ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  }
  void admit_both() {
    admit_publisher();
    ASSERT_EQ(asked(1, subscriber("own1")), "granted");
    ASSERT_TRUE(passes_on("own1"));
  }
  void end_all() {
    for (const auto& [g, name] :
         {std::pair<std::size_t, const char*>{1, "own1"}, {1, "own2"}, {0, "c3own0"}})
      at(g).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = name});
    pass(4 * kSecondNs);
    for (const char* kind : {"r/", "x/", "a/"}) EXPECT_EQ(entries(kind), 0U) << kind;
    for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(at(g).state().admissions().empty()) << g;
  }

  cluster::Codec codec{with_a_third_bus(), cc::Digest{1}};
  std::mt19937 random_;
};

TEST_F(MembersPassing, ARefusalThatIsNotFinalClosesAndIsFollowedByAnotherRequest) {
  admit_both();
  at(1).published.clear();
  refuse("own1");
  EXPECT_FALSE(passes_on("own1"));
  EXPECT_EQ(journalled(1), 1U);
  EXPECT_EQ(said(1, kBusy), 1U);
  pass(2 * kSecondNs);
  EXPECT_FALSE(passes_on("own1"));
  EXPECT_EQ(entries("x/g1/"), 0U) << "it is asked for later";
  pass(10 * kSecondNs);
  EXPECT_TRUE(passes_on("own1"));
  EXPECT_EQ(asked(1, subscriber("own1")), "granted") << "the same one";
  EXPECT_EQ(entries("x/g1/"), 1U);
  EXPECT_EQ(entries("x/g0/"), 2U);
  end_all();
}

TEST_F(MembersPassing, AFinalRefusalEndsIt) {
  admit_both();
  refuse("own1", true);
  EXPECT_FALSE(passes_on("own1"));
  EXPECT_EQ(journalled(1), 0U);
  pass(12 * kSecondNs);
  EXPECT_FALSE(passes_on("own1"));
  EXPECT_EQ(entries("x/g1/"), 0U);
}

/// The one that is refused is granted to nobody on a network of g1 alone, although the publisher is
/// known there for the other one.
TEST_F(MembersPassing, OfTwoSubscribersOfAPublisherTheRefusedOneGetsNothing) {
  admit_both();
  ASSERT_EQ(asked(1, subscriber("own2")), "granted");
  ASSERT_TRUE(passes_on("own2"));
  link(0).answers = false;
  refuse("own1");
  for (int n = 0; n < 30; ++n) {
    EXPECT_FALSE(passes_on("own1")) << n;
    EXPECT_TRUE(passes_on("own2")) << n;
    pass(kStepNs);
  }
  at(1).end();
  start(1);
  for (int n = 0; n < 20; ++n) {
    EXPECT_FALSE(passes_on("own1")) << "after a restart: " << n;
    pass(kStepNs);
  }
  EXPECT_TRUE(passes_on("own2"));
  link(0).answers = true;
  pass(15 * kSecondNs);
  EXPECT_TRUE(passes_on("own1"));
  EXPECT_TRUE(passes_on("own2"));
  EXPECT_EQ(entries("x/g1/"), 2U);
  end_all();
}

/// Both lost their entries. The one that is agreed to again does not open the other one.
TEST_F(MembersPassing, WhoJoinsAgainOpensEachSubscriberByItsOwnVote) {
  admit_both();
  ASSERT_EQ(asked(1, subscriber("own2")), "granted");
  store.write({{.key = "/mlcca/pair/f/g1", .value = "g0"}});
  for (int n = 0; n < 300; ++n) {
    pass(kStepNs);
    refuse("own2");
    EXPECT_FALSE(passes_on("own2")) << n;
  }
  EXPECT_TRUE(passes_on("own1"));
  pass(40 * kSecondNs);
  EXPECT_TRUE(passes_on("own1"));
  EXPECT_TRUE(passes_on("own2"));
  end_all();
}

/// Both have the publisher from the entry of the first one.
TEST_F(MembersPassing, WhatIsReleasedTakesNothingFromAnotherSubscriber) {
  admit_both();
  ASSERT_EQ(asked(1, subscriber("own2")), "granted");
  at(1).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "own1"});
  for (int n = 0; n < 40; ++n) {
    pass(kStepNs);
    EXPECT_FALSE(passes_on("own1")) << n;
    EXPECT_TRUE(passes_on("own2")) << n;
  }
  EXPECT_EQ(entries("x/g0/"), 2U);
  end_all();
}

TEST_F(MembersPassing, ItContinuesWhenTheGatewayOfThePublisherIsBackAfterItsDeath) {
  admit_both();
  at(1).published.clear();
  at(0).end();
  link(0).up = false;
  pass(18 * kSecondNs);
  EXPECT_FALSE(passes_on("own1"));
  EXPECT_EQ(entries("x/g1/"), 0U);
  EXPECT_EQ(journalled(1), 1U);
  EXPECT_EQ(said(1, "g0 is not there"), 1U);
  link(0).up = true;
  start(0);
  pass(20 * kSecondNs);
  EXPECT_TRUE(passes_on("own1"));
  end_all();
}

TEST_F(MembersPassing, ItContinuesWhenTheGatewayOfThePublisherWasStopped) {
  admit_both();
  at(0).daemon().begin_stop();
  pass(3 * kSecondNs);
  at(0).end();
  pass(3 * kSecondNs);
  EXPECT_FALSE(passes_on("own1"));
  start(0);
  pass(15 * kSecondNs);
  EXPECT_TRUE(passes_on("own1"));
  end_all();
}

/// A gateway that was taken for dead is a member again soon, and has its publisher again.
TEST_F(MembersPassing, ItContinuesWhenTheGatewayOfThePublisherWasNoMemberForAMoment) {
  admit_both();
  store.write({{.key = "/mlcca/pair/f/g0", .value = "g1"}});
  run();
  EXPECT_FALSE(passes_on("own1"));
  pass(20 * kSecondNs);
  EXPECT_EQ(journalled(1), 1U);
  EXPECT_TRUE(passes_on("own1"));
  end_all();
}

/// While it waits, it is shown with the reason, and can be released.
TEST_F(MembersPassing, WhatWaitsIsShownAndCanBeReleased) {
  admit_both();
  refuse("own1");
  const auto again = asked(1, subscriber("own1"));
  EXPECT_NE(again.find("it waits for gateway g0"), std::string::npos) << again;
  EXPECT_NE(again.find(kBusy), std::string::npos) << again;
  auto answer = at(1).ask(control::ChannelsRequest{});
  const auto body = answer.slices ? answer.slices()->body : answer.reply.body;
  const auto* const channels = std::get_if<control::Channels>(&body);
  ASSERT_NE(channels, nullptr);
  ASSERT_EQ(channels->admissions_left_out.size(), 1U);
  EXPECT_EQ(channels->admissions_left_out.front().channel, "c3");
  end_all();
  EXPECT_EQ(journalled(1), 0U);
}

/// As an admission of this gateway alone would be, it is granted again when there is room again.
/// The reason is not logged with each request.
TEST_F(MembersPassing, ALackOfCapacityPasses) {
  admit_both();
  link(1).up = false;
  pass(20 * kSecondNs);
  ASSERT_FALSE(passes_on("own1"));
  for (const char* channel : {"c4", "c5"}) {
    auto much = wanted(channel, "own1", "own1");
    much.offered = {attribute_of("Period", 2'200'000)};
    ASSERT_EQ(asked(1, much), "granted");
  }
  link(1).up = true;
  pass(120 * kSecondNs);
  EXPECT_FALSE(passes_on("own1"));
  EXPECT_EQ(journalled(1), 3U);
  EXPECT_LE(said(1, "it waits for gateway g0"), 2U) << all_said(1);
  at(1).published.clear();
  pass(150 * kSecondNs);
  EXPECT_EQ(said(1, "it waits for gateway g0"), 0U) << all_said(1);
  at(1).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "c4own1"});
  pass(40 * kSecondNs);
  EXPECT_TRUE(passes_on("own1"));
}

/// It is closed, and ends when the disk takes that. The log does not repeat what the disk says.
TEST_F(MembersPassing, WhatTheDiskDoesNotLetEndStaysClosed) {
  admit_both();
  at(1).published.clear();
  at(1).disk().trouble(store::test::Trouble::fail, 1, ENOSPC, 1'000'000);
  at(0).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "c3own0"});
  for (int n = 0; n < 100; ++n) {
    pass(kStepNs);
    EXPECT_FALSE(passes_on("own1")) << n;
  }
  EXPECT_EQ(journalled(1), 1U);
  EXPECT_LE(at(1).published.size(), 6U) << all_said(1);
  at(1).disk().trouble(store::test::Trouble::fail, 1, 0, 0);
  pass(12 * kSecondNs);
  EXPECT_EQ(journalled(1), 0U);
  end_all();
}

/// Gateway g1 has changed its mind while g0 was away. That withdraws nothing else at g0.
TEST_F(MembersPassing, WhatWasRefusedWhileAGatewayWasAwayTouchesNothingElseAtItsStart) {
  admit_both();
  at(0).end();
  for (const auto& [name, entry] : store.entries)
    if (name.starts_with("/mlcca/pair/a/g1/g0/")) {
      auto vote = codec.vote(entry.value);
      ASSERT_TRUE(vote);
      vote->vote.ok = false;
      store.write({{.key = name, .value = codec.write(*vote)}});
      break;
    }
  at(0).published.clear();
  at(0).events.clear();
  start(0);
  run();
  EXPECT_EQ(std::ranges::count(at(0).events, "withdrawn"), 0) << all_said(0);
  pass(kSecondNs);
  EXPECT_TRUE(passes(0, 0)) << "it is described";
}

/// A gateway that agrees, and withdraws that at once, is asked more and more rarely.
TEST_F(MembersPassing, ThePausesBecomeLonger) {
  admit_both();
  at(1).published.clear();
  for (int n = 0; n < 2000; ++n) {
    refuse("own1");
    pass(kStepNs);
  }
  const std::size_t times = said(1, kBusy);
  EXPECT_GE(times, 5U);
  EXPECT_LE(times, 10U) << all_said(1);
  EXPECT_EQ(journalled(1), 1U);
}

class MembersWaiting : public MembersForged {};

/// A request of another gateway waits for its turn here until that gateway withdraws it.
TEST_F(MembersWaiting, ARequestOfAnotherGatewayIsNotRefusedForWantOfATurn) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  at(1).end();
  link(0).answers = false;
  auto first = at(0).ask(wanted("c4", "own0", "shared"));
  run();
  request_of_g1(5, cc::Stage::prepared, subscriber_on_own1("c3", "also"));
  for (int n = 0; n < 65; ++n) {
    if (n % 10 == 0) beat_of_g1();
    pass(kStepNs);
  }
  link(0).answers = true;
  run();
  for (int n = 0; n < 10; ++n) pass(kStepNs);
  const auto vote = answer_to_g1(5);
  EXPECT_FALSE(vote && !vote->ok) << vote->reason;
  EXPECT_TRUE(std::ranges::any_of(asked_by_g0(),
                                  [](const auto& one) { return one.second.for_gateway == "g1"; }));
}

/// What waits for its turn is forgotten with the request.
TEST_F(MembersWaiting, ARequestThatEndsDoesNotWaitAnyMore) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  at(1).end();
  link(0).answers = false;
  auto first = at(0).ask(wanted("c4", "own0", "shared"));
  run();
  for (std::uint64_t n = 1; n <= 40; ++n) {
    request_of_g1(n, cc::Stage::prepared, subscriber_on_own1("c3", "also"));
    run();
    store.write({}, {key("x/g1/") + std::to_string(n)});
    run();
  }
  request_of_g1(50, cc::Stage::prepared, subscriber_on_own1("c3", "also"));
  run();
  link(0).answers = true;
  run();
  const auto vote = answer_to_g1(50);
  EXPECT_FALSE(vote && !vote->ok) << vote->reason;
  EXPECT_EQ(std::ranges::count_if(asked_by_g0(),
                                  [](const auto& one) { return one.second.for_gateway == "g1"; }),
            1);
}

/// It is decided once, also where this gateway was no member for a moment while it waited.
TEST_F(MembersWaiting, ARequestIsDecidedOnceAlsoWhereThisGatewayJoinsAgain) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  at(1).end();
  link(0).answers = false;
  auto first = at(0).ask(wanted("c4", "own0", "shared"));
  run();
  request_of_g1(5, cc::Stage::prepared, subscriber_on_own1("c3", "also"));
  run();
  store.write({{.key = key("f/g0"), .value = "g1"}});
  run();
  link(0).answers = true;
  std::size_t most = 0;
  for (int n = 0; n < 60; ++n) {
    if (n % 10 == 0) beat_of_g1();
    pass(kStepNs);
    most = std::max(
        most, static_cast<std::size_t>(std::ranges::count_if(
                  asked_by_g0(), [](const auto& one) { return one.second.for_gateway == "g1"; })));
  }
  EXPECT_EQ(most, 1U);
}

}  // namespace
}  // namespace mlcca::test
