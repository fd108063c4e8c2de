// SPDX-License-Identifier: BSD-2-Clause
// Domains: sets of links that share one medium's time. What they take together must stay below the
// limit of the mesh.
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

/// The domains of a graph, as Mesh::interference says.
///
/// With k_hop, links conflict pairwise, and each link has a domain: itself and all that conflict
/// with it. Sets of links that all conflict with each other (cliques) would allow more, but that no
/// clique is above its limit is necessary only: around a circle of five conflicts every clique is
/// just full with links that need half of the time each, and no schedule gives it to them. That no
/// neighbourhood is above its limit is sufficient: whichever link is given its time last, the
/// others that prevent it have left it enough (row constraints; Ganesan, On some sufficient
/// conditions for distributed quality-of-service support in wireless networks, 2009).
class Domains {
 public:
  Domains(const Graph& graph, const Mesh& mesh);

  [[nodiscard]] std::size_t count() const { return domains_.size(); }
  /// The domains that a link (index into Graph::links) takes time of, rising; at least one.
  [[nodiscard]] std::span<const std::uint32_t> of_link(std::uint32_t link) const;
  /// The number of links in a domain.
  [[nodiscard]] std::size_t links_in(std::size_t domain) const { return domains_[domain].links; }
  /// In words: "all links", "channel 2412", the described name, "around a > b". `node` gives the
  /// name of a node of the graph.
  [[nodiscard]] std::string name(std::size_t domain,
                                 const std::function<std::string(std::uint32_t)>& node) const;
  /// ps in each second that the medium is measured busy: the worst that a link in it reports. Our
  /// own traffic is part of it.
  [[nodiscard]] Value busy_of(std::size_t domain) const { return domains_[domain].busy; }

 private:
  enum class Label : std::uint8_t { all, channel, described, around };
  struct Domain {
    Label label = Label::all;
    std::uint32_t channel = 0;
    std::uint32_t from = 0;  ///< of the link that it is around
    std::uint32_t to = 0;
    std::string name;
    std::size_t links = 0;
    Value busy = 0;  ///< ps/s
  };
  class Builder;

  std::vector<Domain> domains_;
  std::vector<std::size_t> first_;  ///< of each link into membership_, and the end
  std::vector<std::uint32_t> membership_;
};

/// ps in each second of the medium's time that may be taken of each domain.
[[nodiscard]] constexpr Value limit_of(const Mesh& mesh) {
  return Value{mesh.limit} * (kFullTime / kWhole);
}

/// The load of others: what is measured without what we know that we sent in the same time; ps/s,
/// never below 0.
[[nodiscard]] constexpr Value background_of(Value busy, Value own_measured) {
  return busy > own_measured ? busy - own_measured : 0;
}

}  // namespace mlcca::core::mesh
