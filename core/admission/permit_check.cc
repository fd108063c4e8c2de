// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/permit_check.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/admission/media.hpp"
#include "core/admission/permits.hpp"
#include "core/admission/route_check.hpp"
#include "core/can/of_system.hpp"

namespace mlcca::core {

std::optional<Place> unpermitted(const Situation& s, const Ledger& ledger, const Verdict& v,
                                 std::optional<std::uint64_t> without) {
  if (s.permits == nullptr) return std::nullopt;
  const auto hops = hops_of(v.route);
  for (std::size_t i = 0; i < hops.size(); ++i) {
    if (hops[i].kind != Place::Kind::network || !s.world.shared[hops[i].index]) continue;
    const Flow flow = flow_on(s.system, v.publisher, v.route, i);
    const auto paths = paths_on(s.system, s.members, v, i);
    const Permits::Use use{.network = hops[i].index,
                           .source = source_of(s.members, flow),
                           .bytes_per_second = v.demand,
                           .message = ledger.message_of(flow),
                           .paths = paths,
                           .elected = has_another_way(s.topology, s.members, v)};
    if (!s.permits->allow(use, without)) return hops[i];
  }
  return std::nullopt;
}

std::vector<AdmissionId> admissions_to_agree(const Members& members, const Verdict& v) {
  const AdmissionId publisher = members.admission_of_publisher(v.publisher);
  std::vector<AdmissionId> all;
  all.reserve(v.subscribers.size());
  for (const std::size_t subscriber : v.subscribers) {
    const AdmissionId id = members.admission_of_subscriber(subscriber);
    if (id == 0 && publisher == 0) return {};
    all.push_back(id == 0 ? publisher : id);
  }
  return all;
}

namespace {

/// Whether the delivery does not lead over this gateway, and another one has made an admission of
/// it. That one knows who has agreed.
bool is_left_to_another(const Situation& s, const Verdict& v) {
  if (std::ranges::find(v.route, Place{Place::Kind::gateway, s.permits->self()}) != v.route.end())
    return false;
  const auto is_left = [&s](AdmissionId id) { return s.permits->is_left_to_another(id); };
  return is_left(s.members.admission_of_publisher(v.publisher)) ||
         std::ranges::any_of(v.subscribers, [&](std::size_t subscriber) {
           return is_left(s.members.admission_of_subscriber(subscriber));
         });
}

/// The first other gateway on the route that has agreed to none of the admissions.
std::optional<Place> disagreeing(const Situation& s, const Verdict& v,
                                 const std::vector<AdmissionId>& admissions,
                                 std::optional<std::uint64_t> without) {
  const Permits& permits = *s.permits;
  std::optional<Place> first;
  for (const AdmissionId id : admissions) {
    const auto lacking = std::ranges::find_if(v.route, [&](Place place) {
      return place.kind == Place::Kind::gateway && place.index != permits.self() &&
             !permits.is_agreed(id, place.index, without);
    });
    if (lacking == v.route.end()) return std::nullopt;
    if (!first) first = *lacking;
  }
  return first;
}

}  // namespace

std::optional<std::pair<Obstacle, Place>> disagreement(const Situation& s, const Verdict& v,
                                                       std::optional<std::uint64_t> without) {
  if (s.permits == nullptr || !s.permits->needs_agreements()) return std::nullopt;
  const std::vector<AdmissionId> admissions = admissions_to_agree(s.members, v);
  const auto gateway = disagreeing(s, v, admissions, without);
  if (!gateway || is_left_to_another(s, v)) return std::nullopt;
  if (s.permits->is_open()) return std::pair(Obstacle::disagreed, *gateway);
  // Another gateway may carry it all the same: what is missing is the store.
  const auto shared = std::ranges::find_if(v.route, [&s](Place place) {
    return place.kind == Place::Kind::network && s.world.shared[place.index];
  });
  return shared == v.route.end() ? std::pair(Obstacle::disagreed, *gateway)
                                 : std::pair(Obstacle::cluster, *shared);
}

std::optional<std::pair<Obstacle, Place>> bar_on(const Wish& wish, std::span<const Place> hops) {
  for (const Place hop : hops) {
    if (hop.kind != Place::Kind::network) continue;
    const auto barred = wish.barred.find(hop.index);
    if (barred != wish.barred.end()) return std::pair(barred->second, hop);
  }
  return std::nullopt;
}

cluster::Source source_of(const Members& members, const Flow& flow) {
  const AdmissionId admission = members.admission_of_publisher(flow.publisher);
  return {
      .publisher = admission == 0 ? flow.publisher : 0, .admission = admission, .from = flow.from};
}

std::vector<cluster::PathPart> paths_on(const System& system, const Members& members,
                                        const Verdict& v, std::size_t hop) {
  const std::size_t network = hops_of(v.route)[hop].index;
  const Flow flow = flow_on(system, v.publisher, v.route, hop);
  const AttributeSet& offered = attributes_in(members.publisher(v.publisher), v.set);
  std::vector<cluster::PathPart> paths;
  for (const MediumUse& use : v.media)
    if (use.network == network)
      for (const auto& [from, to] : use.pairs)
        paths.push_back({.from = from,
                         .to = to,
                         .bytes_per_second = mesh_demand(offered, v.demand),
                         .event_bytes = mesh_event(offered),
                         .source = source_of(members, flow)});
  return paths;
}

cluster::BusPart bus_part_of(const System& system, const Members& members, const Flow& flow,
                             const can::Message& message) {
  const Publisher& publisher = members.publisher(flow.publisher);
  const Network& network = system.networks[flow.resource];
  cluster::BusPart part{.message = message,
                        .subject = system.channels[publisher.channel].subject,
                        .source = source_of(members, flow)};
  part.message.key = 0;
  const Binding* const binding = network.binding_of(publisher.channel);
  if (binding == nullptr) return part;
  if (const auto id = can::identifier_of(publisher, network, *binding, message.frames > 1)) {
    part.first_id = id->id;
    part.last_id = id->last;
    part.extended = id->extended;
  }
  return part;
}

bool has_another_way(const Topology& topology, const Members& members, const Verdict& v) {
  const auto& ways = topology.routes(members.publisher(v.publisher).place, v.to);
  for (std::size_t i = 1; i + 1 < v.route.size(); ++i) {
    const Place place = v.route[i];
    if (place.kind == Place::Kind::gateway && std::ranges::any_of(ways, [&](const Route& way) {
          return std::ranges::find(way, place) == way.end();
        }))
      return true;
  }
  return false;
}

}  // namespace mlcca::core
