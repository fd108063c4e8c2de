// SPDX-License-Identifier: BSD-2-Clause
// Refusals for want of room on a shared network name the gateways that hold it.
#include "core/admission/holders.hpp"

#include <gtest/gtest.h>

#include <map>
#include <span>
#include <string>
#include <utility>

#include "tests/core/shared/gateways.hpp"

namespace mlcca::core::testing {
namespace {

/// What gateways with these numbers hold, whether or not they are in the description.
class Stated final : public Holdings {
 public:
  cluster::Foreign of_others(std::size_t network) const override {
    return network == there ? held : cluster::Foreign{};
  }
  std::map<std::size_t, MadeFor> made_for(std::size_t network) const override {
    return network == there ? for_others : std::map<std::size_t, MadeFor>{};
  }
  std::string unreadable(std::size_t network) const override {
    return network == there ? strange : std::string();
  }
  [[nodiscard]] std::string objection(std::size_t /*channel*/,
                                      std::span<const std::size_t> /*gateways*/) const override {
    return {};
  }
  void add_rate(std::size_t gateway, Value bytes, AdmissionId admission = 1) {
    held.rates.push_back(
        {.bytes_per_second = bytes, .source = {.admission = admission}, .gateway = gateway});
  }

  std::size_t there = kWire;
  cluster::Foreign held;
  std::map<std::size_t, MadeFor> for_others;
  std::string strange;
};

/// The networks of two gateways, with four more that have nothing of their own.
System six_gateways() {
  System system = networks(true);
  for (std::size_t g = kGateways; g < 6; ++g) {
    Gateway gateway = system.gateways[1];
    gateway.name = "g" + std::to_string(g);
    std::erase_if(gateway.ports, [](const Port& port) { return port.network == kOwn + 1; });
    system.gateways.push_back(gateway);
  }
  return system;
}

std::string refusal(State& state, const Admission& admission) {
  const Proposal wish = state.wish(admission);
  EXPECT_FALSE(wish.fit());
  const Verdict& v = *wish.verdicts().front();
  return reason(state.system(), state.members(), v) + state.held_by_others().of_refusal(v);
}

/// The first gateway with what the others hold.
struct One {
  explicit One(const System& system) : baseline(system), peer(system, baseline, 0, store) {
    peer.state.held_by_others().set_source(&stated);
  }
  void read(std::size_t network) {
    stated.there = network;
    peer.state.set_foreign(network, stated.held);
    static_cast<void>(peer.state.settle());
  }

  cluster::Baseline baseline;
  Store store;
  Stated stated;
  Peer peer;
};

TEST(HoldersTest, WhoHoldsItForOthersIsNamedWithThem) {
  System system = six_gateways();
  const std::size_t c = add_channel(system, every(50 * kMs));
  One one(system);
  for (const auto& [gateway, bytes] :
       {std::pair<std::size_t, Value>{1, 1'900}, {2, 1'100}, {3, 950}})
    one.stated.add_rate(gateway, bytes);
  one.stated.for_others = {{1, {.gateways = {0}, .all = true}},
                           {2, {.gateways = {0, 1, 3, 4, 5}, .all = false}}};
  one.read(kWire);
  Admission a = both_ends(c, 7, every(50 * kMs));
  a.publisher->place = at(0);
  a.subscriber->place = on(kWire);
  const std::string text = refusal(one.peer.state, a);
  EXPECT_NE(text.find("; reserved there by g1 (1.9 kB/s, for g0), g2 (1.1 kB/s, in part for g0 and "
                      "g1 and g3 and 2 more) and g3 (950 B/s)"),
            std::string::npos)
      << text;
}

TEST(HoldersTest, ARefusalForWantOfCapacityNamesTheThreeWithTheMost) {
  System system = six_gateways();
  const std::size_t c = add_channel(system, every(50 * kMs));
  One one(system);
  for (const auto& [gateway, bytes] :
       {std::pair<std::size_t, Value>{1, 400}, {2, 1'900}, {3, 50}, {4, 1'000}, {5, 600}})
    one.stated.add_rate(gateway, bytes);
  one.stated.add_rate(1, 300);  // a part of the same traffic
  one.read(kWire);
  Admission a = both_ends(c, 7, every(50 * kMs));
  a.publisher->place = at(0);
  a.subscriber->place = on(kWire);
  EXPECT_EQ(refusal(one.peer.state, a),
            "160 B/s needed on wire, 50 B/s left (3.95 kB/s promised to others); reserved there by "
            "g2 (1.9 kB/s), g4 (1 kB/s), g5 (600 B/s) and 2 more gateways");
  one.stated.held = {};
  one.stated.add_rate(3, 3'900);
  one.read(kWire);
  EXPECT_TRUE(refusal(one.peer.state, a).ends_with("; reserved there by g3 (3.9 kB/s)"));
}

TEST(HoldersTest, ARefusalForTheScheduleOfABusNamesMessagesAndTime) {
  System system = networks(false);
  const std::size_t first = add_channel(system, every(5 * kMs, 7 * kMs));
  const std::size_t second = add_channel(system, every(50 * kMs, 9 * kMs));
  Pair pair(system);
  admit_at_first(pair, second);
  Stated stated;
  stated.there = kShared;
  stated.held = pair.store.without(1, kShared);
  pair[1].state.held_by_others().set_source(&stated);
  Admission b = both_ends(first, 2, every(5 * kMs, 4 * kMs), 1);
  b.publisher->place = at(1);
  const std::string text = refusal(pair[1].state, b);
  EXPECT_TRUE(text.ends_with("; reserved there by g0 (1 message, 21.6 % of the time)")) << text;
}

TEST(HoldersTest, ARefusalForTheTimeOfAMeshNamesItsShares) {
  System system = networks(true);
  const std::size_t c = add_channel(system, every(50 * kMs));
  One one(system);
  one.stated.held.paths.push_back({.from = 1,
                                   .to = 0,
                                   .bytes_per_second = 25'000,
                                   .event_bytes = 1'000,
                                   .source = {.publisher = 0, .admission = 4},
                                   .gateway = 1});
  one.read(kAir);
  AttributeSet much = every(kMs);
  much.set(Attribute::max_payload, 1000);
  Admission a = both_ends(c, 7, much);
  a.publisher->place = at(0);
  a.subscriber->place = on(kAir);
  const std::string text = refusal(one.peer.state, a);
  EXPECT_TRUE(text.contains("needed on air, ")) << text;
  EXPECT_TRUE(text.contains("; reserved there by g1 (")) << text;
  EXPECT_TRUE(text.ends_with(" % of the time)")) << text;
}

TEST(HoldersTest, WhatIsRefusedForAnotherReasonNamesNobody) {
  System system = networks(true);
  const std::size_t c = add_channel(system, every(50 * kMs));
  One one(system);
  one.stated.add_rate(1, 100);
  one.read(kWire);
  Admission a = both_ends(c, 7, every(50 * kMs));
  a.publisher->place = at(0);
  a.subscriber->place = on(kWire);
  a.subscriber->attributes.set(Attribute::deadline, 1);
  EXPECT_FALSE(refusal(one.peer.state, a).contains("reserved there"));
}

TEST(HoldersTest, WhereItIsNotKnownWhatOthersHoldTheEntryIsNamed) {
  System system = networks(false);
  const std::size_t d = add_channel(system, every(50 * kMs));
  One one(system);
  one.stated.held.unreadable = true;
  one.stated.strange = "/r/shared/g1/7 of g1 is not understood";
  one.read(kShared);
  EXPECT_EQ(refusal(one.peer.state, both_ends(d, 2, every(50 * kMs))),
            "it is not known what other gateways hold of shared: /r/shared/g1/7 of g1 is not "
            "understood");
  one.stated.held = {};
  one.stated.strange.clear();
  one.stated.held.bus.emplace_back().source.admission = 1;  // no frame has these numbers
  one.stated.held.bus.back().gateway = 1;
  one.read(kShared);
  EXPECT_EQ(refusal(one.peer.state, both_ends(d, 2, every(50 * kMs))),
            "it is not known what other gateways hold of shared: reservations cannot be counted "
            "with the network as it is now, those of g1 (1)");
}

TEST(HoldersTest, WhoeverClaimsMoreThanThereIsIsNamed) {
  System system = six_gateways();
  add_channel(system, every(50 * kMs));
  One one(system);
  const auto excess = [&](std::size_t network) {
    return one.peer.state.held_by_others().excess(network);
  };
  one.stated.add_rate(1, 3'000);
  one.stated.add_rate(2, 1'000);
  one.read(kWire);
  EXPECT_EQ(excess(kWire), "");
  one.stated.add_rate(3, 1);
  one.read(kWire);
  EXPECT_EQ(excess(kWire),
            "other gateways have reserved more of wire than it has (4.001 kB/s of 4 kB/s): g1 (3 "
            "kB/s), g2 (1 kB/s) and g3 (1 B/s)");
  one.stated.held = {};
  one.stated.add_rate(2, kUnbounded);
  one.stated.add_rate(2, kUnbounded, 2);
  one.read(kWire);
  EXPECT_TRUE(excess(kWire).contains("g2 (unbounded)")) << excess(kWire);
  one.stated.held = {};
  one.read(kWire);
  for (AdmissionId id = 1; id <= 5; ++id) {
    cluster::BusPart& part = one.stated.held.bus.emplace_back();
    part.message = {.frames = 1,
                    .transmission = kMs,
                    .longest_frame = kMs,
                    .last_frame = kMs,
                    .period = 4 * kMs,
                    .deadline = 400 * kMs};
    part.source.admission = id;
    part.gateway = 1;
  }
  one.read(kShared);
  EXPECT_EQ(excess(kShared),
            "other gateways have reserved more of shared than it has (125 % of its time): g1 (5 "
            "messages, 125 % of the time)");
  one.stated.held = {};
  one.read(kShared);
  for (const std::size_t g : {1U, 2U})
    one.stated.held.paths.push_back({.from = 1,
                                     .to = 0,
                                     .bytes_per_second = 60'000,
                                     .event_bytes = 0,
                                     .source = {.publisher = 0, .admission = 4},
                                     .gateway = g});
  one.read(kAir);
  EXPECT_TRUE(excess(kAir).contains("of its time where it may be")) << excess(kAir);
  EXPECT_TRUE(excess(kAir).contains("g2 (")) << excess(kAir);
}

}  // namespace
}  // namespace mlcca::core::testing
