// SPDX-License-Identifier: BSD-2-Clause
// Tests of a gateway that was taken for dead: what it had belongs to nobody from then on, also if
// it starts several times before that has left the store.
#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <variant>

#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

constexpr std::size_t kC3 = 3;

class MembersFenced : public MembershipBench {
 protected:
  /// g0 has c3 on the shared bus, and is dead for g1.
  void fence_g0() {
    start_both();
    ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
    const auto reserved = store.entries.lower_bound("/mlcca/pair/r/shared/g0/");
    ASSERT_NE(reserved, store.entries.end());
    former_ = reserved->first;
    at(0).end();
    store.write({{.key = "/mlcca/pair/f/g0", .value = "g1"}});
    run();
  }
  /// Runs g0 until it has joined, and not until its former entry has left the store.
  void join_g0() {
    start(0);
    for (int n = 0; n < 20 && phase(0) != "in"; ++n) pass(kStepNs);
    ASSERT_EQ(phase(0), "in");
    ASSERT_TRUE(store.entries.contains(former_)) << "it has left the store";
  }
  std::string phase(std::size_t g) {
    auto answer = at(g).ask(control::ClusterRequest{.part = {}, .network = {}, .gateway = {}});
    const auto* found = std::get_if<control::Cluster>(&answer.reply.body);
    return found == nullptr ? std::string() : found->phase;
  }
  /// Messages on the shared bus that g1 counts.
  std::size_t counted_by_g1() {
    return at(1).state().ledger().schedule(kSharedBus)->messages().size();
  }

  std::string former_;  ///< the key of what g0 had reserved
};

TEST_F(MembersFenced, WhatItHadIsNotTakenUpAgainByTheSecondStartEither) {
  fence_g0();
  join_g0();
  at(0).end();
  join_g0();
  for (int n = 0; n < 30; ++n) {
    EXPECT_TRUE(!passes(0, kC3) || counted_by_g1() == 2U) << "g1 may give it away: " << n;
    pass(kStepNs);
  }
  EXPECT_FALSE(store.entries.contains(former_));
  EXPECT_TRUE(passes(0, kC3)) << "it has asked again";
  EXPECT_EQ(entries("r/shared/g0/"), 1U);
}

}  // namespace
}  // namespace mlcca::test
