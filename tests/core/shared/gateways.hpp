// SPDX-License-Identifier: BSD-2-Clause
// Gateways that decide alone and reserve in one store, as far as that concerns decisions.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/admission/permits.hpp"
#include "core/admission/state.hpp"
#include "core/cluster/baseline.hpp"
#include "core/cluster/footprint.hpp"
#include "core/model/text.hpp"

namespace mlcca::core::testing {

using Random = std::mt19937_64;

inline std::size_t below(Random& random, std::size_t n) { return random() % n; }
inline bool chance(Random& random, unsigned percent) { return random() % 100 < percent; }

inline constexpr Value kMs = 1'000'000;
inline constexpr std::size_t kShared = 0;  ///< the bus of both gateways
inline constexpr std::size_t kOwn = 1;     ///< that of the first; the next one is of the second
inline constexpr std::size_t kWire = 3;
inline constexpr std::size_t kAir = 4;
inline constexpr std::size_t kGateways = 2;

inline Place on(std::size_t network) { return {Place::Kind::network, network}; }
inline Place at(std::size_t gateway) { return {Place::Kind::gateway, gateway}; }

inline AttributeSet every(Value period, Value deadline = 400 * kMs) {
  return AttributeSet{}
      .set(Attribute::period, period)
      .set(Attribute::max_payload, 8)
      .set(Attribute::deadline, deadline);
}

inline Network can_bus(std::string name) {
  Network bus;
  bus.name = std::move(name);
  bus.profile = Profile::raw;
  bus.bus.bitrate = 125'000;
  bus.provision.set(Attribute::max_payload, 8);
  bus.unlisted = {.allowed = true, .subject = 0, .bits = 0, .most = 8};
  return bus;
}

inline mesh::Mesh described_mesh() {
  mesh::Mesh mesh;
  mesh.interference = mesh::Interference::single_domain;
  mesh.per_hop.set(Attribute::latency, 2 * kMs)
      .set(Attribute::jitter, kMs)
      .set(Attribute::period, kMs);
  for (std::uint32_t n = 0; n < kGateways; ++n) {
    mesh::Node node;
    node.name = node.address = "n" + std::to_string(n);
    node.gateway = n;
    mesh.nodes.push_back(node);
    mesh::DescribedLink link;
    link.from = n;
    link.to = 1 - n;
    link.rate = 60'000;
    mesh.links.push_back(link);
  }
  mesh::Source source;
  source.kind = mesh::SourceKind::description;
  mesh.sources.push_back(source);
  return mesh;
}

/// What lies between the two gateways: a bus that both have, and one of their own each; with
/// `media`, a wire and a mesh of both as well.
inline System networks(bool media) {
  System system;
  system.name = "shared";
  for (const char* name : {"shared", "own0", "own1"}) system.networks.push_back(can_bus(name));
  if (media) {
    Network wire;
    wire.name = "wire";
    wire.kind = NetworkKind::udp_multicast;
    wire.profile = Profile::famouso;
    wire.provision.set(Attribute::max_payload, 1400)
        .set(Attribute::bandwidth, 4'000)
        .set(Attribute::latency, kMs)
        .set(Attribute::jitter, kMs)
        .set(Attribute::period, kMs);
    Network air = wire;
    air.name = "air";
    air.kind = NetworkKind::mesh;
    air.provision = AttributeSet{}.set(Attribute::max_payload, 1400);
    air.mesh = described_mesh();
    system.networks.push_back(wire);
    system.networks.push_back(air);
  }
  for (std::size_t g = 0; g < kGateways; ++g) {
    Gateway gateway;
    gateway.name = "g" + std::to_string(g);
    gateway.relay = 100;
    gateway.provision.set(Attribute::latency, kMs).set(Attribute::jitter, kMs);
    std::vector<std::size_t> there{kShared, kOwn + g};
    if (media) there.insert(there.end(), {kWire, kAir});
    for (const std::size_t n : there) {
      Port port;
      port.network = n;
      port.queue_length = 40;
      gateway.ports.push_back(port);
    }
    system.gateways.push_back(gateway);
  }
  return system;
}

inline std::size_t add_channel(System& system, const AttributeSet& attributes) {
  const std::size_t c = system.channels.size();
  EventChannel channel;
  channel.name = "c" + std::to_string(c);
  channel.subject = c + 1;
  channel.attributes = attributes;
  system.channels.push_back(channel);
  for (std::size_t n = 0; n < kWire; ++n) {
    Binding binding;
    binding.channel = c;
    binding.id = static_cast<std::uint32_t>(0x10 + c);
    system.networks[n].bindings.push_back(binding);
  }
  return c;
}

inline Publisher publisher(std::size_t channel, Place place, const AttributeSet& attributes) {
  Publisher p;
  p.name = "p" + std::to_string(channel);
  p.channel = channel;
  p.place = place;
  p.attributes = attributes;
  return p;
}
inline Subscriber subscriber(std::size_t channel, Place place, const AttributeSet& attributes) {
  Subscriber s;
  s.name = "s" + std::to_string(channel);
  s.channel = channel;
  s.place = place;
  s.attributes = attributes;
  return s;
}

/// What is reserved by whom, and how often something was.
struct Store {
  struct Entry {
    std::size_t gateway = 0;
    cluster::Footprint footprint;
  };
  std::map<std::uint64_t, Entry> entries;
  std::uint64_t version = 0;

  [[nodiscard]] cluster::Foreign without(std::size_t gateway, std::size_t network) const {
    cluster::Foreign foreign;
    for (const auto& [number, entry] : entries)
      if (entry.gateway != gateway)
        for (const cluster::Part& part : entry.footprint.parts)
          if (part.network == network) cluster::add(foreign, part, entry.gateway);
    return foreign;
  }
};

/// One that knows of the others what it has read from the store.
class Peer {
 public:
  Peer(const System& system, const cluster::Baseline& baseline, std::size_t self, Store& store)
      : baseline_(baseline), self_(self), store_(store), permits(system, self), state(system) {
    permits.set_standing(baseline.all());
    const World described = described_world(system);
    for (std::size_t n = 0; n < system.networks.size(); ++n)
      if (described.meshes[n]) state.set_graph(n, described.meshes[n]->graph);
    state.set_permits(&permits);
    read();
  }

  void read() {
    for (std::size_t n = 0; n < state.system().networks.size(); ++n)
      if (state.world().shared[n]) state.set_foreign(n, store_.without(self_, n));
    static_cast<void>(state.settle());
    seen_ = store_.version;
  }

  /// What the admission would have to reserve; nothing if it does not fit.
  std::optional<cluster::Footprint> ask(const Admission& admission) {
    const Proposal wish = state.wish(admission);
    if (!wish.fit()) return std::nullopt;
    return cluster::footprint_of(wish, baseline_, self_);
  }
  /// False: somebody else was sooner.
  bool commit(std::uint64_t number, const cluster::Footprint& footprint) {
    if (seen_ != store_.version) return false;
    if (!footprint.parts.empty()) ++store_.version;
    store_.entries.insert_or_assign(number, Store::Entry{self_, footprint});
    seen_ = store_.version;
    permits.put(number, footprint);
    return true;
  }
  /// Asked, reserved and put in force.
  bool admit(const Admission& admission) {
    read();
    const auto footprint = ask(admission);
    if (!footprint || !commit(admission.id, *footprint)) return false;
    Proposal p = state.propose(admission);
    if (!p.fit()) {
      broken = true;
      return false;
    }
    std::move(p).accept();
    static_cast<void>(state.settle());
    return true;
  }
  void release(AdmissionId id) {
    state.remove(id);
    static_cast<void>(state.settle());
    erase(id);
  }
  void erase(std::uint64_t number) {
    store_.entries.erase(number);
    ++store_.version;
    permits.erase(number);
    read();
  }

 private:
  const cluster::Baseline& baseline_;
  std::size_t self_;
  Store& store_;
  std::uint64_t seen_ = 0;

 public:
  Permits permits;
  State state;
  bool broken = false;  ///< what was reserved did not fit afterwards
};

/// In an order of their own, without keys.
inline std::vector<can::Message> sorted(std::vector<can::Message> all) {
  for (can::Message& m : all) m.key = 0;
  std::ranges::sort(all, {}, [](const can::Message& m) {
    return std::tuple(m.priority, m.queue, m.period, m.deadline);
  });
  return all;
}

/// Messages of a bus as they are, whoever counts them.
inline std::vector<can::Message> messages_on(const State& state, std::size_t network) {
  const auto there = state.ledger().schedule(network)->messages();
  return sorted({there.begin(), there.end()});
}

/// Two gateways with one description, and the store between them.
struct Pair {
  explicit Pair(System described) : system(std::move(described)), baseline(system) {
    for (std::size_t g = 0; g < kGateways; ++g)
      peers[g] = std::make_unique<Peer>(system, baseline, g, store);
  }
  Peer& operator[](std::size_t g) { return *peers[g]; }

  System system;
  cluster::Baseline baseline;
  Store store;
  std::array<std::unique_ptr<Peer>, kGateways> peers;
};

inline std::string why(const State& state, std::size_t channel) {
  return reason(state.system(), state.members(), state.decisions()[channel].verdicts.front());
}
inline bool granted(const State& state, std::size_t channel) {
  return state.decisions()[channel].granted != 0;
}

/// From the bus of one gateway to that of the other.
inline void describe(System& system, std::size_t channel, const AttributeSet& traffic,
                     std::size_t gateway = 0) {
  system.publishers.push_back(publisher(channel, on(kOwn + gateway), traffic));
  system.subscribers.push_back(subscriber(channel, on(kOwn + 1 - gateway), traffic));
}
inline Admission both_ends(std::size_t channel, AdmissionId id, const AttributeSet& traffic,
                           std::size_t gateway = 0) {
  return {id, channel, publisher(channel, on(kOwn + gateway), traffic),
          subscriber(channel, on(kShared), traffic)};
}
/// The first gateway admits the channel from itself, with a message each 5 ms on the shared bus,
/// and the second one has read it.
inline void admit_at_first(Pair& pair, std::size_t channel) {
  Admission a = both_ends(channel, 1, every(5 * kMs, 2 * kMs));
  a.publisher->place = at(0);
  ASSERT_TRUE(pair[0].admit(a));
  pair[1].read();
}

}  // namespace mlcca::core::testing
