// SPDX-License-Identifier: BSD-2-Clause
// One description for all members.
#include <gtest/gtest.h>

#include "tests/core/cluster/members.hpp"

namespace mlcca::core::cluster::test {
namespace {

TEST_F(ClusterMember, ADescriptionComesIntoForceForAllOrForNone) {
  in_force(1);
  start(0);
  start(1);
  start(2);
  at(0).stage({.digest = TextCodec::digest(2), .chunks = {"<sys", "tem/>"}, .without = {}});
  run();
  for (Node& node : nodes) {
    const auto judge = node.take<Judge>();
    ASSERT_EQ(judge.size(), 1U);
    EXPECT_EQ(judge[0].content, "<system/>");
  }
  at(0).vote_rollout(TextCodec::digest(2), true, {});
  at(1).vote_rollout(TextCodec::digest(2), true, {});
  for (Node& node : nodes) node.take<Switch>();
  run();
  EXPECT_TRUE(nodes[0].take<Switch>().empty());
  at(2).vote_rollout(TextCodec::digest(2), true, {});
  run();
  for (Node& node : nodes) {
    const auto to = node.take<Switch>();
    ASSERT_EQ(to.size(), 1U);
    EXPECT_FALSE(to[0].open);
    EXPECT_EQ(to[0].generation, 2U);
    EXPECT_EQ(to[0].former, TextCodec::digest(1));
  }
  start(0, at(0).journalled(), 2);
  start(1, at(1).journalled(), 2);
  pass(3 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::other_digest) << "not before all are in it";
  start(2, at(2).journalled(), 2);
  pass(3 * kSecond);
  for (std::size_t g = 0; g < 3; ++g) EXPECT_EQ(at(g).standing(now), Member::Standing::joined) << g;
}

TEST_F(ClusterMember, ADescriptionOpensWhenTheLastFrameOfTheFormerOneHasLeftItsQueue) {
  start(0);
  start(1);
  at(0).stage({.digest = TextCodec::digest(1), .chunks = {"x"}, .without = {"B", "C"}});
  run();
  at(0).vote_rollout(TextCodec::digest(1), true, {});
  run();
  ASSERT_TRUE(store.entries.contains(keys->current()));
  EXPECT_EQ(at(0).standing(now), Member::Standing::other_digest) << "all are in it, just now";
  pass(2 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined);
}

TEST_F(ClusterMember, WhoWasLeftOutAndIsThereIsWaitedFor) {
  in_force(1);
  start(0);
  start(1);
  at(0).stage({.digest = TextCodec::digest(2), .chunks = {"x"}, .without = {"B", "C"}});
  run();
  at(0).vote_rollout(TextCodec::digest(2), true, {});
  run();
  start(0, at(0).journalled(), 2);
  pass(5 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::other_digest) << "B is in the former one";
  start(1, at(1).journalled(), 2);
  pass(5 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined);
}

TEST_F(ClusterMember, WhatWasRefutedIsNotAskedAgainBeforeItIsSeenWhy) {
  in_force(1);
  start(0);
  start(1);
  at(0).stage({.digest = TextCodec::digest(2), .chunks = {"x"}, .without = {"C"}});
  run();
  at(1).vote_rollout(TextCodec::digest(2), true, {});
  run();
  at(0).vote_rollout(TextCodec::digest(2), true, {});
  turn(nodes[0]);
  for (; nodes[0].seen < store.log.size(); ++nodes[0].seen)
    at(0).on_batch(store.log[nodes[0].seen], now);
  // The vote of the other one is another entry by now, which this one does not see yet.
  const std::string vote = keys->rollout_vote(1);
  store.write({{.key = vote, .value = store.entries[vote].value}});
  std::size_t asked = 0;
  for (int n = 0; n < 50; ++n)
    for (const Txn& txn : at(0).take_txns(now)) {
      ++asked;
      at(0).on_result(store.apply(txn), now);
    }
  EXPECT_LE(asked, 3U);
  run();
  EXPECT_FALSE(store.entries.contains(keys->next())) << "decided";
}

TEST_F(ClusterMember, OneObjectionEndsARollout) {
  in_force(1);
  start(0);
  start(1);
  start(2);
  at(0).stage({.digest = TextCodec::digest(2), .chunks = {"x"}, .without = {"C"}});
  run();
  at(0).vote_rollout(TextCodec::digest(2), true, {});
  at(1).vote_rollout(TextCodec::digest(2), false, "line 3: no such network");
  run();
  const auto ended = nodes[0].take<NotRolledOut>();
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].why, "B: line 3: no such network");
  EXPECT_FALSE(store.entries.contains(keys->next()));
  EXPECT_EQ(at(1).standing(now), Member::Standing::joined);
}

TEST_F(ClusterMember, WhoDoesNotVoteEndsItAfterAMinute) {
  in_force(1);
  start(0);
  start(1);
  start(2);
  at(0).stage({.digest = TextCodec::digest(2), .chunks = {"x"}, .without = {"B"}});
  run();
  at(0).vote_rollout(TextCodec::digest(2), true, {});
  pass(59 * kSecond);
  EXPECT_TRUE(nodes[0].take<NotRolledOut>().empty());
  pass(2 * kSecond);
  const auto ended = nodes[0].take<NotRolledOut>();
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].why, "C: it has not answered");
}

TEST_F(ClusterMember, TheFirstDescriptionIsRolledOutAsAnyOther) {
  start(0);
  start(1);
  at(0).stage({.digest = TextCodec::digest(1), .chunks = {"x"}, .without = {"C"}});
  run();
  at(0).vote_rollout(TextCodec::digest(1), true, {});
  at(1).vote_rollout(TextCodec::digest(1), true, {});
  pass(3 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined);
  EXPECT_EQ(at(1).standing(now), Member::Standing::joined);
}

}  // namespace
}  // namespace mlcca::core::cluster::test
