// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <unordered_map>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/admission/media.hpp"
#include "core/model/text.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

control::Outcome outcome_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::fit:
      return control::Outcome::fit;
    case Outcome::unfit:
      return control::Outcome::unfit;
    case Outcome::run_time:
      return control::Outcome::run_time;
  }
  return control::Outcome::unfit;
}

/// The indices of the comparisons that are listed, in their order. If there are too many, those
/// that do not fit have precedence.
std::vector<std::size_t> listed_rows(const core::Verdict& v) {
  const std::vector<core::Row>& rows = v.rows;
  std::vector<std::size_t> listed;
  const auto is_listed = [&](const core::Row& row) {
    if (core::is_unknown_for_lateness(v, row)) return false;
    return row.against != core::Against::hop || !core::is_said_by_another(v, row);
  };
  const auto add = [&](bool fit) {
    for (std::size_t i = 0; i < rows.size() && listed.size() < control::Channel::kMostRows; ++i)
      if ((rows[i].comparison.outcome == Outcome::fit) == fit && is_listed(rows[i]))
        listed.push_back(i);
  };
  add(false);
  add(true);
  std::ranges::sort(listed);
  return listed;
}

/// The margin of the comparison that decided; nullopt if the reason is about no comparison.
std::optional<control::Margin> margin_report(const core::State& state, const core::Verdict& v) {
  if (v.obstacle != core::Obstacle::none) return std::nullopt;
  const core::Row* const row = core::deciding_row(v);
  if (row == nullptr) return std::nullopt;
  const core::System& system = state.system();
  const Comparison& c = row->comparison;
  const bool is_bounded = c.required != kUnbounded && c.provided != kUnbounded;
  return control::Margin{.where = core::where(system, state.members(), v, *row),
                         .attribute = core::attribute_name(system, *row),
                         .unit = core::unit_name(system, *row),
                         .outcome = outcome_of(c.outcome),
                         .amount_known = c.known,
                         .amount = is_bounded ? c.margin() : kUnbounded,
                         .words = core::format_margin(system, *row)};
}

/// Adds the rates of a path through a mesh, with its present links and reservations.
void add_rates(const core::State& state, const core::Verdict& v, const core::MediumUse& use,
               Own own, control::MediumUse& out) {
  const core::MeshView& view = *state.world().meshes[use.network];
  std::unordered_map<std::size_t, Value> of_its_own;  // by domain
  if (own == Own::is_available)
    for (const core::Holding& h : state.ledger().holdings_of(v.publisher)) {
      if (h.resource != use.network || !h.mesh) continue;
      for (const core::mesh::Share& share : h.mesh->shares) of_its_own[share.domain] += share.time;
    }
  const auto held = [&](std::size_t domain) {
    const auto known = of_its_own.find(domain);
    return known == of_its_own.end() ? Value{0} : known->second;
  };
  const auto taken = [&](std::size_t domain) {
    return add_saturating(state.ledger().medium_time(use.network, domain) - held(domain),
                          view.background[domain]);
  };
  const core::Publisher& publisher = state.members().publisher(v.publisher);
  const Value event = core::mesh_event(core::attributes_in(publisher, v.set));
  out.path_rate = out.available = kUnbounded;
  std::size_t longest = 0;
  for (const auto& [from, to] : use.pairs) {
    const auto& path = view.path(from, to);
    const auto rate =
        path.empty() ? core::mesh::RouteRate{} : view.cost(from, to).evaluate(event, taken);
    out.path_rate = std::min(out.path_rate, rate.paper);
    if (rate.available < out.available) {
      out.available = rate.available;
      out.limited_by = path.empty() ? "" : view.domain_name(rate.limiting_domain);
    }
    if (path.size() <= longest) continue;
    longest = path.size();
    out.path = {view.node_name(view.graph.links[path.front()].from)};
    for (const std::uint32_t link : path)
      out.path.push_back(view.node_name(view.graph.links[link].to));
  }
}

}  // namespace

std::string why(const core::State& state, const core::Verdict& v) {
  std::string problem;
  if (v.obstacle == core::Obstacle::unavailable)
    problem = state.world().conditions[v.obstacle_at.index].problem;
  if (v.obstacle == core::Obstacle::contradicted)
    if (const auto* found =
            state.world().conditions[v.obstacle_at.index].contradiction_of(v.channel))
      problem = found->how;
  if (std::string objection = state.held_by_others().objection_to(v); !objection.empty())
    problem = std::move(objection);
  return core::reason(state.system(), state.members(), v, problem) +
         state.held_by_others().of_refusal(v);
}

control::MediumUse medium_report(const core::State& state, const core::Verdict& v,
                                 const core::MediumUse& use, Own own) {
  control::MediumUse out;
  out.network = state.system().networks[use.network].name;
  out.response_ns = use.response;
  out.guaranteed_ns = use.guaranteed;
  // Other messages may have been admitted or released since the decision.
  const auto* bus = state.ledger().schedule(use.network);
  if (const auto* message = bus != nullptr ? bus->find(use.key) : nullptr;
      message != nullptr && use.guaranteed != 0 && bus->response(use.key) >= message->jitter)
    out.response_ns = bus->response(use.key) - message->jitter;
  if (state.world().meshes[use.network] && !use.pairs.empty()) add_rates(state, v, use, own, out);
  return out;
}

control::Channel described_row(const core::EventChannel& channel) {
  control::Channel out;
  out.subject = channel.subject;
  out.name = channel.name;
  out.description = channel.description;
  out.importance = channel.importance;
  return out;
}

control::Channel delivery_report(const core::State& state, const core::Verdict& v) {
  const core::System& system = state.system();
  const core::Members& members = state.members();
  const core::Publisher& publisher = members.publisher(v.publisher);
  control::Channel out = described_row(system.channels[v.channel]);
  out.publisher = publisher.name;
  out.from = core::name_of(system, publisher.place);
  out.to = core::name_of(system, v.to);
  for (const std::size_t s : v.subscribers) {
    if (out.subscribers.size() < control::Channel::kMostSubscribers)
      out.subscribers.push_back(members.subscriber(s).name);
    else
      ++out.subscribers_left_out;
  }
  out.set = static_cast<std::uint32_t>(v.set);
  out.sets = static_cast<std::uint32_t>(core::sets_of(system, v.channel));
  for (const core::Place place : v.route) out.route.push_back(core::name_of(system, place));
  return out;
}

control::Channel channel_report(const core::State& state, const core::Verdict& v,
                                const Frames& frames) {
  const core::System& system = state.system();
  const core::Members& members = state.members();
  control::Channel out = delivery_report(state, v);
  out.admission = members.admission_of_publisher(v.publisher);
  for (const std::size_t s : v.subscribers)
    if (out.admission == 0) out.admission = members.admission_of_subscriber(s);
  out.granted = v.granted;
  out.sporadic = v.sporadic;
  out.withdrawn = v.obstacle == core::Obstacle::withdrawn;
  for (const core::MediumUse& use : v.media)
    out.media.push_back(medium_report(state, v, use, Own::is_available));
  out.reason = why(state, v);
  out.margin = margin_report(state, v);
  const auto rows = listed_rows(v);
  out.rows_left_out = static_cast<std::uint32_t>(v.rows.size() - rows.size());
  for (const std::size_t at : rows) {
    const core::Row& row = v.rows[at];
    out.rows.push_back({.where = core::where(system, members, v, row),
                        .attribute = core::attribute_name(system, row),
                        .unit = core::unit_name(system, row),
                        .required = row.comparison.required,
                        .provided_known = row.comparison.known,
                        .provided = row.comparison.provided,
                        .dynamic = row.comparison.dynamic,
                        .outcome = outcome_of(row.comparison.outcome),
                        .margin = core::format_margin(system, row)});
  }
  if (v.granted) out.reaction = core::reaction(v);
  // Without a route, the counters are those of all frames that come in from the publisher.
  out.passed = v.granted || !v.route.empty() ? frames.passed : 0;
  out.dropped = frames.dropped;
  out.would_drop = frames.would_drop;
  out.excess = frames.excess;
  out.would_exceed = frames.would_exceed;
  return out;
}

void set_not_supervised(control::Channel& channel, std::string why) {
  channel.not_supervised = std::move(why);
  if (!channel.not_supervised.empty() && !channel.reaction.empty())
    channel.reaction = "not known: " + channel.not_supervised;
}

control::Network network_report(const core::State& state, std::size_t index) {
  const core::System& system = state.system();
  const core::Network& network = system.networks[index];
  control::Network out;
  out.name = network.name;
  out.kind = core::to_text(network.kind);
  out.profile = core::to_text(network.profile);
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (network.provision.has(a))
      out.provision.push_back(
          {info(a).name, network.provision[a], info(a).unit, network.provision.is_dynamic(a)});
  }
  out.capacity_known = network.provision.has(Attribute::bandwidth);
  out.capacity = network.provision[Attribute::bandwidth];
  out.reserved = state.ledger().reserved(index);
  out.described_bitrate = network.bus.bitrate;
  out.described_data_bitrate = network.bus.data_bitrate;
  out.available = state.world().conditions[index].available;
  out.problem = state.world().conditions[index].problem;
  for (const core::Gateway& gateway : system.gateways)
    if (gateway.port_on(index) != nullptr) out.gateways.push_back(gateway.name);
  return out;
}

std::string verdict_line(const core::State& state, const core::Verdict& v) {
  const core::System& system = state.system();
  const core::EventChannel& channel = system.channels[v.channel];
  const core::Publisher& publisher = state.members().publisher(v.publisher);
  return fmt::format("{} ({}) {} from {} to {}: {}", channel.name,
                     core::format_subject(channel.subject), v.granted ? "granted" : "refused",
                     core::name_of(system, publisher.place), core::name_of(system, v.to),
                     why(state, v));
}

std::string switch_line(const core::State& state, const core::Verdict& v, std::size_t former_set) {
  const core::System& system = state.system();
  const core::EventChannel& channel = system.channels[v.channel];
  return fmt::format("{} ({}) {} from attribute set {} to {} of {}, from {} to {}: {}",
                     channel.name, core::format_subject(channel.subject),
                     v.set > former_set ? "degraded" : "upgraded", former_set + 1, v.set + 1,
                     core::sets_of(system, v.channel),
                     core::name_of(system, state.members().publisher(v.publisher).place),
                     core::name_of(system, v.to), why(state, v));
}

std::string reroute_line(const core::State& state, const core::Verdict& v,
                         const core::Route& former_route) {
  const core::System& system = state.system();
  const core::EventChannel& channel = system.channels[v.channel];
  const auto names = [&system](const core::Route& route) {
    std::string out;
    for (const core::Place hop : core::hops_of(route))
      out += (out.empty() ? "" : ", ") + core::name_of(system, hop);
    return out;
  };
  return fmt::format("{} ({}) takes another route from {} to {}: {} instead of {}: {}",
                     channel.name, core::format_subject(channel.subject),
                     core::name_of(system, state.members().publisher(v.publisher).place),
                     core::name_of(system, v.to), names(v.route), names(former_route),
                     why(state, v));
}

}  // namespace mlcca
