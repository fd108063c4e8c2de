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
  at(0).stage({.digest = TextCodec::digest(2), .chunks = {"x"}, .without = {"B", "C"}});
  run();
  at(0).vote_rollout(TextCodec::digest(2), true, {});
  run();
  start(1);
  start(0, at(0).journalled(), 2);
  pass(5 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::other_digest) << "B is in the former one";
  start(1, at(1).journalled(), 2);
  pass(5 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined);
}

/// It has something to leave, and the next description may not know it.
TEST_F(ClusterMember, WhoIsThereCannotBeCalledOff) {
  in_force(1);
  start(0);
  start(1);
  at(0).stage({.digest = TextCodec::digest(2), .chunks = {"x"}, .without = {"B", "C"}});
  run();
  at(0).vote_rollout(TextCodec::digest(2), true, {});
  run();
  EXPECT_FALSE(store.entries.contains(keys->next())) << "it is given up";
  pass(5 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined) << "in the former one";
}

/// It joins between the count of the votes and the transaction that follows from it.
TEST_F(ClusterMember, WhoIsBackBeforeItIsDecidedIsNotCalledOff) {
  in_force(1);
  start(0);
  at(0).stage({.digest = TextCodec::digest(2), .chunks = {"x"}, .without = {"B", "C"}});
  run();
  at(0).vote_rollout(TextCodec::digest(2), true, {});
  std::vector<Txn> decides;
  for (int n = 0; n < 10 && decides.empty(); ++n) {
    for (; nodes[0].seen < store.log.size(); ++nodes[0].seen)
      at(0).on_batch(store.log[nodes[0].seen], now);
    for (Txn& txn : at(0).take_txns(now)) {
      if (std::ranges::find(txn.deletes, keys->next()) == txn.deletes.end())
        at(0).on_result(store.apply(txn), now);
      else
        decides.push_back(std::move(txn));
    }
  }
  ASSERT_EQ(decides.size(), 1U);
  start(1);
  ASSERT_EQ(at(1).standing(now), Member::Standing::joined);
  at(1).reserve(unit(1), now);
  run();
  ASSERT_EQ(nodes[1].take<Reserved>().size(), 1U);
  at(0).on_result(store.apply(decides[0]), now);
  run();
  EXPECT_EQ(at(1).standing(now), Member::Standing::joined);
  EXPECT_TRUE(nodes[1].take<Withdrawn>().empty());
  const auto ended = nodes[0].take<NotRolledOut>();
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].why, "B: it was called off, and is there");
}

/// What gateways propose by themselves calls nobody off.
TEST_F(ClusterMember, WhereNoneIsInForceAnOperatorCallsOffWhoIsNotThere) {
  start(0);
  start(1);
  at(0).stage({.digest = TextCodec::digest(1), .chunks = {"x"}, .without = {}});
  run();
  for (Node& node : nodes) ASSERT_EQ(node.take<Judge>().size(), 1U);
  at(1).stage({.digest = TextCodec::digest(1), .chunks = {"x"}, .without = {"C"}});
  run();
  EXPECT_EQ(nodes[0].take<NotRolledOut>().size(), 1U) << "of what it has proposed itself";
  EXPECT_TRUE(nodes[1].take<NotRolledOut>().empty());
  for (std::size_t g = 0; g < 2; ++g) {
    ASSERT_EQ(nodes[g].take<Judge>().size(), 1U) << g;
    at(g).vote_rollout(TextCodec::digest(1), true, {});
  }
  pass(3 * kSecond);
  for (std::size_t g = 0; g < 2; ++g) EXPECT_EQ(at(g).standing(now), Member::Standing::joined) << g;
}

TEST_F(ClusterMember, WhatAGatewayProposesByItselfGivesWayToItsOperator) {
  start(0);
  at(0).stage({.digest = TextCodec::digest(1), .chunks = {"x", "y"}, .without = {}});
  // Its first transaction is under way.
  const auto first = at(0).take_txns(now);
  ASSERT_EQ(first.size(), 1U);
  at(0).stage({.digest = TextCodec::digest(1), .chunks = {"x", "y"}, .without = {"B", "C"}});
  at(0).on_result(store.apply(first[0]), now);
  run();
  EXPECT_TRUE(nodes[0].take<NotRolledOut>().empty());
  ASSERT_FALSE(nodes[0].take<Judge>().empty());
  at(0).vote_rollout(TextCodec::digest(1), true, {});
  pass(3 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined);
}

TEST_F(ClusterMember, TheSameDescriptionWithOthersCalledOffIsAnotherProposal) {
  in_force(1);
  start(0);
  start(1);
  at(0).stage({.digest = TextCodec::digest(2), .chunks = {"x"}, .without = {"C"}});
  run();
  at(1).stage({.digest = TextCodec::digest(2), .chunks = {"x"}, .without = {}});
  pass(kSecond);
  const auto ended = nodes[1].take<NotRolledOut>();
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].why, "it is being rolled out already, with other gateways called off");
  EXPECT_TRUE(nodes[0].take<NotRolledOut>().empty());
}

/// It does not know every gateway that has the one in force.
TEST_F(ClusterMember, WhoHasAnotherDescriptionRollsOutNothing) {
  in_force(1);
  start(0, {}, 3);
  start(1);
  run();
  at(0).stage({.digest = TextCodec::digest(3), .chunks = {"x"}, .without = {"C"}});
  run();
  EXPECT_FALSE(store.entries.contains(keys->next()));
  EXPECT_EQ(at(1).standing(now), Member::Standing::joined);
}

/// It was called off, came back, and has its own file.
TEST_F(ClusterMember, WhoStaysInTheFormerDescriptionGivesBackWhatItHasReserved) {
  in_force(1);
  start(0);
  at(0).reserve(unit(1), now);
  run();
  ASSERT_EQ(nodes[0].take<Reserved>().size(), 1U);
  in_force(2);
  run();
  const auto withdrawn = nodes[0].take<Withdrawn>();
  ASSERT_EQ(withdrawn.size(), 1U);
  EXPECT_EQ(withdrawn[0].why.reason, "another description is in force");
  EXPECT_TRUE(store.entries.contains(keys->reservation(0, 0, 1))) << "before it is closed";
  at(0).release(1, now);
  pass(3 * kSecond);
  EXPECT_FALSE(store.entries.contains(keys->reservation(0, 0, 1)));
  EXPECT_FALSE(store.entries.contains(keys->asked(0, 1)));
  EXPECT_TRUE(nodes[0].take<Withdrawn>().empty()) << "once";
}

TEST_F(ClusterMember, WhatWasTakenOfANetworkThatIsNotThereAnyMoreIsDeletedWhenAllHaveLeftIt) {
  const std::vector<std::string> own = {"r/gone/A/1", "r/gone/A/2", "v/gone"};
  for (const std::string& key : own) store.write({{.key = key, .value = "5"}});
  store.write({{.key = "r/gone/B/1", .value = "5"}});
  start(0);
  for (const std::string& key : own)
    EXPECT_TRUE(store.entries.contains(key)) << "before it is open";
  in_force(1);
  run();
  for (const std::string& key : own) EXPECT_FALSE(store.entries.contains(key)) << key;
  EXPECT_TRUE(store.entries.contains("r/gone/B/1")) << "B alone may";
  start(1);
  run();
  EXPECT_FALSE(store.entries.contains("r/gone/B/1"));
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

TEST_F(ClusterMember, OfTwoWhoProposeAtOnceOneIsRefusedAndTheOtherIsJudged) {
  in_force(1);
  start(0);
  start(1);
  at(0).stage({.digest = TextCodec::digest(2), .chunks = {"of ", "A"}, .without = {}});
  at(1).stage({.digest = TextCodec::digest(3), .chunks = {"of ", "B"}, .without = {}});
  run();
  const auto first = nodes[0].take<Judge>();
  const auto second = nodes[1].take<Judge>();
  ASSERT_EQ(first.size(), 1U);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(first[0].content, second[0].content);
  const std::size_t refused =
      nodes[0].take<NotRolledOut>().size() + nodes[1].take<NotRolledOut>().size();
  EXPECT_EQ(refused, 1U);
}

TEST_F(ClusterMember, WhatFormerRolloutsHaveLeftMakesRoom) {
  in_force(1);
  for (std::uint8_t d = 50; d < 56; ++d)
    for (std::size_t n = 0; n < 70; ++n)
      store.write({{.key = keys->blob(std::string(64, static_cast<char>('a' + d - 50)), n),
                    .value = "old"}});
  start(0);
  start(1);
  at(0).stage({.digest = TextCodec::digest(2), .chunks = {"a", "b"}, .without = {}});
  run();
  ASSERT_EQ(nodes[1].take<Judge>().size(), 1U);
  std::size_t blobs = 0;
  for (const auto& [key, entry] : store.entries) blobs += key.find("/blob/") != std::string::npos;
  EXPECT_EQ(blobs, 2U);
}

class Switching : public ClusterMember {
 protected:
  /// 1 is in force, and 2 is taken back; all of the three are in 1.
  void SetUp() override {
    in_force(1);
    for (std::size_t g = 0; g < 3; ++g) start(g);
    at(0).stage({.digest = TextCodec::digest(2), .chunks = {"x"}, .without = {}});
    run();
    for (std::size_t g = 0; g < 3; ++g) at(g).vote_rollout(TextCodec::digest(2), true, {});
    run();
    for (Node& node : nodes) ASSERT_EQ(node.take<Switch>().size(), 2U);
  }
};

TEST_F(Switching, WhoCannotFollowBringsTheFormerOneBack) {
  start(0, at(0).journalled(), 2);
  at(1).cannot_switch("no memory for a gate");
  run();
  for (std::size_t g = 0; g < 3; ++g) {
    const auto to = nodes[g].take<Switch>();
    ASSERT_FALSE(to.empty()) << g;
    EXPECT_EQ(to.back().digest, TextCodec::digest(1));
    EXPECT_TRUE(to.back().undone);
    EXPECT_FALSE(to.back().open);
  }
  EXPECT_EQ(at(1).standing(now), Member::Standing::other_digest) << "one is in the other one";
  start(0, at(0).journalled(), 1);
  pass(3 * kSecond);
  for (std::size_t g = 0; g < 3; ++g) EXPECT_EQ(at(g).standing(now), Member::Standing::joined) << g;
}

TEST_F(Switching, WhoDoesNotFollowInAMinuteBringsTheFormerOneBackOnce) {
  start(0, at(0).journalled(), 2);
  start(1, at(1).journalled(), 2);
  pass(70 * kSecond);
  const auto to = nodes[2].take<Switch>();
  ASSERT_EQ(to.size(), 1U);
  EXPECT_TRUE(to[0].undone);
  // Nobody follows: it stays so.
  pass(100 * kSecond);
  EXPECT_TRUE(nodes[2].take<Switch>().empty());
  start(0, at(0).journalled(), 1);
  start(1, at(1).journalled(), 1);
  pass(3 * kSecond);
  EXPECT_EQ(at(2).standing(now), Member::Standing::joined);
}

TEST_F(ClusterMember, WhatTheStoreForbidsIsNotTriedInPlaceOfBeats) {
  store.write({{.key = keys->current(),
                .value = codec.write(
                    Current{.generation = 1, .digest = TextCodec::digest(1), .waits = {}})}});
  start(0);
  std::size_t forbidden = 0;
  std::size_t beats = 0;
  for (int n = 0; n < 100; ++n) {
    now += kSecond / 10;
    for (; nodes[0].seen < store.log.size(); ++nodes[0].seen)
      at(0).on_batch(store.log[nodes[0].seen], now);
    at(0).on_time(now);
    at(0).applied(store.revision);
    for (const Txn& txn : at(0).take_txns(now)) {
      const bool d = std::ranges::any_of(
          txn.puts, [](const Put& put) { return put.key.find("d/current") != std::string::npos; });
      forbidden += d ? 1U : 0U;
      beats += d ? 0U : 1U;
      if (d)
        at(0).on_result({.id = txn.id, .outcome = Outcome::forbidden, .why = "permission denied"},
                        now);
      else
        at(0).on_result(store.apply(txn), now);
    }
  }
  EXPECT_LE(forbidden, 6U);
  EXPECT_GE(forbidden, 2U) << "it may open it, and tries";
  EXPECT_GE(beats, 3U);
}

TEST_F(ClusterMember, AfterAStoreWasRestoredWhatWasRefutedIsTriedAgain) {
  in_force(1);
  start(0);
  start(1);
  at(0).stage({.digest = TextCodec::digest(2), .chunks = {"x"}, .without = {}});
  at(1).stage({.digest = TextCodec::digest(3), .chunks = {"x"}, .without = {}});
  const auto first = at(0).take_txns(now);
  const auto second = at(1).take_txns(now);
  for (const Txn& txn : first) at(0).on_result(store.apply(txn), now);
  for (const Txn& txn : second) at(1).on_result(store.apply(txn), now);
  // One was refuted, at a late revision. The store begins again below it.
  for (Node& node : nodes)
    node.member->on_state({.reachable = false, .endpoint = {}, .problem = {}}, now);
  store = StoreStub();
  store.write({{.key = keys->epoch(), .value = std::string(16, 'e')}});
  in_force(1);
  for (std::size_t g = 0; g < 2; ++g) {
    nodes[g].seen = store.log.size();
    at(g).on_state({.reachable = true, .endpoint = {}, .problem = {}}, now);
    read_all(g);
  }
  pass(15 * kSecond);
  ASSERT_EQ(at(0).standing(now), Member::Standing::joined);
  ASSERT_EQ(at(1).standing(now), Member::Standing::joined);
  for (Node& node : nodes) node.take<Judge>();
  for (std::size_t g = 0; g < 2; ++g)
    at(g).stage({.digest = TextCodec::digest(static_cast<std::uint8_t>(4 + g)),
                 .chunks = {"y"},
                 .without = {}});
  run();
  EXPECT_EQ(nodes[0].take<Judge>().size(), 1U);
}

}  // namespace
}  // namespace mlcca::core::cluster::test
