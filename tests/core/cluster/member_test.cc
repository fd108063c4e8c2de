// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/member.hpp"

#include <gtest/gtest.h>

#include "tests/core/cluster/members.hpp"

namespace mlcca::core::cluster::test {
namespace {

TEST_F(ClusterMember, JoinsBeatsAndKnowsHowLongItMaySend) {
  in_force(1);
  start(0);
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined);
  const Value first = at(0).valid_until();
  EXPECT_LE(first, valid_until(now, kTen));
  pass(5 * kSecond);
  EXPECT_GE(at(0).valid_until(), valid_until(now - (kTen / 4), kTen));
}

TEST_F(ClusterMember, GrantsAndLeavesNothingBehind) {
  in_force(1);
  start(0);
  start(1);
  at(0).reserve(unit(7), now);
  run();
  ASSERT_EQ(nodes[0].take<Reserved>().size(), 1U);
  EXPECT_TRUE(at(0).holds(7));
  EXPECT_EQ(bytes_of(at(1).view().foreign(0).rates), 1U);
  at(0).release(7, now);
  run();
  EXPECT_EQ(bytes_of(at(1).view().foreign(0).rates), 1U) << "frames may wait in a queue";
  pass(2 * kSecond);
  EXPECT_EQ(bytes_of(at(1).view().foreign(0).rates), 0U);
  EXPECT_FALSE(store.entries.contains(keys->asked(0, 7)));
}

TEST_F(ClusterMember, WhoIsSecondDecidesAgain) {
  in_force(1);
  start(0);
  start(1);
  at(0).reserve(unit(1), now);
  at(1).reserve(unit(2), now);
  run();
  pass(kSecond / 4);
  EXPECT_EQ(nodes[0].take<Reserved>().size(), 1U);
  const auto conflicts = nodes[1].take<Conflict>();
  ASSERT_EQ(conflicts.size(), 1U);
  EXPECT_EQ(conflicts[0].by, "A 1");
  EXPECT_EQ(conflicts[0].tries, 1U);
  EXPECT_EQ(bytes_of(at(1).view().foreign(0).rates), 1U) << "it sees why";
  at(1).reserve(unit(2), now);
  run();
  EXPECT_EQ(nodes[1].take<Reserved>().size(), 1U);
}

TEST_F(ClusterMember, WithoutTheDescriptionInForceNothingIsTaken) {
  start(0);
  EXPECT_EQ(at(0).standing(now), Member::Standing::other_digest);
  at(0).reserve(unit(1), now);
  run();
  ASSERT_EQ(nodes[0].take<Refused>().size(), 1U);
  in_force(2);
  run();
  EXPECT_EQ(at(0).standing(now), Member::Standing::other_digest);
  in_force(1);
  run();
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined);
}

TEST_F(ClusterMember, WhatIsFullOrForbiddenIsAskedAgainAndThenRefused) {
  in_force(1);
  start(0);
  nodes[0].cut_off = true;
  at(0).reserve(unit(1), now);
  pass_while_full(5 * kSecond);
  turn(nodes[0]);
  EXPECT_EQ(nodes[0].take<Refused>().size(), 1U);
  EXPECT_EQ(at(0).problem(), "no space");
}

TEST_F(ClusterMember, AFullStoreEndsTheLeaseAndIsTheReason) {
  in_force(1);
  start(0);
  nodes[0].cut_off = true;
  pass_while_full(20 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::silent);
  EXPECT_EQ(at(0).why_not(now), std::string(Member::kFull) + ": no space");
  nodes[0].cut_off = false;
  pass(kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined) << "there is room again";
}

TEST_F(ClusterMember, ALostAnswerIsFoundOutByTheNextBeat) {
  in_force(1);
  start(0);
  nodes[0].cut_off = true;
  at(0).reserve(unit(1), now);
  turn(nodes[0]);
  ASSERT_EQ(nodes[0].lost.size(), 1U);
  const Txn txn = std::exchange(nodes[0].lost, {})[0];
  static_cast<void>(store.apply(txn));
  at(0).on_result({.id = txn.id, .outcome = Outcome::unsure, .why = {}}, now);
  nodes[0].cut_off = false;
  pass(2 * kSecond);
  EXPECT_EQ(nodes[0].take<Reserved>().size(), 1U);
  EXPECT_TRUE(at(0).holds(1));
}

TEST_F(ClusterMember, WhoIsCutOffIsSilentAtVAndIsFencedLater) {
  in_force(1);
  start(0);
  start(1);
  at(0).reserve(unit(1), now);
  run();
  nodes[0].cut_off = true;
  const Value until = at(0).valid_until();
  pass(until - now);
  EXPECT_EQ(at(0).standing(now), Member::Standing::silent);
  EXPECT_EQ(bytes_of(at(1).view().foreign(0).rates), 1U);
  pass(4 * kSecond);
  EXPECT_EQ(bytes_of(at(1).view().foreign(0).rates), 0U);
  nodes[0].cut_off = false;
  pass(3 * kSecond);
  EXPECT_GE(nodes[0].take<Lost>().size(), 1U);
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined);
  EXPECT_FALSE(at(0).holds(1));
  EXPECT_FALSE(store.entries.contains(keys->reservation(0, 0, 1)));
}

TEST_F(ClusterMember, ANewProcessGoesOnWithWhatTheStoreHas) {
  in_force(1);
  start(0);
  at(0).reserve(unit(1), now);
  run();
  const Journalled was = at(0).journalled();
  start(0, was);
  const auto found = nodes[0].take<Found>();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].admission, "request");
  const auto joined = nodes[0].take<Joined>();
  ASSERT_EQ(joined.size(), 1U);
  EXPECT_TRUE(joined[0].goes_on);
  EXPECT_TRUE(nodes[0].take<Lost>().empty());
  EXPECT_EQ(at(0).journalled().incarnation, was.incarnation);
}

TEST_F(ClusterMember, WithoutAJournalItJoinsAgainAndCleansUp) {
  in_force(1);
  start(0);
  at(0).reserve(unit(1), now);
  run();
  start(0);
  EXPECT_EQ(nodes[0].take<Lost>().size(), 1U) << "before it is a member";
  EXPECT_TRUE(nodes[0].take<Found>().empty());
  pass(2 * kSecond);
  EXPECT_FALSE(store.entries.contains(keys->reservation(0, 0, 1)));
}

TEST_F(ClusterMember, AStoreThatHasGoneBackNeedsAnOperator) {
  in_force(1);
  const StoreStub backup = store;
  start(0);
  nodes[0].take<Lost>();
  at(0).reserve(unit(1), now);
  run();
  store = backup;
  read_all(0);
  run();
  EXPECT_EQ(nodes[0].take<Lost>().size(), 1U);
  EXPECT_LE(at(0).valid_until(), now);
  pass(kTen);
  EXPECT_EQ(at(0).standing(now), Member::Standing::gone_back);
  store.write({{.key = keys->epoch(), .value = "n"}});
  run();
  EXPECT_EQ(at(0).standing(now), Member::Standing::waiting) << "others may still send";
  pass(12 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined);
}

/// Others have written so much to the restored store that its revision is no lower than before. Its
/// own entry is one that it wrote, but an earlier one.
TEST_F(ClusterMember, AnEarlierEntryOfItsOwnShowsThatTheStoreHasGoneBack) {
  in_force(1);
  start(0);
  pass(3 * kSecond);
  const StoreStub backup = store;
  at(0).reserve(unit(1), now);
  run();
  ASSERT_TRUE(at(0).holds(1));
  const std::int64_t seen = store.revision;
  store = backup;
  while (store.revision <= seen) store.write({{.key = keys->version(0), .value = "B"}});
  read_all(0);
  pass(kTen / 4);
  EXPECT_EQ(at(0).standing(now), Member::Standing::gone_back);
  EXPECT_FALSE(at(0).holds(1));
  EXPECT_LE(at(0).valid_until(), now);
}

/// After the restart nothing in the store shows that it has gone back.
TEST_F(ClusterMember, AStoreThatHasGoneBackStaysSoOverARestart) {
  in_force(1);
  start(0);
  go_back();
  ASSERT_EQ(at(0).standing(now), Member::Standing::gone_back);
  while (store.revision < at(0).journalled().seen_revision + 100)
    store.write({{.key = keys->version(0), .value = "B"}});
  start(0, at(0).journalled());
  pass(kTen);
  EXPECT_EQ(at(0).standing(now), Member::Standing::gone_back);
  EXPECT_LE(at(0).valid_until(), now);

  store.write({{.key = keys->epoch(), .value = "n"}});
  run();
  pass(12 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined);
  start(0, at(0).journalled());
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined) << "it is over";
}

TEST_F(ClusterMember, LeasesFromBeforeANewEpochAreWaitedForAlsoAfterARestart) {
  in_force(1);
  start(0);
  store.write({{.key = keys->epoch(), .value = "n"}});
  run();
  pass(3 * kSecond);
  ASSERT_EQ(at(0).standing(now), Member::Standing::waiting);
  start(0, at(0).journalled());
  EXPECT_EQ(at(0).standing(now), Member::Standing::waiting);
  at(0).reserve(unit(1), now);
  run();
  EXPECT_EQ(nodes[0].take<Refused>().size(), 1U);
  pass(12 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined);
  start(0, at(0).journalled());
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined) << "it is over";
}

/// A crash after the new epoch was seen, and before this gateway has joined in it.
TEST_F(ClusterMember, AStoreThatHasGoneBackStaysSoUntilItHasJoinedInANewEpoch) {
  in_force(1);
  start(0);
  go_back();
  const StoreStub again = store;
  nodes[0].cut_off = true;
  store.write({{.key = keys->epoch(), .value = "n"}});
  read_all(0);
  turn(nodes[0]);
  ASSERT_EQ(at(0).standing(now), Member::Standing::joining);
  store = again;
  start(0, at(0).journalled());
  EXPECT_EQ(at(0).standing(now), Member::Standing::gone_back);
}

/// It was fenced, and has not seen that before the store was restored.
TEST_F(ClusterMember, WhatWasReadOfAStoreThatHasGoneBackIsNotWaitedFor) {
  in_force(1);
  start(0);
  start(1);
  const StoreStub backup = store;
  pass(20 * kSecond);
  nodes[0].cut_off = true;
  store.write({{.key = keys->fence(0), .value = "B"}});
  pass(3 * kSecond);
  turn(nodes[0]);
  for (const Txn& txn : std::exchange(nodes[0].lost, {})) at(0).on_result(store.apply(txn), now);
  ASSERT_EQ(at(0).standing(now), Member::Standing::off);
  store = backup;
  read_all(0);
  EXPECT_EQ(at(0).standing(now), Member::Standing::gone_back);
  nodes[0].cut_off = false;
  store.write({{.key = keys->epoch(), .value = "n"}});
  for (std::size_t g = 0; g < 2; ++g) read_all(g);
  run();
  pass(12 * kSecond);
  EXPECT_EQ(at(0).standing(now), Member::Standing::joined);
}

TEST_F(ClusterMember, RevisionsFromBeforeARestoreAreForgotten) {
  in_force(1);
  const StoreStub backup = store;
  start(0);
  pass(60 * kSecond);
  at(0).reserve(unit(1), now);
  run();
  store = backup;
  store.write({{.key = keys->epoch(), .value = "n"}});
  read_all(0);
  run();
  pass(12 * kSecond);
  ASSERT_EQ(at(0).standing(now), Member::Standing::joined);
  const auto beat = codec.beat(store.entries.at(keys->member(0)).value);
  ASSERT_TRUE(beat);
  EXPECT_LE(beat->applied, store.revision);
  nodes[0].take<Reserved>();
  at(0).reserve(unit(2), now);
  run();
  EXPECT_EQ(nodes[0].take<Reserved>().size(), 1U);
}

TEST_F(ClusterMember, DrainingLeavesTheStoreEmpty) {
  in_force(1);
  start(0);
  at(0).reserve(unit(1), now);
  run();
  at(0).drain(now);
  pass(3 * kSecond);
  EXPECT_EQ(nodes[0].take<Drained>().size(), 1U);
  EXPECT_EQ(at(0).journalled().incarnation, 0);
  EXPECT_FALSE(store.entries.contains(keys->member(0)));
  EXPECT_FALSE(store.entries.contains(keys->reservation(0, 0, 1)));
}

TEST_F(ClusterMember, AGatewayOnTheWayAgreesFirstAndClosesFirst) {
  in_force(1);
  for (std::size_t g = 0; g < 3; ++g) start(g);
  at(0).reserve(unit(1, {1}), now);
  run();
  const auto adopt = nodes[1].take<Adopt>();
  ASSERT_EQ(adopt.size(), 1U);
  EXPECT_EQ(adopt[0].admission, "request");
  EXPECT_EQ(adopt[0].footprint.parts.size(), 1U);
  EXPECT_TRUE(nodes[0].take<Reserved>().empty());
  EXPECT_EQ(bytes_of(at(1).view().foreign(0).rates), 0U) << "it decides about it itself";
  EXPECT_EQ(bytes_of(at(2).view().foreign(0).rates), 1U);
  at(1).vote(adopt[0].origin, {.ok = true, .hop = {}, .reason = {}}, now);
  run();
  EXPECT_EQ(nodes[1].take<Opened>().size(), 1U);
  EXPECT_EQ(nodes[0].take<Reserved>().size(), 1U);
  at(0).release(1, now);
  run();
  EXPECT_EQ(nodes[1].take<Ended>().size(), 1U);
  pass(3 * kSecond);
  EXPECT_EQ(bytes_of(at(2).view().foreign(0).rates), 0U);
}

TEST_F(ClusterMember, OneRefusalOnTheWayRefusesAll) {
  in_force(1);
  start(0);
  start(1);
  at(0).reserve(unit(1, {1}), now);
  run();
  const auto adopt = nodes[1].take<Adopt>();
  ASSERT_EQ(adopt.size(), 1U);
  at(1).vote(adopt[0].origin, {.ok = false, .hop = {}, .reason = "no bandwidth"}, now);
  run();
  const auto refused = nodes[0].take<Refused>();
  ASSERT_EQ(refused.size(), 1U);
  EXPECT_EQ(refused[0].why.reason, "no bandwidth");
  EXPECT_EQ(refused[0].by, 1U);
  pass(2 * kSecond);
  EXPECT_FALSE(store.entries.contains(keys->reservation(0, 0, 1)));
  EXPECT_FALSE(store.entries.contains(keys->vote(1, 0, 1)));
}

TEST_F(ClusterMember, WhoCannotKeepItLaterWithdrawsIt) {
  in_force(1);
  start(0);
  start(1);
  at(0).reserve(unit(1, {1}), now);
  run();
  const Origin origin = nodes[1].take<Adopt>().at(0).origin;
  at(1).vote(origin, {.ok = true, .hop = {}, .reason = {}}, now);
  run();
  at(1).vote(origin, {.ok = false, .hop = {}, .reason = "link lost"}, now);
  run();
  ASSERT_EQ(nodes[0].take<Reserved>().size(), 1U);
  const auto withdrawn = nodes[0].take<Withdrawn>();
  ASSERT_EQ(withdrawn.size(), 1U);
  EXPECT_EQ(withdrawn[0].why.reason, "link lost");
}

}  // namespace
}  // namespace mlcca::core::cluster::test
