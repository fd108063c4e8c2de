// SPDX-License-Identifier: BSD-2-Clause
#include "core/mesh/evaluation.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/mesh/route.hpp"
#include "mlcca/arithmetic.hpp"
#include "mlcca/compose.hpp"

namespace mlcca::core::mesh {
namespace {

constexpr Value kBitsPerByte = 8;

/// The packets of an event for composition; 0 (which composition treats as the worst) if there are
/// more than it can count.
std::uint16_t packets_of(const Mesh& mesh, Value event_bytes) {
  const Value packets = std::max<Value>(
      div_up(reckoned_event(mesh, event_bytes), std::max<Value>(mesh.packet_bytes, 1)), 1);
  return packets > std::numeric_limits<std::uint16_t>::max() ? std::uint16_t{0}
                                                             : static_cast<std::uint16_t>(packets);
}

/// What a link provides: Mesh::per_hop with the worse of stated and measured loss.
AttributeSet given_by(const LinkQuality& link, const AttributeSet& per_hop) {
  AttributeSet given = per_hop;
  constexpr Attribute loss = Attribute::packet_loss;
  if (link.loss_known)
    given.set(loss, std::max(link.loss, per_hop[loss]), per_hop.is_dynamic(loss));
  return given;
}

}  // namespace

PathCost::PathCost(const Graph& graph, const Mesh& mesh, const Domains& domains,
                   std::span<const std::uint32_t> path)
    : path_(path.begin(), path.end()) {
  packets_.limit = mesh.limit;
  packets_.packet_bytes = mesh.packet_bytes;
  packets_.header_bytes = mesh.header_bytes;
  packets_.packet_time = mesh.packet_time;
  std::vector<Value> rates;
  std::vector<std::pair<std::uint32_t, Mask>> members;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const LinkQuality& quality = graph.links[path[i]].quality;
    qualities_.push_back(quality);
    rates.push_back(quality.rate);
    for (const std::uint32_t domain : domains.of_link(path[i]))
      members.emplace_back(domain, Mask{1} << i);
  }
  paper_ = paper_rate(rates) / kBitsPerByte;
  std::ranges::sort(members);
  for (auto it = members.begin(); it != members.end();) {
    const std::uint32_t domain = it->first;
    Mask mask = 0;
    for (; it != members.end() && it->first == domain; ++it) mask |= it->second;
    const auto group = std::ranges::find(groups_, mask);
    touched_.push_back({domain, static_cast<std::uint32_t>(group - groups_.begin())});
    if (group == groups_.end()) groups_.push_back(mask);
  }
}

std::vector<Value> PathCost::group_times(Value event_bytes) const {
  std::vector<Value> link_times;
  link_times.reserve(qualities_.size());
  for (const LinkQuality& quality : qualities_)
    link_times.push_back(event_time(quality, packets_, event_bytes));
  std::vector<Value> times;
  times.reserve(groups_.size());
  for (const Mask mask : groups_) {
    Value time = 0;
    for (std::size_t i = 0; i < link_times.size(); ++i)
      if (((mask >> i) & 1U) != 0) time = add_saturating(time, link_times[i]);
    times.push_back(time);
  }
  return times;
}

RouteRate PathCost::evaluate(Value event_bytes, const Taken& taken) const {
  RouteRate result;
  if (path_.empty()) return result;
  result.paper = paper_;
  result.available = kUnbounded;
  const Value event = reckoned_event(packets_, event_bytes);
  const auto times = group_times(event);
  // Among domains that take the same time, only the one with the least time left can be the limit.
  struct Fullest {
    Value taken = 0;
    std::uint32_t domain = 0;
    bool known = false;
  };
  std::vector<Fullest> fullest(groups_.size());
  for (const Touched& touched : touched_) {
    Fullest& most = fullest[touched.group];
    const Value here = taken(touched.domain);
    if (!most.known || here > most.taken) most = {here, touched.domain, true};
  }
  for (std::size_t group = 0; group < groups_.size(); ++group) {
    const Value room = sub_floor(limit_of(packets_), fullest[group].taken);
    const Value rate = times[group] == kUnbounded ? 0 : mul_div_down(room, event, times[group]);
    if (rate >= result.available) continue;
    result.available = rate;
    result.limiting_domain = fullest[group].domain;
  }
  return result;
}

std::vector<Share> PathCost::shares(Value bytes_per_second, Value event_bytes) const {
  const Value event = reckoned_event(packets_, event_bytes);
  auto times = group_times(event);
  for (Value& time : times)
    time = time == kUnbounded ? kUnbounded : mul_div_up(bytes_per_second, time, event);
  std::vector<Share> result;
  result.reserve(touched_.size());
  for (const Touched& touched : touched_) result.push_back({touched.domain, times[touched.group]});
  return result;
}

RouteRate evaluate(const Graph& graph, const Mesh& mesh, const Domains& domains,
                   std::span<const std::uint32_t> path, Value event_bytes, const Taken& taken) {
  RouteRate result = PathCost(graph, mesh, domains, path).evaluate(event_bytes, taken);
  result.links.assign(path.begin(), path.end());
  return result;
}

std::vector<Share> shares(const Graph& graph, const Mesh& mesh, const Domains& domains,
                          std::span<const std::uint32_t> path, Value bytes_per_second,
                          Value event_bytes) {
  return PathCost(graph, mesh, domains, path).shares(bytes_per_second, event_bytes);
}

AttributeSet composed_per_hop(const Graph& graph, const Mesh& mesh,
                              std::span<const std::uint32_t> path, Value event_bytes) {
  const auto is_known = [&](std::uint32_t link) { return graph.links[link].quality.loss_known; };
  if (mesh.per_hop == AttributeSet{} && std::ranges::none_of(path, is_known)) return {};
  std::vector<Hop> hops;
  hops.reserve(path.size());
  for (const std::uint32_t link : path)
    hops.push_back({.provision = given_by(graph.links[link].quality, mesh.per_hop),
                    .medium = static_cast<std::uint16_t>(hops.size()),
                    .frames = packets_of(mesh, event_bytes)});
  // Composition takes at most kMaxComposedHops hops. A group of hops provides what its events get
  // as a unit, so each group counts as a hop with one frame.
  if (hops.empty()) return {};
  do {
    std::vector<Hop> parts;
    for (std::size_t i = 0; i < hops.size(); i += kMaxComposedHops)
      parts.push_back({.provision = compose(&hops[i], std::min(hops.size() - i, kMaxComposedHops)),
                       .medium = static_cast<std::uint16_t>(parts.size())});
    hops = std::move(parts);
  } while (hops.size() > 1);
  return hops[0].provision;
}

AttributeSet best_per_hop(const Mesh& mesh, Value event_bytes) {
  const LinkQuality lossless{.loss = 0, .loss_known = true};
  const Hop link{.provision = given_by(lossless, mesh.per_hop),
                 .medium = 0,
                 .frames = packets_of(mesh, event_bytes)};
  return compose(&link, 1);
}

}  // namespace mlcca::core::mesh
