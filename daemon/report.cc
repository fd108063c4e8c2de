// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/report.hpp"

#include <fmt/core.h>

#include "core/text.hpp"

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

}  // namespace

std::string why(const core::State& state, const core::Verdict& v) {
  const bool unavailable = v.obstacle == core::Obstacle::unavailable;
  return core::reason(
      state.system(), state.members(), v,
      unavailable ? state.world().conditions[v.obstacle_at.index].problem : std::string());
}

control::MediumUse medium_report(const core::State& state, const core::MediumUse& use) {
  control::MediumUse out;
  out.network = state.system().networks[use.network].name;
  out.response_ns = use.response;
  out.guaranteed_ns = use.guaranteed;
  // Others may have come or gone since it was decided.
  const auto* bus = state.ledger().schedule(use.network);
  if (const auto* message = bus != nullptr ? bus->find(use.key) : nullptr;
      message != nullptr && use.guaranteed != 0 && bus->response(use.key) >= message->jitter)
    out.response_ns = bus->response(use.key) - message->jitter;
  const auto& view = state.world().meshes[use.network];
  if (!view || use.links.empty()) return out;
  out.paper_rate = use.paper_rate;
  out.available = use.available;
  // The links may be others by now; the names of the domain and nodes are those of now.
  if (use.limiting_domain < view->domains().count())
    out.limiting_domain = view->domain_name(use.limiting_domain);
  for (const auto& [from, to] : use.hops) {
    if (out.nodes.empty()) out.nodes.push_back(view->node_name(from));
    out.nodes.push_back(view->node_name(to));
  }
  return out;
}

control::Channel channel_report(const core::State& state, const core::Verdict& v, Frames frames) {
  const core::System& system = state.system();
  const core::Members& members = state.members();
  const core::EventChannel& channel = system.channels[v.channel];
  const core::Publisher& publisher = members.publisher(v.publisher);
  control::Channel out;
  out.subject = channel.subject;
  out.name = channel.name;
  out.description = channel.description;
  out.publisher = publisher.name;
  out.from = core::name_of(system, publisher.place);
  out.to = core::name_of(system, v.to);
  out.admission = members.admission_of_publisher(v.publisher);
  for (const std::size_t s : v.subscribers) {
    out.subscribers.push_back(members.subscriber(s).name);
    if (out.admission == 0) out.admission = members.admission_of_subscriber(s);
  }
  out.granted = v.granted;
  out.set = static_cast<std::uint32_t>(v.set);
  out.sets = static_cast<std::uint32_t>(core::sets_of(system, v.channel));
  out.importance = channel.importance;
  for (const core::MediumUse& use : v.media) out.media.push_back(medium_report(state, use));
  out.reason = why(state, v);
  for (const core::Place place : v.route) out.route.push_back(core::name_of(system, place));
  for (const core::Row& row : v.rows) {
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
  out.passed = frames.passed;
  out.dropped = frames.dropped;
  return out;
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
  return fmt::format("{} ({}) switched from attribute set {} to {} of {}, from {} to {}: {}",
                     channel.name, core::format_subject(channel.subject), former_set + 1, v.set + 1,
                     core::sets_of(system, v.channel),
                     core::name_of(system, state.members().publisher(v.publisher).place),
                     core::name_of(system, v.to), why(state, v));
}

}  // namespace mlcca
