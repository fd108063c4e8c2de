// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/baseline.hpp"

#include <algorithm>
#include <map>

#include "core/admission/permit_check.hpp"
#include "core/admission/route_check.hpp"
#include "core/admission/state.hpp"

namespace mlcca::core::cluster {
namespace {

/// Adds what one granted delivery needs of shared networks.
void take(const State& state, const Verdict& v, std::map<Flow, Standing>& all) {
  const System& system = state.system();
  const bool elected = has_another_way(state.topology(), state.members(), v);
  const auto hops = hops_of(v.route);
  for (std::size_t i = 0; i < hops.size(); ++i) {
    if (hops[i].kind != Place::Kind::network || !state.world().shared[hops[i].index]) continue;
    const Flow flow = flow_on(system, v.publisher, v.route, i);
    const auto [it, fresh] = all.try_emplace(flow);
    Standing& standing = it->second;
    if (fresh) {
      standing.flow = flow;
      standing.bytes_per_second = state.ledger().find(flow)->bytes_per_second;
      const can::Schedule* const bus = state.ledger().schedule(flow.resource);
      if (const auto* m = bus != nullptr ? bus->find(Ledger::key_of(flow)) : nullptr) {
        standing.message = *m;
        standing.message->key = 0;
      }
    }
    standing.elected = elected && (fresh || standing.elected);
    for (const PathPart& path : paths_on(system, state.members(), v, i))
      if (std::ranges::find(standing.paths, path) == standing.paths.end())
        standing.paths.push_back(path);
  }
}

}  // namespace

Baseline::Baseline(const System& system) : standing_(system.networks.size()) {
  State state(system);
  const World described = described_world(system);
  for (std::size_t n = 0; n < system.networks.size(); ++n)
    if (described.meshes[n]) state.set_graph(n, described.meshes[n]->graph);
  // All is decided from nothing, so that the result depends on the description alone.
  state.decide();
  std::map<Flow, Standing> all;
  for (const Decision& decision : state.decisions())
    for (const Verdict& v : decision.verdicts)
      if (v.granted) take(state, v, all);
  for (auto& [flow, standing] : all) standing_[flow.resource].push_back(std::move(standing));
}

const Standing* Baseline::find(const Flow& flow) const {
  const auto& all = standing_[flow.resource];
  const auto it = std::ranges::lower_bound(all, flow, {}, &Standing::flow);
  return it != all.end() && it->flow == flow ? &*it : nullptr;
}

}  // namespace mlcca::core::cluster
