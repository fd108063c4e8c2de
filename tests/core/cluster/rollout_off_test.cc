// SPDX-License-Identifier: BSD-2-Clause
// A gateway that dies while a description comes into force, or comes back, can be called off.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/cluster/members.hpp"

namespace mlcca::core::cluster::test {
namespace {

class RolloutOff : public ClusterMember {
 protected:
  static constexpr Value kDead = 15 * kSecond;  // then it has been fenced, and its lease has ended

  void come_up() {
    for (std::size_t g = 0; g < 3; ++g) start(g);
  }
  /// 1 is in force, all agree to 2, and A and B change to it. C has died.
  void switch_without_c() {
    in_force(1);
    come_up();
    stage(0, 2);
    run();
    for (std::size_t g = 0; g < 3; ++g) at(g).vote_rollout(TextCodec::digest(2), true, {});
    run();
    die();
    change_to(2);
  }
  void die() { nodes[2].cut_off = true; }
  void change_to(std::uint8_t digest) {
    for (std::size_t g = 0; g < 2; ++g) start(g, at(g).journalled(), digest);
  }
  /// A minute has passed: the former description comes back, and A and B have changed to it.
  void go_back() {
    pass(65 * kSecond);
    ASSERT_TRUE(current().undone);
    change_to(1);
    pass(100 * kSecond);
    ASSERT_FALSE(current().open) << "it waits for C";
  }
  void stage(std::size_t g, std::uint8_t digest, std::vector<std::string> without = {}) {
    for (Node& node : nodes) node.take<NotRolledOut>();
    at(g).stage(
        {.digest = TextCodec::digest(digest), .chunks = {"x"}, .without = std::move(without)});
  }
  [[nodiscard]] Current current() const {
    return codec.current(store.entries.at(keys->current()).value).value_or(Current{});
  }
  void expect_open(std::uint8_t digest) {
    EXPECT_TRUE(current().open);
    EXPECT_EQ(current().digest, TextCodec::digest(digest));
    for (std::size_t g = 0; g < 2; ++g)
      EXPECT_EQ(at(g).standing(now), Member::Standing::joined) << g;
  }
  std::string why_not_rolled_out(std::size_t g) {
    const auto ends = nodes[g].take<NotRolledOut>();
    return ends.empty() ? std::string() : ends.back().why;
  }
};

TEST_F(RolloutOff, WhileTheFormerDescriptionComesBack) {
  switch_without_c();
  go_back();
  stage(0, 1, {"C"});
  pass(3 * kSecond);
  EXPECT_EQ(why_not_rolled_out(0), "");
  expect_open(1);
}

TEST_F(RolloutOff, WhileADescriptionComesIntoForce) {
  switch_without_c();
  pass(kDead);
  ASSERT_FALSE(current().open);
  stage(1, 2, {"C"});
  pass(3 * kSecond);
  EXPECT_EQ(why_not_rolled_out(1), "");
  expect_open(2);
  EXPECT_FALSE(current().undone);
}

/// There is none before it that could come back.
TEST_F(RolloutOff, WhileTheFirstDescriptionComesIntoForce) {
  come_up();
  stage(0, 1);
  run();
  for (std::size_t g = 0; g < 3; ++g) at(g).vote_rollout(TextCodec::digest(1), true, {});
  turn(nodes[2]);
  die();
  pass(200 * kSecond);
  ASSERT_TRUE(store.entries.contains(keys->current()));
  ASSERT_FALSE(current().open);
  stage(0, 1, {"C"});
  pass(3 * kSecond);
  expect_open(1);
}

TEST_F(RolloutOff, OnlyWhoIsSurelyGone) {
  switch_without_c();
  stage(0, 2, {"C"});
  pass(kSecond);
  EXPECT_NE(why_not_rolled_out(0).find("C: it was called off, and is there"), std::string::npos);
  EXPECT_FALSE(current().open);
  EXPECT_EQ(current().waits.size(), 3U);
}

/// A gateway that has just started does not know when the lease of a fenced one has begun.
TEST_F(RolloutOff, OnceTheLeaseOfAFencedOneIsSurelyOver) {
  switch_without_c();
  pass(kDead);
  change_to(2);
  stage(0, 2, {"C"});
  pass(kSecond);
  EXPECT_EQ(why_not_rolled_out(0), "");
  EXPECT_EQ(current().waits.size(), 3U);
  pass(kDead);
  EXPECT_EQ(why_not_rolled_out(0), "");
  expect_open(2);
}

/// It comes back between the decision and the transaction.
TEST_F(RolloutOff, NotWhoIsBackMeanwhile) {
  switch_without_c();
  pass(kDead);
  stage(0, 2, {"C"});
  const auto txns = at(0).take_txns(now);
  ASSERT_EQ(txns.size(), 1U);
  start(2, at(2).journalled(), 1);
  at(0).on_result(store.apply(txns[0]), now);
  run();
  EXPECT_EQ(current().waits.size(), 3U);
  EXPECT_FALSE(current().open);
  EXPECT_NE(why_not_rolled_out(0).find("is there"), std::string::npos);
}

TEST_F(RolloutOff, WhoIsNotWaitedForIsNobodyToCallOff) {
  switch_without_c();
  pass(kDead);
  stage(0, 2, {"C"});
  pass(kSecond / 4);
  ASSERT_EQ(current().waits.size(), 2U);
  stage(0, 2, {"C"});
  pass(kSecond / 4);
  EXPECT_NE(why_not_rolled_out(0).find("waits for none"), std::string::npos);
}

TEST_F(RolloutOff, WhatTheStoreForbidsIsReported) {
  switch_without_c();
  pass(kDead);
  stage(0, 2, {"C"});
  const auto txns = at(0).take_txns(now);
  ASSERT_EQ(txns.size(), 1U);
  at(0).on_result({.id = txns[0].id, .outcome = Outcome::forbidden, .why = "permission denied"},
                  now);
  run();
  EXPECT_NE(why_not_rolled_out(0).find("permission denied"), std::string::npos);
}

/// The one before is what was last in force, not what never was.
TEST_F(RolloutOff, AnotherOneMeanwhileIsFollowedByWhatWasInForce) {
  switch_without_c();
  pass(kDead);
  stage(0, 3, {"C"});
  run();
  for (std::size_t g = 0; g < 2; ++g) at(g).vote_rollout(TextCodec::digest(3), true, {});
  run();
  ASSERT_EQ(current().digest, TextCodec::digest(3));
  EXPECT_EQ(current().former, TextCodec::digest(1));
  EXPECT_FALSE(current().undone);
}

TEST_F(RolloutOff, TheFormerOneByAnOperatorIsAReturn) {
  switch_without_c();
  pass(kDead);
  stage(0, 1, {"C"});
  run();
  for (std::size_t g = 0; g < 2; ++g) at(g).vote_rollout(TextCodec::digest(1), true, {});
  run();
  ASSERT_EQ(current().digest, TextCodec::digest(1));
  EXPECT_TRUE(current().undone) << "the other one does not come back if a gateway is late";
  change_to(1);
  pass(kDead);
  expect_open(1);
}

/// The description has opened since the operator has asked.
TEST_F(RolloutOff, WhatIsInForceMeanwhileIsNotProposedAgain) {
  switch_without_c();
  pass(kDead);
  stage(0, 2, {"C"});
  pass(kSecond / 4);
  at(1).stage({.digest = TextCodec::digest(2), .chunks = {"x"}, .without = {"C"}});
  store.write({{.key = keys->current(), .value = [this] {
                  Current open = current();
                  open.open = true;
                  return codec.write(open);
                }()}});
  run();
  const std::uint64_t generation = current().generation;
  pass(5 * kSecond);
  expect_open(2);
  EXPECT_EQ(current().generation, generation);
  EXPECT_FALSE(store.entries.contains(keys->next()));
}

}  // namespace
}  // namespace mlcca::core::cluster::test
