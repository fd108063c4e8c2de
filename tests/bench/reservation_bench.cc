// SPDX-License-Identifier: BSD-2-Clause
// Admissions and changes with many reservations: in process, no kernel and no disk.
// reservation_bench [DDS-PEER]: the peer is run for as many pairs as channels are admitted.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/admission/state.hpp"

namespace {

using namespace mlcca;        // NOLINT(google-build-using-namespace): a bench
using namespace mlcca::core;  // NOLINT(google-build-using-namespace)

constexpr Value kMs = 1'000'000;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Place on(std::size_t network) { return {Place::Kind::network, network}; }

AttributeSet rate(Value bytes) {
  return AttributeSet{}.set(Attribute::bandwidth, bytes).set(Attribute::max_payload, 100);
}

EventChannel channel(std::size_t c, Value bytes) {
  EventChannel out;
  out.name = "c" + std::to_string(c);
  out.subject = c + 1;
  out.attributes = rate(bytes);
  return out;
}

void add_ends(System& system, std::size_t c, std::size_t network, std::optional<std::uint32_t> from,
              std::optional<std::uint32_t> to) {
  Publisher p;
  p.name = "p" + std::to_string(c);
  p.channel = c;
  p.place = on(network);
  p.attributes = system.channels[c].attributes;
  p.mesh_node = from;
  system.publishers.push_back(p);
  Subscriber s;
  s.name = "s" + std::to_string(c);
  s.channel = c;
  s.place = on(network);
  s.attributes = p.attributes;
  s.mesh_node = to;
  system.subscribers.push_back(s);
}

/// 1000 links, each a network of its own; the channels spread over them.
System wires(std::size_t channels) {
  System system;
  for (std::size_t n = 0; n < 1000; ++n) {
    Network wire;
    wire.name = "n" + std::to_string(n);
    wire.kind = NetworkKind::other;
    wire.provision.set(Attribute::bandwidth, 1'000'000'000).set(Attribute::max_payload, 1400);
    system.networks.push_back(wire);
  }
  for (std::size_t c = 0; c < channels; ++c) {
    system.channels.push_back(channel(c, 100));
    add_ends(system, c, c % 1000, {}, {});
  }
  return system;
}

constexpr std::uint32_t kSide = 16;

/// A mesh of 16 x 16 nodes, each linked to its neighbours: 960 links, those within two hops share.
System grid(std::size_t channels) {
  System system;
  Network air;
  air.name = "air";
  air.kind = NetworkKind::mesh;
  air.provision.set(Attribute::max_payload, 1400);
  mesh::Mesh m;
  m.interference = mesh::Interference::k_hop;
  m.hops = 2;
  for (std::uint32_t n = 0; n < kSide * kSide; ++n)
    m.nodes.push_back({"n" + std::to_string(n), "n" + std::to_string(n), {}, {}});
  air.mesh = m;
  system.networks.push_back(air);
  Gateway gateway;
  gateway.name = "g";
  system.gateways.push_back(gateway);
  for (std::size_t c = 0; c < channels; ++c) {
    system.channels.push_back(channel(c, 1));
    // Four hops along a row.
    const auto row = static_cast<std::uint32_t>(c % kSide);
    const auto column = static_cast<std::uint32_t>(c / kSide % (kSide - 4));
    add_ends(system, c, 0, row * kSide + column, row * kSide + column + 4);
  }
  return system;
}

mesh::Graph grid_links(Value rate_of_first) {
  mesh::Graph graph;
  graph.nodes = kSide * kSide;
  const auto link = [&](std::uint32_t from, std::uint32_t to) {
    mesh::Link l;
    l.from = from;
    l.to = to;
    l.quality.rate = graph.links.empty() ? rate_of_first : 10'000'000'000;
    l.quality.kind = mesh::RateKind::effective;
    l.channel = 1;
    graph.links.push_back(l);
  };
  for (std::uint32_t n = 0; n < graph.nodes; ++n) {
    if (n >= kSide) link(n, n - kSide);
    if (n % kSide != 0) link(n, n - 1);
    if (n % kSide + 1 != kSide) link(n, n + 1);
    if (n + kSide < graph.nodes) link(n, n + kSide);
  }
  // The first of them, from node 0 to node 1, comes first in the order as well.
  return graph;
}

/// A publisher for each of the last channels, which have none; then all of them leave again.
struct PerSecond {
  double admitted = 0;
  double both = 0;
};

PerSecond admissions_per_second(State& state, const std::vector<Publisher>& newcomers) {
  PerSecond best;
  for (int round = 0; round < 5; ++round) {
    std::vector<Admission> asked;
    for (const Publisher& p : newcomers) asked.push_back({asked.size() + 1, p.channel, p, {}});
    const double start = now();
    for (Admission& a : asked) {
      Proposal p = state.propose(std::move(a));
      if (!p.fit()) {
        fmt::print(stderr, "refused\n");
        std::exit(1);
      }
      std::move(p).accept();
    }
    const double admitted = now();
    for (std::size_t i = 0; i < newcomers.size(); ++i) {
      state.remove(i + 1);
      state.settle();
    }
    const auto n = static_cast<double>(newcomers.size());
    best.admitted = std::max(best.admitted, n / (admitted - start));
    best.both = std::max(best.both, n / (now() - start));
  }
  return best;
}

/// The publishers of the last channels, which the system has no more.
std::vector<Publisher> take_publishers(System& system, std::size_t count) {
  const auto first = system.publishers.end() - static_cast<std::ptrdiff_t>(count);
  std::vector<Publisher> taken(first, system.publishers.end());
  system.publishers.erase(first, system.publishers.end());
  return taken;
}

/// The ledger alone: check and commit of a flow over one resource, and its release.
double ledger_per_second(const System& system, std::size_t channels, std::size_t rounds) {
  Ledger ledger(system);
  for (std::size_t c = 0; c < channels; ++c) ledger.add({c, c % 1000, Flow::kOwn}, 100);
  const double start = now();
  for (std::size_t i = 0; i < rounds; ++i) {
    const Flow flow{channels, i % 1000, Flow::kOwn};
    const Value left = 1'000'000'000 - ledger.reserved(flow.resource);
    if (left < 100 || !ledger.add(flow, 100)) std::exit(1);
    ledger.remove(channels);
  }
  return static_cast<double>(rounds) / (now() - start);
}

/// What a changed link takes until it is known which slots of the gates change.
void link_change(std::size_t touched, std::size_t others) {
  System system = grid(touched + others);
  // Those that are touched go over the first link, the others are far away from it.
  for (std::size_t c = 0; c < touched + others; ++c) {
    const bool near = c < touched;
    system.publishers[c].mesh_node = near ? 0 : kSide * kSide - kSide;
    system.subscribers[c].mesh_node = near ? 1 : kSide * kSide - kSide + 1;
  }
  State state(std::move(system));
  state.set_graph(0, grid_links(10'000'000'000));
  state.settle();
  std::vector<double> times;
  const std::size_t rounds = touched > 10'000 ? 5 : 21;
  for (std::size_t i = 0; i < rounds; ++i) {
    mesh::Graph graph = grid_links(i % 2 == 0 ? 9'000'000'000 : 10'000'000'000);
    const double start = now();
    state.set_graph(0, std::move(graph));
    const auto changes = state.settle();
    const auto gates = state.gate_changes(changes, 0);
    times.push_back(now() - start);
    if (changes.size() < touched || !gates.empty()) std::exit(1);
  }
  std::ranges::sort(times);
  fmt::print("link change, {:>6} channels touched of {:>6}      {:>10.3f} ms\n", touched,
             touched + others, times[rounds / 2] * 1e3);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  constexpr std::size_t many = 100'000;
  constexpr std::size_t spare = 10'000;
  {
    System system = wires(many + spare);
    fmt::print("ledger alone, one link of 1000, {} flows       {:>9.0f} /s\n", many,
               ledger_per_second(system, many, 2'000'000));
    const auto newcomers = take_publishers(system, spare);
    State state(std::move(system));
    const PerSecond ours = admissions_per_second(state, newcomers);
    fmt::print("admit, one link of 1000, {} others             {:>9.0f} /s\n", many, ours.admitted);
    fmt::print("admit and release, one link of 1000            {:>14.0f} /s\n", ours.both);
    if (argc > 1) {
      double peer = 0;
      const std::string command = std::string(argv[1]) + " 1000";
      if (FILE* pipe = ::popen(command.c_str(), "r")) {
        if (std::fscanf(pipe, "%lf", &peer) != 1) peer = 0;
        ::pclose(pipe);
      }
      fmt::print("  Cyclone DDS, reader and writer pairs of 1000    {:>9.0f} /s   ratio {:.0f}\n",
                 peer, peer > 0 ? ours.both / peer : 0);
    }
  }
  {
    System system = grid(many + spare);
    const auto newcomers = take_publishers(system, spare);
    State state(std::move(system));
    state.set_graph(0, grid_links(10'000'000'000));
    state.settle();
    const PerSecond ours = admissions_per_second(state, newcomers);
    fmt::print("admit, four hops of a mesh, {} others          {:>9.0f} /s\n", many, ours.admitted);
    fmt::print("admit and release, four hops of a mesh         {:>14.0f} /s\n", ours.both);
  }
  for (const std::size_t touched : {10, 1000}) link_change(touched, 0);
  link_change(1000, 99'000);
  link_change(100'000, 0);
}
