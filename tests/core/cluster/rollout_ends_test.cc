// SPDX-License-Identifier: BSD-2-Clause
// Whatever is proposed ends, for whoever has proposed it as for the others, and makes room for the
// next one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/cluster/members.hpp"

namespace mlcca::core::cluster::test {
namespace {

class RolloutEnds : public ClusterMember {
 protected:
  void SetUp() override {
    in_force(1);
    start(0);
    start(1);
    run();
    for (Node& node : nodes) node.events.clear();
  }
  void stage(std::size_t g, std::uint8_t digest, std::vector<std::string> chunks = {"x"}) {
    at(g).stage({.digest = TextCodec::digest(digest), .chunks = std::move(chunks), .without = {}});
  }
  std::vector<std::string> ends(std::size_t g) {
    std::vector<std::string> whys;
    for (const NotRolledOut& end : nodes[g].take<NotRolledOut>()) whys.push_back(end.why);
    return whys;
  }
  static Next next_of(std::uint8_t digest, std::string by, std::uint32_t chunks = 0,
                      std::vector<std::string> without = {}) {
    return {.generation = 2,
            .digest = TextCodec::digest(digest),
            .chunks = chunks,
            .by = std::move(by),
            .without = std::move(without),
            .patience = std::numeric_limits<Value>::max() / 2};
  }
  void put_next(const std::string& value) { store.write({{.key = keys->next(), .value = value}}); }
  [[nodiscard]] bool proposed() const { return store.entries.contains(keys->next()); }
  /// The next one can be proposed, and is judged by the other gateway.
  void expect_room(std::size_t g = 0) {
    nodes[1].take<Judge>();
    stage(g, 5);
    run();
    EXPECT_TRUE(proposed());
    EXPECT_EQ(nodes[1].take<Judge>().size(), 1U);
  }
  /// The gateway would write nothing else of what it has staged.
  void expect_no_more_of(std::size_t g) {
    Member member = at(g);
    for (const Txn& txn : member.take_txns(now))
      for (const auto& put : txn.puts) {
        EXPECT_NE(put.key, keys->next());
        EXPECT_NE(put.value, "a") << "a chunk";
        EXPECT_NE(put.value, "b") << "a chunk";
      }
  }
  void see_all(std::size_t g) {
    for (; nodes[g].seen < store.log.size(); ++nodes[g].seen)
      at(g).on_batch(store.log[nodes[g].seen], now);
  }
  /// One transaction of a gateway, which does not see what others write.
  void step_alone(std::size_t g) {
    for (Event& event : at(g).take_events()) nodes[g].events.push_back(std::move(event));
    for (const Txn& txn : at(g).take_txns(now)) at(g).on_result(store.apply(txn), now);
    for (Event& event : at(g).take_events()) nodes[g].events.push_back(std::move(event));
  }
};

TEST_F(RolloutEnds, WithAReasonWhereItsTextMeetsAnotherProposal) {
  stage(0, 2, {"a", "b"});
  step_alone(0);
  ASSERT_TRUE(proposed());
  see_all(0);
  put_next(codec.write(next_of(3, "B")));
  step_alone(0);
  const auto why = ends(0);
  ASSERT_EQ(why.size(), 1U);
  EXPECT_NE(why[0].find("changed"), std::string::npos) << why[0];
  expect_no_more_of(0);
}

TEST_F(RolloutEnds, WhereAnotherOneTakesItsPlace) {
  stage(0, 2);
  run();
  ASSERT_TRUE(ends(0).empty());
  put_next(codec.write(next_of(3, "B")));
  run();
  EXPECT_EQ(ends(0).size(), 1U);
}

/// The view of the one that has proposed it goes from before it to after it.
TEST_F(RolloutEnds, WhereItWasNeverSeen) {
  stage(0, 2, {});
  step_alone(0);
  ASSERT_TRUE(proposed());
  expect_no_more_of(0);
  store.write({}, {keys->next()});
  read_all(0);
  run();
  EXPECT_EQ(ends(0).size(), 1U);
  expect_room();
}

TEST_F(RolloutEnds, AnEntryThatCannotBeReadMakesRoomAfterABoundedTime) {
  put_next("garbage");
  run();
  stage(0, 2);
  at(0).on_time(now);
  run();
  EXPECT_EQ(ends(0).size(), 1U) << "refused, and not kept waiting";
  pass(115 * kSecond);
  EXPECT_TRUE(proposed()) << "it may be of a version that others can read";
  pass(10 * kSecond);
  EXPECT_FALSE(proposed());
  auto whys = ends(0);
  for (const std::string& why : ends(1)) whys.push_back(why);
  EXPECT_TRUE(std::ranges::any_of(whys, [](const std::string& why) {
    return why.find("cannot be read") != std::string::npos;
  }));
  expect_room();
}

TEST_F(RolloutEnds, HostileEntriesMakeRoomAfterABoundedTime) {
  const std::vector<Next> hostile = {next_of(9, "nobody", 1), next_of(9, "A", 1),
                                     next_of(9, "C", 256), next_of(9, "B", 1, {"A", "B", "C"})};
  for (const Next& next : hostile) {
    put_next(codec.write(next));
    pass(125 * kSecond);
    EXPECT_FALSE(proposed()) << next.by;
    EXPECT_EQ(at(0).standing(now), Member::Standing::joined);
  }
  expect_room();
}

/// Its other gateway is the only one left that can end it.
TEST_F(RolloutEnds, AHostileEntryInTheNameOfTheOnlyOneThatIsThere) {
  nodes[1].member.reset();
  put_next(codec.write(next_of(9, "A", 1)));
  pass(65 * kSecond);
  EXPECT_FALSE(proposed());
}

/// Whoever has proposed it loads another description before its text is complete.
TEST_F(RolloutEnds, WhereNobodyPutsTheRestOfItsTextAnyMore) {
  stage(0, 2, {"a", "b", "c"});
  step_alone(0);
  see_all(0);
  step_alone(0);
  ASSERT_TRUE(proposed());
  start(0, at(0).journalled());
  run();
  EXPECT_FALSE(proposed()) << "nobody waits a minute for it";
  EXPECT_FALSE(ends(1).empty());
  expect_room();
}

TEST_F(RolloutEnds, AReasonOfTheStoreIsSaidWhereItsTextDoesNotGetThere) {
  stage(0, 2, {"a", "b"});
  run();
  ASSERT_EQ(nodes[1].take<Judge>().size(), 1U);
  at(1).vote_rollout(TextCodec::digest(2), false, "not here");
  run();
  ASSERT_EQ(ends(0), std::vector<std::string>{"B: not here"});
  stage(0, 3, {"c"});
  for (int n = 0; n < 700; ++n) {
    now += kSecond / 10;
    for (std::size_t g = 0; g < 2; ++g) {
      for (; nodes[g].seen < store.log.size(); ++nodes[g].seen)
        at(g).on_batch(store.log[nodes[g].seen], now);
      at(g).on_time(now);
      for (Event& event : at(g).take_events()) nodes[g].events.push_back(std::move(event));
      at(g).applied(store.revision);
      for (const Txn& txn : at(g).take_txns(now)) {
        const bool text = std::ranges::any_of(
            txn.puts, [](const Put& put) { return put.key.find("/blob/") != std::string::npos; });
        at(g).on_result(text ? TxnResult{.id = txn.id, .outcome = Outcome::full, .why = "no space"}
                             : store.apply(txn),
                        now);
      }
    }
  }
  const auto why = ends(0);
  ASSERT_EQ(why.size(), 1U);
  EXPECT_NE(why[0].find("no space"), std::string::npos) << why[0];
}

/// A vote on what is proposed next does not take the place of what brings the former one back.
TEST_F(RolloutEnds, WhoCannotFollowIsNotPassedOverForTheNextProposal) {
  start(2);
  stage(0, 2);
  run();
  for (std::size_t g = 0; g < 3; ++g) at(g).vote_rollout(TextCodec::digest(2), true, {});
  run();
  for (Node& node : nodes) node.take<Switch>();
  at(1).cannot_switch("no memory for a gate");
  put_next(codec.write(next_of(3, "B")));
  nodes[1].member->on_batch(store.log.back(), now);
  nodes[1].seen = store.log.size();
  run();
  const auto to = nodes[0].take<Switch>();
  ASSERT_FALSE(to.empty());
  EXPECT_TRUE(to.back().undone);
}

}  // namespace
}  // namespace mlcca::core::cluster::test
