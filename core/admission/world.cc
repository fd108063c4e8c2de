// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/world.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include "core/can/cover.hpp"
#include "core/can/level.hpp"
#include "core/can/of_system.hpp"
#include "core/profiles/profile.hpp"
#include "mlcca/arithmetic.hpp"

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
  if (!names_channels(n.profile) || timing.bitrate == 0) return std::nullopt;
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
    if (world.foreign[n].empty()) continue;
    ledger.rebuild_others(n, others_on(system, world, n, world.meshes[n].get()));
  }
  return ledger;
}

namespace {

/// More than any network has, and little enough that sums of many do not overflow.
constexpr Value kTooMuch = Value{1} << 44U;
/// The same of the sum of all that others have reserved of a network, whatever they write.
constexpr Value kTooMuchInAll = Value{1} << 62U;

/// An admission of a gateway, with the way in.
using Theirs = std::pair<std::size_t, cluster::Source>;

bool is_theirs(std::size_t gateway, const cluster::Source& source,
               const CountsWithPublisher& counts) {
  return source.admission != 0 && !(counts && counts(gateway, source));
}

/// What several reservations have of one admission counts once: the most of it.
Value rate_of_all(const cluster::Foreign& foreign, const CountsWithPublisher& counts) {
  std::vector<std::pair<Theirs, Value>> rates;
  rates.reserve(foreign.rates.size());
  for (const cluster::RatePart& part : foreign.rates)
    if (is_theirs(part.gateway, part.source, counts))
      rates.emplace_back(Theirs(part.gateway, part.source),
                         std::min(part.bytes_per_second, kTooMuch));
  // Mostly they are sorted: gateways number their admissions and reservations as they come.
  if (!std::ranges::is_sorted(rates)) std::ranges::sort(rates);
  Value sum = 0;
  for (std::size_t i = 0; i < rates.size(); ++i)
    if (i + 1 == rates.size() || rates[i].first != rates[i + 1].first)
      sum = std::min(sum + rates[i].second, kTooMuchInAll);
  return sum;
}

bool take_messages(const cluster::Foreign& foreign, const can::Assumptions& bus,
                   const CountsWithPublisher& counts, Others& others) {
  bool all = true;
  std::map<Theirs, can::Message> messages;
  for (const cluster::BusPart& part : foreign.bus) {
    if (!can::usable(bus, part.message)) {
      all = false;
      continue;
    }
    if (!is_theirs(part.gateway, part.source, counts)) continue;
    const auto [it, fresh] = messages.try_emplace({part.gateway, part.source}, part.message);
    if (!fresh) it->second = can::strictest(it->second, part.message);
  }
  for (auto& [theirs, message] : messages) {
    message.key = Ledger::key_of_other(theirs.first);
    others.messages.push_back(message);
  }
  return all;
}

bool take_paths(const cluster::Foreign& foreign, const mesh::Mesh& mesh, const MeshView& view,
                const CountsWithPublisher& counts, Others& others) {
  bool all = true;
  std::map<Theirs, std::vector<cluster::PathPart>> paths;
  for (const cluster::PathPart& part : foreign.paths)
    if (is_theirs(part.gateway, part.source, counts))
      join(paths[{part.gateway, part.source}], part);
  std::map<std::uint32_t, Value> sums;
  for (const auto& [theirs, parts] : paths) {
    const auto shares = shares_of_joined(mesh, view, parts);
    all = all && shares;
    if (!shares) continue;
    for (const mesh::Share& share : *shares) sums[share.domain] += share.time;
  }
  for (const auto& [domain, time] : sums) others.shares.push_back({domain, time});
  return all;
}

}  // namespace

void join(std::vector<cluster::PathPart>& paths, const cluster::PathPart& path) {
  const auto it = std::ranges::find_if(
      paths, [&](const cluster::PathPart& p) { return p.from == path.from && p.to == path.to; });
  if (it == paths.end()) {
    paths.push_back(path);
    return;
  }
  it->bytes_per_second = std::max(it->bytes_per_second, path.bytes_per_second);
  // Smaller events take more time for the same payload; 0 are full packets.
  if (it->event_bytes == 0 || (path.event_bytes != 0 && path.event_bytes < it->event_bytes))
    it->event_bytes = path.event_bytes;
}

std::optional<std::vector<mesh::Share>> shares_of_joined(const mesh::Mesh& mesh,
                                                         const MeshView& view,
                                                         std::vector<cluster::PathPart> paths) {
  std::ranges::stable_sort(paths, std::greater<>(), &cluster::PathPart::bytes_per_second);
  return shares_of(mesh, view, paths);
}

std::optional<std::vector<mesh::Share>> shares_of(const mesh::Mesh& mesh, const MeshView& view,
                                                  std::span<const cluster::PathPart> paths) {
  std::vector<mesh::Share> sum;
  std::vector<std::uint32_t> carried;  // a link carries it once, wherever it goes from there
  for (const cluster::PathPart& p : paths) {
    if (p.from == p.to) continue;
    if (p.from >= mesh.nodes.size() || p.to >= mesh.nodes.size()) return std::nullopt;
    std::vector<std::uint32_t> more;
    const auto& path = view.path(p.from, p.to);
    if (path.empty()) return std::nullopt;
    for (const std::uint32_t link : path)
      if (std::ranges::find(carried, link) == carried.end()) more.push_back(link);
    if (more.empty()) continue;
    carried.insert(carried.end(), more.begin(), more.end());
    for (const mesh::Share& share :
         mesh::shares(view.graph, mesh, view.domains(), more, p.bytes_per_second, p.event_bytes)) {
      const auto it = std::ranges::find(sum, share.domain, &mesh::Share::domain);
      mesh::Share& here = it == sum.end() ? sum.emplace_back(mesh::Share{share.domain, 0}) : *it;
      here.time = std::min(add_saturating(here.time, share.time), kTooMuch);
    }
  }
  return sum;
}

Others others_on(const System& system, const World& world, std::size_t network,
                 const MeshView* view, const CountsWithPublisher& counts) {
  const cluster::Foreign& foreign = world.foreign[network];
  const Network& medium = system.networks[network];
  Others others;
  constexpr Attribute rate = Attribute::bandwidth;
  if (medium.provision.has(rate) && !medium.provision.is_dynamic(rate))
    others.most_bytes = medium.provision[rate];
  if (view != nullptr) {
    others.most_time = mesh::limit_of(*medium.mesh);
    others.busy = view->background;
  }
  others.complete = !foreign.unreadable;
  others.bytes_per_second = rate_of_all(foreign, counts);
  if (!foreign.bus.empty()) {
    const auto bus = bus_of(system, world.conditions[network], network);
    if (!bus || !take_messages(foreign, *bus, counts, others)) others.complete = false;
  }
  if (!foreign.paths.empty() &&
      (view == nullptr || !take_paths(foreign, *medium.mesh, *view, counts, others)))
    others.complete = false;
  return others;
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
