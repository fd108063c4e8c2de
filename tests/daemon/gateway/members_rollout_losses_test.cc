// SPDX-License-Identifier: BSD-2-Clause
// A rollout that would refuse what is granted at a gateway does not come into force, unless the
// operator wants that.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <string>

#include "tests/daemon/gateway/members_rollout.hpp"

namespace mlcca::test {
namespace {

/// The same, where a channel has no identifier on a network.
core::System without_binding(const std::string& network, std::size_t channel) {
  core::System system = two_gateways();
  for (core::Network& one : system.networks)
    if (one.name == network)
      std::erase_if(one.bindings, [channel](const auto& b) { return b.channel == channel; });
  return system;
}

/// The same with another name of a network, so that admissions have no place there.
core::System with_renamed(const std::string& network) {
  core::System system = two_gateways();
  for (core::Network& one : system.networks)
    if (one.name == network) one.name = "renamed";
  return system;
}

class MembersRolloutLosses : public MembersRollout {
 protected:
  MembersRolloutLosses() {
    for (std::size_t g = 0; g < 2; ++g) {
      at(g).handed_on[5] = without_binding("own0", 3);
      at(g).handed_on[6] = without_binding("own1", 4);
      at(g).handed_on[7] = without_binding("own0", 0);
      at(g).handed_on[8] = with_renamed("own1");
    }
  }
  /// The answer to a rollout in the end.
  control::Rollout ended(const std::string& text, bool force = false) {
    EXPECT_EQ(rolled(0, {.part = text, .force = force}), "checking");
    pass(8 * kSecondNs);
    return state_of(0);
  }
  void expect_nothing_changed() {
    EXPECT_FALSE(store.entries.contains("/mlcca/pair/d/next"));
    for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 1)) << g;
    EXPECT_TRUE(passes(0, 0));
  }
};

TEST_F(MembersRolloutLosses, WhatIsAdmittedHereAndWouldBeRefusedIsAReasonAgainstIt) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  const auto state = ended("5");
  EXPECT_EQ(state.state, "refused");
  EXPECT_EQ(
      state.why,
      "1 grant would be lost: c3 (0x0000000000000004) from own0 to shared: the channel has no "
      "identifier on own0; --force rolls it out all the same");
  expect_nothing_changed();
  EXPECT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
}

TEST_F(MembersRolloutLosses, WithForceItComesIntoForceAllTheSame) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  const auto state = ended("5", true);
  EXPECT_EQ(state.state, "in-force") << state.why;
  EXPECT_FALSE(passes(0, 3));
  EXPECT_TRUE(passes(0, 0));
}

/// Only the other gateway knows what it has admitted on its own network.
TEST_F(MembersRolloutLosses, WhatAnotherGatewayWouldLoseIsItsObjection) {
  start_both();
  control::Admit local = wanted("c4", "own1", "g1");
  ASSERT_EQ(asked(1, local), "granted");
  const auto state = ended("6");
  EXPECT_EQ(state.state, "refused");
  EXPECT_TRUE(state.why.starts_with("g1: 1 grant would be lost: c4 ")) << state.why;
  expect_nothing_changed();
  EXPECT_EQ(asked(1, local), "granted");
  EXPECT_EQ(ended("6", true).state, "in-force");
}

TEST_F(MembersRolloutLosses, WhatIsStillDescribedAndWouldBeRefusedIsALoss) {
  start_both();
  const auto state = ended("7");
  EXPECT_EQ(state.state, "refused");
  EXPECT_NE(state.why.find("c0 (0x0000000000000001) from own0 to shared"), std::string::npos)
      << state.why;
  expect_nothing_changed();
}

TEST_F(MembersRolloutLosses, AnAdmissionWithoutAPlaceIsALoss) {
  start_both();
  ASSERT_EQ(asked(1, wanted("c4", "own1", "g1")), "granted");
  const auto state = ended("8");
  EXPECT_EQ(state.state, "refused");
  EXPECT_NE(state.why.find("the description has no place for what was admitted"), std::string::npos)
      << state.why;
}

/// The operator has taken it out of the description.
TEST_F(MembersRolloutLosses, WhatIsNotDescribedAnyMoreIsNoLoss) {
  start_both();
  ASSERT_EQ(ended("2").state, "in-force");
  ASSERT_TRUE(passes(0, 5));
  EXPECT_EQ(ended("1").state, "in-force") << state_of(0).why;
  EXPECT_FALSE(passes(0, 5));
}

TEST_F(MembersRolloutLosses, WhatIsRefusedAlreadyIsNoLoss) {
  start_both();
  at(1).kernel.unplug("own1");
  at(1).daemon().links_changed();
  pass(kSecondNs);
  ASSERT_NE(asked(1, wanted("c4", "own1", "g1")), "granted");
  EXPECT_EQ(ended("6").state, "in-force") << state_of(0).why;
}

TEST_F(MembersRolloutLosses, TheWayBackIsOpenWhateverItLoses) {
  start_both();
  ASSERT_EQ(ended("5", true).state, "in-force");
  ASSERT_EQ(asked(0, wanted("c4", "own0", "shared")), "granted");
  at(0).handed_on[1] = at(1).handed_on[1] = without_binding("own0", 4);
  EXPECT_EQ(rolled(0, {.back = true}), "checking");
  pass(8 * kSecondNs);
  EXPECT_EQ(state_of(0).state, "in-force") << state_of(0).why;
}

}  // namespace
}  // namespace mlcca::test
