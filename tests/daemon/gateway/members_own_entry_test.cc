// SPDX-License-Identifier: BSD-2-Clause
// The entry of a gateway in the store is damaged or foreign: status says what to do, and how long
// others wait.
#include <gtest/gtest.h>

#include <string>
#include <variant>

#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

class MembersOwnEntry : public MembershipBench {
 protected:
  void damage(const std::string& gateway) {
    store.write({{.key = "/mlcca/pair/m/" + gateway, .value = "nothing that can be read"}});
  }
  control::Cluster cluster(std::size_t g) {
    auto answer = at(g).ask(control::ClusterRequest{.part = {}, .network = {}, .gateway = {}});
    const auto* found = std::get_if<control::Cluster>(&answer.reply.body);
    return found == nullptr ? control::Cluster{} : *found;
  }
  /// The reasons of the health of the membership, one after the other.
  std::string problems(std::size_t g) {
    std::string all;
    for (const std::string& reason : cluster(g).health.reasons) all += reason + '\n';
    return all;
  }
};

TEST_F(MembersOwnEntry, TheGatewayItselfSaysWhichEntryItIsAndWhatToDo) {
  start_both();
  damage("g0");
  pass(5 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "gone-back");
  EXPECT_NE(cluster(0).why.find("somebody has changed the entry of this gateway "
                                "(/mlcca/pair/m/g0): it needs another epoch "
                                "(docs/how-to/shared-closed.md)"),
            std::string::npos)
      << cluster(0).why;
  // A restart alone does not help, and that is what it says.
  at(0).end();
  start(0);
  pass(5 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "gone-back");
  store.write({{.key = "/mlcca/pair/e", .value = "0123456789abcdef"}});
  pass(20 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "in");
}

TEST_F(MembersOwnEntry, OtherGatewaysSayForHowLongItCounts) {
  start_both();
  damage("g1");
  link(1).up = false;
  pass(5 * kSecondNs);
  const std::string said = problems(0);
  EXPECT_NE(said.find("/mlcca/pair/m/g1 of gateway g1"), std::string::npos) << said;
  EXPECT_NE(said.find("g1 counts as sending for 1 h from then on"), std::string::npos) << said;
  EXPECT_NE(said.find("'mlccactl cluster status' on g1 says what to do"), std::string::npos)
      << said;
}

/// After a restoration it waits for leases, which may take an hour if a beat cannot be read.
TEST_F(MembersOwnEntry, HowLongLeasesFromBeforeMayLastIsStated) {
  start_both();
  store.write({{.key = "/mlcca/pair/e", .value = "0123456789abcdef"}});
  pass(kSecondNs);
  ASSERT_EQ(cluster(0).phase, "waiting");
  EXPECT_NE(cluster(0).why.find("that takes at most 10 s and a second"), std::string::npos)
      << cluster(0).why;
  at(1).end();
  link(1).up = false;
  damage("g1");
  store.write({{.key = "/mlcca/pair/e", .value = "fedcba9876543210"}});
  pass(kSecondNs);
  ASSERT_EQ(cluster(0).phase, "waiting");
  EXPECT_NE(cluster(0).why.find("that takes at most 1 h and a second, because the entry of g1 "
                                "cannot be read"),
            std::string::npos)
      << cluster(0).why;
}

}  // namespace
}  // namespace mlcca::test
