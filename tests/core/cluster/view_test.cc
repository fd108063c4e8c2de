// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/view.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/cluster/footprint.hpp"
#include "core/cluster/lease.hpp"
#include "tests/core/cluster/codec.hpp"
#include "tests/core/cluster/store_stub.hpp"
#include "tests/core/cluster/world.hpp"

namespace mlcca::core::cluster::test {
namespace {

constexpr Value kSecond = 1'000'000'000;

class ClusterView : public testing::Test {
 protected:
  ClusterView() { read_all(0); }

  void read_all(Value now) {
    view.begin_snapshot(store.revision);
    view.apply(store.snapshot(), now);
    view.end_snapshot(now);
  }
  void put(const std::string& key, const std::string& value, Value now) {
    store.write({{.key = key, .value = value}});
    view.apply(store.log.back(), now);
  }
  void drop(const std::string& key, Value now) {
    store.write({}, {key});
    view.apply(store.log.back(), now);
  }
  void beat(std::size_t g, Value now, Beat beat = {}) {
    beat.lease = 10 * kSecond;
    put(keys->member(g), codec.write(beat), now);
  }
  void endless_beat(std::size_t g, Value now) {
    Beat beat;
    beat.lease = kUnbounded;
    put(keys->member(g), codec.write(beat), now);
  }
  void hold(std::size_t g, std::uint64_t id, Value bytes, Value now,
            std::vector<std::size_t> through = {}) {
    put(keys->reservation(0, g, id),
        codec.write(Taken{.channel = {},
                          .publisher = {},
                          .part = part_of(0, bytes),
                          .through = std::move(through)}),
        now);
  }
  Value held() { return bytes_of(view.foreign(0).rates); }

  TextCodec codec;
  std::shared_ptr<const Keys> keys = keys_of(4);
  StoreStub store;
  View view{keys, codec, 0};
};

TEST_F(ClusterView, CountsWhatOthersHoldAndNotWhatItHoldsItself) {
  hold(1, 1, 5, 0);
  hold(2, 1, 7, 0);
  hold(0, 1, 100, 0);
  EXPECT_EQ(held(), 12U);
  EXPECT_FALSE(view.foreign(0).unreadable);
  EXPECT_EQ(view.take_changed(), std::vector<std::size_t>({0, 1}));
  drop(keys->reservation(0, 1, 1), 0);
  EXPECT_EQ(held(), 7U);
  EXPECT_EQ(view.take_changed(), std::vector<std::size_t>{0});
}

TEST_F(ClusterView, WhatCannotBeReadIsNotNothing) {
  for (const std::string& key :
       {keys->reservation(0, 1, 1), std::string("r/bus/nobody/1"), std::string("r/bus/B/1/2")}) {
    put(key, "?", 0);
    EXPECT_TRUE(view.foreign(0).unreadable) << key;
    EXPECT_FALSE(view.foreign(1).unreadable);
    drop(key, 0);
    EXPECT_FALSE(view.foreign(0).unreadable) << key;
  }
  put(keys->reservation(0, 1, 1), std::string(kMostEntryBytes + 1, '1'), 0);
  EXPECT_TRUE(view.foreign(0).unreadable);
}

TEST_F(ClusterView, ARevisionCountsWhenAllOfItIsThere) {
  store.write({{.key = keys->version(0), .value = "B 1"}});
  Batch part = store.log.back();
  part.last = false;
  view.apply(part, 0);
  EXPECT_EQ(view.version(0), 0);
  EXPECT_LT(view.revision(), part.revision);
  view.apply({.revision = part.revision, .entries = {}}, 0);
  EXPECT_EQ(view.version(0), part.revision);
  EXPECT_EQ(view.revision(), part.revision);
}

TEST_F(ClusterView, WhatWasSeenBeforeIsNotAppliedAgain) {
  hold(1, 1, 5, 0);
  const Batch old = store.log.back();
  drop(keys->reservation(0, 1, 1), 0);
  view.apply(old, 0);
  EXPECT_EQ(held(), 0U);
}

/// A rollout called it off, so the description does not have it any more.
TEST_F(ClusterView, WhatAGatewayOfAFormerDescriptionHasLeftIsOverWhenItIsDead) {
  const std::string left = "r/bus/gone/1";
  put("m/gone", codec.write(Beat{.lease = 10 * kSecond}), 20 * kSecond);
  put(left, "5", 20 * kSecond);
  const Value end = may_fence_at(20 * kSecond, 10 * kSecond);
  view.on_time(2 * end);
  EXPECT_TRUE(view.foreign(0).unreadable) << "nobody has fenced it";
  put("f/gone", "A", 21 * kSecond);
  EXPECT_EQ(view.next_event(end - 1), end);
  view.on_time(end - 1);
  EXPECT_TRUE(view.foreign(0).unreadable) << "somebody hostile may have fenced it";
  static_cast<void>(view.take_changed());
  view.on_time(end);
  EXPECT_FALSE(view.foreign(0).unreadable);
  EXPECT_EQ(view.take_changed(), std::vector<std::size_t>{0});
  // Whoever reads all of it again waits again only where it cannot know better.
  read_all(end);
  view.on_time(end);
  EXPECT_FALSE(view.foreign(0).unreadable);
  put(left, "5", end);
  view.on_time(2 * end);
  EXPECT_TRUE(view.foreign(0).unreadable) << "it is younger than the fence";
  drop(left, end);
  EXPECT_FALSE(view.foreign(0).unreadable);
}

TEST_F(ClusterView, ADeadGatewayCountsUntilItIsFencedAndItsLeaseHasEnded) {
  beat(1, 0);
  hold(1, 1, 5, 0);
  beat(1, 20 * kSecond);
  const Value end = may_fence_at(20 * kSecond, 10 * kSecond);
  EXPECT_EQ(view.fence_from(1), end);
  view.on_time(end);
  EXPECT_EQ(held(), 5U) << "nobody has fenced it";
  put(keys->fence(1), "A", 21 * kSecond);
  EXPECT_EQ(view.fence_from(1), std::nullopt);
  EXPECT_EQ(view.alive(1, end - 1), Alive::silent);
  view.on_time(end - 1);
  EXPECT_EQ(held(), 5U) << "somebody hostile may have fenced it";
  view.on_time(end);
  EXPECT_EQ(held(), 0U);
  EXPECT_EQ(view.alive(1, end), Alive::fenced);
}

/// Such an entry is refused, and its gateway may send for so long all the same.
TEST_F(ClusterView, WhoStatesALongerLeaseThanItMayHaveCountsForAllOfIt) {
  const Value lease = 5 * kMostLease;
  hold(1, 1, 5, 0);
  Beat beat;
  beat.lease = lease;
  put(keys->member(1), codec.write(beat), 0);
  EXPECT_EQ(view.alive(1, kSecond), Alive::silent) << "it is not understood";
  EXPECT_EQ(view.fence_from(1), may_fence_at(0, lease));
  EXPECT_EQ(view.all_leases_end(0, 10 * kSecond), may_fence_at(0, lease));
  EXPECT_EQ(view.with_too_long_lease(), 1U);
  put(keys->fence(1), "2", kSecond);
  view.on_time(may_fence_at(0, lease) - 1);
  EXPECT_EQ(held(), 5U) << "somebody hostile may have fenced it";
  view.on_time(may_fence_at(0, lease));
  EXPECT_EQ(held(), 0U);
}

TEST_F(ClusterView, ALeaseWithoutAnEndLastsAsLongAsItsEntry) {
  hold(1, 1, 5, 0);
  endless_beat(1, 0);
  put(keys->fence(1), "2", kSecond);
  view.on_time(kUnbounded - 1);
  EXPECT_EQ(held(), 5U);
  put(keys->member(1), "?", 2 * kSecond);
  EXPECT_EQ(view.counts_until(1), kUnbounded) << "it does not say that it states less now";
  EXPECT_EQ(view.with_too_long_lease(), 1U);
}

/// No process of mlccad sends for longer than that, and its successor has replaced the entry.
TEST_F(ClusterView, AfterALeaseWithoutAnEndANextBeatCountsForTheLongestLease) {
  hold(1, 1, 5, 0);
  endless_beat(1, 0);
  put(keys->fence(1), "2", kSecond);
  beat(1, 2 * kSecond);
  const Value end = may_fence_at(2 * kSecond, kMostLease);
  EXPECT_EQ(view.with_too_long_lease(), std::nullopt);
  EXPECT_EQ(view.fence_from(1), end);
  EXPECT_EQ(view.next_event(end - 1), end);
  beat(1, 3 * kSecond);
  EXPECT_EQ(view.fence_from(1), end);
  view.on_time(end - 1);
  EXPECT_EQ(held(), 5U) << "what it had before its fence";
  view.on_time(end);
  EXPECT_EQ(held(), 0U);
  beat(1, end);
  EXPECT_EQ(view.fence_from(1), may_fence_at(end, 10 * kSecond));
}

TEST_F(ClusterView, AfterALeaseWithoutAnEndADeletedEntryCountsForTheLongestLease) {
  endless_beat(1, 0);
  drop(keys->member(1), 10 * kMostLease);
  const Value end = may_fence_at(10 * kMostLease, kMostLease);
  EXPECT_EQ(view.alive(1, end - 1), Alive::silent);
  EXPECT_EQ(view.alive(1, end), Alive::absent);
}

TEST_F(ClusterView, WhatARemovedGatewayWithoutAnEndHasLeftIsOverAfterItsEntry) {
  const std::string left = "r/bus/gone/1";
  Beat beat;
  beat.lease = kUnbounded;
  put("m/gone", codec.write(beat), 0);
  put(left, "5", 0);
  put("f/gone", "A", kSecond);
  view.on_time(kUnbounded - 1);
  EXPECT_TRUE(view.foreign(0).unreadable);
  drop("m/gone", 2 * kSecond);
  const Value end = may_fence_at(2 * kSecond, kMostLease);
  view.on_time(end - 1);
  EXPECT_TRUE(view.foreign(0).unreadable);
  view.on_time(end);
  EXPECT_FALSE(view.foreign(0).unreadable);
}

TEST_F(ClusterView, ABeatThatCannotBeReadCountsForTheLongestLease) {
  hold(1, 1, 5, 0);
  put(keys->member(1), "?", 0);
  EXPECT_EQ(view.fence_from(1), may_fence_at(0, kMostLease));
}

TEST_F(ClusterView, WhatItTakesAfterItsFenceCountsAtOnce) {
  beat(1, 0);
  hold(1, 1, 5, 0);
  put(keys->fence(1), "A", 0);
  beat(1, kSecond);
  hold(1, 2, 9, kSecond);
  view.on_time(may_fence_at(0, 10 * kSecond));
  EXPECT_EQ(held(), 9U);
}

TEST_F(ClusterView, WhoReadsEverythingAgainKnowsStillHowLongOthersAreSilent) {
  beat(1, 0);
  read_all(5 * kSecond);
  EXPECT_EQ(view.fence_from(1), may_fence_at(0, 10 * kSecond));
  store.write({{.key = keys->member(1), .value = codec.write(Beat{.lease = 10 * kSecond})}});
  read_all(6 * kSecond);
  EXPECT_EQ(view.fence_from(1), may_fence_at(6 * kSecond, 10 * kSecond));
}

TEST_F(ClusterView, WhatWasFreedIsFreedInTheNextSnapshot) {
  beat(1, 0);
  hold(1, 1, 5, 0);
  put(keys->fence(1), "A", 0);
  const Value end = may_fence_at(0, 10 * kSecond);
  view.on_time(end);
  read_all(end + 1);
  EXPECT_EQ(held(), 0U);
}

TEST_F(ClusterView, WhatADeadOneHasThroughOthersCountsUntilTheyHaveClosedIt) {
  beat(1, 0);
  beat(2, 0);
  hold(1, 1, 5, 0, {2});
  put(keys->fence(1), "A", 0);
  const std::int64_t fence = view.revision();
  const Value end = may_fence_at(0, 10 * kSecond);
  beat(2, end, {.applied = fence - 1});
  view.on_time(end + (5 * kSecond));
  EXPECT_EQ(held(), 5U);
  beat(2, end + (6 * kSecond), {.applied = fence});
  EXPECT_EQ(held(), 5U) << "its last frames may be in a queue";
  view.on_time(queues_empty_at(end + (6 * kSecond)));
  EXPECT_EQ(held(), 0U);
}

TEST_F(ClusterView, WhatIsAdoptedIsNotForeign) {
  hold(1, 1, 5, 0, {0});
  view.adopt(1, 1, true);
  EXPECT_EQ(held(), 0U);
  view.adopt(1, 1, false);
  EXPECT_EQ(held(), 5U);
}

/// Whatever has changed since it was asked for.
TEST_F(ClusterView, WhatOthersHoldFollowsFromItsRecordsAtAnyTime) {
  std::mt19937_64 random(7);
  const auto below = [&](std::size_t n) { return random() % n; };
  std::set<Records::AskedKey> adopted;
  Value now = 0;
  std::size_t held_something = 0;
  for (std::size_t g = 0; g < 4; ++g) beat(g, now);
  for (int step = 0; step < 2000; ++step) {
    const std::size_t network = below(2);
    const std::size_t gateway = below(4);
    const std::uint64_t id = 1 + below(5);
    const std::string key = keys->reservation(network, gateway, id);
    switch (below(8)) {
      case 0:
      case 1:
      case 2:
        put(key,
            codec.write(Taken{.channel = {},
                              .publisher = {},
                              .part = part_of(network, 1 + below(9)),
                              .through = {}}),
            now);
        break;
      case 3:
        drop(key, now);
        break;
      case 4: {
        const Records::AskedKey one{1 + below(3), id};
        const bool more = adopted.insert(one).second;
        if (!more) adopted.erase(one);
        view.adopt(one.first, one.second, more);
        break;
      }
      case 5:
        put(key, "?", now);
        break;
      case 6:
        // A gateway is fenced, and comes back later.
        if (gateway != 0) put(keys->fence(gateway), "fence", now);
        now += 20 * kSecond;
        view.on_time(now);
        if (gateway != 0) beat(gateway, now);
        break;
      default:
        if (below(10) == 0) read_all(now);
    }
    for (std::size_t n = 0; n < 2; ++n) {
      Foreign expected;
      expected.unreadable = view.records().unreadable(n);
      for (const auto& [at, record] : view.records().reservations) {
        if (at.network != n || at.gateway == 0 || adopted.contains({at.gateway, at.id})) continue;
        if (record.taken)
          add(expected, record.taken->part, at.gateway);
        else
          expected.unreadable = true;
      }
      held_something += expected.rates.empty() ? 0 : 1;
      ASSERT_EQ(view.foreign(n), expected) << "step " << step;
    }
  }
  EXPECT_GT(held_something, 1000U);
}

TEST_F(ClusterView, TellsWhoIsThere) {
  EXPECT_EQ(view.alive(1, 0), Alive::absent);
  beat(1, 0, {.role = Role::standby});
  EXPECT_EQ(view.alive(1, 0), Alive::standby);
  beat(1, 0, {.role = Role::active});
  EXPECT_EQ(view.alive(1, 0), Alive::present);
  EXPECT_EQ(view.alive(1, may_fence_at(0, 10 * kSecond)), Alive::silent);
  beat(1, 0, {.role = Role::active, .draining = true});
  EXPECT_EQ(view.alive(1, 0), Alive::draining);
  drop(keys->member(1), 0);
  EXPECT_EQ(view.alive(1, 0), Alive::absent);
  beat(2, 0, {.role = Role::active});
  drop(keys->member(2), 0);
  EXPECT_EQ(view.alive(2, 0), Alive::silent) << "it did not say that it goes";
  put(keys->member(3), "?", 0);
  EXPECT_EQ(view.alive(3, 0), Alive::silent);
  EXPECT_EQ(view.fence_from(3), may_fence_at(0, kMostLease)) << "its lease is not known";
}

TEST_F(ClusterView, ASnapshotThatIsOlderIsNoticed) {
  hold(1, 1, 5, 0);
  store = StoreStub{};
  read_all(0);
  EXPECT_TRUE(view.went_back());
  EXPECT_EQ(held(), 0U);
}

}  // namespace
}  // namespace mlcca::core::cluster::test
