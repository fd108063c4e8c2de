// SPDX-License-Identifier: BSD-2-Clause
// Two gateways that could carry the same: by the store one knows when the other one has failed.
#include <gtest/gtest.h>

#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

/// Both are on own0 and on the shared bus, so both could carry c0; g0 is the first one.
core::System parallel_gateways() {
  core::System system = two_gateways();
  core::Port port = system.gateways[0].ports.back();
  port.identity.name = "own0";
  system.gateways[1].ports.push_back(port);
  return system;
}

class MembersSideBySide : public MembershipBench {
 protected:
  MembersSideBySide() : MembershipBench(parallel_gateways()) {}

  /// Until g0 is counted as dead: its lease, and what others wait beside that.
  static constexpr std::uint64_t kDead = 14 * kSecondNs;
};

TEST_F(MembersSideBySide, OneCarriesAndTheOtherTakesOver) {
  start_both();
  EXPECT_TRUE(passes(0, 0));
  EXPECT_FALSE(passes(1, 0));
  at(0).end();
  pass(kDead);
  EXPECT_TRUE(passes(1, 0));
  start(0);
  pass(4 * kSecondNs);
  EXPECT_TRUE(passes(0, 0));
  EXPECT_FALSE(passes(1, 0));
}

TEST_F(MembersSideBySide, ItTakesOverASecondTimeAsSoonAsTheFirst) {
  start_both();
  for (int time = 0; time < 3; ++time) {
    at(0).end();
    pass(kDead);
    EXPECT_TRUE(passes(1, 0)) << "time " << time;
    start(0);
    pass(4 * kSecondNs);
    EXPECT_FALSE(passes(1, 0));
  }
}

}  // namespace
}  // namespace mlcca::test
