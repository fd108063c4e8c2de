// SPDX-License-Identifier: BSD-2-Clause
// What a ledger counts beside what is held, and takes back exactly.
#include <gtest/gtest.h>

#include <random>

#include "core/admission/world.hpp"
#include "core/can/cover.hpp"
#include "core/reserve/ledger.hpp"

namespace mlcca::core::testing {
namespace {

constexpr can::Time kMillisecond = 1'000'000;
constexpr std::size_t kBus = 0;
constexpr std::size_t kMesh = 1;

can::Assumptions bus_500() {
  can::Assumptions bus;
  bus.timing.bitrate = 500'000;
  return bus;
}

Ledger two_networks() {
  System system;
  system.networks.resize(2);
  system.publishers.resize(20);
  Ledger ledger(system);
  ledger.set_bus(kBus, bus_500());
  ledger.set_domains(kMesh, 2);
  return ledger;
}

can::Message frame(std::uint32_t priority, can::Time deadline = 10 * kMillisecond,
                   can::Time time = kMillisecond) {
  can::Message m;
  m.priority = priority;
  m.transmission = m.longest_frame = m.last_frame = time;
  m.period = 10 * kMillisecond;
  m.deadline = deadline;
  return m;
}

can::Message of_other(can::Message m, std::size_t gateway = 3) {
  m.key = Ledger::key_of_other(gateway);
  return m;
}

Flow flow(std::size_t publisher, std::size_t resource = kBus) { return {publisher, resource}; }

Placeholder promised(std::size_t publisher, can::Message m, Value bytes = 100) {
  Placeholder p;
  p.flow = flow(publisher);
  p.bytes_per_second = bytes;
  p.message = m;
  return p;
}

TEST(OthersTest, AKeyNamesTheGateway) {
  EXPECT_TRUE(Ledger::is_of_other(Ledger::key_of_other(7)));
  EXPECT_EQ(Ledger::gateway_of(Ledger::key_of_other(7) | 12345), 7U);
  EXPECT_FALSE(Ledger::is_of_other(Ledger::key_of({1U << 20U, 3, Flow::kOwn})));
}

TEST(OthersTest, HoweverManyClaimHoweverMuchTheirSumDoesNotOverflow) {
  System system;
  system.networks.resize(1);
  World world;
  world.conditions.resize(1);
  world.foreign.resize(1);
  std::vector<cluster::RatePart>& rates = world.foreign[kBus].rates;
  rates.resize((std::size_t{1} << 20U) + 1);
  for (std::size_t i = 0; i < rates.size(); ++i) {
    rates[i].source.admission = i + 1;
    rates[i].bytes_per_second = kUnbounded;
  }
  const Others others = others_on(system, world, kBus, nullptr);
  EXPECT_GE(others.bytes_per_second, Value{1} << 62U);
  EXPECT_LE(others.bytes_per_second, kUnbounded / 2) << "there is room for what is held here";
}

TEST(OthersTest, WhatIsPromisedCountsWhetherOrNotItIsHeld) {
  Ledger l = two_networks();
  Others others;
  others.standing = {promised(1, frame(5))};
  EXPECT_TRUE(l.set_others(kBus, others).fits);
  EXPECT_EQ(l.reserved(kBus), 100U);
  EXPECT_EQ(l.reserved_without(flow(1)), 0U);
  EXPECT_TRUE(l.schedule(kBus)->contains(Ledger::key_of(flow(1))));
  EXPECT_FALSE(l.carries(flow(1)));

  l.add(flow(1), 40);
  EXPECT_EQ(l.reserved(kBus), 100U) << "others count all of it";
  EXPECT_FALSE(l.schedule(kBus)->contains(Ledger::key_of(flow(1))));
  can::Message slower = frame(5);
  slower.period *= 4;
  ASSERT_FALSE(l.schedule(flow(1), slower));
  EXPECT_EQ(l.schedule(kBus)->find(Ledger::key_of(flow(1)))->period, frame(5).period);
  EXPECT_EQ(l.message_of(flow(1))->period, slower.period) << "as it was asked for";
  l.remove(1);
  EXPECT_EQ(l.reserved(kBus), 100U);
  EXPECT_EQ(l.schedule(kBus)->find(Ledger::key_of(flow(1)))->priority, 5U);

  l.forget_placeholders(1);
  EXPECT_EQ(l.reserved(kBus), 0U);
  EXPECT_TRUE(l.schedule(kBus)->messages().empty());
}

/// A flow that is held as it is promised, and of which that becomes known only now: what it holds
/// counts in full, and nothing else has to be decided again.
TEST(OthersTest, APromiseOfWhatIsHeldAlreadyChangesNothing) {
  Ledger l = two_networks();
  l.add(flow(1), 100);
  ASSERT_FALSE(l.schedule(flow(1), frame(5)));
  Others others;
  others.standing = {promised(1, frame(5))};
  const Ledger::Change change = l.set_others(kBus, others);
  EXPECT_TRUE(change.fits);
  EXPECT_TRUE(change.held);
  EXPECT_TRUE(l.counts_all(kBus));
  EXPECT_EQ(l.reserved(kBus), 100U);
  EXPECT_EQ(l.schedule(kBus)->messages().size(), 1U);
  const Ledger::Change again = l.set_others(kBus, others);
  EXPECT_TRUE(again.fits);
  EXPECT_FALSE(again.held) << "it is known";
  l.remove(1);
  EXPECT_EQ(l.reserved(kBus), 100U) << "the promise stays";
}

/// Others count more of it than is held.
TEST(OthersTest, APromiseOfMoreThanIsHeldIsDecidedAgain) {
  const auto fits = [](Value bytes, const can::Message& message) {
    Ledger l = two_networks();
    l.add(flow(1), 100);
    EXPECT_FALSE(l.schedule(flow(1), frame(5)));
    Others others;
    others.standing = {promised(1, message, bytes)};
    return l.set_others(kBus, others).fits;
  };
  EXPECT_TRUE(fits(100, frame(5)));
  EXPECT_FALSE(fits(101, frame(5)));
  EXPECT_FALSE(fits(100, frame(4)));
  EXPECT_FALSE(fits(100, frame(5, 9 * kMillisecond)));
}

/// What counts then depends on the order.
TEST(OthersTest, APromiseIsDecidedAgainWhereNotAllThatIsPromisedCounts) {
  Ledger l = two_networks();
  Others others;
  others.most_bytes = 250;
  others.standing = {promised(1, frame(5)), promised(2, frame(6)), promised(3, frame(7))};
  l.set_others(kBus, others);
  EXPECT_FALSE(l.counts_all(kBus)) << "there is room for two of them";
  l.add(flow(4), 1);
  ASSERT_FALSE(l.schedule(flow(4), frame(8)));
  others.standing.push_back(promised(4, frame(8), 1));
  EXPECT_FALSE(l.set_others(kBus, others).fits);
}

TEST(OthersTest, WhatAnotherHasReservedOfTheSameFlowCountsInFullWhereItIsGivenUp) {
  Ledger l = two_networks();
  Others others;
  others.standing = {promised(1, frame(5))};
  others.standing[0].by_others = true;
  l.set_others(kBus, others);
  l.relax(1);
  l.add(flow(1), 40);
  can::Message slower = frame(5);
  slower.period *= 4;
  ASSERT_FALSE(l.schedule(flow(1), slower));
  EXPECT_EQ(l.reserved(kBus), 100U);
  EXPECT_EQ(l.schedule(kBus)->find(Ledger::key_of(flow(1)))->period, frame(5).period);
}

TEST(OthersTest, AWishFindsEverythingAsItIsPromised) {
  Ledger l = two_networks();
  Others others;
  others.standing = {promised(1, frame(5))};
  l.set_others(kBus, others);
  l.relax(1);
  l.add(flow(1), 40);
  can::Message slower = frame(5);
  slower.period *= 4;
  ASSERT_FALSE(l.schedule(flow(1), slower));
  l.commit();
  const can::Schedule before = *l.schedule(kBus);
  const Ledger::Mark mark = l.mark();
  EXPECT_TRUE(l.raise(kBus));
  EXPECT_EQ(l.reserved(kBus), 100U);
  EXPECT_EQ(l.schedule(kBus)->find(Ledger::key_of(flow(1)))->period, frame(5).period);
  l.roll_back(mark);
  EXPECT_EQ(l.reserved(kBus), 40U);
  EXPECT_EQ(*l.schedule(kBus), before);
}

TEST(OthersTest, NothingIsWishedWhereWhatIsPromisedDoesNotFit) {
  Ledger l = two_networks();
  Others others;
  others.most_bytes = 150;
  others.standing = {promised(1, frame(5)), promised(2, frame(6))};
  EXPECT_FALSE(l.set_others(kBus, others).fits);
  const Ledger::Mark mark = l.mark();
  EXPECT_FALSE(l.raise(kBus));
  l.roll_back(mark);
  l.commit();
  others.most_bytes = 250;
  l.set_others(kBus, others);
  l.place_rest();
  EXPECT_EQ(l.reserved(kBus), 200U);
  static_cast<void>(l.mark());
  EXPECT_TRUE(l.raise(kBus));
}

TEST(OthersTest, WhatOthersSendIsInTheResponses) {
  Ledger l = two_networks();
  Ledger alone = two_networks();
  Others others;
  others.messages = {of_other(frame(1)), of_other(frame(9), 4)};
  EXPECT_TRUE(l.set_others(kBus, others).fits);
  l.add(flow(1), 1);
  ASSERT_FALSE(l.schedule(flow(1), frame(5)));
  for (const std::size_t p : {2U, 3U}) alone.add(flow(p), 0);
  alone.add(flow(1), 1);
  ASSERT_FALSE(alone.schedule(flow(2), frame(1)));
  ASSERT_FALSE(alone.schedule(flow(3), frame(9)));
  ASSERT_FALSE(alone.schedule(flow(1), frame(5)));
  const std::uint64_t key = Ledger::key_of(flow(1));
  EXPECT_EQ(l.schedule(kBus)->response(key), alone.schedule(kBus)->response(key));
  EXPECT_EQ(l.schedule(kBus)->utilisation_ppm(), alone.schedule(kBus)->utilisation_ppm());

  // One that is as it was stays; only the other one goes.
  others.messages = {of_other(frame(9), 4)};
  const Ledger::Change change = l.set_others(kBus, others);
  EXPECT_TRUE(change.fits);
  EXPECT_TRUE(change.relieved);
  EXPECT_EQ(l.schedule(kBus)->messages().size(), 2U);
}

TEST(OthersTest, WhatWouldMakeOursLateIsNotTakenInBesideIt) {
  Ledger l = two_networks();
  l.add(flow(1), 1);
  ASSERT_FALSE(l.schedule(flow(1), frame(5, 3 * kMillisecond)));
  Others others;
  others.messages = {of_other(frame(1)), of_other(frame(2)), of_other(frame(3))};
  EXPECT_FALSE(l.set_others(kBus, others).fits);
  EXPECT_TRUE(l.schedule(kBus)->late().empty());
}

TEST(OthersTest, AMessageOfOthersThatIsLateByItselfDisturbsNoOneElse) {
  Ledger l = two_networks();
  Others others;
  others.messages = {of_other(frame(1)), of_other(frame(9, 1000))};
  l.rebuild_others(kBus, others);
  EXPECT_TRUE(l.schedule(kBus)->spares_any());
  EXPECT_TRUE(l.schedule(kBus)->late().empty());
  ASSERT_EQ(l.schedule(kBus)->spared().size(), 1U);
  l.add(flow(1), 1);
  EXPECT_FALSE(l.schedule(flow(1), frame(5))) << "ours is in time";
  l.commit();
  static_cast<void>(l.mark());
  EXPECT_FALSE(l.raise(kBus)) << "nothing new is promised beside it";
}

TEST(OthersTest, ASparedMessageThatIsInTimeAgainIsKept) {
  can::Schedule bus(bus_500());
  can::Message first = frame(1);
  first.key = 1;
  can::Message second = frame(2, 3 * kMillisecond / 2);
  second.key = 2;
  bus.put(std::vector<can::Message>{first, second});
  ASSERT_TRUE(bus.spares_any());
  EXPECT_EQ(bus.spared().front().key, 2U);
  bus.remove(1);
  bus.review();
  EXPECT_FALSE(bus.spares_any());
  EXPECT_TRUE(bus.add(first)) << "it would make the other one late";
}

TEST(OthersTest, NothingIsAddedBesideAMessageThatCannotBeAnalysed) {
  can::Schedule bus(bus_500());
  can::Message bad = frame(1);
  bad.key = 1;
  bad.period = 0;
  bus.put(std::vector<can::Message>{bad});
  can::Message good = frame(2);
  good.key = 2;
  EXPECT_TRUE(bus.add(good));
  bus.remove(1);
  EXPECT_FALSE(bus.add(good));
}

TEST(OthersTest, SharesOfAMeshAreWithinItsLimit) {
  Ledger l = two_networks();
  Others others;
  others.most_time = 100;
  others.shares = {{0, 60}};
  Placeholder p;
  p.flow = flow(1, kMesh);
  p.shares = {{0, 30}, {1, 30}};
  Placeholder more = p;
  more.flow = flow(2, kMesh);
  others.standing = {p, more};
  EXPECT_FALSE(l.set_others(kMesh, others).fits);
  EXPECT_EQ(l.medium_time(kMesh, 0), 90U);
  EXPECT_EQ(l.medium_time(kMesh, 1), 30U);
  others.shares = {};
  EXPECT_TRUE(l.set_others(kMesh, others).relieved);
  l.place_rest();
  EXPECT_EQ(l.medium_time(kMesh, 0), 60U);
  EXPECT_EQ(l.medium_time(kMesh, 1), 60U);
  l.add(flow(1, kMesh), 1);
  EXPECT_EQ(l.medium_time(kMesh, 0), 30U) << "held, and not on any link yet";
  l.set_domains(kMesh, 1);
  EXPECT_FALSE(l.has_others(kMesh));
}

/// Every other gateway counts a promise in full, however busy the medium is. If this one did not,
/// two gateways could each keep what is theirs.
TEST(OthersTest, WhatDoesNotFitBesideWhatIsMeasuredCountsAllTheSame) {
  Ledger l = two_networks();
  Others others;
  others.most_time = 100;
  others.busy = {50};
  others.shares = {{0, 50}, {1, 90}};
  EXPECT_TRUE(l.set_others(kMesh, others).fits);
  Placeholder p;
  p.flow = flow(1, kMesh);
  p.shares = {{0, 30}};
  others.standing = {p};
  EXPECT_FALSE(l.set_others(kMesh, others).fits);
  EXPECT_EQ(l.medium_time(kMesh, 0), 80U);
  EXPECT_TRUE(l.set_others(kMesh, others).fits) << "nothing is more than it was";
  others.standing = {};
  others.shares = {{0, 51}};
  const Ledger::Change change = l.set_others(kMesh, others);
  EXPECT_TRUE(change.relieved);
  EXPECT_TRUE(change.fits) << "it is less than it was";
  others.shares = {{0, 52}};
  EXPECT_FALSE(l.set_others(kMesh, others).fits);
}

TEST(OthersTest, ARollBackIsExactWhateverHappened) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    std::mt19937_64 random(seed);
    const auto below = [&](std::size_t n) { return random() % n; };
    Ledger l = two_networks();
    Others others;
    for (std::size_t p = 0; p < 10; ++p)
      if (below(2) == 0)
        others.standing.push_back(
            promised(p, frame(static_cast<std::uint32_t>(below(30)), (5 + below(20)) * kMillisecond,
                              kMillisecond / (2 + below(4)))));
    for (std::size_t g = 0; g < below(4); ++g)
      others.messages.push_back(of_other(frame(static_cast<std::uint32_t>(below(30))), g));
    others.bytes_per_second = below(50);
    others.most_bytes = 1500;
    l.rebuild_others(kBus, others);
    const auto change = [&] {
      const std::size_t p = below(12);
      if (below(3) == 0) {
        l.remove(p);
      } else if (l.add(flow(p), below(200))) {
        static_cast<void>(l.schedule(
            flow(p), frame(static_cast<std::uint32_t>(below(30)), (5 + below(20)) * kMillisecond,
                           kMillisecond / (2 + below(4)))));
      }
    };
    for (int i = 0; i < 10; ++i) change();
    l.commit();
    const can::Schedule before = *l.schedule(kBus);
    const Value reserved = l.reserved(kBus);
    std::vector<std::size_t> held;
    for (std::size_t p = 0; p < 12; ++p) held.push_back(l.holdings_of(p).size());
    const Ledger::Mark mark = l.mark();
    if (below(2) == 0) static_cast<void>(l.raise(kBus));
    for (int i = 0; i < 10; ++i) {
      const Ledger::Mark inner = l.mark();
      change();
      if (below(3) == 0) l.roll_back(inner);
    }
    l.roll_back(mark);
    EXPECT_EQ(*l.schedule(kBus), before) << seed;
    EXPECT_EQ(l.reserved(kBus), reserved) << seed;
    for (std::size_t p = 0; p < 12; ++p) EXPECT_EQ(l.holdings_of(p).size(), held[p]);
    // The placeholders count as they did: without what is held all of them are there.
    l.commit();
    for (std::size_t p = 0; p < 12; ++p) l.remove(p);
    l.rebuild_others(kBus, others);
    Value sum = others.bytes_per_second;
    for (const Placeholder& p : others.standing) sum += p.bytes_per_second;
    EXPECT_EQ(l.reserved(kBus), sum) << seed;
  }
}

TEST(CoverTest, WhoeverDisturbsMoreOrIsToBeThereSoonerIsNotCovered) {
  can::Message m = frame(5);
  m.jitter = kMillisecond;
  EXPECT_TRUE(can::covers(m, m));
  const auto changed = [&m](auto change) {
    can::Message other = m;
    change(other);
    return other;
  };
  const std::vector<can::Message> worse{
      changed([](auto& o) { --o.deadline; }),      changed([](auto& o) { --o.period; }),
      changed([](auto& o) { ++o.jitter; }),        changed([](auto& o) { ++o.transmission; }),
      changed([](auto& o) { ++o.longest_frame; }), changed([](auto& o) { --o.last_frame; }),
      changed([](auto& o) { --o.priority; }),      changed([](auto& o) { o.lowest_priority = 9; }),
      changed([](auto& o) { ++o.pauses; }),        changed([](auto& o) { o.queue = 1; }),
      changed([](auto& o) { o.frames = 2; }),      changed([](auto& o) { o.sender = 1; }),
      changed([](auto& o) { o.least_pause = 1; })};
  for (const can::Message& other : worse) EXPECT_FALSE(can::covers(m, other));
  can::Message less = m;
  ++less.deadline;
  ++less.period;
  --less.transmission;
  EXPECT_TRUE(can::covers(m, less));
  less.deadline = can::kNever;
  EXPECT_TRUE(can::covers(m, less));
  EXPECT_FALSE(can::covers(less, m));
}

TEST(CoverTest, TheStrictestOfTwoCoversBoth) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937_64 random(seed);
    const auto draw = [&] {
      can::Message m = frame(static_cast<std::uint32_t>(random() % 4),
                             (1 + random() % 20) * kMillisecond, (1 + random() % 3) * 500'000);
      m.period = (1 + random() % 5) * kMillisecond;
      m.jitter = random() % 2 * kMillisecond;
      m.last_frame = m.transmission / (1 + random() % 2);
      m.deadline += m.jitter;
      return m;
    };
    const can::Message a = draw();
    const can::Message b = draw();
    const can::Message both = can::strictest(a, b);
    EXPECT_TRUE(can::covers(both, a));
    EXPECT_TRUE(can::covers(both, b));
    EXPECT_EQ(can::covers(a, b), can::covers(a, both)) << "whoever covers b and a itself";
  }
}

}  // namespace
}  // namespace mlcca::core::testing
