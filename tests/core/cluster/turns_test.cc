// SPDX-License-Identifier: BSD-2-Clause
// Tests of what a gateway does first when it has much to do for others.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/core/cluster/members.hpp"

namespace mlcca::core::cluster::test {
namespace {

class ClusterTurns : public ClusterMember {
 protected:
  void SetUp() override {
    in_force(1);
    for (std::size_t g = 0; g < 3; ++g) start(g);
    pass(kSecond);
  }
  /// Another gateway asks for the agreement of the first one.
  void ask(std::size_t gateway, std::uint64_t id) {
    store.write({{.key = keys->asked(gateway, id),
                  .value = codec.write(RouteRequest{
                      .stage = Stage::prepared, .admission = "request", .gateways = {0}})}});
  }
  void see() {
    Node& node = nodes[0];
    while (node.seen < store.log.size()) node.member->on_batch(store.log[node.seen++], now);
    for (Event& event : node.member->take_events()) node.events.push_back(std::move(event));
  }
  void agree_to_all() {
    see();
    for (const Adopt& event : nodes[0].take<Adopt>())
      at(0).vote(event.origin, {.ok = true, .hop = {}, .reason = {}}, now);
  }
  [[nodiscard]] std::int64_t created(const std::string& key) const {
    const auto it = store.entries.find(key);
    return it == store.entries.end() ? 0 : it->second.create;
  }
  [[nodiscard]] std::vector<std::int64_t> votes_on(std::size_t gateway, std::uint64_t from,
                                                   std::uint64_t to) const {
    std::vector<std::int64_t> all;
    for (std::uint64_t id = from; id < to; ++id) all.push_back(created(keys->vote(0, gateway, id)));
    return all;
  }
  [[nodiscard]] static std::ptrdiff_t before(const std::vector<std::int64_t>& all,
                                             std::int64_t revision) {
    return std::ranges::count_if(all, [&](std::int64_t one) { return one < revision; });
  }
};

TEST_F(ClusterTurns, VotesOnOneGatewaysAdmissionsDoNotHoldUpThoseOnAnothers) {
  for (std::uint64_t id = 1; id <= 200; ++id) ask(1, id);
  ask(2, 1);
  agree_to_all();
  run();
  const auto all = votes_on(1, 1, 201);
  EXPECT_EQ(std::ranges::count(all, 0), 0);
  ASSERT_NE(created(keys->vote(0, 2, 1)), 0);
  EXPECT_LT(before(all, created(keys->vote(0, 2, 1))), 20);
}

TEST_F(ClusterTurns, VotesDoNotHoldUpAnOwnAdmissionNorAFence) {
  nodes[2].cut_off = true;
  for (std::uint64_t id = 1; id <= 200; ++id) ask(1, id);
  see();
  const auto asked = nodes[0].take<Adopt>();
  while (now + kSecond < *at(0).view().fence_from(2)) pass(kSecond / 4);
  ASSERT_EQ(created(keys->fence(2)), 0);
  now += 2 * kSecond;
  for (Node& node : nodes) node.member->on_time(now);
  nodes[1].cut_off = true;
  for (const Adopt& event : asked)
    at(0).vote(event.origin, {.ok = true, .hop = {}, .reason = {}}, now);
  at(0).reserve(unit(7), now);
  run();
  const auto all = votes_on(1, 1, 201);
  EXPECT_EQ(std::ranges::count(all, 0), 0);
  ASSERT_NE(created(keys->fence(2)), 0);
  EXPECT_LT(before(all, created(keys->fence(2))), 60);
  ASSERT_NE(created(keys->asked(0, 7)), 0);
  EXPECT_LT(before(all, created(keys->asked(0, 7))), 20);
}

TEST_F(ClusterTurns, OwnAdmissionsDoNotHoldUpVotes) {
  for (std::uint64_t id = 10; id < 30; ++id) {
    at(0).reserve(unit(id), now);
    run();
    ASSERT_NE(created(keys->asked(0, id)), 0);
  }
  for (std::uint64_t id = 10; id < 30; ++id) at(0).release(id, now);
  ask(1, 1);
  now += 2 * kSecond;
  agree_to_all();
  run();
  const std::int64_t vote = created(keys->vote(0, 1, 1));
  ASSERT_NE(vote, 0);
  const std::string first = keys->asked(0, 0);
  const std::string own = first.substr(0, first.size() - 1);
  std::vector<std::int64_t> ends;
  for (const Batch& batch : store.log)
    for (const Entry& entry : batch.entries)
      if (entry.gone && entry.key.starts_with(own)) ends.push_back(batch.revision);
  EXPECT_EQ(ends.size(), 20U);
  EXPECT_LT(before(ends, vote), 4);
}

/// One admission is another one when the votes arrive: the other votes are sent again, and the one
/// on the other admission is not taken for sent.
TEST_F(ClusterTurns, AnAdmissionThatHasChangedHoldsUpNoOtherVote) {
  for (std::uint64_t id = 1; id <= 3; ++id) ask(1, id);
  agree_to_all();
  auto txns = at(0).take_txns(now);
  ASSERT_EQ(txns.size(), 1U);
  store.write({}, {keys->asked(1, 2)});
  ask(1, 2);
  agree_to_all();
  const TxnResult result = store.apply(txns.front());
  ASSERT_EQ(result.outcome, Outcome::conflict);
  at(0).on_result(result, now);
  run();
  for (std::uint64_t id = 1; id <= 3; ++id) {
    const auto vote = store.entries.find(keys->vote(0, 1, id));
    ASSERT_NE(vote, store.entries.end()) << id;
    EXPECT_EQ(codec.vote(vote->second.value)->asked, created(keys->asked(1, id))) << id;
  }
}

}  // namespace
}  // namespace mlcca::core::cluster::test
