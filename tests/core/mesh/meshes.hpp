// SPDX-License-Identifier: BSD-2-Clause
// Meshes and graphs for tests: chains, and random ones with a fixed seed.
#pragma once
#include <algorithm>
#include <cstdint>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/domains.hpp"
#include "core/mesh/evaluation.hpp"
#include "core/mesh/graph.hpp"
#include "core/mesh/route.hpp"

namespace mlcca::core::mesh::testing {

inline constexpr Value kMega = 1'000'000;

/// No overhead and all of the time: the paper's own equation.
inline Mesh bare_mesh() {
  Mesh mesh;
  mesh.limit = kWhole;
  mesh.header_bytes = 0;
  mesh.packet_time = 0;
  return mesh;
}

inline Link link(std::uint32_t from, std::uint32_t to, Value rate, Value loss = 0) {
  Link result;
  result.from = from;
  result.to = to;
  result.quality = {.rate = rate, .kind = RateKind::phy, .loss = loss, .loss_known = loss != 0};
  result.channel = 1;
  return result;
}

/// Nodes 0, 1, 2, ... with a link of each rate (bit/s) from one to the next.
inline Graph chain(const std::vector<Value>& rates) {
  Graph graph;
  graph.nodes = rates.size() + 1;
  for (std::uint32_t i = 0; i < rates.size(); ++i) graph.links.push_back(link(i, i + 1, rates[i]));
  return graph;
}

/// All links of a chain.
inline std::vector<std::uint32_t> whole(const Graph& graph) {
  std::vector<std::uint32_t> path;
  for (std::uint32_t i = 0; i < graph.links.size(); ++i) path.push_back(i);
  return path;
}

inline Value nothing_taken(std::size_t) { return 0; }

/// A draw of everything that evaluation depends on.
class RandomMesh {
 public:
  explicit RandomMesh(unsigned seed) : engine_(seed) {}

  std::uint64_t below(std::uint64_t n) { return engine_() % n; }

  Mesh mesh(const Graph& graph) {
    Mesh result;
    result.interference = static_cast<Interference>(below(4));
    result.hops = static_cast<std::uint32_t>(below(4));
    result.limit = static_cast<std::uint32_t>(1 + below(kWhole));
    result.packet_bytes = static_cast<std::uint32_t>(1 + below(3000));
    result.header_bytes = static_cast<std::uint32_t>(below(60));
    result.packet_time = below(500'000);
    for (std::uint64_t i = below(4); i > 0; --i) {
      DescribedDomain domain;
      domain.name = "set-" + std::to_string(i);
      for (const Link& l : graph.links)
        if (below(2) == 0) domain.links.emplace_back(l.from, l.to);
      result.domains.push_back(domain);
    }
    return result;
  }

  Graph graph(std::uint32_t nodes, std::size_t links) {
    std::set<std::pair<std::uint32_t, std::uint32_t>> ends;
    for (std::size_t i = 0; i < links; ++i) {
      const auto from = static_cast<std::uint32_t>(below(nodes));
      const auto to = static_cast<std::uint32_t>(below(nodes));
      if (from != to) ends.emplace(from, to);
    }
    Graph result;
    result.nodes = nodes;
    for (const auto& [from, to] : ends) {
      Link l = link(from, to, 100'000 + below(100 * kMega), below(3) == 0 ? below(900'000'000) : 0);
      l.quality.kind = static_cast<RateKind>(below(3));
      l.channel = below(10) == 0 ? kAnyChannel : static_cast<std::uint32_t>(below(3));
      l.busy = below(kWhole + 1);
      result.links.push_back(l);
    }
    return result;
  }

  /// A path with at least one link, or an empty one where the graph has none such.
  std::vector<std::uint32_t> path(const Graph& graph, const Mesh& mesh) {
    Paths paths(graph, mesh);
    for (int attempt = 0; attempt < 50; ++attempt) {
      const auto& found = paths.between(static_cast<std::uint32_t>(below(graph.nodes)),
                                        static_cast<std::uint32_t>(below(graph.nodes)));
      if (!found.empty()) return found;
    }
    return {};
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace mlcca::core::mesh::testing
