// SPDX-License-Identifier: BSD-2-Clause
// What is promised, and taken back exactly.
#include "core/reserve/ledger.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace mlcca::core::testing {
namespace {

constexpr std::size_t kBus = 0;
constexpr std::size_t kMesh = 1;
constexpr std::size_t kWire = 2;
constexpr can::Time kMillisecond = 1'000'000;

can::Assumptions bus_of(std::uint32_t bitrate = 500'000) {
  can::Assumptions bus;
  bus.timing.bitrate = bitrate;
  return bus;
}

/// A bus, a mesh of three domains and a wire; three publishers.
Ledger ledger() {
  System system;
  system.networks.resize(3);
  system.publishers.resize(3);
  Ledger ledger(system);
  ledger.set_bus(kBus, bus_of());
  ledger.set_domains(kMesh, 3);
  return ledger;
}

can::Message message(std::uint32_t priority, can::Time frame = kMillisecond) {
  can::Message m;
  m.priority = priority;
  m.transmission = m.longest_frame = m.last_frame = frame;
  m.period = m.deadline = 10 * kMillisecond;
  return m;
}

constexpr Flow on(std::size_t resource, std::size_t publisher = 0, std::size_t from = Flow::kOwn) {
  return {publisher, resource, from};
}

TEST(LedgerTest, AFlowIsCarriedOnceOnEachWayIn) {
  Ledger l = ledger();
  EXPECT_FALSE(l.carries(on(kWire)));
  EXPECT_TRUE(l.add(on(kWire), 100));
  EXPECT_FALSE(l.add(on(kWire), 100)) << "it is carried already";
  EXPECT_EQ(l.reserved(kWire), 100U);
  EXPECT_TRUE(l.add(on(kWire, 0, kBus), 100)) << "once more from another network";
  EXPECT_TRUE(l.add(on(kWire, 1), 30));
  EXPECT_TRUE(l.add(on(kBus), 5));
  EXPECT_EQ(l.reserved(kWire), 230U);
  EXPECT_EQ(l.reserved(kBus), 5U);
  EXPECT_EQ(l.holdings_of(0).size(), 3U);
  EXPECT_EQ(l.find(on(kWire, 1))->bytes_per_second, 30U);
  EXPECT_EQ(l.find(on(kBus, 1)), nullptr);
  l.remove(0);
  EXPECT_EQ(l.reserved(kWire), 30U);
  EXPECT_EQ(l.reserved(kBus), 0U);
  EXPECT_FALSE(l.carries(on(kWire)));
}

TEST(LedgerTest, APublisherThatCameLaterHasRoom) {
  Ledger l = ledger();
  EXPECT_TRUE(l.holdings_of(9).empty());
  l.remove(9);
  EXPECT_TRUE(l.add(on(kWire, 9), 7));
  EXPECT_EQ(l.holdings_of(9).size(), 1U);
  EXPECT_EQ(l.reserved(kWire), 7U);
}

TEST(LedgerTest, TheKeyOfAFlowNamesItsPublisherAndWhereItComesFrom) {
  const std::uint64_t key = Ledger::key_of(on(kBus, 5, 3));
  EXPECT_EQ(Ledger::publisher_of(key), 5U);
  EXPECT_NE(key, Ledger::key_of(on(kBus, 5, 2)));
  EXPECT_NE(key, Ledger::key_of(on(kBus, 5)));
  EXPECT_NE(key, Ledger::key_of(on(kBus, 4, 3)));
  EXPECT_EQ(Ledger::publisher_of(Ledger::key_of(on(kBus, 5))), 5U);
}

TEST(LedgerTest, TheTimeOfADomainIsTheSumOfItsShares) {
  Ledger l = ledger();
  l.add(on(kMesh), 100);
  const std::vector<std::uint32_t> first{4};
  const std::vector<std::uint32_t> second{6, 7};
  l.occupy(on(kMesh), first, {{0, 10}, {1, 20}});
  l.occupy(on(kMesh), second, {{1, 5}, {2, 7}});
  l.add(on(kMesh, 1), 100);
  l.occupy(on(kMesh, 1), first, {{0, 1}});
  EXPECT_EQ(l.medium_time(kMesh, 0), 11U);
  EXPECT_EQ(l.medium_time(kMesh, 1), 25U);
  EXPECT_EQ(l.medium_time(kMesh, 2), 7U);
  EXPECT_EQ(l.find(on(kMesh))->mesh->links, (std::vector<std::uint32_t>{4, 6, 7}));
  EXPECT_EQ(l.find(on(kMesh))->mesh->shares.size(), 3U) << "each domain once";
  l.remove(0);
  EXPECT_EQ(l.medium_time(kMesh, 0), 1U);
  EXPECT_EQ(l.medium_time(kMesh, 1), 0U);
  EXPECT_EQ(l.medium_time(kMesh, 2), 0U);
}

TEST(LedgerTest, ARollBackTakesEachChangeBackExactly) {
  Ledger l = ledger();
  const std::vector<std::uint32_t> links{4};
  l.add(on(kBus), 10);
  l.add(on(kMesh), 10);
  ASSERT_FALSE(l.schedule(on(kBus), message(1)));
  l.occupy(on(kMesh), links, {{0, 10}});

  const Ledger::Mark outer = l.mark();
  l.add(on(kBus, 1), 20);
  ASSERT_FALSE(l.schedule(on(kBus, 1), message(2)));
  const std::vector<std::uint32_t> more{5};
  l.occupy(on(kMesh), more, {{0, 1}, {2, 3}});
  l.add(on(kMesh, 2), 7);
  l.occupy(on(kMesh, 2), links, {{1, 8}});

  const Ledger::Mark inner = l.mark();
  l.remove(0);
  l.remove(1);
  EXPECT_EQ(l.reserved(kBus), 0U);
  EXPECT_TRUE(l.schedule(kBus)->messages().empty());
  l.roll_back(inner);
  EXPECT_EQ(l.reserved(kBus), 30U);
  EXPECT_EQ(l.schedule(kBus)->messages().size(), 2U);
  EXPECT_EQ(l.medium_time(kMesh, 0), 11U);
  EXPECT_EQ(l.medium_time(kMesh, 2), 3U);

  l.roll_back(outer);
  EXPECT_EQ(l.reserved(kBus), 10U);
  EXPECT_EQ(l.reserved(kMesh), 10U);
  EXPECT_EQ(l.schedule(kBus)->messages().size(), 1U);
  EXPECT_EQ(l.medium_time(kMesh, 0), 10U);
  EXPECT_EQ(l.medium_time(kMesh, 1), 0U);
  EXPECT_EQ(l.medium_time(kMesh, 2), 0U);
  EXPECT_EQ(l.find(on(kMesh))->mesh->links, links);
  EXPECT_EQ(l.find(on(kMesh))->mesh->shares.size(), 1U);
  EXPECT_FALSE(l.carries(on(kBus, 1)));
  // Who held no message may get one, as if it had never had one.
  l.add(on(kBus, 1), 20);
  EXPECT_FALSE(l.schedule(on(kBus, 1), message(2)));
  EXPECT_EQ(l.schedule(kBus)->messages().size(), 2U);
}

TEST(LedgerTest, ARollBackTakesAMessageFromAFlowThatStays) {
  Ledger l = ledger();
  l.add(on(kBus), 10);
  const Ledger::Mark mark = l.mark();
  ASSERT_FALSE(l.schedule(on(kBus), message(1)));
  EXPECT_TRUE(l.find(on(kBus))->scheduled);
  l.roll_back(mark);
  EXPECT_FALSE(l.find(on(kBus))->scheduled);
  EXPECT_TRUE(l.schedule(kBus)->messages().empty());
}

TEST(LedgerTest, WhatIsCommittedStaysAndNoLaterMarkTakesItBack) {
  Ledger l = ledger();
  static_cast<void>(l.mark());
  l.add(on(kBus), 10);
  ASSERT_FALSE(l.schedule(on(kBus), message(1)));
  l.commit();
  const Ledger::Mark mark = l.mark();
  l.add(on(kBus, 1), 20);
  ASSERT_FALSE(l.schedule(on(kBus, 1), message(2)));
  l.roll_back(mark);
  EXPECT_EQ(l.reserved(kBus), 10U);
  EXPECT_EQ(l.schedule(kBus)->messages().size(), 1U);
}

TEST(LedgerTest, AMarkInsideAnotherIsTakenBackAgainAndAgain) {
  Ledger l = ledger();
  const Ledger::Mark outer = l.mark();
  for (const std::size_t p : {0, 1, 2}) l.add(on(kBus, p), 1);
  ASSERT_FALSE(l.schedule(on(kBus, 0), message(1)));
  const Ledger::Mark inner = l.mark();
  for (int i = 0; i < 2; ++i) {
    ASSERT_FALSE(l.schedule(on(kBus, 1), message(2)));
    ASSERT_FALSE(l.schedule(on(kBus, 2), message(3)));
    EXPECT_EQ(l.schedule(kBus)->messages().size(), 3U);
    l.roll_back(inner);
    EXPECT_EQ(l.schedule(kBus)->messages().size(), 1U);
  }
  ASSERT_FALSE(l.schedule(on(kBus, 1), message(2)));
  l.roll_back(outer);
  EXPECT_TRUE(l.schedule(kBus)->messages().empty());
  EXPECT_EQ(l.reserved(kBus), 0U);
}

TEST(LedgerTest, AMessageTakesThePlaceOfTheOneThatTheFlowHas) {
  Ledger l = ledger();
  l.add(on(kBus), 10);
  l.add(on(kBus, 1), 10);
  ASSERT_FALSE(l.schedule(on(kBus), message(1)));
  ASSERT_FALSE(l.schedule(on(kBus, 1), message(2)));
  ASSERT_FALSE(l.schedule(on(kBus), message(1, 2 * kMillisecond)));
  EXPECT_EQ(l.schedule(kBus)->messages().size(), 2U);
  EXPECT_EQ(l.schedule(kBus)->response(Ledger::key_of(on(kBus))), 3 * kMillisecond);
  // One that does not fit leaves the one that was there.
  EXPECT_TRUE(l.schedule(on(kBus), message(1, 9 * kMillisecond + 1)));
  EXPECT_EQ(l.schedule(kBus)->response(Ledger::key_of(on(kBus))), 3 * kMillisecond);
  l.remove(0);
  EXPECT_EQ(l.schedule(kBus)->messages().size(), 1U);
  EXPECT_EQ(l.schedule(kBus)->messages()[0].key, Ledger::key_of(on(kBus, 1)));
}

TEST(LedgerTest, WhatIsAssumedOfABusIsTakenBackToo) {
  Ledger l = ledger();
  can::Assumptions loaded = bus_of();
  loaded.background = 100'000;
  l.set_bus(kBus, loaded);
  const Ledger::Mark mark = l.mark();
  l.assume(kBus, bus_of());
  EXPECT_EQ(l.schedule(kBus)->assumptions().background, 0U);
  l.roll_back(mark);
  EXPECT_EQ(l.schedule(kBus)->assumptions().background, 100'000U);
  l.commit();
  l.set_bus(kBus, std::nullopt);
  EXPECT_EQ(l.schedule(kBus), nullptr);
}

/// What a ledger is made to hold, to be varied one thing at a time.
struct Held {
  std::size_t publisher = 0;
  std::size_t from = Flow::kOwn;
  Value wire = 10;
  Value mesh = 10;
  std::vector<std::uint32_t> links = {4, 5};
  std::vector<mesh::Share> shares = {{0, 10}, {1, 20}};
  bool over_mesh = true;
  bool scheduled = true;
  std::uint32_t priority = 1;
  std::uint32_t bitrate = 500'000;

  [[nodiscard]] Ledger made() const {
    Ledger l = ledger();
    l.set_bus(kBus, bus_of(bitrate));
    l.add(on(kWire, publisher, from), wire);
    l.add(on(kMesh, publisher), mesh);
    if (over_mesh) l.occupy(on(kMesh, publisher), links, shares);
    l.add(on(kBus, publisher), 1);
    if (scheduled) {
      EXPECT_FALSE(l.schedule(on(kBus, publisher), message(priority)));
    }
    return l;
  }
};

TEST(LedgerTest, TheSameIsPromisedWhateverTheOrderWas) {
  const Ledger held = Held{}.made();
  EXPECT_TRUE(held.same_promises(Held{}.made()));
  EXPECT_TRUE(held.same_promises(Held{.links = {5, 4}}.made())) << "the order of links";
  Ledger turned = ledger();
  turned.add(on(kBus), 1);
  EXPECT_FALSE(turned.schedule(on(kBus), message(1)));
  turned.add(on(kMesh), 10);
  turned.occupy(on(kMesh), std::vector<std::uint32_t>{4, 5}, {{0, 10}, {1, 20}});
  turned.add(on(kWire), 10);
  EXPECT_TRUE(held.same_promises(turned)) << "the order of flows";
  Ledger more_room = Held{}.made();
  more_room.add(on(kWire, 9), 1);
  EXPECT_FALSE(held.same_promises(more_room));
  more_room.remove(9);
  EXPECT_TRUE(held.same_promises(more_room)) << "a publisher that holds nothing";
  EXPECT_TRUE(more_room.same_promises(held));
}

TEST(LedgerTest, SomethingElseIsPromised) {
  const Ledger held = Held{}.made();
  const std::vector<std::pair<std::string, Held>> others = {
      {"by another publisher", {.publisher = 1}},
      {"from another resource", {.from = kBus}},
      {"more bytes", {.wire = 11}},
      {"more bytes over the mesh", {.mesh = 11}},
      {"over other links", {.links = {4, 6}}},
      {"over fewer links", {.links = {4}}},
      {"more time of a domain", {.shares = {{0, 10}, {1, 21}}}},
      {"over no links", {.over_mesh = false}},
      {"over no links that take time", {.shares = {}, .over_mesh = false}},
      {"no message", {.scheduled = false}},
      {"another message", {.priority = 2}},
      {"a slower bus", {.bitrate = 250'000}}};
  for (const auto& [what, other] : others) {
    EXPECT_FALSE(held.same_promises(other.made())) << what;
    EXPECT_FALSE(other.made().same_promises(held)) << what;
  }
}

/// The sums are the same, and each resource carries as much.
TEST(LedgerTest, ThePromisesOfTwoPublishersAreNotMixedUp) {
  const auto made = [](Value first, Value second, bool crosswise) {
    Ledger l = ledger();
    l.add(on(kWire, 0), first);
    l.add(on(kWire, 1), second);
    for (const std::size_t p : {0, 1}) l.add(on(kMesh, p), 1);
    const std::vector<std::uint32_t> near{1};
    const std::vector<std::uint32_t> far{2};
    l.occupy(on(kMesh, 0), crosswise ? far : near, {{0, 5}});
    l.occupy(on(kMesh, 1), crosswise ? near : far, {{0, 5}});
    return l;
  };
  EXPECT_TRUE(made(1, 2, false).same_promises(made(1, 2, false)));
  EXPECT_FALSE(made(1, 2, false).same_promises(made(2, 1, false)));
  EXPECT_FALSE(made(1, 2, false).same_promises(made(1, 2, true)));
  // A flow of the same rate on another resource, and the reverse from another publisher.
  Ledger a = ledger();
  a.add(on(kWire, 0), 3);
  a.add(on(kBus, 1), 3);
  Ledger b = ledger();
  b.add(on(kBus, 0), 3);
  b.add(on(kWire, 1), 3);
  EXPECT_FALSE(a.same_promises(b));
  // The first publisher has the same, and the others have each other's.
  const auto exchanged = [](std::size_t second, std::size_t third) {
    Ledger l = ledger();
    for (const auto& [p, bytes] : {std::pair(std::size_t{0}, 1U), {second, 2U}, {third, 3U}})
      l.add(on(kWire, p), bytes);
    return l;
  };
  EXPECT_TRUE(exchanged(1, 2).same_promises(exchanged(1, 2)));
  EXPECT_FALSE(exchanged(1, 2).same_promises(exchanged(2, 1)));
  // A way over links that take no time is not none.
  const Ledger timeless = Held{.shares = {}}.made();
  EXPECT_FALSE(timeless.same_promises(Held{.over_mesh = false}.made()));
  EXPECT_FALSE(Held{.over_mesh = false}.made().same_promises(timeless));
  // Where it comes from is part of a flow.
  Ledger c = ledger();
  c.add(on(kWire, 0, kBus), 3);
  Ledger d = ledger();
  d.add(on(kWire, 0, kMesh), 3);
  EXPECT_FALSE(c.same_promises(d));
}

}  // namespace
}  // namespace mlcca::core::testing
