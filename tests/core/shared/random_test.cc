// SPDX-License-Identifier: BSD-2-Clause
// Two gateways that each decide alone, on random systems: together they never promise more than
// the media have, and each counts what one gateway would count that had admitted everything.
#include <gtest/gtest.h>

#include <set>

#include "core/can/analysis.hpp"
#include "core/can/cover.hpp"
#include "tests/core/shared/random_systems.hpp"

namespace mlcca::core::testing {
namespace {

/// Of described publishers it is the same traffic, whoever has reserved it.
using Whose = std::pair<std::size_t, cluster::Source>;
Whose whose(std::size_t gateway, const cluster::Source& source) {
  return {source.admission == 0 ? kGateways : gateway, source};
}
Whose whose(const Flow& flow) {
  return whose(kGateways, {.publisher = flow.publisher, .admission = 0, .from = flow.from});
}

/// All that the members may send on the shared bus: what is promised twice of one flow is sent
/// once.
std::vector<can::Message> promised(const cluster::Baseline& baseline, const Store& store) {
  std::map<Whose, can::Message> promises;
  const auto take = [&](const Whose& key, const can::Message& message) {
    const auto [it, fresh] = promises.try_emplace(key, message);
    if (!fresh) it->second = can::strictest(it->second, message);
  };
  for (const cluster::Standing& s : baseline.standing(kShared))
    if (s.message) take(whose(s.flow), *s.message);
  for (const auto& [number, entry] : store.entries)
    for (const cluster::Part& part : entry.footprint.parts)
      if (part.network == kShared)
        for (const cluster::BusPart& bus : part.bus)
          take(whose(entry.gateway, bus.source), bus.message);
  std::vector<can::Message> all;
  for (const auto& [key, message] : promises) {
    all.push_back(message);
    all.back().key = all.size();
  }
  return all;
}

/// Whoever holds something of the shared bus was promised it.
void expect_promised(const State& state, const std::vector<can::Message>& all) {
  for (std::size_t c = 0; c < state.system().channels.size(); ++c)
    for (const std::size_t p : state.members().publishers_of(c))
      for (const Holding& h : state.ledger().holdings_of(p)) {
        if (h.resource != kShared || !h.scheduled) continue;
        const auto* const held = state.ledger().message_of({p, h.resource, h.from});
        EXPECT_TRUE(
            std::ranges::any_of(all, [&](const can::Message& m) { return can::covers(m, *held); }));
      }
}

void expect_within(const System& system, const cluster::Baseline& baseline, const Store& store,
                   const State& state) {
  const auto all = promised(baseline, store);
  const can::Assumptions bus = *bus_of(system, {}, kShared);
  const auto responses = can::analyse(bus, all);
  for (std::size_t i = 0; i < all.size(); ++i)
    EXPECT_TRUE(can::fits(bus, all[i], responses[i])) << "message " << i << " of " << all.size();
  expect_promised(state, all);
  if (system.networks.size() <= kWire) return;
  std::map<Whose, Value> wire;
  std::map<std::tuple<Whose, std::uint32_t>, cluster::PathPart> air;
  const auto take_rate = [&](const Whose& key, Value bytes) {
    wire[key] = std::max(wire[key], bytes);
  };
  const auto take_path = [&](const Whose& key, const cluster::PathPart& path) {
    const auto [it, fresh] = air.try_emplace({key, path.to}, path);
    it->second.bytes_per_second = std::max(it->second.bytes_per_second, path.bytes_per_second);
  };
  for (const cluster::Standing& s : baseline.standing(kWire))
    take_rate(whose(s.flow), s.bytes_per_second);
  for (const cluster::Standing& s : baseline.standing(kAir))
    for (const cluster::PathPart& path : s.paths) take_path(whose(s.flow), path);
  for (const auto& [number, entry] : store.entries)
    for (const cluster::Part& part : entry.footprint.parts) {
      for (const cluster::RatePart& r : part.rates)
        if (part.network == kWire) take_rate(whose(entry.gateway, r.source), r.bytes_per_second);
      for (const cluster::PathPart& path : part.paths)
        take_path(whose(entry.gateway, path.source), path);
    }
  Value on_wire = 0;
  for (const auto& [key, bytes] : wire) on_wire += bytes;
  Value on_air = 0;
  for (const auto& [key, path] : air) {
    const auto shares =
        shares_of(*system.networks[kAir].mesh, *state.world().meshes[kAir], std::span(&path, 1));
    ASSERT_TRUE(shares);
    for (const mesh::Share& share : *shares) on_air += share.time;
  }
  EXPECT_LE(on_wire, system.networks[kWire].provision[Attribute::bandwidth]);
  EXPECT_LE(on_air, mesh::limit_of(*system.networks[kAir].mesh));
}

class GatewaysTest : public ::testing::TestWithParam<unsigned> {
 protected:
  /// Histories in which nothing is reserved, or nothing refused, would prove little.
  static void TearDownTestSuite() {
    if (histories < 10) return;
    for (const std::size_t n : {kShared, kWire, kAir}) EXPECT_GE(reserved[n], histories) << n;
    EXPECT_GE(refused, 5 * histories);
  }
  static inline std::size_t histories = 0;
  static inline std::size_t refused = 0;
  static inline std::map<std::size_t, std::size_t> reserved;  ///< how often, by network
};

TEST_P(GatewaysTest, TogetherNeverPromiseMoreThanTheMediaHave) {
  Random random(GetParam());
  const System system = random_system(random, GetParam() % 2 == 0);
  const cluster::Baseline baseline(system);
  Store store;
  std::array<std::unique_ptr<Peer>, kGateways> peers;
  for (std::size_t g = 0; g < kGateways; ++g)
    peers[g] = std::make_unique<Peer>(system, baseline, g, store);
  ++histories;
  std::vector<std::pair<std::size_t, AdmissionId>> there;
  for (AdmissionId id = 1; id <= 60; ++id) {
    const std::size_t g = below(random, kGateways);
    Peer& peer = *peers[g];
    if (!there.empty() && chance(random, 20)) {
      const std::size_t i = below(random, there.size());
      peers[there[i].first]->release(there[i].second);
      there.erase(there.begin() + static_cast<std::ptrdiff_t>(i));
    } else if (chance(random, 15)) {
      // A gateway may withdraw or reinstate: what others count does not change.
      const std::size_t c = below(random, kChannels / 2);
      peer.state.set_withdrawn(c, !peer.state.withdrawn(c));
      static_cast<void>(peer.state.settle());
    } else if (chance(random, 15)) {
      Condition condition;
      condition.background = chance(random, 50) ? 200'000 : 0;
      peer.state.set_condition(kShared, condition);
      static_cast<void>(peer.state.settle());
    } else {
      const Admission a = chance(random, 30) ? late_subscriber(random, system, g, id)
                                             : random_admission(random, system, g, id);
      peer.read();
      const can::Schedule before = *peer.state.ledger().schedule(kShared);
      const bool done = peer.admit(a);
      if (done) {
        for (const cluster::Part& part : store.entries.at(id).footprint.parts)
          ++reserved[part.network];
        there.emplace_back(g, id);
      } else {
        ++refused;
        EXPECT_EQ(before, *peer.state.ledger().schedule(kShared)) << "a refusal changes nothing";
      }
      EXPECT_FALSE(peer.broken) << "what was reserved fits";
    }
    for (const auto& other : peers) {
      EXPECT_TRUE(other->state.ledger().schedule(kShared)->late().empty());
      expect_within(system, baseline, store, other->state);
    }
    if (HasFailure()) FAIL() << "at step " << id;
  }
}

TEST_P(GatewaysTest, CountTogetherWhatOneWouldThatHadAdmittedAll) {
  Random random(GetParam() + 1000);
  const System system = random_system(random, false);
  const cluster::Baseline baseline(system);
  Store store;
  std::array<std::unique_ptr<Peer>, kGateways> peers;
  for (std::size_t g = 0; g < kGateways; ++g)
    peers[g] = std::make_unique<Peer>(system, baseline, g, store);
  State one(system);
  std::size_t admitted = 0;
  for (AdmissionId id = 1; id <= 30; ++id) {
    const std::size_t g = below(random, kGateways);
    const Admission a = random_admission(random, system, g, id);
    if (!peers[g]->admit(a)) continue;
    Proposal p = one.propose(a);
    if (p.fit()) {
      std::move(p).accept();
      ++admitted;
      continue;
    }
    // Of a bus of one gateway the other does not know what was admitted there at run time.
    const Row* const why = deciding_row(*p.verdicts().front());
    ASSERT_NE(why, nullptr);
    EXPECT_NE(why->place, on(kShared));
    peers[g]->release(id);
  }
  EXPECT_GT(admitted, 0U);
  for (const auto& peer : peers) {
    peer->read();
    EXPECT_EQ(messages_on(peer->state, kShared), messages_on(one, kShared));
    EXPECT_EQ(peer->state.ledger().reserved(kShared), one.ledger().reserved(kShared));
    const auto responses = [](const State& state) {
      std::multiset<can::Time> all;
      const can::Schedule& bus = *state.ledger().schedule(kShared);
      for (const can::Message& m : bus.messages()) all.insert(bus.response(m.key));
      return all;
    };
    EXPECT_EQ(responses(peer->state), responses(one));
  }
}

TEST_P(GatewaysTest, OfTwoWhoAskAtOnceOneIsTooLateAndDecidesAgain) {
  Random random(GetParam() + 2000);
  const System system = random_system(random, GetParam() % 2 == 0);
  const cluster::Baseline baseline(system);
  Store store;
  std::array<std::unique_ptr<Peer>, kGateways> peers;
  for (std::size_t g = 0; g < kGateways; ++g)
    peers[g] = std::make_unique<Peer>(system, baseline, g, store);
  for (AdmissionId id = 1; id <= 40; id += 2) {
    std::array<Admission, kGateways> asked;
    std::array<std::optional<cluster::Footprint>, kGateways> wanted;
    for (std::size_t g = 0; g < kGateways; ++g) peers[g]->read();
    for (std::size_t g = 0; g < kGateways; ++g) {
      asked[g] = chance(random, 30) ? late_subscriber(random, system, g, id + g)
                                    : random_admission(random, system, g, id + g);
      wanted[g] = peers[g]->ask(asked[g]);
    }
    const std::size_t first = below(random, kGateways);
    for (const std::size_t g : {first, 1 - first}) {
      if (!wanted[g]) continue;
      if (peers[g]->commit(asked[g].id, *wanted[g])) {
        Proposal p = peers[g]->state.propose(asked[g]);
        ASSERT_TRUE(p.fit());
        std::move(p).accept();
      } else {
        static_cast<void>(peers[g]->admit(asked[g]));
        ASSERT_FALSE(peers[g]->broken);
      }
    }
    for (const auto& peer : peers) {
      peer->read();
      expect_within(system, baseline, store, peer->state);
      EXPECT_EQ(messages_on(peer->state, kShared), sorted(promised(baseline, store)))
          << "each counts what is promised to anyone, and nothing else";
    }
    if (HasFailure()) FAIL() << "at step " << id;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, GatewaysTest, ::testing::Range(1U, 41U));

}  // namespace
}  // namespace mlcca::core::testing
