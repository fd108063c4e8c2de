// SPDX-License-Identifier: BSD-2-Clause
// Texts of descriptions on the disk: it may be slow, damaged or full.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>

#include "core/cluster/keys.hpp"
#include "daemon/cluster/codec.hpp"
#include "tests/daemon/gateway/members_rollout.hpp"

namespace mlcca::test {
namespace {

class RolledOutTexts : public MembersRollout {
 protected:
  /// Both are in the second one, and the first gateway has been started with the first one.
  void until_in_force() {
    start_both();
    ASSERT_EQ(roll_out(0, "2"), "checking");
    pass(6 * kSecondNs);
    for (std::size_t g = 0; g < 2; ++g) ASSERT_TRUE(has(g, 2)) << g;
  }
  [[nodiscard]] bool reports(std::size_t g, const std::string& words) {
    return std::ranges::any_of(at(g).published, [&](const control::Event& event) {
      return event.message.find(words) != std::string::npos;
    });
  }
  static std::string blob(std::uint8_t digest) {
    return "/mlcca/pair/d/blob/" + core::cluster::hex_of(Sha256::Digest{digest}) + "/0";
  }
  /// What the gateway has said of what is proposed; the other one sees and does nothing meanwhile.
  bool agrees(std::size_t g) {
    const auto& entries = store.entries;
    const cluster::Codec codec(two_gateways(), Sha256::Digest{1});
    const auto vote = entries.find("/mlcca/pair/d/vote/g" + std::to_string(g));
    if (vote == entries.end() || !entries.contains("/mlcca/pair/d/next")) return false;
    const auto said = codec.rollout_vote(vote->second.value);
    return said && said->ok && said->next == entries.at("/mlcca/pair/d/next").mod;
  }
};

TEST_F(RolledOutTexts, AreNeverWaitedForByTheLoop) {
  for (std::size_t g = 0; g < 2; ++g) at(g).threads = true;
  until_in_force();
  EXPECT_EQ(rolled(1, {.back = true}), "checking");
  pass(5 * kSecondNs);
  ASSERT_TRUE(has(0, 1));
  ASSERT_EQ(roll_out(0, "2"), "checking");
  pass(6 * kSecondNs);
  start_again(1);
  pass(4 * kSecondNs);
  at(1).digest = 7;
  at(1).daemon().reload();
  pass(4 * kSecondNs);
  ASSERT_TRUE(has(1, 7));
  EXPECT_EQ(rolled(1, {.accept = true}).find("description"), 0U);
  pass(5 * kSecondNs);
  ASSERT_TRUE(has(1, 2));
  for (std::size_t g = 0; g < 2; ++g) EXPECT_EQ(at(g).texts.in_loop, 0U) << g;
}

TEST_F(RolledOutTexts, ComeFromTheStoreAtAStartWhereTheyAreDamaged) {
  until_in_force();
  at(1).end();
  at(1).texts.damaged = {Sha256::Digest{2}};
  start(1);
  EXPECT_TRUE(has(1, 1)) << "the file";
  pass(8 * kSecondNs);
  EXPECT_TRUE(has(1, 2));
  EXPECT_TRUE(at(1).texts.has(2)) << "kept again";
  EXPECT_TRUE(reports(1, "it is damaged"));
  EXPECT_EQ(asked(1, wanted("c3", "own1", "shared")), "granted");
}

TEST_F(RolledOutTexts, ComeFromTheStoreWhereTheyWereDamagedAfterTheVote) {
  propose_to_both();
  at(1).reading().finish();
  link(0).answers = false;
  run();
  at(1).end();
  at(1).texts.damaged = {Sha256::Digest{2}};
  start(1);
  link(0).answers = true;
  finish_reading = true;
  pass(8 * kSecondNs);
  for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 2)) << g;
}

TEST_F(RolledOutTexts, OfTheFormerOneComeFromTheStoreForAWayBack) {
  until_in_force();
  at(1).texts.damaged = {Sha256::Digest{1}};
  EXPECT_EQ(rolled(1, {.back = true}), "checking");
  pass(6 * kSecondNs);
  for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 1)) << g;
}

TEST_F(RolledOutTexts, ThatNobodyHasAreReportedAndFollowedWhenTheyAreThere) {
  start_both();
  at(1).end();
  pass(25 * kSecondNs);  // until it is fenced
  ASSERT_EQ(roll_out(0, "2", {"g1"}), "checking");
  pass(60 * kSecondNs);
  ASSERT_EQ(state_of(0).state, "in-force") << state_of(0).why;
  const std::string text = store.entries.at(blob(2)).value;
  store.write({}, {blob(2)});
  start(1);
  pass(5 * kSecondNs);
  EXPECT_TRUE(has(1, 1));
  EXPECT_TRUE(reports(1, "neither kept here nor in the store"));
  store.write({{.key = blob(2), .value = text}});
  pass(5 * kSecondNs);
  EXPECT_TRUE(has(1, 2));
}

TEST_F(RolledOutTexts, OfTheFileAreKeptBeforeItIsAgreedTo) {
  start_both();
  at(1).system = grown_system();
  at(1).digest = 2;
  at(1).daemon().reload();
  pass(kSecondNs);
  ASSERT_TRUE(has(1, 2));
  at(1).texts.all.clear();
  at(1).texts.full = true;
  ASSERT_EQ(roll_out(0, "2"), "checking");
  pass(3 * kSecondNs);
  EXPECT_NE(state_of(0).why.find("g1: it cannot be kept"), std::string::npos) << state_of(0).why;
  at(1).texts.full = false;
  link(1).answers = false;
  ASSERT_EQ(roll_out(0, "2"), "checking");
  run();
  link(0).answers = false;
  link(1).answers = true;
  run();
  ASSERT_TRUE(agrees(1));
  EXPECT_TRUE(at(1).texts.has(2));
}

TEST_F(RolledOutTexts, ThatWereCheckedAreStillThereWhenTheyAreAgreedTo) {
  start_both();
  link(0).answers = false;
  ASSERT_EQ(roll_out(0, "2"), "checking");
  run();
  ASSERT_EQ(state_of(0).state, "staging");
  // The other one is quicker, and what it proposes is objected to.
  at(0).handed_on.erase(3);
  ASSERT_EQ(roll_out(1, "3"), "checking");
  run();
  link(0).answers = true;
  pass(3 * kSecondNs);
  ASSERT_EQ(state_of(1).state, "refused");
  link(0).answers = false;
  ASSERT_EQ(roll_out(1, "2"), "checking");
  run();
  link(1).answers = false;
  link(0).answers = true;
  run();
  ASSERT_TRUE(agrees(0));
  EXPECT_TRUE(at(0).texts.has(2));
}

}  // namespace
}  // namespace mlcca::test
