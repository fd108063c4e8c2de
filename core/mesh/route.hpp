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

/// Links of a path at most; what is farther away is not reached.
inline constexpr std::size_t kMaxPath = 32;

/// Paths of a graph that does not change meanwhile; graph and mesh must outlive it.
///
/// Next hops are followed as far as they are known: the routing protocol has decided. From there on
/// it is the least sum of weights where every link has one, since that is what the protocol will
/// take, and else of packet_time() of full packets. Of equal sums it is one with the fewest links,
/// always the same.
///
/// There is no path where next hops turn in a circle, or where protocol or weights lead over a link
/// that carries nothing now: packets would go there all the same.
class Paths {
 public:
  Paths(const Graph& graph, const Mesh& mesh);

  /// Indices into Graph::links, in the order of travel. Empty: no path, or from == to. Stays valid
  /// as long as this object. One search for each node that paths start from.
  const std::vector<std::uint32_t>& between(std::uint32_t from, std::uint32_t to);

 private:
  struct Edge {
    std::uint32_t to = 0;
    std::uint32_t link = 0;  ///< index into Graph::links, or kUnusable
    Value cost = 0;
  };
  /// How a node is reached: the edge, and the node that it leaves.
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
  std::vector<Edge> edges_;              ///< by the node that they leave
  std::vector<std::size_t> first_edge_;  ///< of each node, and the end
  std::unordered_map<std::uint32_t, std::vector<Reached>> trees_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> paths_;
};

/// A single path; see Paths.
[[nodiscard]] std::vector<std::uint32_t> path(const Graph& graph, const Mesh& mesh,
                                              std::uint32_t from, std::uint32_t to);

/// Of each node to which links lead from there, but only over such as carry nothing now: what the
/// most lacking one of them lacks, on the way where that is least. A rate is less than time, time
/// less than presence; links that are gone lead nowhere. Nothing: there is a way, or none at all.
[[nodiscard]] std::vector<std::optional<Lack>> lacking_from(const Graph& graph, std::uint32_t from);

}  // namespace mlcca::core::mesh
