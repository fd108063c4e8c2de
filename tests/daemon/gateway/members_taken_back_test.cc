// SPDX-License-Identifier: BSD-2-Clause
// Tests of what a gateway has agreed to and cannot carry any more: the gateway that has asked for
// it ends it, and nobody is promised its part before the store has nothing of it.
#include <gtest/gtest.h>

#include <cstddef>
#include <string>

#include "tests/daemon/gateway/members_passing.hpp"

namespace mlcca::test {
namespace {

class MembersTakenBack : public MembersPassing {
 protected:
  /// c0, as described, and c3: messages that the gateway counts on the shared bus.
  std::size_t counted(std::size_t g) {
    return at(g).state().ledger().schedule(kSharedBus)->messages().size();
  }
  void set_link(std::size_t g, const std::string& network, bool up) {
    at(g).kernel.interfaces.at(network).up = up;
    at(g).daemon().links_changed();
    run();
  }
};

TEST_F(MembersTakenBack, WhatEndsWithItsPublisherCountsAsLongAsTheStoreHasIt) {
  admit_both();
  ASSERT_EQ(counted(0), 2U);
  // The gateway for which it was made does not learn of the end.
  link(1).answers = false;
  at(0).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "c3own0"});
  for (int n = 0; n < 200; ++n) {
    run();
    EXPECT_EQ(counted(0), entries("r/shared/") == 0 ? 1U : 2U) << n;
    pass(kStepNs);
  }
  EXPECT_EQ(entries("r/shared/"), 0U) << "at the end of the lease of the other gateway";
}

/// The publisher is behind the network that is down: its gateway has admitted the subscriber in the
/// name of the other one.
TEST_F(MembersTakenBack, ASubscriberOfAPublisherWhoseNetworkIsDownEndsAndIsAskedForAgain) {
  admit_both();
  set_link(0, "own0", false);
  pass(kSecondNs);
  EXPECT_FALSE(passes_on("own1"));
  EXPECT_TRUE(at(1).state().admissions().empty()) << "it waits for the other gateway";
  EXPECT_EQ(said(1, "own0 is down"), 1U) << all_said(1);
  set_link(0, "own0", true);
  pass(40 * kSecondNs);
  EXPECT_TRUE(passes_on("own1")) << all_said(1);
  end_all();
}

/// The subscriber is behind it: its gateway has agreed to an admission of the other one.
TEST_F(MembersTakenBack, AnAdmissionOverANetworkOfAnotherGatewayEndsWhileThatIsDown) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
  ASSERT_TRUE(passes_on("own1"));
  set_link(1, "own1", false);
  pass(kSecondNs);
  EXPECT_FALSE(granted(0, kThirdChannel));
  EXPECT_FALSE(passes(0, kThirdChannel)) << "nothing is sent to nowhere";
  EXPECT_EQ(said(0, "refused from own0 to own1: waits for gateway g1: "), 1U) << all_said(0);
  EXPECT_GE(said(0, "own1 is down"), 1U) << all_said(0);
  // Also soon after it was granted again.
  for (int n = 0; n < 3; ++n) {
    set_link(1, "own1", true);
    pass(15 * kSecondNs);
    EXPECT_TRUE(granted(0, kThirdChannel)) << n << '\n' << all_said(0);
    EXPECT_TRUE(passes_on("own1")) << n;
    set_link(1, "own1", false);
    pass(kSecondNs);
    EXPECT_FALSE(granted(0, kThirdChannel)) << n;
  }
}

TEST_F(MembersTakenBack, WhatIsCarriedAgainIsGrantedAgainAfterEachOutage) {
  admit_both();
  for (int n = 0; n < 3; ++n) {
    set_link(0, "own0", false);
    pass(2 * kSecondNs);
    EXPECT_FALSE(passes_on("own1")) << n;
    set_link(0, "own0", true);
    pass(40 * kSecondNs);
    EXPECT_TRUE(passes_on("own1")) << n;
  }
  EXPECT_EQ(counted(0), 2U);
  EXPECT_EQ(counted(1), 2U);
  end_all();
}

/// Nothing is taken back only because the store does not answer: the lease decides then.
TEST_F(MembersTakenBack, NothingIsTakenBackWhileNetworksAreClosedForAnotherReason) {
  admit_both();
  link(0).up = false;
  pass(12 * kSecondNs);
  EXPECT_FALSE(passes_on("own1"));
  link(0).up = true;
  pass(40 * kSecondNs);
  EXPECT_TRUE(passes_on("own1"));
  EXPECT_EQ(said(1, "is down"), 0U) << all_said(1);
}

}  // namespace
}  // namespace mlcca::test
