// SPDX-License-Identifier: BSD-2-Clause
// Contention domains: sets of links that share the time of one medium. What they take together must
// not exceed the limit of the mesh.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/graph.hpp"
#include "core/mesh/mesh.hpp"

namespace mlcca::core::mesh {

/// The domains of a graph, according to Mesh::interference.
///
/// With k_hop, links conflict in pairs, and each link has a domain: itself and all that conflict
/// with it. Sums over cliques (sets of links that all conflict with each other) would allow more,
/// but are necessary only: in a ring of five conflicts every clique is exactly full if each link
/// needs half of the time, yet no schedule exists. Sums over neighbourhoods are sufficient: the
/// link that is given its time last finds enough left by those that conflict with it (row
/// constraints; Ganesan, On some sufficient conditions for distributed quality-of-service support
/// in wireless networks, 2009).
class Domains {
 public:
  Domains(const Graph& graph, const Mesh& mesh);

  [[nodiscard]] std::size_t count() const { return domains_.size(); }
  /// The domains of which a link (index into Graph::links) takes time, rising; at least one.
  [[nodiscard]] std::span<const std::uint32_t> of_link(std::uint32_t link) const;
  /// The name of a domain: "all links", "channel 2412", the described name, or "around a > b".
  /// `node` returns the name of a node of the graph.
  [[nodiscard]] std::string name(std::size_t domain,
                                 const std::function<std::string(std::uint32_t)>& node) const;
  /// The ps per second that the medium is measured busy, our own traffic included: the worst that a
  /// link of the domain reports.
  [[nodiscard]] Value busy_of(std::size_t domain) const { return domains_[domain].busy; }

 private:
  enum class Label : std::uint8_t { all, channel, described, around };
  struct Domain {
    Label label = Label::all;
    std::uint32_t channel = 0;
    std::uint32_t from = 0;  ///< ends of the link that it is around
    std::uint32_t to = 0;
    std::string name;
    Value busy = 0;  ///< ps/s
  };
  class Builder;

  std::vector<Domain> domains_;
  std::vector<std::size_t> first_;  ///< per link, index into membership_, and one behind the last
  std::vector<std::uint32_t> membership_;
};

/// The ps per second that may be taken of each domain.
[[nodiscard]] constexpr Value limit_of(const Mesh& mesh) {
  return Value{mesh.limit} * (kFullTime / kWhole);
}

}  // namespace mlcca::core::mesh
