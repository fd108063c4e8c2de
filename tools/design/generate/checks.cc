// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/generate/checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <span>
#include <utility>

#include "core/design/inspect.hpp"
#include "core/model/user_values.hpp"
#include "mlcca/check.hpp"

namespace mlcca::tools::design {
namespace {

using core::FindingId;

std::vector<RouteHop> hops_of(const core::Verdict& verdict) {
  std::vector<RouteHop> out;
  if (verdict.hops.empty()) return out;
  const auto places = core::hops_of(verdict.route);
  for (std::size_t i = 0; i < verdict.hops.size(); ++i) {
    const bool late =
        !verdict.granted && std::ranges::any_of(verdict.rows, [&](const core::Row& row) {
          return row.against == core::Against::schedule && row.place == places[i] &&
                 core::is_unfit(row);
        });
    const bool left =
        !verdict.granted && std::ranges::any_of(verdict.rows, [&](const core::Row& row) {
          return row.against == core::Against::medium_time && row.place == places[i] &&
                 core::is_unfit(row) &&
                 row.comparison.provided == verdict.hops[i].provision[Attribute::bandwidth];
        });
    out.push_back({places[i], verdict.hops[i], verdict.granted, late, left});
  }
  return out;
}

bool is_of_one_pair(FindingId id) {
  return id == FindingId::traffic_mismatch || id == FindingId::hop_unfit ||
         id == FindingId::route_unfit;
}

/// As check_user() in mlcca/user_check.hpp.
bool is_user_refused(const core::System& system, const core::UserValues& asked,
                     const std::vector<core::UserHop>& hops) {
  const std::span<const core::UserHop> all(hops);
  const auto fails = [&](const core::UserValue& value, std::span<const core::UserHop> over) {
    return core::compare(system, value, core::composed(system, over)).outcome == Outcome::unfit;
  };
  return std::ranges::any_of(asked, [&](const core::UserValue& value) {
    for (std::size_t i = 0; i < hops.size(); ++i) {
      const bool stated =
          std::ranges::find(*hops[i].provision, value.attribute, &core::UserValue::attribute) !=
          hops[i].provision->end();
      const auto composition = system.user_attributes[value.attribute].composition;
      Value none = 0;
      if (hops[i].gateway && !stated && unlimited_by_gateway(composition, &none)) continue;
      if (fails(value, all.subspan(i, 1))) return true;
    }
    return fails(value, all);
  });
}

}  // namespace

Decisions::Decisions(const core::System& system)
    : members_(system), sets_(system.channels.size(), 0), errors_(system.channels.size()) {
  const auto keep = [this](std::size_t channel, const core::Decision& decision,
                           std::span<const core::Finding> errors) {
    const auto kept =
        std::make_shared<const std::vector<core::Finding>>(errors.begin(), errors.end());
    if (errors_[channel] == nullptr) {
      errors_[channel] = kept;
      sets_[channel] = decision.set;
    }
    for (const core::Verdict& v : decision.verdicts)
      // A delivery that is granted only while others are not is decided at run time, so it counts
      // as not refused.
      deliveries_[{v.publisher, v.to, decision.set}] = {
          hops_of(v), v.granted || v.outcome == Outcome::run_time, kept};
  };
  for (const core::ChannelResult& result : core::inspect(system, {}, keep).channels)
    open_sets_.push_back(result.open_set);
}

std::vector<Pair> pairs_of(const core::System& system, const core::Members& members,
                           const Unit& unit) {
  std::vector<Pair> out;
  std::set<std::pair<der::Role, std::size_t>> own_ends;
  for (const End end : unit.ends) own_ends.emplace(end.role, end.index);
  for (const auto own : unit.ends) {
    const bool publishes = own.role == der::Role::publisher;
    const auto role = publishes ? der::Role::subscriber : der::Role::publisher;
    const std::size_t channel = channel_of(system, own);
    const auto& others =
        publishes ? members.subscribers_of(channel) : members.publishers_of(channel);
    for (const std::size_t i : others) {
      const End other{role, i};
      // A pair within the unit is added only from the publisher's side.
      if (!publishes && own_ends.contains({role, i})) continue;
      out.push_back(publishes ? Pair{own, other} : Pair{other, own});
    }
    if (others.empty()) out.push_back(publishes ? Pair{own, {}} : Pair{{}, own});
  }
  return out;
}

bool is_refused_by_types(const core::System& system, std::size_t publisher, std::size_t subscriber,
                         std::size_t set, const std::vector<RouteHop>& hops) {
  const auto& p = system.publishers[publisher];
  const auto& s = system.subscribers[subscriber];
  const AttributeSet& offered = core::attributes_in(p, set);
  const AttributeSet& asked = core::attributes_in(s, set);
  if (check_traffic(offered, asked).outcome == Outcome::unfit) return true;
  if (hops.empty()) return false;
  const AttributeSet both = requirement_between(offered, asked);
  std::vector<Hop> way;
  std::vector<core::UserHop> users;
  for (const auto& hop : hops) {
    way.push_back(hop.gives);
    if (check_hop(both, hop.gives).outcome == Outcome::unfit) return true;
    users.push_back({hop.gives.gateway ? &system.gateways[hop.place.index].user
                                       : &system.networks[hop.place.index].user,
                     hop.gives.gateway, hop.gives.frames});
  }
  if (check_route(both, way.data(), way.size(), offered[Attribute::jitter]).outcome ==
      Outcome::unfit)
    return true;
  return is_user_refused(system, core::user_values_in(p, set), users) ||
         is_user_refused(system, core::user_values_in(s, set), users);
}

std::string refusal_of(const core::System& system, const std::vector<core::Finding>& errors,
                       std::size_t publisher, std::size_t subscriber) {
  const auto concerns = [&](const core::Finding& f) {
    if (f.publisher != core::kNone && f.publisher != publisher) return false;
    return f.subscriber == core::kNone ||
           system.subscribers[f.subscriber].place == system.subscribers[subscriber].place;
  };
  const core::Finding* found = nullptr;
  for (const auto& f : errors) {
    if (!concerns(f)) continue;
    // A reason that the compile-time checks of the pair cannot find is the better explanation.
    if (found == nullptr || (is_of_one_pair(found->id) && !is_of_one_pair(f.id))) found = &f;
  }
  if (found == nullptr)
    return fmt::format("mlccactl check refuses {}", system.publishers[publisher].name);
  return fmt::format("{}: {}", core::code_of(found->id), found->text);
}

}  // namespace mlcca::tools::design
