// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/world.hpp"

#include <algorithm>
#include <utility>

#include "core/can/of_system.hpp"

namespace mlcca::core {
namespace {

/// Domains know how busy their links are, and nothing else that changes with the state of a link.
bool equally_busy(const mesh::Graph& a, const mesh::Graph& b) {
  return std::ranges::equal(a.links, b.links, {}, &mesh::Link::busy, &mesh::Link::busy);
}

}  // namespace

MeshView::MeshView(const mesh::Mesh& mesh, mesh::Graph links,
                   std::vector<std::string> node_addresses, const MeshView* before)
    : graph(std::move(links)),
      addresses(std::move(node_addresses)),
      mesh_(&mesh),
      domains_(before != nullptr && equally_busy(before->graph, graph)
                   ? before->domains_
                   : std::make_shared<const mesh::Domains>(graph, mesh)),
      paths_(graph, mesh) {
  background.assign(domains_->count(), 0);
}

const mesh::PathCost& MeshView::cost(std::uint32_t from, std::uint32_t to) const {
  const std::uint64_t key = std::uint64_t{from} << 32U | to;
  const auto it = costs_.find(key);
  if (it != costs_.end()) return it->second;
  return costs_.emplace(key, mesh::PathCost(graph, *mesh_, *domains_, path(from, to)))
      .first->second;
}

std::optional<mesh::Lack> MeshView::lack(std::uint32_t from, std::uint32_t to) const {
  const auto [it, fresh] = lacking_.try_emplace(from);
  if (fresh) it->second = mesh::lacking_from(graph, from);
  return to < it->second.size() ? it->second[to] : std::nullopt;
}

std::string MeshView::node_name(std::uint32_t node) const {
  if (node < mesh_->nodes.size()) return mesh_->nodes[node].name;
  return node < addresses.size() ? addresses[node] : "node " + std::to_string(node);
}

std::string MeshView::domain_name(std::size_t domain) const {
  return domains_->name(domain, [this](std::uint32_t node) { return node_name(node); });
}

World described_world(const System& system) {
  World world(system);
  for (std::size_t n = 0; n < system.networks.size(); ++n) {
    const auto& mesh = system.networks[n].mesh;
    if (!mesh) continue;
    mesh::Mesh described = *mesh;
    described.sources = {{mesh::SourceKind::description, {}, {}, {}, {}}};
    mesh::LinkTable table(described);
    table.take(0, mesh::described_snapshot(described, 0), 0);
    world.meshes[n] = std::make_shared<MeshView>(*mesh, table.graph());
  }
  return world;
}

std::optional<can::Assumptions> bus_of(const System& system, const Condition& condition,
                                       std::size_t network) {
  const Network& n = system.networks[network];
  can::Timing timing = can::timing_of(n);
  if (condition.timing.bitrate != 0) timing = condition.timing;
  if (n.profile == Profile::none || timing.bitrate == 0) return std::nullopt;
  can::Assumptions bus = can::assumptions_of(system, network, timing);
  // A station that is not described may send any frame.
  if (condition.background != 0) bus.unknown_senders = true;
  bus.background += condition.background;
  return bus;
}

Ledger empty_ledger(const System& system, const World& world) {
  Ledger ledger(system);
  for (std::size_t n = 0; n < system.networks.size(); ++n) {
    ledger.set_bus(n, bus_of(system, world.conditions[n], n));
    if (world.meshes[n]) ledger.set_domains(n, world.meshes[n]->domains().count());
  }
  return ledger;
}

std::uint32_t queue_of(const System& system, std::size_t gateway, std::size_t network) {
  std::uint32_t queue = 0;
  for (std::size_t g = 0; g < system.gateways.size(); ++g) {
    if (system.gateways[g].port_on(network) == nullptr) continue;
    if (g == gateway) return queue;
    ++queue;
  }
  return can::kOwnQueue;
}

}  // namespace mlcca::core
