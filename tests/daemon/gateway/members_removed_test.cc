// SPDX-License-Identifier: BSD-2-Clause
// Tests of what a gateway says after its restart of deliveries that it carried for another one.
#include <gtest/gtest.h>

#include "tests/daemon/gateway/members_passing.hpp"

namespace mlcca::test {
namespace {

class MembersRemoved : public MembersPassing {
 protected:
  void restart_g1() {
    at(1).end();
    at(1).published.clear();
    start(1);
    run();
  }
};

TEST_F(MembersRemoved, ThePublisherIsOfAnotherGateway) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
  restart_g1();
  EXPECT_EQ(said(1, "the description has no place"), 0U) << all_said(1);
  EXPECT_EQ(said(1, "is removed: another gateway has admitted its publisher"), 1U) << all_said(1);
  pass(4 * kSecondNs);
  EXPECT_TRUE(passes_on("own1"));
}

TEST_F(MembersRemoved, ThePublisherIsDescribed) {
  start_both();
  auto request = subscriber("own1");
  request.channel = "c2";
  ASSERT_EQ(asked(0, request), "granted");
  restart_g1();
  EXPECT_EQ(said(1, "the description has it no more"), 0U) << all_said(1);
  EXPECT_EQ(said(1, "is removed: no subscriber of it is described or admitted there now"), 1U)
      << all_said(1);
}

}  // namespace
}  // namespace mlcca::test
