// SPDX-License-Identifier: BSD-2-Clause
// A rollout ends whatever fails meanwhile, and the next one is possible.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <variant>

#include "tests/daemon/gateway/members_rollout.hpp"

namespace mlcca::test {
namespace {

class MembersRolloutEnds : public MembersRollout {
 protected:
  void expect_that_the_next_one_comes_into_force(std::uint8_t digest = 3) {
    finish_reading = true;
    ASSERT_EQ(roll_out(0, std::to_string(digest)), "checking");
    pass(8 * kSecondNs);
    EXPECT_EQ(state_of(0).state, "in-force") << state_of(0).why;
    for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, digest)) << g;
  }
  /// Both have agreed to the second one, and the first gateway is to load it.
  void until_loaded() {
    propose_to_both();
    at(1).reading().finish();
    for (int n = 0; n < 20 && !at(0).reading().busy(); ++n) pass(kStepNs);
    ASSERT_TRUE(at(0).reading().busy());
  }
  void load_and_be_refused() {
    at(0).kernel.calls.refuse(1, 1000);
    at(0).reading().finish();
    at(0).kernel.calls.relent();
    ASSERT_TRUE(has(0, 1));
    // The turn ends before the store says anything to the member of the description that is back.
    at(0).act();
  }
  /// Both have agreed to the second one. The other gateway dies, and the first one changes to it.
  void die_before_the_change() {
    until_loaded();
    at(1).end();
    at(0).reading().finish();
    finish_reading = true;
    pass(kSecondNs);
    ASSERT_TRUE(has(0, 2));
  }
  void wait_for_the_way_back() {
    pass(80 * kSecondNs);
    ASSERT_TRUE(has(0, 1));
    pass(60 * kSecondNs);
    ASSERT_FALSE(passes(0, 0)) << "the other one may still send what it was promised";
    ASSERT_EQ(state_of(0).waiting, std::vector<std::string>{"g1"});
  }
  void expect_back_without_g1() {
    pass(3 * kSecondNs);
    EXPECT_EQ(state_of(0).state, "in-force") << state_of(0).why;
    EXPECT_TRUE(has(0, 1));
    EXPECT_TRUE(passes(0, 0));
    start(1);
    pass(5 * kSecondNs);
    EXPECT_TRUE(has(1, 1));
    EXPECT_EQ(asked(1, wanted("c3", "own1", "shared")), "granted");
  }
  std::string rolled_in_journal(std::size_t g) {
    std::mt19937 random(1);
    return at(g).recorded(random).membership.rolled_digest;
  }
};

/// What was handed to the member of before was not proposed yet.
TEST_F(MembersRolloutEnds, WhereAnotherDescriptionIsLoadedBeforeItIsProposed) {
  start_both();
  link(0).answers = false;
  ASSERT_EQ(roll_out(0, "2"), "checking");
  run();
  ASSERT_EQ(state_of(0).state, "staging");
  link(0).sent.clear();
  at(0).digest = 7;
  at(0).daemon().reload();
  run();
  ASSERT_TRUE(has(0, 7));
  link(0).answers = true;
  pass(5 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "refused");
  EXPECT_NE(state_of(0).why, "");
  EXPECT_EQ(rolled(0, {.accept = true}).find("description"), 0U);
  pass(5 * kSecondNs);
  ASSERT_TRUE(has(0, 1));
  expect_that_the_next_one_comes_into_force();
}

TEST_F(MembersRolloutEnds, WhereAnotherDescriptionIsLoadedWhileItIsJudged) {
  propose_to_both();
  finish_reading = true;
  link(1).answers = false;
  at(0).digest = 7;
  at(0).daemon().reload();
  run();
  ASSERT_TRUE(has(0, 7));
  pass(5 * kSecondNs);
  link(1).answers = true;
  pass(2 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "refused");
  EXPECT_FALSE(store.entries.contains("/mlcca/pair/d/next"));
  EXPECT_TRUE(has(1, 1));
  EXPECT_EQ(rolled(0, {.accept = true}).find("description"), 0U);
  pass(5 * kSecondNs);
  expect_that_the_next_one_comes_into_force();
}

TEST_F(MembersRolloutEnds, WhereTheKernelRefusesItTheFormerOneIsBackSoon) {
  until_loaded();
  load_and_be_refused();
  finish_reading = true;
  pass(15 * kSecondNs);
  for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 1)) << g;
  EXPECT_EQ(state_of(0).state, "refused");
  EXPECT_TRUE(passes(0, 0));
  expect_that_the_next_one_comes_into_force();
}

TEST_F(MembersRolloutEnds, WhatTheKernelHasRefusedIsNotLoadedAtTheNextStart) {
  until_loaded();
  load_and_be_refused();
  EXPECT_EQ(rolled_in_journal(0).find('\2'), std::string::npos);
  at(0).end();
  ASSERT_FALSE(at(0).start());
  EXPECT_TRUE(has(0, 1));
}

/// After a minute the former one comes back, and waits for the dead gateway as well.
TEST_F(MembersRolloutEnds, WhereOneDiesItIsCalledOffWhileTheFormerOneComesBack) {
  die_before_the_change();
  wait_for_the_way_back();
  ASSERT_EQ(roll_out(0, "1", {"g1"}), "checking");
  expect_back_without_g1();
}

TEST_F(MembersRolloutEnds, WhereOneDiesItIsCalledOffOnTheWayBackByTheWayBack) {
  die_before_the_change();
  wait_for_the_way_back();
  ASSERT_EQ(rolled(0, {.without = {"g1"}, .back = true}), "checking");
  expect_back_without_g1();
}

TEST_F(MembersRolloutEnds, WhereOneDiesItIsCalledOffWhileTheNewOneComesIntoForce) {
  die_before_the_change();
  pass(20 * kSecondNs);
  ASSERT_TRUE(has(0, 2));
  ASSERT_FALSE(passes(0, 5));
  ASSERT_EQ(roll_out(0, "2", {"g1"}), "checking");
  pass(3 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "in-force") << state_of(0).why;
  EXPECT_TRUE(passes(0, 5));
}

TEST_F(MembersRolloutEnds, WhoIsThereIsNotCalledOffWhileADescriptionComesIntoForce) {
  die_before_the_change();
  ASSERT_EQ(roll_out(0, "2", {"g1"}), "checking");
  pass(kSecondNs);
  EXPECT_EQ(state_of(0).state, "refused");
  EXPECT_NE(state_of(0).why.find("g1: it was called off, and is there"), std::string::npos)
      << state_of(0).why;
}

TEST_F(MembersRolloutEnds, AnEntryThatCannotBeReadDoesNotBarItForEver) {
  start_both();
  store.write({{.key = "/mlcca/pair/d/next", .value = "\xff garbage"}});
  run();
  EXPECT_NE(roll_out(0, "2").find("cannot be read"), std::string::npos);
  pass(125 * kSecondNs);
  EXPECT_FALSE(store.entries.contains("/mlcca/pair/d/next"));
  expect_that_the_next_one_comes_into_force();
}

/// A file system that hangs, under a reload.
TEST_F(MembersRolloutEnds, WhereNothingCanBeRead) {
  start_both();
  finish_reading = false;
  at(0).daemon().reload();
  ASSERT_TRUE(at(0).reading().busy());
  at(0).reading().forget();
  ASSERT_EQ(roll_out(0, "2"), "checking");
  pass(125 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "refused");
  at(0).reading().finish();
  expect_that_the_next_one_comes_into_force();
}

// --- texts that are handed over ------------------------------------------------------------------

class Uploading : public MembersRolloutEnds {
 protected:
  void SetUp() override { start_both(); }
  std::string part(std::uint64_t session, const std::string& text, bool more, uid_t uid = 1000) {
    auto peer = member(session);
    peer.uid = uid;
    const auto body =
        at(0).ask(control::RolloutRequest{.part = text, .more = more}, peer).reply.body;
    if (const auto* error = std::get_if<control::Error>(&body)) return error->message;
    if (const auto* done = std::get_if<control::Done>(&body)) return done->message;
    return std::get<control::Rollout>(body).state;
  }
};

TEST_F(Uploading, ThatNeverEndsDoesNotBlockOthers) {
  EXPECT_EQ(part(9, "2", true), "1 byte");
  EXPECT_EQ(part(1, "3", false), "checking");
  pass(8 * kSecondNs);
  EXPECT_TRUE(has(0, 3));
}

TEST_F(Uploading, ManyThatNeverEndGiveWay) {
  for (std::uint64_t session = 10; session < 40; ++session)
    EXPECT_EQ(part(session, "4", true), "1 byte") << session;
  // One of another user, with both of its parts.
  at(0).handed_on[22] = at(1).handed_on[22] = grown_system();
  EXPECT_EQ(part(50, "2", true, 1001), "1 byte");
  for (std::uint64_t session = 60; session < 80; ++session) part(session, "4", true);
  EXPECT_EQ(part(50, "2", false, 1001), "checking");
  pass(8 * kSecondNs);
  EXPECT_TRUE(has(0, 22));
  EXPECT_NE(part(10, "4", false).find("given up"), std::string::npos);
}

TEST_F(Uploading, EndsWithItsClientOrAfterAWhile) {
  EXPECT_EQ(part(9, "4", true), "1 byte");
  at(0).daemon().session_closed(9);
  EXPECT_EQ(part(9, "4", true), "1 byte");
  pass(61 * kSecondNs);
  EXPECT_NE(part(9, "4", true).find("given up"), std::string::npos);
  EXPECT_EQ(part(9, "3", false), "checking") << "from the beginning";
}

TEST_F(Uploading, BeginsAfreshAfterAnotherRequestOfTheSameClient) {
  EXPECT_EQ(part(1, "4", true), "1 byte");
  EXPECT_NE(rolled(0, {.back = true}).find("nothing was changed"), std::string::npos);
  EXPECT_EQ(part(1, "3", false), "checking");
  pass(8 * kSecondNs);
  EXPECT_TRUE(has(0, 3));
}

}  // namespace
}  // namespace mlcca::test
