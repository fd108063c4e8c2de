// SPDX-License-Identifier: BSD-2-Clause
// What a path of a mesh carries: by the paper's equation, and by the medium time that is left. See
// docs/explanation/mesh.md.
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

/// The two rates of a path.
struct RouteRate {
  Value paper = 0;      ///< bytes/s, 1/sum(1/R) of the reported link rates
  Value available = 0;  ///< payload bytes/s in events of the given size that still fit, after
                        ///< overhead, loss, limit, background and reservations
  std::size_t limiting_domain = 0;   ///< the domain that limits `available`
  std::vector<std::uint32_t> links;  ///< the path; set by the function evaluate() only
};

/// What a flow takes of one domain.
struct Share {
  std::uint32_t domain = 0;
  Value time = 0;  ///< ps per second
  bool operator==(const Share&) const = default;
};

/// Returns the ps/s of a domain that are reserved or taken by others.
using Taken = std::function<Value(std::size_t domain)>;

/// A path with its domains computed once. It refers to none of its arguments, but is only valid as
/// long as graph, mesh and domains do not change.
class PathCost {
 public:
  /// `path`: indices into Graph::links, at most kMaxPath.
  PathCost(const Graph& graph, const Mesh& mesh, const Domains& domains,
           std::span<const std::uint32_t> path);

  /// The rates of the path beside what is taken. A flow of exactly `available` bytes/s fits, one
  /// with a byte/s more does not. event_bytes 0: not known, computed in full packets.
  [[nodiscard]] RouteRate evaluate(Value event_bytes, const Taken& taken) const;
  /// What a flow takes of each domain; one entry per domain, by rising index.
  [[nodiscard]] std::vector<Share> shares(Value bytes_per_second, Value event_bytes) const;
  [[nodiscard]] const std::vector<std::uint32_t>& links() const { return path_; }

 private:
  /// The links of the path that belong to a domain, as bits. Domains with equal masks take equal
  /// time.
  using Mask = std::uint32_t;
  struct Touched {
    std::uint32_t domain = 0;
    std::uint32_t group = 0;
  };

  [[nodiscard]] std::vector<Value> group_times(Value event_bytes) const;

  std::vector<std::uint32_t> path_;
  std::vector<LinkQuality> qualities_;
  std::vector<Mask> groups_;
  std::vector<Touched> touched_;  ///< by rising domain
  Mesh packets_;     ///< the parameters for packets and limit, without nodes and sources
  Value paper_ = 0;  ///< bytes/s
};

/// For a path that is evaluated once; see PathCost::evaluate().
[[nodiscard]] RouteRate evaluate(const Graph& graph, const Mesh& mesh, const Domains& domains,
                                 std::span<const std::uint32_t> path, Value event_bytes,
                                 const Taken& taken);
/// See PathCost::shares().
[[nodiscard]] std::vector<Share> shares(const Graph& graph, const Mesh& mesh,
                                        const Domains& domains, std::span<const std::uint32_t> path,
                                        Value bytes_per_second, Value event_bytes);

/// What a path provides according to Mesh::per_hop, apart from its rate, while no domain exceeds
/// its limit: its links composed as hops on separate media (mlcca/compose.hpp). The loss of a link
/// is the worse of the stated and the measured one; an event of several packets (event_bytes 0:
/// one) survives if all of them do. Bandwidth, if stated in per_hop, is the least of a single link.
/// An empty path provides nothing.
[[nodiscard]] AttributeSet composed_per_hop(const Graph& graph, const Mesh& mesh,
                                            std::span<const std::uint32_t> path, Value event_bytes);

/// The best that any path can provide according to Mesh::per_hop: one link with only the stated
/// loss.
[[nodiscard]] AttributeSet best_per_hop(const Mesh& mesh, Value event_bytes);

}  // namespace mlcca::core::mesh
