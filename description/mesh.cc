// SPDX-License-Identifier: BSD-2-Clause
// Resolves the names of nodes and gateways in meshes.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "description/resolve.hpp"

namespace mlcca::description {
namespace {

using core::FindingId;
using core::mesh::DescribedLink;
using core::mesh::Interference;
using core::mesh::Mesh;

class MeshResolver {
 public:
  MeshResolver(MeshDraft& draft, const Resolved& to, Index& nodes, Problems& problems)
      : draft_(draft), to_(to), nodes_(nodes), problems_(problems), mesh_(std::move(draft.mesh)) {}

  Mesh run() {
    mesh_.per_hop = draft_.per_hop.set;
    add_nodes();
    add_links();
    add_domains();
    if (mesh_.sources.empty() && !mesh_.links.empty())
      mesh_.sources.emplace_back().origin = mesh_.origin;  // its default kind is `description`
    return std::move(mesh_);
  }

 private:
  void add_nodes() {
    nodes_.reserve(draft_.nodes.size());
    for (const auto& d : draft_.nodes) {
      nodes_.add(d.node.name);
      auto& node = mesh_.nodes.emplace_back(d.node);
      if (d.gateway.empty()) continue;
      if (const auto found = to_.gateways.find(d.gateway, node.origin, "Node", problems_))
        node.gateway = static_cast<std::uint32_t>(*found);
    }
  }

  using Pair = std::pair<std::uint32_t, std::uint32_t>;
  std::optional<Pair> pair_of(const NodePairDraft& ends, std::string_view element) {
    const auto from = nodes_.find(ends.from, ends.origin, element, problems_);
    const auto to = nodes_.find(ends.to, ends.origin, element, problems_);
    if (!from || !to) return std::nullopt;
    if (*from == *to) {
      problems_.add(ends.origin, element,
                    fmt::format("from and to are both {}: a link is between two nodes", ends.from));
      return std::nullopt;
    }
    return Pair(static_cast<std::uint32_t>(*from), static_cast<std::uint32_t>(*to));
  }

  void add_links() {
    for (const auto& d : draft_.links) {
      const auto pair = pair_of(d.ends, "Link");
      if (!pair) continue;
      DescribedLink link = d.link;
      std::tie(link.from, link.to) = *pair;
      mesh_.links.push_back(link);
      if (!d.both_ways) continue;
      std::swap(link.from, link.to);
      mesh_.links.push_back(link);
    }
  }

  void add_domains() {
    for (auto& d : draft_.domains) {
      auto& domain = mesh_.domains.emplace_back(std::move(d.domain));
      for (const auto& member : d.members)
        if (const auto pair = pair_of(member, "Member")) domain.links.push_back(*pair);
    }
  }

  MeshDraft& draft_;
  const Resolved& to_;
  Index& nodes_;
  Problems& problems_;
  Mesh mesh_;
};

void check_media(const NetworkDraft& draft, Problems& problems) {
  const auto& network = draft.network;
  if (draft.bus && network.kind != core::NetworkKind::can)
    problems.add(
        *draft.bus, "Bus",
        fmt::format("only a CAN network has a Bus, and {} is none: remove it", network.name),
        FindingId::wrong_place);
  if (!draft.mesh) return;
  const auto& mesh = *draft.mesh;
  if (network.kind != core::NetworkKind::mesh)
    problems.add(mesh.mesh.origin, "Mesh",
                 fmt::format("only a network of kind mesh has a Mesh, and {} is none: remove it",
                             network.name),
                 FindingId::wrong_place);
  if (mesh.states_hops && mesh.mesh.interference != Interference::k_hop)
    problems.add(mesh.mesh.origin, "Mesh",
                 "attribute hops is for interference k-hop: add that or remove it",
                 FindingId::wrong_place);
  if (!mesh.domains.empty() && mesh.mesh.interference != Interference::explicit_sets)
    problems.add(mesh.domains.front().domain.origin, "Domain",
                 "a Domain is for interference explicit: state that in the Mesh or remove it",
                 FindingId::wrong_place);
}

}  // namespace

void add_meshes(Draft& draft, Resolved& to, Problems& problems) {
  for (std::size_t i = 0; i < draft.networks.size(); ++i) {
    auto& d = draft.networks[i];
    check_media(d, problems);
    if (!d.mesh || d.network.kind != core::NetworkKind::mesh) continue;
    // The index of nodes refers to names in the draft, which stays until the ends have been added.
    auto& nodes = to.mesh_nodes.try_emplace(i, "mesh node").first->second;
    to.system.networks[i].mesh = MeshResolver(*d.mesh, to, nodes, problems).run();
  }
}

}  // namespace mlcca::description
