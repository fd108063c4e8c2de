// SPDX-License-Identifier: BSD-2-Clause
// What a former daemon has left on interfaces that are no ports is closed, once it is known.
#include "daemon/ports/former_gates.hpp"

#include <gtest/gtest.h>

#include "tests/daemon/ports/fake_gates.hpp"

namespace mlcca {
namespace {

Result<std::vector<std::uint32_t>> pinned(std::vector<std::uint32_t> interfaces) {
  return interfaces;
}
using Found = Result<std::vector<gates::GatedInterface>>;

/// Interface 7 is a port, 8 is none.
class FormerGatesTest : public ::testing::Test {
 protected:
  FormerGatesTest() {
    links_.emplace(7, test::ethernet(7, "eth7"));
    links_.emplace(8, test::ethernet(8, "eth8"));
  }

  net::InterfaceTable links_;
  net::Presence answer_ = net::Presence::there;
  std::vector<std::string> reported_;
  test::FakeHooks hooks_;
  GateSet gates_{test::load_into(hooks_)};
  FormerGates former_{
      [this](const std::string&, const std::string& line, bool) { reported_.push_back(line); }};
  const FormerGates::Present present_{.links = links_,
                                      .presence = [this](int) { return answer_; },
                                      .is_gated_port = [](int ifindex) { return ifindex == 7; },
                                      .slots = 8};
};

TEST_F(FormerGatesTest, WhatIsPinnedForNoPortIsReplacedAndDenied) {
  former_.close_pinned(pinned({7, 8}), present_, gates_);
  EXPECT_EQ(gates_.interfaces(), std::vector{8});
  EXPECT_TRUE(hooks_.denied.contains(hooks_.in_place[8]));
  EXPECT_EQ(hooks_.loaded, 1U);
  former_.close_pinned(pinned({7, 8}), present_, gates_);
  EXPECT_EQ(hooks_.loaded, 1U) << "it is closed already";
}

TEST_F(FormerGatesTest, WhileThePinsCannotBeReadEverythingIsToBeClosed) {
  former_.close_pinned(fail("input/output error"), present_, gates_);
  former_.close_pinned(fail("input/output error"), present_, gates_);
  EXPECT_TRUE(former_.unread());
  EXPECT_TRUE(former_.needs_recheck());
  EXPECT_EQ(reported_.size(), 1U) << "reported once";
  former_.close_pinned(pinned({}), present_, gates_);
  EXPECT_FALSE(former_.unread());
}

TEST_F(FormerGatesTest, AnInterfaceThatIsNotListedIsLookedForAgainUnlessItHasGone) {
  former_.close_orphans(Found({}), present_, gates_);
  former_.close_pinned(pinned({9}), present_, gates_);
  EXPECT_TRUE(former_.needs_recheck());
  answer_ = net::Presence::gone;
  former_.close_pinned(pinned({9}), present_, gates_);
  EXPECT_FALSE(former_.needs_recheck());
}

TEST_F(FormerGatesTest, OrphansThatPassNothingStayAsTheyAre) {
  former_.close_orphans(Found({{.ifindex = 8, .name = "eth8", .passes = false}}), present_, gates_);
  EXPECT_TRUE(gates_.interfaces().empty());
  EXPECT_FALSE(former_.may_leave_orphans());
}

TEST_F(FormerGatesTest, OrphansAreLookedForUntilTheyAreFound) {
  former_.close_orphans(fail("no answer"), present_, gates_);
  EXPECT_EQ(former_.orphans_unknown(), "no answer");
  EXPECT_TRUE(former_.may_leave_orphans());
  former_.close_orphans(Found({{.ifindex = 8, .name = "eth8", .passes = true}}), present_, gates_);
  EXPECT_EQ(gates_.interfaces(), std::vector{8});
  EXPECT_EQ(former_.orphans_unknown(), "");
  EXPECT_FALSE(former_.may_leave_orphans());
}

TEST_F(FormerGatesTest, AGateThatCannotBeMadeIsReported) {
  hooks_.lacks_memory = true;
  former_.close_pinned(pinned({8}), present_, gates_);
  EXPECT_EQ(reported_, std::vector<std::string>{"no memory for eth8 for 8 slots"});
}

}  // namespace
}  // namespace mlcca
