// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/usage.hpp"

#include <algorithm>
#include <utility>

namespace mlcca::core {
namespace {

void note(const System& system, std::vector<std::size_t>& resources, const Route& route) {
  for (const Place hop : hops_of(route)) {
    const std::size_t resource = system.resource_of(hop);
    if (std::ranges::find(resources, resource) == resources.end()) resources.push_back(resource);
  }
}

void note_pairs(std::vector<std::pair<std::size_t, std::uint64_t>>& pairs,
                const std::vector<MediumUse>& media) {
  for (const MediumUse& use : media)
    for (const auto& [from, to] : use.pairs) {
      const std::pair entry(use.network, std::uint64_t{from} << 32U | to);
      if (std::ranges::find(pairs, entry) == pairs.end()) pairs.push_back(entry);
    }
}

}  // namespace

void Usage::forget(std::size_t channel) {
  OfChannel& old = of_channel_[channel];
  for (const std::size_t r : old.carried) carried_[r].erase(channel);
  for (const std::size_t r : old.waiting) waiting_[r].erase(channel);
  for (const auto& [n, pair] : old.pairs) {
    const auto it = pairs_[n].find(pair);
    it->second.erase(channel);
    if (it->second.empty()) pairs_[n].erase(it);
  }
  if (std::exchange(old.detour, false)) detours_.erase(channel);
  granted_ -= std::exchange(old.granted, 0);
  refused_ -= std::exchange(old.refused, 0);
  old.carried.clear();
  old.waiting.clear();
  old.pairs.clear();
}

Usage::OfChannel Usage::use_of(const Situation& s, const Decision& decision) {
  OfChannel out;
  const bool best = decision.all_granted() && decision.set == 0;
  for (const Verdict& v : decision.verdicts) {
    ++(v.granted ? out.granted : out.refused);
    if (v.granted) {
      note(s.system, out.carried, v.route);
      note_pairs(out.pairs, v.media);
    }
    const auto& routes = s.topology.routes(s.members.publisher(v.publisher).place, v.to);
    if (v.granted && !routes.empty() && v.route != routes.front()) out.detour = true;
    if (best) continue;
    for (const Route& route : routes) note(s.system, out.waiting, route);
  }
  return out;
}

void Usage::set(const Situation& s, std::size_t channel, const Decision& decision) {
  OfChannel now = use_of(s, decision);
  if (now == of_channel_[channel]) return;
  forget(channel);
  for (const std::size_t r : now.carried) carried_[r].insert(channel);
  for (const std::size_t r : now.waiting) waiting_[r].insert(channel);
  for (const auto& [n, pair] : now.pairs) pairs_[n][pair].insert(channel);
  if (now.detour) detours_.insert(channel);
  granted_ += now.granted;
  refused_ += now.refused;
  of_channel_[channel] = std::move(now);
}

}  // namespace mlcca::core
