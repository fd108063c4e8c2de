// SPDX-License-Identifier: BSD-2-Clause
// Which links packets take from one node of a mesh to another.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/mesh/graph.hpp"
#include "core/mesh/mesh.hpp"

namespace mlcca::core::mesh {

/// The most links of a path. Nodes farther away are not reached.
inline constexpr std::size_t kMaxPath = 32;

/// Finds paths in a graph that does not change meanwhile; graph and mesh must outlive it.
///
/// Next hops are followed as far as they are known, because the routing protocol has decided them.
/// From there on the path has the least sum of weights, if every link has a weight, as the protocol
/// will choose; otherwise the least sum of packet_time() for full packets. Among equal sums it has
/// the fewest links, and the choice is deterministic.
///
/// There is no path if next hops form a loop, or if protocol or weights lead over a link that
/// carries nothing now, because packets would be sent there all the same.
class Paths {
 public:
  Paths(const Graph& graph, const Mesh& mesh);

  /// The path as indices into Graph::links in the order of travel; empty if there is none or from
  /// == to. The reference stays valid as long as this object. One search is made for each starting
  /// node.
  const std::vector<std::uint32_t>& between(std::uint32_t from, std::uint32_t to);

 private:
  struct Edge {
    std::uint32_t to = 0;
    std::uint32_t link = 0;  ///< index into Graph::links, or kUnusable
    Value cost = 0;
  };
  /// How the search reaches a node: by which edge, from which node.
  struct Reached {
    Value cost = kUnbounded;
    std::uint32_t links = 0;
    std::uint32_t before = 0;
    std::uint32_t link = 0;
  };

  [[nodiscard]] std::span<const Edge> edges_of(std::uint32_t node) const;
  const std::vector<Reached>& tree_of(std::uint32_t from);
  [[nodiscard]] bool meets_itself(std::span<const std::uint32_t> links) const;
  std::vector<std::uint32_t> find(std::uint32_t from, std::uint32_t to);

  const Graph& graph_;
  std::vector<Edge> edges_;              ///< sorted by the node that they leave
  std::vector<std::size_t> first_edge_;  ///< per node, and one behind the last
  std::unordered_map<std::uint32_t, std::vector<Reached>> trees_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> paths_;
};

/// Finds a single path; see Paths.
[[nodiscard]] std::vector<std::uint32_t> path(const Graph& graph, const Mesh& mesh,
                                              std::uint32_t from, std::uint32_t to);

/// For each node that is reachable from `from` only over links that carry nothing now: what the
/// most lacking link on the best such way lacks, in the order rate, time, presence. Links that are
/// gone do not count. Nullopt for nodes that have a path or no way at all.
[[nodiscard]] std::vector<std::optional<Lack>> lacking_from(const Graph& graph, std::uint32_t from);

}  // namespace mlcca::core::mesh
