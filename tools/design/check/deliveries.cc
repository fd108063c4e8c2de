// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/deliveries.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/admission/route_check.hpp"
#include "core/design/room.hpp"
#include "core/model/text.hpp"

namespace mlcca::tools::design {
namespace {

using core::Against;
using core::Obstacle;

constexpr std::size_t kMostNamed = 4;

std::string subscribers_of(const core::Members& members, const core::Verdict& v) {
  std::string out;
  const std::size_t all = v.subscribers.size();
  const std::size_t named = all > kMostNamed ? kMostNamed - 1 : all;
  for (std::size_t i = 0; i < named; ++i)
    out += (i == 0 ? "" : ", ") + members.subscriber(v.subscribers[i]).name;
  return named == all ? out : fmt::format("{} and {} more", out, all - named);
}

/// Whether the obstacle is at a place of the route.
bool has_place(Obstacle obstacle) {
  switch (obstacle) {
    case Obstacle::none:
    case Obstacle::no_route:
    case Obstacle::no_traffic:
    case Obstacle::withdrawn:
    case Obstacle::unlisted:
      return false;
    default:
      return true;
  }
}

/// Whether the row states that the place itself, as a hop, does not fit.
bool blames(const core::Row& row, core::Place place) {
  if (row.place != place || !is_unfit(row)) return false;
  return row.against == Against::hop || row.against == Against::capacity ||
         row.against == Against::schedule || row.against == Against::medium_time;
}

std::optional<core::Place> refused_at(const core::Verdict& v) {
  for (const core::Place place : v.route) {
    if (has_place(v.obstacle) && v.obstacle_at == place) return place;
    if (std::ranges::any_of(v.rows, [&](const auto& row) { return blames(row, place); }))
      return place;
  }
  return std::nullopt;
}

void add_margin(const core::System& system, const core::Members& members, const core::Verdict& v,
                ReportedDelivery& to) {
  const core::Row* const row = v.granted ? core::deciding_row(v) : nullptr;
  const core::Row* const room = core::want_of_room(v);
  if (v.outcome == Outcome::run_time && !v.granted && room != nullptr) {
    to.margin = core::open_room_words(system, *room);
    return;
  }
  if (row == nullptr) {
    to.margin = core::reason(system, members, v);
    return;
  }
  to.margin = fmt::format("{}, {}: {}", core::attribute_name(system, *row),
                          core::where(system, members, v, *row), core::format_margin(system, *row));
  to.share = core::slack(row->comparison);
}

/// Whether the message consists of the frames of the delivery on that bus.
bool is_on_its_way(const core::System& system, const core::BusMessage& m,
                   const ReportedDelivery& d) {
  if (!m.held || m.publisher != d.publisher_number) return false;
  const auto hops = core::hops_of(d.route);
  for (std::size_t hop = 0; hop < hops.size(); ++hop)
    if (hops[hop] == core::Place{core::Place::Kind::network, m.network} &&
        core::flow_on(system, d.publisher_number, d.route, hop).from == m.from)
      return true;
  return false;
}

}  // namespace

ReportedDelivery in_words(const core::System& system, const core::Members& members,
                          const core::Verdict& v) {
  ReportedDelivery out;
  out.channel = v.channel;
  out.publisher_number = v.publisher;
  out.publisher = members.publisher(v.publisher).name;
  out.subscribers = subscribers_of(members, v);
  out.outcome = v.outcome;
  out.set = v.set;
  out.from = members.publisher(v.publisher).place;
  out.to = v.to;
  out.route = v.route;
  if (v.outcome == Outcome::unfit) out.refused_at = refused_at(v);
  add_margin(system, members, v, out);
  if (v.outcome == Outcome::unfit) return out;
  const std::string reaction = core::reaction(v);
  const auto equals = reaction.find(" = ");
  if (equals == std::string::npos) return out;
  out.reaction = reaction.substr(0, equals);
  out.reaction_terms = reaction.substr(equals + 3);
  return out;
}

void consider(const core::System& system, std::span<const core::SentMessage* const> messages,
              ReportedDelivery& delivery) {
  if (delivery.outcome == Outcome::unfit) return;
  for (const core::SentMessage* const sent : messages) {
    const core::BusMessage& m = *sent->message;
    if (!is_on_its_way(system, m, delivery)) continue;
    const std::string& bus = system.networks[m.network].name;
    if (!sent->response.meets(m.sent->deadline)) {
      delivery.share = 0;
      delivery.margin = fmt::format(
          "Deadline, response times on {}: in time only while what is refused there is silent",
          bus);
      return;
    }
    Comparison c;
    c.attribute = Attribute::deadline;
    c.outcome = Outcome::fit;
    c.known = true;
    c.required = m.sent->deadline;
    c.provided = sent->response.response;
    const Value share = core::slack(c);
    if (share >= delivery.share) continue;
    delivery.share = share;
    delivery.margin =
        fmt::format("Deadline, response times on {}: {}", bus, core::format_margin(c));
  }
}

}  // namespace mlcca::tools::design
