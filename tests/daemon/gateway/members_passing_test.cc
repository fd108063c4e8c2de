// SPDX-License-Identifier: BSD-2-Clause
// Tests of subscribers whose publisher another gateway has admitted, and to which that gateway does
// not agree for a while.
#include "tests/daemon/gateway/members_passing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

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

class MembersWaiting : public MembersForged {
 protected:
  /// g0 has admitted a publisher, and waits for the store with another request; g1 has ended.
  void keep_g0_busy() {
    start_both();
    ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
    at(1).end();
    link(0).answers = false;
    waits_.emplace(at(0).ask(wanted("c4", "own0", "shared")));
    run();
  }
  /// The entries of what g0 asks for to admit it for g1.
  std::size_t made_for_g1() {
    return static_cast<std::size_t>(std::ranges::count_if(
        asked_by_g0(), [](const auto& one) { return one.second.for_gateway == "g1"; }));
  }

 private:
  std::optional<serve::Answer> waits_;
};

/// A request of another gateway waits for its turn here until that gateway withdraws it.
TEST_F(MembersWaiting, ARequestOfAnotherGatewayIsNotRefusedForWantOfATurn) {
  keep_g0_busy();
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
  EXPECT_GE(made_for_g1(), 1U);
}

/// What waits for its turn is forgotten with the request.
TEST_F(MembersWaiting, ARequestThatEndsDoesNotWaitAnyMore) {
  keep_g0_busy();
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
  EXPECT_EQ(made_for_g1(), 1U);
}

/// It is decided once, also where this gateway was no member for a moment while it waited.
TEST_F(MembersWaiting, ARequestIsDecidedOnceAlsoWhereThisGatewayJoinsAgain) {
  keep_g0_busy();
  request_of_g1(5, cc::Stage::prepared, subscriber_on_own1("c3", "also"));
  run();
  store.write({{.key = key("f/g0"), .value = "g1"}});
  run();
  link(0).answers = true;
  std::size_t most = 0;
  for (int n = 0; n < 60; ++n) {
    if (n % 10 == 0) beat_of_g1();
    pass(kStepNs);
    most = std::max(most, made_for_g1());
  }
  EXPECT_EQ(most, 1U);
}

}  // namespace
}  // namespace mlcca::test
