// SPDX-License-Identifier: BSD-2-Clause
// Tests of admissions that need no reservation, and that another gateway on their way does not
// carry any more, or not yet.
#include <gtest/gtest.h>

#include <cstddef>
#include <string>

#include "daemon/cluster/record_codec.hpp"
#include "tests/daemon/gateway/members_across.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

class MembersAgreed : public MembersAcross {
 protected:
  void admit_program() {
    start_both();
    ASSERT_EQ(asked(0, program_on("g1")), "granted");
  }
  /// What g0 says of it now.
  std::string shown() { return asked(0, program_on("g1")); }
  bool is_described_one_granted() {
    const auto& verdicts = at(0).state().decisions().front().verdicts;
    return !verdicts.empty() && verdicts.front().granted;
  }
  /// g1 takes back that it carries what g0 has asked it for.
  void take_back() {
    for (const auto& [name, entry] : store.entries) {
      if (!name.starts_with("/mlcca/pair/x/g0/")) continue;
      store.write(
          {{.key = "/mlcca/pair/a/g1/g0/" + name.substr(name.rfind('/') + 1),
            .value = codec.write(cc::VoteOf{
                .asked = entry.create, .vote = {.ok = false, .hop = {}, .reason = "cable"}})}});
      break;
    }
    run();
  }

  cluster::RecordCodec codec{with_datagrams(), cc::Digest{1}};
};

TEST_F(MembersAgreed, WhatTheOtherGatewayHasTakenBackIsNotGranted) {
  admit_program();
  take_back();
  EXPECT_NE(shown().find("waits for gateway g1"), std::string::npos) << shown();
  EXPECT_TRUE(is_described_one_granted()) << "what is described goes on";
  pass(15 * kSecondNs);
  EXPECT_EQ(shown(), "granted") << "the other gateway was asked again";
  EXPECT_EQ(at(1).state().admissions().size(), 1U);
  EXPECT_EQ(entries("x/g0/"), 1U);
}

TEST_F(MembersAgreed, WhatADeadGatewayWouldCarryIsNotGrantedUntilItIsBack) {
  admit_program();
  at(1).end();
  link(1).up = false;
  pass(20 * kSecondNs);
  EXPECT_NE(shown().find("waits for gateway g1"), std::string::npos) << shown();
  EXPECT_TRUE(is_described_one_granted());
  link(1).up = true;
  start(1);
  pass(20 * kSecondNs);
  EXPECT_EQ(shown(), "granted");
  EXPECT_EQ(at(1).state().admissions().size(), 1U);
}

TEST_F(MembersAgreed, WhoHasLostItsMembershipDoesNotGrantItBeforeTheOthersAgree) {
  admit_program();
  link(1).answers = false;  // g1 cannot vote
  store.write({{.key = "/mlcca/pair/f/g0", .value = "g1"}});
  pass(2 * kSecondNs);
  ASSERT_TRUE(is_described_one_granted()) << "it has joined again";
  EXPECT_NE(shown().find("waits for gateway g1"), std::string::npos) << shown();
  link(1).answers = true;
  pass(20 * kSecondNs);
  EXPECT_EQ(shown(), "granted");
}

TEST_F(MembersAgreed, ItContinuesOverARestart) {
  admit_program();
  for (const std::size_t g : {std::size_t{0}, std::size_t{1}}) {
    at(g).end();
    start(g);
    pass(4 * kSecondNs);
    EXPECT_EQ(shown(), "granted") << g;
    EXPECT_EQ(at(1).state().admissions().size(), 1U) << g;
  }
}

/// The publisher has a subscriber on its own gateway, too.
TEST_F(MembersAgreed, WhatStaysOnThisGatewayIsNotConcerned) {
  start_both();
  auto here = program_on("g0");
  here.key = here.subscriber = "here";
  ASSERT_EQ(asked(0, here), "granted");
  ASSERT_EQ(asked(0, program_on("g1")), "granted");
  take_back();
  EXPECT_EQ(asked(0, here), "granted");
}

}  // namespace
}  // namespace mlcca::test
