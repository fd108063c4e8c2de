// SPDX-License-Identifier: BSD-2-Clause
// What must hold whatever happens, on random systems through random histories: no resource above
// its bound, no message late, what is touched decided as if everything were.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/admission/state.hpp"
#include "tests/core/admission/bounds.hpp"

namespace mlcca::core::testing {
namespace {

using Random = std::mt19937_64;

std::size_t below(Random& random, std::size_t n) {
  return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
}
bool chance(Random& random, unsigned percent) { return below(random, 100) < percent; }

constexpr Value kMs = 1'000'000;
constexpr std::uint32_t kNodes = 6;
constexpr std::size_t kBuses = 3;
constexpr std::size_t kAir = kBuses;
constexpr std::size_t kChannels = 24;

Place on(std::size_t network) { return {Place::Kind::network, network}; }

/// Three buses, each behind a gateway that is a node of one mesh; channels go from bus to bus, from
/// bus to mesh, or stay on a bus.
System random_system(Random& random) {
  System system;
  system.name = "random";
  for (std::size_t b = 0; b < kBuses; ++b) {
    Network bus;
    bus.name = "bus" + std::to_string(b);
    bus.profile = Profile::raw;
    bus.bus.bitrate = 125'000;
    bus.bus.unknown_senders = chance(random, 30);
    bus.provision.set(Attribute::max_payload, 8);
    bus.unlisted = {.allowed = true, .subject = 0, .bits = 0, .most = 3};
    system.networks.push_back(bus);
  }
  Network air;
  air.name = "air";
  air.kind = NetworkKind::mesh;
  air.provision.set(Attribute::max_payload, 1400);
  air.unlisted = {.allowed = true, .subject = 0, .bits = 0, .most = 2};
  mesh::Mesh m;
  m.interference = std::array{mesh::Interference::single_domain, mesh::Interference::k_hop,
                              mesh::Interference::channel}[below(random, 3)];
  m.hops = 1;
  m.per_hop.set(Attribute::latency, 2 * kMs)
      .set(Attribute::jitter, kMs)
      .set(Attribute::period, kMs);
  for (std::uint32_t n = 0; n < kNodes; ++n) {
    mesh::Node node;
    node.name = "n" + std::to_string(n);
    node.address = node.name;
    if (n < kBuses) node.gateway = n;
    m.nodes.push_back(node);
  }
  air.mesh = m;
  system.networks.push_back(air);
  for (std::size_t g = 0; g < kBuses; ++g) {
    Gateway gateway;
    gateway.name = "g" + std::to_string(g);
    gateway.provision.set(Attribute::latency, kMs).set(Attribute::jitter, kMs);
    for (const std::size_t n : {g, kAir}) {
      Port port;
      port.network = n;
      port.queue_length = 40;
      port.queueing = chance(random, 50) ? Queueing::priority : Queueing::fifo;
      gateway.ports.push_back(port);
    }
    system.gateways.push_back(gateway);
  }
  for (std::size_t c = 0; c < kChannels; ++c) {
    EventChannel channel;
    channel.name = "c" + std::to_string(c);
    channel.subject = c + 1;
    channel.importance = static_cast<std::uint8_t>(below(random, 3));
    const Value period = (5 + below(random, 60)) * kMs;
    const auto every = [](Value p) {
      return AttributeSet{}.set(Attribute::period, p).set(Attribute::max_payload, 8);
    };
    channel.attributes = every(period);
    if (chance(random, 50)) {
      channel.priority = 1;
      channel.lower = {{0, every(4 * period), {}}};
    }
    system.channels.push_back(channel);
    for (std::size_t b = 0; b < kBuses; ++b) {
      Binding binding;
      binding.channel = c;
      binding.id = static_cast<std::uint32_t>(0x10 + c);
      system.networks[b].bindings.push_back(binding);
    }
    Publisher p;
    p.name = "p" + std::to_string(c);
    p.channel = c;
    p.place = on(below(random, kBuses));
    p.attributes = channel.attributes;
    p.lower = channel.lower;
    system.publishers.push_back(p);
    for (std::size_t i = 0; i <= below(random, 2); ++i) {
      Subscriber s;
      s.name = "s" + std::to_string(c) + "-" + std::to_string(i);
      s.channel = c;
      s.place = on(below(random, kBuses + 1));
      if (s.place.index == kAir) s.mesh_node = static_cast<std::uint32_t>(below(random, kNodes));
      s.attributes = channel.attributes;
      s.lower = channel.lower;
      if (chance(random, 60)) {
        s.attributes.set(Attribute::deadline, 100 * kMs);
        for (Alternative& a : s.lower) a.attributes.set(Attribute::deadline, 100 * kMs);
      }
      system.subscribers.push_back(s);
    }
    // A longer deadline than the period, so that ways of many hops have a chance.
    system.publishers.back().attributes.set(Attribute::deadline, 100 * kMs);
    for (Alternative& a : system.publishers.back().lower)
      a.attributes.set(Attribute::deadline, 100 * kMs);
  }
  return system;
}

mesh::Graph random_graph(Random& random) {
  mesh::Graph graph;
  graph.nodes = kNodes;
  for (std::uint32_t from = 0; from < kNodes; ++from)
    for (std::uint32_t to = 0; to < kNodes; ++to) {
      if (from == to || chance(random, 40)) continue;
      mesh::Link link;
      link.from = from;
      link.to = to;
      link.quality.rate = 20'000 + below(random, 200'000);
      link.quality.loss = chance(random, 30) ? below(random, 300'000'000) : 0;
      link.channel = static_cast<std::uint32_t>(below(random, 2));
      graph.links.push_back(link);
    }
  return graph;
}

/// The same links, some of them better or worse.
mesh::Graph varied(Random& random, mesh::Graph graph) {
  for (mesh::Link& link : graph.links)
    if (chance(random, 20)) link.quality.rate = 10'000 + below(random, 300'000);
  // A link that carries nothing joins what is around its ends all the same.
  graph.unusable.clear();
  for (std::uint32_t from = 0; from < kNodes; ++from)
    for (std::uint32_t to = 0; to < kNodes; ++to)
      if (from != to && graph.find(from, to) == nullptr && chance(random, 20))
        graph.unusable.push_back({from, to, {}});
  if (chance(random, 30)) graph.links.front().busy = below(random, 100'000);
  return graph;
}

Admission random_admission(Random& random, const State& state, AdmissionId id) {
  Admission a;
  a.id = id;
  a.channel = below(random, kChannels);
  Subscriber s;
  s.name = "late" + std::to_string(id);
  s.channel = a.channel;
  s.place = on(below(random, kBuses + 1));
  if (s.place.index == kAir) s.mesh_node = static_cast<std::uint32_t>(below(random, kNodes));
  s.attributes = state.system().channels[a.channel].attributes;
  s.lower = state.system().channels[a.channel].lower;
  a.subscriber = s;
  return a;
}

/// A channel that is not described, now and then by an identifier that another one has.
UnlistedChannel random_unlisted(Random& random) {
  UnlistedChannel wanted;
  wanted.subject = 0x1000 + below(random, 6);
  for (std::size_t b = 0; b < kBuses; ++b)
    wanted.bindings.push_back(
        {.network = b, .id = static_cast<std::uint32_t>(0x10 + kChannels - 2 + below(random, 16))});
  return wanted;
}

/// From one bus to another, with a publisher of its own.
Admission admission_of(Random& random, std::size_t channel, AdmissionId id) {
  Admission a;
  a.id = id;
  a.channel = channel;
  const auto traffic = AttributeSet{}
                           .set(Attribute::period, (20 + below(random, 60)) * kMs)
                           .set(Attribute::max_payload, 8);
  Publisher p;
  p.name = "new" + std::to_string(id);
  p.channel = channel;
  p.place = on(below(random, kBuses));
  p.attributes = traffic;
  Subscriber s;
  s.name = "late" + std::to_string(id);
  s.channel = channel;
  s.place = on(below(random, kBuses));
  s.attributes = traffic;
  a.publisher = p;
  a.subscriber = s;
  return a;
}

/// What one channel is granted on a bus no other one could use.
void check_identifiers(const State& state) {
  for (std::size_t g = 0; g < kBuses; ++g) {
    std::map<std::pair<std::size_t, std::uint32_t>, Subject> of;
    for (const GateRule& rule : state.gate_state(g)) {
      if (!rule.pass || rule.entry.port != 0) continue;
      const auto [it, fresh] = of.try_emplace({g, rule.entry.id}, rule.entry.subject);
      EXPECT_EQ(it->second, rule.entry.subject) << "identifier " << rule.entry.id;
    }
  }
  for (const Network& network : state.system().networks)
    for (const Binding& b : network.bindings)
      EXPECT_FALSE(state.system().channels[b.channel].name.empty()) << "of a channel that is gone";
}

class RandomTest : public ::testing::TestWithParam<int> {
 protected:
  /// Histories in which no request is admitted, or none refused, would prove little.
  static void TearDownTestSuite() {
    if (histories == 0) return;
    EXPECT_GE(unlisted, histories);
    EXPECT_GE(refused, histories);
  }
  static inline std::size_t histories = 0;
  static inline std::size_t unlisted = 0;  ///< admissions of channels that are not described
  static inline std::size_t refused = 0;   ///< of such, for their identifier or their number
};

TEST_P(RandomTest, BoundsHoldAndWhatIsTouchedIsDecidedAsIfEverythingWere) {
  Random random(static_cast<std::uint64_t>(GetParam()));
  const System system = random_system(random);
  State state(system);
  State thorough(system);
  mesh::Graph graph = random_graph(random);
  std::vector<AdmissionId> admitted;
  AdmissionId next = 1;
  std::size_t grants = 0;
  ++histories;
  for (int step = 0; step < 40; ++step) {
    const auto both = [&](const auto& change) {
      change(state);
      change(thorough);
    };
    switch (below(random, 8)) {
      case 6:
      case 7: {
        const UnlistedChannel wanted = random_unlisted(random);
        const auto listed = state.list(wanted);
        const auto in_twin = thorough.list(wanted);
        ASSERT_EQ(listed.has_value(), in_twin.has_value());
        if (!listed) {
          EXPECT_EQ(listed.error().text, in_twin.error().text);
          ++refused;
          break;
        }
        ASSERT_EQ(*listed, *in_twin);
        const Admission a = admission_of(random, *listed, next++);
        Proposal p = state.propose(a);
        Proposal twin = thorough.propose(a);
        ASSERT_EQ(p.fit(), twin.fit());
        if (!p.fit()) break;
        std::move(p).accept();
        std::move(twin).accept();
        admitted.push_back(a.id);
        ++unlisted;
        break;
      }
      case 0:
        graph = random_graph(random);
        both([&](State& s) { s.set_graph(kAir, graph); });
        break;
      case 1:
      case 2:
        graph = varied(random, graph);
        both([&](State& s) { s.set_graph(kAir, graph); });
        break;
      case 3: {
        Condition condition;
        condition.available = chance(random, 80);
        condition.timing.bitrate = chance(random, 50) ? 125'000 : 50'000;
        condition.background = chance(random, 20) ? 100'000 : 0;
        const std::size_t bus = below(random, kBuses);
        both([&](State& s) { s.set_condition(bus, condition); });
        break;
      }
      case 4: {
        const Admission a = random_admission(random, state, next++);
        const std::string before = service(state);
        bool fit = false;
        {
          Proposal p = state.propose(a);
          fit = p.fit();
          if (fit && chance(random, 80))
            std::move(p).accept();
          else
            fit = false;
        }
        if (!fit) {
          EXPECT_EQ(service(state), before);
        }
        Proposal twin = thorough.propose(a);
        if (fit) {
          std::move(twin).accept();
          admitted.push_back(a.id);
        }
        break;
      }
      default:
        if (!admitted.empty()) {
          const std::size_t i = below(random, admitted.size());
          const AdmissionId id = admitted[i];
          admitted.erase(admitted.begin() + static_cast<std::ptrdiff_t>(i));
          both([&](State& s) { EXPECT_TRUE(s.remove(id)); });
        } else {
          const std::size_t c = below(random, kChannels);
          const bool released = !state.withdrawn(c);
          both([&](State& s) { s.set_withdrawn(c, released); });
        }
    }
    state.settle();
    thorough.invalidate_all();
    thorough.settle();
    ASSERT_EQ(service(state), service(thorough)) << "step " << step;
    EXPECT_TRUE(state.ledger().same_promises(thorough.ledger())) << "step " << step;
    EXPECT_EQ(beyond_bounds(state), "") << "step " << step;
    check_identifiers(state);
    for (const Decision& d : state.decisions()) grants += d.granted;
    if (HasFailure()) break;
  }
  EXPECT_GT(grants, 0U);
}
INSTANTIATE_TEST_SUITE_P(Seeds, RandomTest, ::testing::Range(1, 41));

/// What a daemon writes down.
std::map<std::size_t, Grants> grants_of(const State& state) {
  std::map<std::size_t, Grants> all;
  for (std::size_t c = 0; c < kChannels; ++c)
    if (state.decisions()[c].granted != 0) all.emplace(c, state.grants(c));
  return all;
}

/// By a restart a gateway becomes what it would have become without, where the networks have
/// changed meanwhile.
TEST(RandomRestartTest, NetworksThatAreWorseThenAreAsIfTheyHadBecomeSo) {
  std::size_t degraded = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(seed);
    const System system = random_system(random);
    mesh::Graph graph = random_graph(random);
    State goes_on(system);
    goes_on.set_graph(kAir, graph);
    goes_on.settle();
    const auto before = grants_of(goes_on);
    State again(system);
    graph = varied(random, graph);
    for (mesh::Link& link : graph.links) link.quality.rate /= 2;
    Condition slow;
    slow.timing.bitrate = 50'000;
    for (State* s : {&goes_on, &again}) {
      s->set_graph(kAir, graph);
      s->set_condition(0, slow);
    }
    goes_on.settle();
    again.decide(before);
    EXPECT_EQ(service(again), service(goes_on)) << seed;
    EXPECT_EQ(beyond_bounds(again), "") << seed;
    for (const auto& [c, grants] : before) {
      const Decision& now = again.decisions()[c];
      if (now.granted >= grants.deliveries.size() && now.set > grants.set) ++degraded;
    }
  }
  EXPECT_GT(degraded, 100U);
}

TEST(RandomReleaseTest, WhoCameAndWentLeavesNothing) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const System system = random_system(random);
    const mesh::Graph graph = random_graph(random);
    State state(system);
    State untouched(system);
    for (State* s : {&state, &untouched}) {
      s->set_graph(kAir, graph);
      s->settle();
    }
    std::vector<AdmissionId> admitted;
    for (AdmissionId id = 1; id <= 10; ++id) {
      Proposal p = state.propose(random_admission(random, state, id));
      if (!p.fit()) continue;
      std::move(p).accept();
      admitted.push_back(id);
    }
    std::ranges::shuffle(admitted, random);
    for (const AdmissionId id : admitted) {
      EXPECT_TRUE(state.remove(id));
      state.settle();
    }
    EXPECT_EQ(service(state), service(untouched)) << seed;
    EXPECT_TRUE(state.ledger().same_promises(untouched.ledger())) << seed;
  }
}

}  // namespace
}  // namespace mlcca::core::testing
