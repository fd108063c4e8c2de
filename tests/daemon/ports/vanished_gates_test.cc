// SPDX-License-Identifier: BSD-2-Clause
// Which gates are let go, by what the kernel lists, reports and answers.
#include "daemon/ports/vanished_gates.hpp"

#include <gtest/gtest.h>

#include "tests/daemon/ports/fake_gates.hpp"

namespace mlcca {
namespace {

class VanishedGatesTest : public ::testing::Test {
 protected:
  VanishedGatesTest() {
    EXPECT_TRUE(gates_.hold(closed_gate_spec(eth7_, 8)));
    links_.emplace(7, eth7_);
  }
  void let_go() {
    vanished_.let_go(gates_, links_, [this](int) { return answer_; });
  }

  net::Link eth7_ = test::ethernet(7, "eth7");
  net::InterfaceTable links_;
  net::Presence answer_ = net::Presence::there;
  test::FakeHooks hooks_;
  GateSet gates_{test::load_into(hooks_)};
  VanishedGates vanished_;
};

TEST_F(VanishedGatesTest, AGateStaysWhileItsInterfaceIsListed) {
  answer_ = net::Presence::gone;
  let_go();
  EXPECT_TRUE(gates_.contains(7)) << "the kernel has not reported that it went";
  EXPECT_FALSE(vanished_.unconfirmed());
}

TEST_F(VanishedGatesTest, AGateIsLetGoWhenTheKernelSaysThatItsInterfaceHasGone) {
  links_.clear();
  answer_ = net::Presence::gone;
  let_go();
  EXPECT_FALSE(gates_.contains(7));
  EXPECT_TRUE(hooks_.unpinned.contains(7));
}

TEST_F(VanishedGatesTest, AGateStaysWhileTheKernelDoesNotAnswer) {
  links_.clear();
  answer_ = net::Presence::unknown;
  let_go();
  EXPECT_TRUE(gates_.contains(7));
  EXPECT_TRUE(vanished_.unconfirmed()) << "it is asked again";
}

TEST_F(VanishedGatesTest, AnInterfaceThatIsThereButNotListedYetKeepsItsGate) {
  links_.clear();
  let_go();
  EXPECT_TRUE(gates_.contains(7));
  EXPECT_TRUE(vanished_.unconfirmed());
}

TEST_F(VanishedGatesTest, WhereAnotherInterfaceHasTheNumberThePinsStayForTheNextGate) {
  vanished_.note({7}, gates_);
  let_go();
  EXPECT_FALSE(gates_.contains(7));
  EXPECT_FALSE(hooks_.unpinned.contains(7));
  EXPECT_FALSE(vanished_.unconfirmed());
}

TEST_F(VanishedGatesTest, InterfacesWithoutAGateAreNotWaitedFor) {
  vanished_.note({8}, gates_);
  EXPECT_FALSE(vanished_.unconfirmed());
}

}  // namespace
}  // namespace mlcca
