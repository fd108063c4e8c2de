// SPDX-License-Identifier: BSD-2-Clause
// What a route of a mesh carries: by the paper's equation, and by what is left of the medium's
// time.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/mesh/domains.hpp"
#include "core/mesh/graph.hpp"
#include "core/mesh/mesh.hpp"

namespace mlcca::core::mesh {

/// Both numbers of an answer.
struct RouteRate {
  Value paper = 0;      ///< bytes/s, 1/sum(1/R) of the links' rates as they are reported
  Value available = 0;  ///< bytes/s of payload in events of that size that still fit, with
                        ///< overhead, loss, limit, background and what is reserved
  std::size_t limiting_domain = 0;   ///< which allows no more than `available`
  std::vector<std::uint32_t> links;  ///< the path, of the function evaluate()
};

/// What a flow takes of a domain.
struct Share {
  std::uint32_t domain = 0;
  Value time = 0;  ///< ps in each second
  bool operator==(const Share&) const = default;
};

/// ps/s of a domain that are reserved or taken by others.
using Taken = std::function<Value(std::size_t domain)>;

/// A path with its domains worked out once: valid as long as graph, mesh and domains do not change,
/// none of which it refers to.
class PathCost {
 public:
  /// `path`: indices into Graph::links, at most kMaxPath.
  PathCost(const Graph& graph, const Mesh& mesh, const Domains& domains,
           std::span<const std::uint32_t> path);

  /// What fits besides what is taken. A flow of exactly `available` bytes/s fits, one of a byte
  /// more does not. event_bytes 0: not known, full packets.
  [[nodiscard]] RouteRate evaluate(Value event_bytes, const Taken& taken) const;
  /// What a flow takes of each domain, each once, domains rising.
  [[nodiscard]] std::vector<Share> shares(Value bytes_per_second, Value event_bytes) const;
  [[nodiscard]] const std::vector<std::uint32_t>& links() const { return path_; }

 private:
  /// Links of a domain on this path, as bits: domains with the same ones take the same time.
  using Mask = std::uint32_t;
  struct Touched {
    std::uint32_t domain = 0;
    std::uint32_t group = 0;
  };

  [[nodiscard]] std::vector<Value> group_times(Value event_bytes) const;

  std::vector<std::uint32_t> path_;
  std::vector<LinkQuality> qualities_;
  std::vector<Mask> groups_;
  std::vector<Touched> touched_;  ///< domains rising
  Mesh packets_;                  ///< limit and packets of the mesh, without nodes and sources
  Value paper_ = 0;               ///< bytes/s
};

/// For a path that is evaluated once; see PathCost.
[[nodiscard]] RouteRate evaluate(const Graph& graph, const Mesh& mesh, const Domains& domains,
                                 std::span<const std::uint32_t> path, Value event_bytes,
                                 const Taken& taken);
[[nodiscard]] std::vector<Share> shares(const Graph& graph, const Mesh& mesh,
                                        const Domains& domains, std::span<const std::uint32_t> path,
                                        Value bytes_per_second, Value event_bytes);

/// What a path gives of Mesh::per_hop beside its rate, while no domain is above its limit: its
/// links composed as hops of a route on media of their own (mlcca/compose.hpp). The loss of a link
/// is the worse of what is stated and what is measured; an event of several packets (event_bytes 0:
/// one) survives if each of them does. Bandwidth, if per_hop has it, is the least of a single link.
/// An empty path gives nothing.
[[nodiscard]] AttributeSet composed_per_hop(const Graph& graph, const Mesh& mesh,
                                            std::span<const std::uint32_t> path, Value event_bytes);

/// The best that any way gives of Mesh::per_hop: one link without more loss than is stated.
[[nodiscard]] AttributeSet best_per_hop(const Mesh& mesh, Value event_bytes);

}  // namespace mlcca::core::mesh
