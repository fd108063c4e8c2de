// SPDX-License-Identifier: BSD-2-Clause
// What clients want to know, one handle() for each kind of request. Nothing here changes anything.
#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "control/version.hpp"
#include "core/text.hpp"
#include "daemon/clock.hpp"
#include "daemon/gate_report.hpp"
#include "daemon/gateway.hpp"
#include "daemon/outlook.hpp"
#include "daemon/report.hpp"
#include "daemon/reservations.hpp"

namespace mlcca {
namespace {

control::Error error(control::ErrorKind kind, std::string message) {
  return {kind, std::move(message), {}};
}

}  // namespace

Gateway::Body Gateway::handle(const control::StatusRequest&) {
  control::Status s;
  s.version = kVersion;
  s.gateway = state_->system().gateways[self_].name;
  s.system = state_->system().name;
  s.description_file = options_.description;
  s.mode = mode_name();
  s.open = control_.is_open() && !control_.lapsed();
  s.grace_ns = control_.grace();
  s.lapses = control_.lapses();
  for (const core::Decision& decision : state_->decisions())
    for (const core::Verdict& v : decision.verdicts)
      ++(v.granted ? s.channels_granted : s.channels_refused);
  s.started_unix_s = static_cast<std::uint64_t>(started_);
  s.loaded_unix_s = static_cast<std::uint64_t>(loaded_);
  s.last_error = last_error_;
  if (ports_.out_of_hand())
    s.problem = "an interface cannot be held: everything is denied";
  else
    s.problem = forwarder_.problem();
  s.interfaces = ports_.report();
  return s;
}

Gateway::Body Gateway::handle(const control::NetworksRequest&) {
  control::Networks out;
  for (std::size_t n = 0; n < state_->system().networks.size(); ++n)
    out.networks.push_back(network_report(*state_, n));
  return out;
}

Gateway::Body Gateway::handle(const control::ChannelsRequest&) {
  control::Channels out;
  for (const core::Decision& decision : state_->decisions()) {
    std::vector<const core::Verdict*> all;
    all.reserve(decision.verdicts.size());
    for (const core::Verdict& v : decision.verdicts) all.push_back(&v);
    std::ranges::move(report(all), std::back_inserter(out.channels));
  }
  return out;
}

Gateway::Body Gateway::handle(const control::ExplainRequest& request) {
  const auto channel = channel_named(*state_, request.channel);
  if (!channel) return error(control::ErrorKind::invalid, channel.error().text);
  return report_known({*channel, {}, {}, {}});
}

control::Channels Gateway::report_admission(core::AdmissionId id) const {
  const auto known = state_->admissions().find(id);
  if (known == state_->admissions().end()) return {};
  std::vector<const core::Verdict*> concerned;
  for (const core::Verdict& v : state_->decisions()[known->second].verdicts)
    if (concerns(v, id)) concerned.push_back(&v);
  return {report(concerned)};
}

Gateway::Body Gateway::handle(const control::RoutesRequest&) {
  control::Routes out = routes_report(*state_);
  for (std::size_t n = 0; n < state_->system().networks.size(); ++n)
    if (const auto* table = meshes_.table(n))
      add_links(*meshes_.mesh(n), *table, state_->system().networks[n].name, monotonic_ns(), out);
  add_can_rules(out);
  return out;
}

Gateway::Body Gateway::handle(const control::ReservationsRequest& request) {
  std::optional<core::Place> place;
  if (!request.place.empty()) {
    place = state_->find_place(request.place);
    if (!place)
      return error(control::ErrorKind::invalid,
                   fmt::format("there is no network or gateway '{}'", request.place));
  }
  return reservations_report(*state_, place, [this](core::AdmissionId id) -> std::uint64_t {
    return leases_.remaining(id, monotonic_ns()).value_or(0);
  });
}

Gateway::Body Gateway::handle(const control::GateRequest& request) {
  control::Gates out = gates_report(ports_, *state_, request.place);
  if (out.gates.empty() && !request.place.empty())
    return error(
        control::ErrorKind::invalid,
        fmt::format("there is no gated interface or network '{}' at this gateway (there are: "
                    "{})",
                    request.place, gated_places(ports_)));
  return out;
}

Gateway::Body Gateway::handle(const control::WhatIfRequest& request) {
  auto then = suppose(*state_, request);
  if (!then) return error(control::ErrorKind::invalid, then.error().text);
  return outlook(*state_, **then);
}

Gateway::Body Gateway::handle(const control::HistoryRequest& request) {
  constexpr std::uint32_t usual = 100;
  constexpr std::uint32_t most = 10'000;
  if (!request.kind.empty() && !kind_named(request.kind))
    return error(control::ErrorKind::invalid,
                 fmt::format("there is no kind '{}' (there are: {})", request.kind, kind_names()));
  store::HistoryFilter filter;
  filter.channel = request.channel;
  filter.kind = request.kind;
  filter.since_ns = request.since_unix_ns;
  if (request.until_unix_ns != 0) filter.until_ns = request.until_unix_ns;
  filter.limit = request.limit == 0 ? usual : std::min(request.limit, most);
  auto found = history_->query(filter);
  if (!found) return error(control::ErrorKind::world, found.error().text);
  if (found->empty() && !request.channel.empty() && !state_->find_channel(request.channel))
    return error(control::ErrorKind::invalid,
                 fmt::format("no event channel is called '{}', and the history knows none",
                             request.channel));
  control::History out;
  for (store::Decision& d : *found)
    out.entries.push_back({d.unix_ns, std::move(d.kind), d.subject, std::move(d.channel),
                           std::move(d.from), std::move(d.to), std::move(d.network),
                           std::move(d.message)});
  return out;
}

}  // namespace mlcca
