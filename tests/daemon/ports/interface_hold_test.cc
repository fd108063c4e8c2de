// SPDX-License-Identifier: BSD-2-Clause
// What holds an interface whose gate cannot be put in place.
#include "daemon/ports/interface_hold.hpp"

#include <gtest/gtest.h>

#include "tests/daemon/ports/fake_gates.hpp"

namespace mlcca {
namespace {

class InterfaceHoldTest : public ::testing::Test {
 protected:
  /// As a gate for so many slots.
  bool attach(std::size_t slots = 8) {
    return hold_
        .attach(
            link_,
            gate_spec(link_, core::NetworkKind::udp_multicast, core::Profile::famouso,
                      core::Refused::error, slots),
            gates_, [this](const std::string&) { return closing_; },
            [this](const std::string& line) { reported_.push_back(line); })
        .has_value();
  }

  net::Link link_ = test::ethernet(7, "eth7");
  test::FakeHooks hooks_;
  GateSet gates_{test::load_into(hooks_)};
  Result<gates::Closing> closing_ = gates::Closing::closed;
  std::vector<std::string> reported_;
  InterfaceHold hold_;
};

TEST_F(InterfaceHoldTest, TheGateOfAFormerDescriptionIsDenied) {
  ASSERT_TRUE(attach(8));
  hooks_.refuses = true;
  EXPECT_FALSE(attach(9));
  EXPECT_TRUE(hold_.is_by_former());
  EXPECT_FALSE(hold_.is_lost());
  EXPECT_TRUE(hooks_.denied.contains("eth7 for 8 slots"));
  EXPECT_EQ(reported_, (std::vector<std::string>{"no permission to attach eth7 for 9 slots",
                                                 "eth7 is held closed"}));
  hooks_.refuses = false;
  EXPECT_TRUE(attach(9));
  EXPECT_FALSE(hold_.is_by_former());
}

TEST_F(InterfaceHoldTest, WithoutAnyGateItIsClosedByAProgramWithoutSlots) {
  hooks_.lacks_memory = true;
  EXPECT_FALSE(attach());
  EXPECT_FALSE(hold_.is_lost());
  closing_ = gates::Closing::was_gated;
  EXPECT_FALSE(attach());
  EXPECT_FALSE(hold_.is_lost()) << "that program is still the one there";
  EXPECT_EQ(reported_.size(), 2U) << "the same reason is reported once";
}

TEST_F(InterfaceHoldTest, BehindAnOlderGateOrWithoutAProgramItIsLost) {
  hooks_.lacks_memory = true;
  closing_ = gates::Closing::was_gated;
  EXPECT_FALSE(attach());
  EXPECT_TRUE(hold_.is_lost()) << "that one may pass what it holds";
  closing_ = fail("no permission");
  EXPECT_FALSE(attach());
  EXPECT_TRUE(hold_.is_lost());
  EXPECT_EQ(reported_.back(), "eth7 cannot be held: every gate is closed until it can");
  hooks_.lacks_memory = false;
  EXPECT_TRUE(attach());
  EXPECT_FALSE(hold_.is_lost());
}

TEST_F(InterfaceHoldTest, TheProgramIsKnownAgainAfterANewDescription) {
  hooks_.lacks_memory = true;
  EXPECT_FALSE(attach());
  InterfaceHold next;
  next.take_over(hold_);
  hold_ = next;
  closing_ = gates::Closing::was_gated;
  EXPECT_FALSE(attach());
  EXPECT_FALSE(hold_.is_lost());
}

TEST_F(InterfaceHoldTest, AChangeThatGoesBackLeavesTheInterfaceAsItIs) {
  ASSERT_TRUE(attach(8));
  gates_.begin_change();
  hooks_.refuses = true;
  EXPECT_FALSE(attach(9));
  EXPECT_FALSE(hold_.is_by_former());
  EXPECT_TRUE(hooks_.denied.empty());
  EXPECT_TRUE(reported_.empty());
}

}  // namespace
}  // namespace mlcca
