// SPDX-License-Identifier: BSD-2-Clause
// One description for all gateways: it comes into force for all or for none, whoever dies
// meanwhile.
#include "tests/daemon/gateway/members_rollout.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <variant>

namespace mlcca::test {
namespace {

TEST_F(MembersRollout, ComesIntoForceForAllUnderAnAdmission) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  ASSERT_FALSE(passes(0, 5));
  EXPECT_EQ(roll_out(0, "2"), "checking");
  pass(5 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "in-force") << state_of(0).why;
  for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 2)) << g;
  EXPECT_TRUE(passes(0, 5));
  EXPECT_TRUE(passes(0, 0));
  EXPECT_TRUE(passes(0, 2)) << "it has asked again";
  EXPECT_NE(std::ranges::find(at(0).events, "rollout"), at(0).events.end());
}

TEST_F(MembersRollout, WhatOneGatewayAdmitsForAnotherIsThereAgain) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  control::Admit subscriber;
  subscriber.channel = "c2";
  subscriber.to = "own1";
  subscriber.key = subscriber.subscriber = "also";
  ASSERT_EQ(asked(1, subscriber), "granted");
  ASSERT_EQ(roll_out(0, "2"), "checking");
  pass(25 * kSecondNs);
  ASSERT_EQ(state_of(0).state, "in-force") << state_of(0).why;
  EXPECT_EQ(asked(1, subscriber), "granted") << "the same one";
  EXPECT_EQ(entries("x/g1/"), 1U);
  EXPECT_EQ(at(0).state().decisions()[2].granted, 2U);
}

TEST_F(MembersRollout, WhatOneRefusesComesIntoForceForNobody) {
  start_both();
  at(1).handed_on.erase(2);
  ASSERT_EQ(roll_out(0, "2"), "checking");
  pass(3 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "refused");
  EXPECT_EQ(state_of(0).why, "g1: line 3: no such network");
  for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 1)) << g;
  EXPECT_TRUE(passes(0, 0));
}

TEST_F(MembersRollout, WhatTheProposerCannotUseIsNotProposed) {
  start_both();
  EXPECT_EQ(roll_out(0, "9"), "checking");
  pass(kSecondNs);
  EXPECT_EQ(state_of(0).state, "refused");
  EXPECT_FALSE(store.entries.contains("/mlcca/pair/d/next"));
  ASSERT_EQ(roll_out(0, "4"), "checking");
  pass(kSecondNs);
  EXPECT_NE(state_of(0).why.find("cannot rename"), std::string::npos) << state_of(0).why;
  ASSERT_EQ(roll_out(0, "2", {"g7"}), "checking");
  pass(kSecondNs);
  EXPECT_NE(state_of(0).why.find("no gateway 'g7'"), std::string::npos) << state_of(0).why;
  EXPECT_NE(roll_out(0, "2", {"g0"}).find("not off"), std::string::npos);
}

TEST_F(MembersRollout, ComesInParts) {
  start_both();
  at(0).handed_on[22] = at(1).handed_on[22] = grown_system();
  EXPECT_EQ(rolled(0, {.part = "2", .more = true}), "1 byte");
  EXPECT_EQ(rolled(1, {.part = "3", .more = true}), "1 byte") << "another gateway's own";
  EXPECT_EQ(roll_out(0, "2"), "checking");
  pass(5 * kSecondNs);
  EXPECT_TRUE(has(1, 22));
}

TEST_F(MembersRollout, GoesBackByOneCommand) {
  start_both();
  ASSERT_EQ(roll_out(0, "2"), "checking");
  pass(5 * kSecondNs);
  ASSERT_TRUE(has(1, 2));
  EXPECT_EQ(rolled(1, {.back = true}), "checking");
  pass(5 * kSecondNs);
  EXPECT_EQ(state_of(1).state, "in-force") << state_of(1).why;
  for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 1)) << g;
  EXPECT_TRUE(passes(0, 0));
  EXPECT_FALSE(passes(0, 5));
}

TEST_F(MembersRollout, StaysAfterARestartUntilTheFileIsChanged) {
  start_both();
  ASSERT_EQ(roll_out(0, "2"), "checking");
  pass(5 * kSecondNs);
  start_again(1);
  EXPECT_TRUE(has(1, 2)) << "the file is as it was";
  pass(3 * kSecondNs);
  EXPECT_TRUE(passes(0, 5));
  at(1).daemon().reload();
  pass(3 * kSecondNs);
  EXPECT_TRUE(has(1, 2));
  // The operator has written another one: it is what he wants, and closes what is shared.
  at(1).digest = 7;
  start_again(1);
  pass(5 * kSecondNs);
  EXPECT_TRUE(has(1, 7));
  EXPECT_NE(asked(1, wanted("c3", "own1", "shared")).find("--accept"), std::string::npos);
  EXPECT_EQ(rolled(1, {.accept = true}).find("description"), 0U);
  pass(5 * kSecondNs);
  EXPECT_TRUE(has(1, 2));
  EXPECT_EQ(asked(1, wanted("c3", "own1", "shared")), "granted");
}

TEST_F(MembersRollout, WhoWasOffFollowsWhenItIsBack) {
  start_both();
  at(1).daemon().begin_stop();
  pass(3 * kSecondNs);
  at(1).daemon().stop();
  at(1).end();
  ASSERT_EQ(roll_out(0, "2", {"g1"}), "checking");
  pass(5 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "in-force") << state_of(0).why;
  start(1);
  EXPECT_TRUE(has(1, 1));
  EXPECT_FALSE(granted(1, 0));
  pass(5 * kSecondNs);
  EXPECT_TRUE(has(1, 2)) << "from the store";
  EXPECT_EQ(asked(1, wanted("c3", "own1", "shared")), "granted");
}

/// The gateways that are there propose it all the time by themselves, and wait for the other one.
TEST_F(MembersRollout, TheFirstOneComesIntoForceWithoutWhoIsOff) {
  start(0);
  pass(5 * kSecondNs);
  ASSERT_TRUE(store.entries.contains("/mlcca/pair/d/next"));
  ASSERT_EQ(roll_out(0, "1", {"g1"}), "checking");
  pass(4 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "in-force") << state_of(0).why;
  EXPECT_TRUE(passes(0, 0));
  start(1);
  pass(4 * kSecondNs);
  EXPECT_EQ(asked(1, wanted("c3", "own1", "shared")), "granted");
}

TEST_F(MembersRollout, WhoComesWithADescriptionCanBeCalledOff) {
  core::System more = grown_system();
  more.gateways.push_back(more.gateways[1]);
  more.gateways.back().name = "g2";
  for (std::size_t g = 0; g < 2; ++g) at(g).handed_on[5] = more;
  start_both();
  ASSERT_EQ(roll_out(0, "5", {"g2"}), "checking");
  pass(5 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "in-force") << state_of(0).why;
  EXPECT_TRUE(passes(0, 0));
}

TEST_F(MembersRollout, WhoHasAFileThatNeverWasInForceDoesNotFollow) {
  start_both();
  at(1).end();
  at(1).texts.all.clear();
  at(1).digest = 7;
  start(1);
  pass(5 * kSecondNs);
  EXPECT_TRUE(has(1, 7));
  EXPECT_FALSE(granted(1, 0));
}

TEST_F(MembersRollout, WhoRestartsBetweenVoteAndSwitchSwitches) {
  propose_to_both();
  ASSERT_TRUE(at(1).reading().busy());
  at(1).reading().finish();
  link(0).answers = false;  // the one that decides stands still
  run();
  at(1).end();
  start(1);
  EXPECT_TRUE(has(1, 1));
  link(0).answers = true;
  finish_reading = true;
  pass(6 * kSecondNs);
  for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 2)) << g;
  EXPECT_TRUE(passes(0, 5));
}

TEST_F(MembersRollout, IsGivenUpWhenWhoHasProposedItDies) {
  propose_to_both();
  at(0).end();
  finish_reading = true;
  pass(125 * kSecondNs);
  EXPECT_FALSE(store.entries.contains("/mlcca/pair/d/next"));
  EXPECT_TRUE(has(1, 1));
  start(0);
  pass(5 * kSecondNs);
  EXPECT_TRUE(passes(0, 0));
}

TEST_F(MembersRollout, GoesOnWhenTheStoreIsBack) {
  propose_to_both();
  for (std::size_t g = 0; g < 2; ++g) link(g).up = false;
  finish_reading = true;
  pass(5 * kSecondNs);
  EXPECT_TRUE(has(1, 1));
  EXPECT_NE(roll_out(1, "3").find("the store does not answer"), std::string::npos);
  for (std::size_t g = 0; g < 2; ++g) link(g).up = true;
  pass(8 * kSecondNs);
  for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 2)) << g;
}

TEST_F(MembersRollout, OfTwoAtOnceOneIsRefused) {
  start_both();
  ASSERT_EQ(roll_out(0, "2"), "checking");
  ASSERT_EQ(roll_out(1, "3"), "checking");
  pass(6 * kSecondNs);
  const std::string one = state_of(0).state;
  const std::string other = state_of(1).state;
  EXPECT_TRUE((one == "in-force") != (other == "in-force")) << one << ' ' << other;
  EXPECT_TRUE(one == "refused" || other == "refused") << one << ' ' << other;
  EXPECT_EQ(has(0, 2), has(1, 2));
  EXPECT_TRUE(passes(0, 5));
}

TEST_F(MembersRollout, ThatOneCannotPutInForceIsTakenBack) {
  propose_to_both();
  ASSERT_TRUE(at(1).reading().busy());
  at(1).reading().finish();
  // It has agreed, and cannot read it any more.
  at(1).handed_on.erase(2);
  finish_reading = true;
  pass(10 * kSecondNs);
  for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 1)) << g;
  EXPECT_EQ(state_of(0).state, "refused");
  EXPECT_TRUE(passes(0, 0));
  EXPECT_FALSE(passes(0, 5));
}

TEST_F(MembersRollout, WhatCannotBeKeptIsNotAgreedTo) {
  start_both();
  at(1).texts.full = true;
  ASSERT_EQ(roll_out(0, "2"), "checking");
  pass(3 * kSecondNs);
  EXPECT_NE(state_of(0).why.find("cannot be kept"), std::string::npos) << state_of(0).why;
}

TEST_F(MembersRollout, IsNothingForAGatewayAlone) {
  at(0).cluster = nullptr;
  ASSERT_FALSE(at(0).start());
  EXPECT_NE(roll_out(0, "2").find("mlccactl reload"), std::string::npos);
}

}  // namespace
}  // namespace mlcca::test
