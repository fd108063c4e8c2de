// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/outlook.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/model/text.hpp"
#include "daemon/gateway/report.hpp"

namespace mlcca {
namespace {

/// The changed links of each mesh that the question is about.
using Graphs = std::map<std::size_t, core::mesh::Graph>;

Result<std::size_t> mesh_named(const core::State& state, const std::string& name) {
  std::optional<std::size_t> found;
  std::string known;
  for (std::size_t n = 0; n < state.system().networks.size(); ++n) {
    if (!state.world().meshes[n]) continue;
    const std::string& here = state.system().networks[n].name;
    known += (known.empty() ? "" : ", ") + here;
    if (!name.empty() && name != here) continue;
    if (found) return fail("there are several meshes: say which one, NETWORK/FROM,TO=RATE");
    found = n;
  }
  if (found) return *found;
  return fail(fmt::format("there is no mesh{} whose links are known ({})",
                          name.empty() ? "" : " '" + name + "'",
                          known.empty() ? "there is none at all" : known));
}

Result<std::uint32_t> node_named(const core::MeshView& view, const std::string& name) {
  std::string known;
  for (std::uint32_t n = 0; n < view.graph.nodes; ++n) {
    if (view.node_name(n) == name || (n < view.addresses.size() && view.addresses[n] == name))
      return n;
    known += (known.empty() ? "" : ", ") + view.node_name(n);
  }
  return fail(fmt::format("there is no node '{}' ({})", name, known));
}

void set_link(core::mesh::Graph& graph, std::uint32_t from, std::uint32_t to, Value rate) {
  const auto ends = [](const core::mesh::Link& l) { return std::pair(l.from, l.to); };
  const auto it = std::ranges::lower_bound(graph.links, std::pair(from, to), {}, ends);
  const bool there = it != graph.links.end() && ends(*it) == std::pair(from, to);
  if (rate == 0) {
    if (there) graph.links.erase(it);
    return;
  }
  if (there) {
    it->quality.rate = rate;
    return;
  }
  core::mesh::Link link;
  link.from = from;
  link.to = to;
  link.quality.rate = rate;
  graph.links.insert(it, link);
}

Result<void> change_link(const core::State& state, const control::LinkChange& change,
                         Graphs& graphs) {
  const auto network = mesh_named(state, change.network);
  if (!network) return std::unexpected(network.error());
  const core::MeshView& view = *state.world().meshes[*network];
  const auto from = node_named(view, change.from);
  if (!from) return std::unexpected(from.error());
  const auto to = node_named(view, change.to);
  if (!to) return std::unexpected(to.error());
  if (*from == *to) return fail("a link has two ends: " + change.from + " is both");
  core::mesh::Graph& graph = graphs.try_emplace(*network, view.graph).first->second;
  set_link(graph, *from, *to, change.rate);
  if (!change.one_way) set_link(graph, *to, *from, change.rate);
  return {};
}

void take_away(core::System& system, std::size_t gateway) {
  system.gateways[gateway].ports.clear();
  const core::Place gone{core::Place::Kind::gateway, gateway};
  std::erase_if(system.routes, [&](const core::DeclaredRoute& r) {
    return std::ranges::find(r.places, gone) != r.places.end();
  });
}

using Key = std::pair<std::size_t, core::Delivery>;
Key key_of(const core::State& state, const core::Verdict& v) {
  return {v.channel, state.delivery_of(v)};
}

}  // namespace

Result<std::unique_ptr<core::State>> suppose(const core::State& now,
                                             const control::WhatIfRequest& request) {
  core::System system = now.system();
  Graphs graphs;
  std::set<std::size_t> gone;
  for (const control::LinkChange& change : request.links)
    if (const auto done = change_link(now, change, graphs); !done)
      return std::unexpected(done.error());
  for (const std::string& name : request.without) {
    const auto place = now.find_place(name);
    if (!place) return fail(fmt::format("there is no network or gateway '{}'", name));
    if (place->kind == core::Place::Kind::network)
      gone.insert(place->index);
    else
      take_away(system, place->index);
  }

  auto then = std::make_unique<core::State>(std::move(system));
  for (const auto& [id, channel] : now.admissions()) then->restore(now.admission(id));
  std::map<std::size_t, core::Grants> granted;
  for (std::size_t c = 0; c < now.decisions().size(); ++c) {
    then->set_withdrawn(c, now.withdrawn(c));
    if (now.decisions()[c].granted != 0) granted.emplace(c, now.grants(c));
  }
  for (std::size_t n = 0; n < now.system().networks.size(); ++n) {
    then->set_condition(n, now.world().conditions[n]);
    if (const auto& view = now.world().meshes[n]) then->set_graph(n, view->graph, view->addresses);
    then->set_foreign(n, now.world().foreign[n]);
  }
  for (std::size_t g = 0; g < now.system().gateways.size(); ++g)
    then->set_failed(g, now.world().failed[g]);
  // Existing reservations stay, and no further ones are possible.
  then->set_permits(now.permits());
  then->decide(granted);
  for (auto& [network, graph] : graphs)
    then->set_graph(network, std::move(graph), now.world().meshes[network]->addresses);
  for (const std::size_t n : gone) {
    core::Condition condition = now.world().conditions[n];
    condition.available = false;
    condition.problem = "it is supposed not to be there";
    then->set_condition(n, std::move(condition));
  }
  then->settle();
  return then;
}

control::WhatIf outlook(const core::State& now, const core::State& then) {
  std::map<Key, const core::Verdict*> before;
  for (const core::Decision& d : now.decisions())
    for (const core::Verdict& v : d.verdicts) before.emplace(key_of(now, v), &v);
  control::WhatIf out;
  for (const core::Decision& d : then.decisions()) {
    for (const core::Verdict& v : d.verdicts) {
      const auto it = before.find(key_of(then, v));
      const core::Verdict* old = it == before.end() ? nullptr : it->second;
      const bool was = old != nullptr && old->granted;
      if (was == v.granted && (!was || old->set == v.set)) {
        ++out.unchanged;
        continue;
      }
      out.outlooks.push_back({.channel = then.system().channels[v.channel].name,
                              .publisher = then.members().publisher(v.publisher).name,
                              .to = core::name_of(then.system(), v.to),
                              .granted_now = was,
                              .granted_then = v.granted,
                              .set_now = static_cast<std::uint32_t>(old != nullptr ? old->set : 0),
                              .set_then = static_cast<std::uint32_t>(v.set),
                              .reason = why(then, v)});
    }
  }
  return out;
}

}  // namespace mlcca
