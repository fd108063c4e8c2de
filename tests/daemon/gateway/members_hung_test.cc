// SPDX-License-Identifier: BSD-2-Clause
// A daemon that has hung until its kernel closed the gates does not know what has come into force
// since.
#include <gtest/gtest.h>

#include "tests/daemon/gateway/members_rollout.hpp"

namespace mlcca::test {
namespace {

class MembersHung : public MembersRollout {
 protected:
  void hang() {
    start_both();
    ASSERT_TRUE(passes(0, 0));
    nodes[0]->hangs = true;
    pass(20 * kSecondNs);
    ASSERT_FALSE(at(0).kernel.passes());
  }
  /// Its first heart-beat comes before it has read anything.
  void go_on() {
    nodes[0]->hangs = false;
    at(0).daemon().beat();
  }
};

TEST_F(MembersHung, DoesNotSendByADescriptionThatWasReplaced) {
  hang();
  ASSERT_EQ(roll_out(1, "2", {"g0"}), "checking");
  pass(15 * kSecondNs);  // it counts the lease of the other one from its reload
  ASSERT_EQ(state_of(1).state, "in-force") << state_of(1).why;
  go_on();
  EXPECT_FALSE(passes(0, 0));
  pass(5 * kSecondNs);
  EXPECT_TRUE(has(0, 2));
  EXPECT_TRUE(passes(0, 0));
}

TEST_F(MembersHung, OpensAgainWhenTheStoreHasAnswered) {
  hang();
  link(0).up = false;
  go_on();
  pass(5 * kSecondNs);
  EXPECT_FALSE(passes(0, 0)) << "another description may be in force";
  EXPECT_TRUE(at(0).kernel.passes()) << "its own networks are open";
  link(0).up = true;
  pass(5 * kSecondNs);
  EXPECT_TRUE(passes(0, 0));
}

}  // namespace
}  // namespace mlcca::test
