// SPDX-License-Identifier: BSD-2-Clause
// A rollout is given up by an operator: nothing of it is in force anywhere, and the next one is
// possible.
#include <gtest/gtest.h>

#include <cstddef>
#include <string>

#include "tests/daemon/gateway/members_rollout.hpp"

namespace mlcca::test {
namespace {

constexpr const char* kGivenUpAt0 = "g0: an operator has given it up at g0";

class MembersRolloutCancel : public MembersRollout {
 protected:
  std::string give_up(std::size_t g) { return rolled(g, {.cancel = true}); }
  void expect_the_former_one() {
    EXPECT_FALSE(store.entries.contains("/mlcca/pair/d/next"));
    for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 1)) << g;
    EXPECT_TRUE(state_of(0).open);
    EXPECT_TRUE(passes(0, 0));
    EXPECT_FALSE(passes(0, 5));
  }
  void expect_that_the_next_one_comes_into_force() {
    finish_reading = true;
    ASSERT_EQ(roll_out(0, "3"), "checking");
    pass(8 * kSecondNs);
    EXPECT_EQ(state_of(0).state, "in-force") << state_of(0).why;
    for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 3)) << g;
  }
};

TEST_F(MembersRolloutCancel, WhileGatewaysVote) {
  propose_to_both();
  EXPECT_EQ(give_up(0), "judged");
  pass(3 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "refused");
  EXPECT_EQ(state_of(0).why, kGivenUpAt0);
  expect_the_former_one();
  expect_that_the_next_one_comes_into_force();
}

TEST_F(MembersRolloutCancel, AtAnotherGateway) {
  propose_to_both();
  give_up(1);
  pass(3 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "refused");
  EXPECT_EQ(state_of(0).why, "g1: an operator has given it up at g1");
  expect_the_former_one();
  expect_that_the_next_one_comes_into_force();
}

TEST_F(MembersRolloutCancel, WhileTheTextIsRead) {
  start_both();
  finish_reading = false;
  ASSERT_EQ(roll_out(0, "2"), "checking");
  run();
  EXPECT_EQ(give_up(0), "refused");
  at(0).reading().finish();
  pass(3 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "refused");
  expect_the_former_one();
  expect_that_the_next_one_comes_into_force();
}

/// The text that was given up is read to its end, and counts for nothing.
TEST_F(MembersRolloutCancel, AnotherOneIsBegunBeforeTheTextWasRead) {
  start_both();
  finish_reading = false;
  ASSERT_EQ(roll_out(0, "2"), "checking");
  run();
  ASSERT_EQ(give_up(0), "refused");
  ASSERT_EQ(roll_out(0, "3"), "checking");
  at(0).reading().finish();
  finish_reading = true;
  pass(8 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "in-force") << state_of(0).why;
  for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 3)) << g;
}

TEST_F(MembersRolloutCancel, BeforeTheStoreHasTheProposal) {
  start_both();
  link(0).answers = false;
  ASSERT_EQ(roll_out(0, "2"), "checking");
  run();
  give_up(0);
  link(0).answers = true;
  pass(8 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "refused") << state_of(0).why;
  expect_the_former_one();
  expect_that_the_next_one_comes_into_force();
}

/// All have agreed, and the other gateway does not load it.
TEST_F(MembersRolloutCancel, WhileOneGatewayHasNotFollowed) {
  propose_to_both();
  at(1).reading().finish();
  for (int n = 0; n < 20 && !at(0).reading().busy(); ++n) pass(kStepNs);
  ASSERT_TRUE(at(0).reading().busy());
  at(0).reading().finish();
  pass(kSecondNs);
  ASSERT_EQ(state_of(0).state, "switching");
  ASSERT_TRUE(has(0, 2));
  ASSERT_TRUE(has(1, 1));
  give_up(0);
  finish_reading = true;
  pass(8 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "refused") << state_of(0).why;
  expect_the_former_one();
  expect_that_the_next_one_comes_into_force();
}

TEST_F(MembersRolloutCancel, NothingIsBeingRolledOut) {
  start_both();
  EXPECT_EQ(give_up(0), "nothing was changed: no description is being rolled out");
  ASSERT_EQ(roll_out(0, "2"), "checking");
  pass(8 * kSecondNs);
  EXPECT_EQ(give_up(0), "nothing was changed: no description is being rolled out");
  EXPECT_TRUE(has(0, 2));
}

}  // namespace
}  // namespace mlcca::test
