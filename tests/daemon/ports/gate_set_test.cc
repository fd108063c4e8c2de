// SPDX-License-Identifier: BSD-2-Clause
// One gate takes the place of another, alone or with others and a way back.
#include "daemon/ports/gate_set.hpp"

#include <gtest/gtest.h>

#include "tests/daemon/ports/fake_gates.hpp"

namespace mlcca {
namespace {

GateSpec spec(int ifindex, std::size_t slots) {
  return gate_spec(test::ethernet(ifindex, "eth" + std::to_string(ifindex)),
                   core::NetworkKind::udp_multicast, core::Profile::famouso, core::Refused::error,
                   slots);
}

class GateSetTest : public ::testing::Test {
 protected:
  GateSetTest() {
    EXPECT_TRUE(gates_.hold(spec(1, 8)));
    EXPECT_TRUE(gates_.hold(spec(2, 8)));
    hooks_.loaded = 0;
  }
  /// Both interfaces get gates for so many slots.
  Result<void> change_to(std::size_t slots) {
    for (const int ifindex : {1, 2})
      if (auto made = gates_.make_spare(spec(ifindex, slots)); !made) return made;
    gates_.begin_change();
    return {};
  }

  test::FakeHooks hooks_;
  GateSet gates_{test::load_into(hooks_)};
};

TEST_F(GateSetTest, AGateThatIsThereIsNotLoadedAgain) {
  EXPECT_TRUE(gates_.hold(spec(1, 8)));
  EXPECT_TRUE(gates_.make_spare(spec(1, 8)));
  EXPECT_EQ(hooks_.loaded, 0U);
}

TEST_F(GateSetTest, AGateThatCannotBePutLeavesTheOneThatWasThere) {
  hooks_.refuses = true;
  EXPECT_FALSE(gates_.hold(spec(1, 9)));
  EXPECT_EQ(hooks_.in_place[1], "eth1 for 8 slots, again");
  hooks_.refuses = false;
  EXPECT_TRUE(gates_.hold(spec(1, 8))) << "it is still the one that is commanded";
  EXPECT_EQ(hooks_.loaded, 1U);
}

TEST_F(GateSetTest, AChangeTakesWhatWasMadeForIt) {
  ASSERT_TRUE(change_to(9));
  EXPECT_EQ(hooks_.in_place[1], "eth1 for 8 slots") << "nothing is put in place yet";
  hooks_.lacks_memory = true;
  EXPECT_TRUE(gates_.hold(spec(1, 9)));
  EXPECT_TRUE(gates_.hold(spec(2, 9)));
  EXPECT_EQ(hooks_.in_place[1], "eth1 for 9 slots");
}

TEST_F(GateSetTest, AChangeThatFailsGoesBackWithoutMemory) {
  ASSERT_TRUE(change_to(9));
  ASSERT_TRUE(gates_.hold(spec(1, 9)));
  hooks_.refuses = true;
  EXPECT_FALSE(gates_.hold(spec(2, 9)));
  hooks_.refuses = false;
  EXPECT_TRUE(gates_.must_go_back());
  EXPECT_FALSE(gates_.hold(spec(1, 7))) << "after the first error nothing is put in place";
  gates_.go_back();
  hooks_.lacks_memory = true;
  EXPECT_TRUE(gates_.hold(spec(1, 8)));
  EXPECT_TRUE(gates_.hold(spec(2, 8)));
  EXPECT_EQ(hooks_.in_place[1], "eth1 for 8 slots");
}

TEST_F(GateSetTest, WhatFailsOnTheWayBackDoesNotEndIt) {
  ASSERT_TRUE(change_to(9));
  gates_.go_back();
  hooks_.refuses = true;
  EXPECT_FALSE(gates_.hold(spec(1, 7)));
  hooks_.refuses = false;
  EXPECT_FALSE(gates_.must_go_back());
  EXPECT_TRUE(gates_.hold(spec(2, 8)));
}

TEST_F(GateSetTest, AfterAChangeADisplacedGateIsMadeAgain) {
  ASSERT_TRUE(change_to(9));
  ASSERT_TRUE(gates_.hold(spec(1, 9)));
  gates_.end_change();
  hooks_.lacks_memory = true;
  EXPECT_FALSE(gates_.hold(spec(1, 8)));
}

TEST_F(GateSetTest, WhatMayBePutInPlaceIsDeniedAsWell) {
  ASSERT_TRUE(change_to(9));
  gates_.deny(1);
  EXPECT_EQ(hooks_.denied, (std::set<std::string>{"eth1 for 8 slots", "eth1 for 9 slots"}));
}

TEST_F(GateSetTest, TheGateBehindTheLastOneIsNone) {
  EXPECT_EQ(gates_.next(0), 1);
  EXPECT_EQ(gates_.next(1), 2);
  EXPECT_EQ(gates_.next(2), std::nullopt);
}

}  // namespace
}  // namespace mlcca
