// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/losses.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "core/model/text.hpp"
#include "daemon/gateway/report.hpp"

namespace mlcca {
namespace {

/// A delivery by what does not depend on a description.
using Named = std::pair<core::Subject, core::Delivery>;

template <class Item>
std::optional<std::size_t> index_of(const std::vector<Item>& all, const std::string& name) {
  const auto it = std::ranges::find(all, name, &Item::name);
  return it == all.end() ? std::nullopt : std::optional<std::size_t>(it - all.begin());
}

/// Whether links of the one are links of the other.
bool have_same_nodes(const core::mesh::Mesh& one, const core::mesh::Mesh& other) {
  return std::ranges::equal(one.nodes, other.nodes, [](const auto& a, const auto& b) {
    return a.name == b.name && a.address == b.address;
  });
}

/// The networks and gateways as they are now, where both descriptions have them.
void take_over_world(const core::State& now, core::State& then) {
  for (std::size_t n = 0; n < then.system().networks.size(); ++n) {
    const core::Network& network = then.system().networks[n];
    const auto before = index_of(now.system().networks, network.name);
    if (!before) continue;
    then.set_condition(n, now.world().conditions[*before]);
    const auto& view = now.world().meshes[*before];
    const auto& former = now.system().networks[*before].mesh;
    if (view && former && network.mesh && have_same_nodes(*former, *network.mesh))
      then.set_graph(n, view->graph, view->addresses);
  }
  for (std::size_t g = 0; g < then.system().gateways.size(); ++g)
    if (const auto before = index_of(now.system().gateways, then.system().gateways[g].name))
      then.set_failed(g, now.world().failed[*before]);
}

/// Whether the refusal follows from the description, and not from what is not known before it is in
/// force.
bool is_certain(const core::Verdict& v) {
  switch (v.obstacle) {
    case core::Obstacle::unavailable:
    case core::Obstacle::no_data_rate:
    case core::Obstacle::no_path:
    case core::Obstacle::no_rate:
    case core::Obstacle::links_absent:
    case core::Obstacle::links_must_last:
    case core::Obstacle::untagged:
    case core::Obstacle::contradicted:
    case core::Obstacle::others_unknown:
      return false;
    default:
      return v.outcome == Outcome::unfit;
  }
}

/// The deliveries of a state, by their names.
std::map<Named, const core::Verdict*> by_names(const core::State& state) {
  std::map<Named, const core::Verdict*> all;
  for (std::size_t c = 0; c < state.decisions().size(); ++c)
    for (const core::Verdict& v : state.decisions()[c].verdicts)
      all.emplace(Named(state.system().channels[c].subject, state.delivery_of(v)), &v);
  return all;
}

/// The admissions that a delivery depends on, without those of the description.
std::set<core::AdmissionId> admissions_of(const core::State& state, const core::Verdict& v) {
  std::set<core::AdmissionId> all{state.members().admission_of_publisher(v.publisher)};
  for (const std::size_t s : v.subscribers) all.insert(state.members().admission_of_subscriber(s));
  all.erase(0);
  return all;
}

}  // namespace

std::vector<std::string> lost_grants(const core::State& now, core::State& then,
                                     const std::function<bool(core::AdmissionId)>& is_own) {
  take_over_world(now, then);
  std::map<std::size_t, core::Grants> granted;
  for (std::size_t c = 0; c < now.decisions().size(); ++c) {
    const auto channel = then.find_channel(core::format_subject(now.system().channels[c].subject));
    if (channel && now.decisions()[c].granted != 0) granted.emplace(*channel, now.grants(c));
  }
  then.decide(granted);
  const auto after = by_names(then);
  std::vector<std::string> lost;
  for (const auto& [named, v] : by_names(now)) {
    if (!v->granted) continue;
    const core::EventChannel& channel = now.system().channels[v->channel];
    const std::string line =
        fmt::format("{} ({}) from {} to {}", channel.name, core::format_subject(channel.subject),
                    core::name_of(now.system(), now.members().publisher(v->publisher).place),
                    core::name_of(now.system(), v->to));
    const auto here = after.find(named);
    const bool has_place = std::ranges::all_of(admissions_of(now, *v), [&](core::AdmissionId id) {
      return !is_own(id) || then.admissions().contains(id);
    });
    if (!has_place)
      lost.push_back(line + ": the description has no place for what was admitted");
    else if (here != after.end() && !here->second->granted && is_certain(*here->second))
      lost.push_back(line + ": " + why(then, *here->second));
  }
  return lost;
}

}  // namespace mlcca
