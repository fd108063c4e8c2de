// SPDX-License-Identifier: BSD-2-Clause
// What a gateway may hold of networks that it shares, and what it says of what it may not.
#include <gtest/gtest.h>

#include "core/model/text.hpp"
#include "tests/core/shared/gateways.hpp"

namespace mlcca::core::testing {
namespace {

TEST(PermitsTest, WhatIsDescribedNeedsNoReservation) {
  System system = networks(false);
  const std::size_t c = add_channel(system, every(50 * kMs));
  describe(system, c, every(50 * kMs));
  Pair pair(system);
  ASSERT_EQ(pair.baseline.standing(kShared).size(), 1U);
  EXPECT_TRUE(pair.baseline.standing(kOwn).empty()) << "one gateway has that bus";
  EXPECT_TRUE(granted(pair[0].state, c));
  EXPECT_TRUE(pair[0].state.wishes().empty());
  EXPECT_TRUE(cluster::footprint_of(pair[0].state, c, pair.baseline, 0).parts.empty());
}

TEST(PermitsTest, WhatIsAdmittedWaitsForTheStore) {
  System system = networks(false);
  const std::size_t c = add_channel(system, every(50 * kMs));
  Pair pair(system);
  const Admission a = both_ends(c, 1, every(50 * kMs));
  {
    const Proposal p = pair[0].state.propose(a);
    EXPECT_FALSE(p.fit());
    EXPECT_EQ(p.verdicts().front()->obstacle, Obstacle::cluster);
    EXPECT_EQ(reason(system, pair[0].state.members(), *p.verdicts().front()),
              "waits for the store: other gateways use shared too, and this is not reserved there");
  }
  const auto footprint = pair[0].ask(a);
  ASSERT_TRUE(footprint);
  ASSERT_EQ(footprint->parts.size(), 1U);
  EXPECT_EQ(footprint->parts[0].network, kShared);
  ASSERT_EQ(footprint->parts[0].bus.size(), 1U);
  EXPECT_EQ(footprint->parts[0].bus[0].first_id, 0x10U + c);
  EXPECT_EQ(footprint->parts[0].bus[0].source.admission, 1U);
  EXPECT_TRUE(footprint->gateways.empty()) << "it goes over no other gateway";
  EXPECT_TRUE(pair[0].admit(a));
  EXPECT_FALSE(pair[0].broken);
  pair[1].read();
  EXPECT_EQ(messages_on(pair[1].state, kShared), messages_on(pair[0].state, kShared));
  pair[0].release(1);
  pair[1].read();
  EXPECT_TRUE(messages_on(pair[1].state, kShared).empty());
  EXPECT_TRUE(messages_on(pair[0].state, kShared).empty());
}

TEST(PermitsTest, AnAdmissionOnOwnedNetworksAsksNobody) {
  System system = networks(false);
  const std::size_t c = add_channel(system, every(50 * kMs));
  Pair pair(system);
  Admission a = both_ends(c, 1, every(50 * kMs));
  a.subscriber->place = on(kOwn);
  const auto footprint = pair[0].ask(a);
  ASSERT_TRUE(footprint);
  EXPECT_TRUE(footprint->parts.empty());
  EXPECT_TRUE(pair[0].state.propose(a).fit());
}

TEST(PermitsTest, TheGatewaysOnTheWayAreNamed) {
  System system = networks(false);
  const std::size_t c = add_channel(system, every(50 * kMs));
  Pair pair(system);
  Admission a = both_ends(c, 1, every(50 * kMs));
  a.subscriber->place = on(kOwn + 1);
  const auto footprint = pair[0].ask(a);
  ASSERT_TRUE(footprint);
  EXPECT_EQ(footprint->gateways, std::vector<std::size_t>{1});
}

TEST(PermitsTest, ARefusalSaysWhoHasTakenTheBus) {
  System system = networks(false);
  const std::size_t first = add_channel(system, every(5 * kMs, 7 * kMs));
  const std::size_t second = add_channel(system, every(50 * kMs, 9 * kMs));
  Pair pair(system);
  admit_at_first(pair, second);
  Admission b = both_ends(first, 2, every(5 * kMs, 4 * kMs), 1);
  b.publisher->place = at(1);
  const Proposal wish = pair[1].state.wish(b);
  ASSERT_FALSE(wish.fit());
  const std::string text = reason(system, pair[1].state.members(), *wish.verdicts().front());
  EXPECT_NE(text.find("taken by gateway g0 on shared"), std::string::npos) << text;
}

TEST(PermitsTest, WhatIsWithdrawnHereIsCountedAllTheSame) {
  System system = networks(false);
  const std::size_t c = add_channel(system, every(50 * kMs));
  describe(system, c, every(50 * kMs));
  Pair pair(system);
  const auto before = messages_on(pair[0].state, kShared);
  pair[0].state.set_withdrawn(c, true);
  pair[0].state.settle();
  EXPECT_FALSE(granted(pair[0].state, c));
  EXPECT_EQ(messages_on(pair[0].state, kShared), before);
  pair[0].state.set_withdrawn(c, false);
  pair[0].state.settle();
  EXPECT_TRUE(granted(pair[0].state, c));
  EXPECT_EQ(messages_on(pair[0].state, kShared), before);
}

TEST(PermitsTest, KnowsOfWhichTrafficLessMayBeUsed) {
  System system = networks(false);
  Permits permits(system, 0);
  const auto ended = [&](std::uint64_t since) {
    std::vector<AdmissionId> all;
    const auto sources = permits.ended_since(kShared, since);
    if (!sources) return std::vector<AdmissionId>{0};
    for (const cluster::Source& source : *sources) all.push_back(source.admission);
    return all;
  };
  const auto put = [&](std::uint64_t number, AdmissionId admission) {
    cluster::Part part;
    part.network = kShared;
    part.rates.push_back({.bytes_per_second = 1, .source = {.admission = admission}});
    permits.put(number, {.parts = {part}, .gateways = {}});
  };
  const std::uint64_t before = permits.shrunk(kShared);
  put(1, 11);
  put(2, 12);
  EXPECT_EQ(permits.shrunk(kShared), before);
  EXPECT_TRUE(permits.has_reserved(kShared, 11));
  EXPECT_FALSE(permits.has_reserved(kOwn, 11));
  permits.erase(1);
  EXPECT_FALSE(permits.has_reserved(kShared, 11));
  EXPECT_TRUE(permits.has_reserved(kShared, 12));
  EXPECT_EQ(ended(before), std::vector<AdmissionId>{11});
  put(2, 13);  // in place of the other one
  EXPECT_EQ(ended(before), (std::vector<AdmissionId>{11, 12}));
  const std::uint64_t between = permits.shrunk(kShared);
  EXPECT_TRUE(ended(between).empty());
  permits.erase(2);
  EXPECT_EQ(ended(between), std::vector<AdmissionId>{13});
  permits.close(false);
  EXPECT_NE(permits.shrunk(kShared), between);
  EXPECT_EQ(ended(between), std::vector<AdmissionId>{0}) << "that may be anything";
  const std::uint64_t closed = permits.shrunk(kShared);
  for (std::uint64_t number = 1; number <= 3000; ++number) {
    put(number, number);
    permits.erase(number);
  }
  EXPECT_EQ(ended(closed), std::vector<AdmissionId>{0}) << "more than it remembers";
  EXPECT_EQ(ended(permits.shrunk(kShared) - 1), std::vector<AdmissionId>{3000});
}

/// Where one channel is given back, another one is not decided again.
TEST(PermitsTest, AChangeOfOneChannelDecidesNoOther) {
  System system = networks(false);
  std::vector<std::size_t> channels;
  for (int i = 0; i < 5; ++i) channels.push_back(add_channel(system, every(50 * kMs)));
  describe(system, channels[0], every(50 * kMs));
  Pair pair(system);
  State& state = pair[0].state;
  for (std::size_t i = 1; i < 4; ++i)
    ASSERT_TRUE(pair[0].admit(both_ends(channels[i], i, every(50 * kMs))));
  const Admission last = both_ends(channels[4], 4, every(50 * kMs));
  const auto footprint = pair[0].ask(last);
  ASSERT_TRUE(footprint);
  ASSERT_TRUE(pair[0].commit(4, *footprint));
  EXPECT_TRUE(state.settle().empty()) << "others count it";
  Proposal p = state.propose(last);
  ASSERT_TRUE(p.fit());
  std::move(p).accept();
  EXPECT_TRUE(state.settle().empty()) << "it is in force, and so is all else, as before";
  state.remove(4);
  const auto changes = state.settle();
  EXPECT_TRUE(changes.empty() || (changes.size() == 1 && changes[0].channel == channels[4]));
  pair[0].permits.erase(4);
  EXPECT_TRUE(state.settle().empty());
}

TEST(PermitsTest, WithoutTheStoreWhatIsReservedEndsAndWhatIsDescribedStays) {
  System system = networks(false);
  const std::size_t c = add_channel(system, every(50 * kMs));
  describe(system, c, every(50 * kMs));
  const std::size_t d = add_channel(system, every(50 * kMs));
  Pair pair(system);
  ASSERT_TRUE(pair[0].admit(both_ends(d, 1, every(50 * kMs))));
  const auto all = messages_on(pair[0].state, kShared);
  pair[0].permits.close(false);
  const auto changes = pair[0].state.settle();
  EXPECT_FALSE(changes.empty());
  EXPECT_TRUE(granted(pair[0].state, c));
  EXPECT_FALSE(granted(pair[0].state, d));
  EXPECT_EQ(messages_on(pair[0].state, kShared), all) << "others count it still";
  pair[0].permits.close(true);
  pair[0].state.settle();
  EXPECT_FALSE(granted(pair[0].state, c));
  pair[0].permits.open();
  pair[0].state.settle();
  EXPECT_TRUE(granted(pair[0].state, c));
  EXPECT_TRUE(granted(pair[0].state, d));
}

TEST(PermitsTest, WhatAnotherGatewayCouldTakeOverEndsToo) {
  System system = networks(false);
  const std::size_t c = add_channel(system, every(50 * kMs));
  system.publishers.push_back(publisher(c, on(kShared), every(50 * kMs)));
  system.subscribers.push_back(subscriber(c, on(kOwn + 1), every(50 * kMs)));
  Port port = system.gateways[1].ports.front();
  port.network = kOwn + 1;
  system.gateways[0].ports.push_back(port);  // both join the two buses
  Pair pair(system);
  ASSERT_TRUE(granted(pair[0].state, c));
  pair[0].permits.close(false);
  pair[0].state.settle();
  EXPECT_FALSE(granted(pair[0].state, c));
}

TEST(PermitsTest, AChannelThatTheDescriptionDoesNotSatisfyIsWished) {
  System system = networks(false);
  const std::size_t c = add_channel(system, every(50 * kMs));
  describe(system, c, every(50 * kMs));
  system.networks[kShared].bindings.front().dynamic = true;  // its tag is dealt at run time
  system.networks[kShared].bindings.front().id = 0;
  Pair pair(system);
  EXPECT_TRUE(pair.baseline.standing(kShared).empty());
  EXPECT_TRUE(pair[0].state.wishes().empty());
  for (std::size_t g = 0; g < kGateways; ++g) {
    State& state = pair[g].state;
    state.set_tag(kShared, c, 0x42);
    state.settle();
    ASSERT_EQ(state.wishes(), std::vector<std::size_t>{c});
    EXPECT_EQ(state.decisions()[c].verdicts.front().obstacle, Obstacle::cluster) << why(state, c);
    cluster::Footprint footprint;
    {
      const Proposal wish = state.wish(c);
      ASSERT_TRUE(wish.fit());
      footprint = cluster::footprint_of(wish, pair.baseline, g);
    }
    pair[g].read();
    ASSERT_TRUE(pair[g].commit(7 + g, footprint));
    state.settle();
    EXPECT_TRUE(granted(state, c));
    EXPECT_TRUE(state.wishes().empty());
    EXPECT_FALSE(state.wish(c).fit()) << "it has all that it could have";
  }
  // Both have reserved the same frames of one publisher: they are on the bus once.
  pair[0].read();
  EXPECT_EQ(messages_on(pair[0].state, kShared).size(), 1U);
  EXPECT_EQ(messages_on(pair[1].state, kShared).size(), 1U);
  // The other one's reservation is no permit.
  pair[0].erase(7);
  EXPECT_FALSE(granted(pair[0].state, c));
  EXPECT_EQ(messages_on(pair[0].state, kShared).size(), 1U);
  EXPECT_EQ(pair[0].state.wishes(), std::vector<std::size_t>{c});
}

TEST(PermitsTest, WhatAnotherHasReservedOfTheSamePublisherCountsInFull) {
  System system = networks(false);
  const std::size_t c = add_channel(system, every(50 * kMs));
  describe(system, c, every(50 * kMs));
  Pair pair(system);
  const cluster::Standing& standing = pair.baseline.standing(kShared).front();
  cluster::BusPart part;
  part.message = *standing.message;
  part.source = {.publisher = standing.flow.publisher, .from = standing.flow.from};
  part.message.period /= 2;
  cluster::Foreign foreign;
  foreign.bus.push_back(part);
  State& state = pair[0].state;
  state.set_foreign(kShared, foreign);
  state.settle();
  ASSERT_EQ(messages_on(state, kShared).size(), 1U);
  EXPECT_EQ(messages_on(state, kShared).front().period, part.message.period);
  EXPECT_TRUE(granted(state, c)) << "ours is what the description promises, as before";
  EXPECT_TRUE(cluster::footprint_of(state, c, pair.baseline, 0).parts.empty());
  state.set_foreign(kShared, {});
  state.settle();
  EXPECT_TRUE(granted(state, c));
  EXPECT_EQ(messages_on(state, kShared).front().period, standing.message->period);
}

TEST(PermitsTest, AForeignMessageThatIsLateClosesNothingOfOurs) {
  System system = networks(false);
  const std::size_t c = add_channel(system, every(50 * kMs));
  describe(system, c, every(50 * kMs));
  const std::size_t d = add_channel(system, every(50 * kMs));
  Pair pair(system);
  cluster::Footprint footprint = *pair[1].ask(both_ends(d, 1, every(50 * kMs), 1));
  cluster::Foreign foreign;
  footprint.parts[0].bus[0].message.deadline = 1;  // nobody could keep that
  cluster::add(foreign, footprint.parts[0], 1);
  State& state = pair[0].state;
  state.set_foreign(kShared, foreign);
  state.settle();
  EXPECT_TRUE(granted(state, c));
  EXPECT_TRUE(state.ledger().schedule(kShared)->late().empty());
  EXPECT_EQ(state.ledger().schedule(kShared)->messages().size(), 2U);
  const Proposal wish = state.wish(both_ends(d, 2, every(50 * kMs)));
  EXPECT_FALSE(wish.fit());
  EXPECT_EQ(wish.verdicts().front()->obstacle, Obstacle::crowded);
}

TEST(PermitsTest, NothingIsReservedWhereItIsNotKnownWhatOthersHold) {
  System system = networks(false);
  const std::size_t c = add_channel(system, every(50 * kMs));
  describe(system, c, every(50 * kMs));
  const std::size_t d = add_channel(system, every(50 * kMs));
  Pair pair(system);
  State& state = pair[0].state;
  const auto obstacle = [&] {
    const Proposal wish = state.wish(both_ends(d, 2, every(50 * kMs)));
    return wish.verdicts().front()->obstacle;
  };
  EXPECT_EQ(obstacle(), Obstacle::none);
  cluster::Foreign foreign;
  foreign.unreadable = true;
  state.set_foreign(kShared, foreign);
  state.settle();
  EXPECT_EQ(obstacle(), Obstacle::others_unknown);
  EXPECT_TRUE(granted(state, c)) << "what is described goes on";
  foreign = {};
  foreign.bus.emplace_back().source.admission = 1;  // no frame has these numbers
  state.set_foreign(kShared, foreign);
  state.settle();
  EXPECT_EQ(obstacle(), Obstacle::others_unknown);
  foreign = {};
  foreign.rates.push_back({.bytes_per_second = kUnbounded, .source = {.publisher = 1'000'000}});
  state.set_foreign(kShared, foreign);
  state.settle();
  EXPECT_EQ(obstacle(), Obstacle::others_unknown);
  state.set_foreign(kShared, {});
  state.settle();
  EXPECT_EQ(obstacle(), Obstacle::none);
}

TEST(PermitsTest, ABusWithoutABitRateCannotBeShared) {
  System system = networks(false);
  system.networks[kShared].bus.bitrate = 0;
  system.networks[kShared]
      .provision.set(Attribute::latency, kMs)
      .set(Attribute::jitter, kMs)
      .set(Attribute::period, kMs);
  const std::size_t c = add_channel(system, every(50 * kMs));
  Pair pair(system);
  const Proposal wish = pair[0].state.wish(both_ends(c, 1, every(50 * kMs)));
  EXPECT_FALSE(wish.fit());
  EXPECT_EQ(reason(system, pair[0].state.members(), *wish.verdicts().front()),
            "it is not known what other gateways hold of shared: the description states no bit "
            "rate of it");
}

TEST(PermitsTest, IdentifiersThatOthersHaveAreTaken) {
  System system = networks(false);
  add_channel(system, every(50 * kMs));
  Pair pair(system);
  const auto unlisted = [](Subject subject, std::uint32_t id) {
    UnlistedChannel wanted;
    wanted.subject = subject;
    wanted.bindings = {{.network = kShared, .id = id}, {.network = kOwn, .id = id}};
    return wanted;
  };
  const auto listed = pair[0].state.list(unlisted(0x1000, 0x300));
  ASSERT_TRUE(listed);
  ASSERT_TRUE(pair[0].admit(both_ends(*listed, 1, every(50 * kMs))));
  State& other = pair[1].state;
  pair[1].read();
  EXPECT_EQ(
      other.list(unlisted(0x2000, 0x300)).error().text,
      "identifier 0x300 on shared is taken by gateway g0 for channel 0x0000000000001000: choose "
      "another");
  EXPECT_EQ(other.list(unlisted(0x1000, 0x301)).error().text,
            "channel 0x0000000000001000 is admitted on shared with another identifier, by gateway "
            "g0");
  EXPECT_TRUE(other.list(unlisted(0x1000, 0x300)));
  EXPECT_TRUE(other.list(unlisted(0x2000, 0x301)));
}

TEST(PermitsTest, APathThatIsNotKnownHereStopsWishesOnly) {
  System system = networks(true);
  const std::size_t c = add_channel(system, every(50 * kMs));
  Pair pair(system);
  State& state = pair[0].state;
  cluster::Foreign foreign;
  foreign.paths.push_back({.from = 0,
                           .to = 1,
                           .bytes_per_second = 100,
                           .event_bytes = 8,
                           .source = {.publisher = 0, .admission = 4},
                           .gateway = 1});
  state.set_foreign(kAir, foreign);
  state.settle();
  EXPECT_GT(state.ledger().medium_time(kAir, 0), 0U);
  mesh::Graph other_way = state.world().meshes[kAir]->graph;
  std::erase_if(other_way.links, [](const mesh::Link& link) { return link.from == 0; });
  state.set_graph(kAir, other_way);
  state.settle();
  Admission a = both_ends(c, 1, every(50 * kMs));
  a.subscriber->place = on(kAir);
  const Proposal wish = state.wish(a);
  EXPECT_FALSE(wish.fit());
  EXPECT_EQ(wish.verdicts().front()->obstacle, Obstacle::others_unknown);
}

/// By two reservations of one gateway, of which the first one is of less.
TEST(PermitsTest, APathThatIsReservedTwiceCountsOnceAndInFull) {
  System system = networks(true);
  add_channel(system, every(50 * kMs));
  Pair pair(system);
  State& state = pair[0].state;
  const auto time_of = [&](const std::vector<std::pair<Value, Value>>& parts) {
    cluster::Foreign foreign;
    for (const auto& [bytes, event] : parts)
      foreign.paths.push_back({.from = 0,
                               .to = 1,
                               .bytes_per_second = bytes,
                               .event_bytes = event,
                               .source = {.publisher = 0, .admission = 4},
                               .gateway = 1});
    state.set_foreign(kAir, foreign);
    state.settle();
    return state.ledger().medium_time(kAir, 0);
  };
  EXPECT_EQ(time_of({{100, 8}, {200, 8}}), time_of({{200, 8}}));
  EXPECT_EQ(time_of({{200, 8}, {100, 8}}), time_of({{200, 8}}));
  EXPECT_EQ(time_of({{200, 0}, {100, 8}}), time_of({{200, 8}})) << "smaller events take more";
}

TEST(PermitsTest, WhatGotWorseIsGivenUpAndComesBack) {
  System system = networks(false);
  const auto fast = every(12 * kMs, 60 * kMs);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t c = add_channel(system, fast);
    system.channels[c].priority = 1;
    system.channels[c].lower = {{0, every(200 * kMs, 300 * kMs), {}}};
    describe(system, c, fast, i % 2);
    system.publishers.back().lower = system.channels[c].lower;
    system.subscribers.back().lower = system.channels[c].lower;
  }
  Pair pair(system);
  State& state = pair[0].state;
  const auto service = [&] {
    std::string all;
    for (const Decision& d : state.decisions())
      all += std::to_string(d.granted) + "/" + std::to_string(d.set) + " ";
    return all;
  };
  const std::string before = service();
  ASSERT_NE(before.find("1/0"), std::string::npos);
  const auto messages = messages_on(state, kShared);
  for (const std::uint32_t load : {500'000U, 0U, 800'000U, 0U}) {
    Condition condition;
    condition.background = load;
    state.set_condition(kShared, condition);
    state.settle();
    EXPECT_TRUE(state.ledger().schedule(kShared)->late().empty());
    if (load != 0) {
      EXPECT_NE(service(), before);
    } else {
      EXPECT_EQ(service(), before);
      EXPECT_EQ(messages_on(state, kShared), messages);
    }
  }
}

TEST(PermitsTest, WithoutPermitsOneGatewayDecidesAloneAgain) {
  System system = networks(false);
  const std::size_t c = add_channel(system, every(50 * kMs));
  describe(system, c, every(50 * kMs));
  const std::size_t d = add_channel(system, every(50 * kMs));
  Pair pair(system);
  State& state = pair[0].state;
  state.set_permits(nullptr);
  state.settle();
  EXPECT_TRUE(state.propose(both_ends(d, 1, every(50 * kMs))).fit());
  state.set_withdrawn(c, true);
  state.settle();
  EXPECT_TRUE(state.ledger().schedule(kShared)->messages().empty());
  EXPECT_FALSE(state.ledger().has_others(kShared));
  const State plain(system);
  EXPECT_FALSE(plain.ledger().has_others(kShared));
}

}  // namespace
}  // namespace mlcca::core::testing
