// SPDX-License-Identifier: BSD-2-Clause
// What clients want to know, one handle() for each kind of request. Nothing here changes anything.
#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "base/clock.hpp"
#include "control/version.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/gate_report.hpp"
#include "daemon/gateway/gateway.hpp"
#include "daemon/gateway/history_pages.hpp"
#include "daemon/gateway/outlook.hpp"
#include "daemon/gateway/pace.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/gateway/report_size.hpp"
#include "daemon/gateway/reservations.hpp"

namespace mlcca {
namespace {

control::Error error(control::ErrorKind kind, std::string message) {
  return {kind, std::move(message), {}};
}

constexpr std::size_t kLeastRow = 32;      // bytes on the wire
constexpr std::size_t kChannelRow = 1024;  // bytes on the wire, mostly

}  // namespace

/// What a handler answers whose reply is made in slices, each of what is known when it is made.
Gateway::Body Gateway::in_slices(std::size_t least_bytes, std::function<serve::Slice()> next) {
  least_bytes_ = least_bytes;
  slices_ = [this, description = scene_.description, next = std::move(next)] {
    if (description == scene_.description) return std::optional(next());
    return std::optional(serve::Slice{
        error(control::ErrorKind::world, "the description was reloaded meanwhile: ask again")});
  };
  return {};
}

Gateway::Body Gateway::known_or_aside(const Asked& asked) {
  if (!has_many_lines(asked.channel)) return report_known(asked);
  return aside([this, asked] { return report_known(asked); });
}

/// What a handler answers whose reply is made by a child process, of what is known now.
Gateway::Body Gateway::aside(Aside::Make make) {
  slices_ = aside_.ask(peer_, std::move(make), may_slice_);
  return {};
}

Gateway::Body Gateway::handle(const control::StatusRequest&) {
  constexpr std::size_t many = 16;  // ports
  if (ports_.size() > many || has_much_trouble()) return aside([this] { return status(); });
  return status();
}

control::Status Gateway::status() const {
  control::Status s;
  s.version = kVersion;
  s.gateway = scene_.state->system().gateways[scene_.self].name;
  s.system = scene_.state->system().name;
  s.description_file = options_.description;
  s.mode = mode_name();
  s.open = control_.is_open() && !control_.lapsed();
  s.grace_ns = control_.grace();
  s.lapses = control_.lapses();
  s.channels_granted = static_cast<std::uint32_t>(scene_.state->granted());
  s.channels_refused = static_cast<std::uint32_t>(scene_.state->refused());
  s.started_unix_s = static_cast<std::uint64_t>(started_);
  s.loaded_unix_s = static_cast<std::uint64_t>(loaded_);
  s.last_error = last_error_;
  if (const auto problems = own_problems(); !problems.empty()) s.problem = problems.front();
  s.interfaces = ports_.report();
  s.health = health(s.interfaces);
  return s;
}

Gateway::Body Gateway::handle(const control::NetworksRequest&) {
  const auto make = [this] {
    control::Networks out;
    for (std::size_t n = 0; n < scene_.state->system().networks.size(); ++n)
      out.networks.push_back(network_report(*scene_.state, n));
    return out;
  };
  return is_large() ? aside(make) : make();
}

Gateway::Body Gateway::handle(const control::ChannelsRequest&) {
  if (has_channel_of_many_ends())
    return aside([this] {
      control::Channels out;
      for (std::size_t c = 0; c < scene_.state->decisions().size(); ++c)
        std::ranges::move(report_known({c, {}, {}, {}}).channels, std::back_inserter(out.channels));
      return out;
    });
  return in_slices(scene_.state->decisions().size() * kLeastRow,
                   [this, at = Position{}]() mutable { return some_channels(at); });
}

/// From there on, of one channel after the other. Of a channel as many deliveries as there is time
/// for: each has as many lines as all that is compared for it.
serve::Slice Gateway::some_channels(Position& at) const {
  constexpr std::size_t lines_of_a_row = 16;
  control::Channels out;
  const auto& decisions = scene_.state->decisions();
  Pace pace(kChannelRow);
  for (bool goes_on = true; goes_on && at.channel < decisions.size();) {
    const auto& verdicts = decisions[at.channel].verdicts;
    std::vector<const core::Verdict*> some;
    std::size_t lines = 0;
    for (; at.verdict < verdicts.size() && lines < control::kListedRows; ++at.verdict) {
      some.push_back(&verdicts[at.verdict]);
      lines += lines_of(*scene_.state, verdicts[at.verdict]);
    }
    std::ranges::move(report(some), std::back_inserter(out.channels));
    if (at.verdict >= verdicts.size()) at = {at.channel + 1, 0};
    goes_on = pace.made(std::max({std::size_t{1}, some.size(), lines / lines_of_a_row}));
  }
  return {{std::move(out)}, at.channel < decisions.size()};
}

Gateway::Body Gateway::handle(const control::ExplainRequest& request) {
  const auto channel = channel_named(*scene_.state, request.channel);
  if (!channel) return error(control::ErrorKind::invalid, channel.error().text);
  return known_or_aside({*channel, {}, {}, {}});
}

control::Channels Gateway::report_admission(core::AdmissionId id) const {
  const auto known = scene_.state->admissions().find(id);
  if (known == scene_.state->admissions().end()) return {};
  std::vector<const core::Verdict*> concerned;
  for (const core::Verdict& v : scene_.state->decisions()[known->second].verdicts)
    if (deliveries_.concerns(v, id)) concerned.push_back(&v);
  control::Channels out;
  out.left_out = leave_out(*scene_.state, concerned);
  out.channels = report(concerned);
  return out;
}

Gateway::Body Gateway::handle(const control::RoutesRequest&) {
  const auto make = [this](net::CanRules* rules) {
    control::Routes out = routes_report(*scene_.state);
    for (std::size_t n = 0; n < scene_.state->system().networks.size(); ++n)
      if (const auto* table = meshes_.table(n))
        add_links(*meshes_.mesh(n), *table, scene_.state->system().networks[n].name, monotonic_ns(),
                  out);
    add_can_rules(out, rules == nullptr ? forwarder_.read() : rules->read());
    return out;
  };
  if (!is_large()) return make(nullptr);
  // The child has none of the sockets of the daemon.
  return aside([make] {
    net::KernelCanRules rules;
    return make(&rules);
  });
}

Gateway::Body Gateway::handle(const control::ReservationsRequest& request) {
  std::optional<core::Place> place;
  if (!request.place.empty()) {
    place = scene_.state->find_place(request.place);
    if (!place)
      return error(control::ErrorKind::invalid,
                   fmt::format("there is no network or gateway '{}'", request.place));
  }
  const auto make = [this, place] {
    return reservations_report(*scene_.state, place, [this](core::AdmissionId id) -> std::uint64_t {
      return leases_.remaining(id, monotonic_ns()).value_or(0);
    });
  };
  return is_large() ? aside(make) : make();
}

Gateway::Body Gateway::handle(const control::GateRequest& request) {
  const auto make = [this, place = request.place]() -> Body {
    control::Gates out = gates_report(ports_, *scene_.state, place);
    if (out.gates.empty() && !place.empty())
      return error(
          control::ErrorKind::invalid,
          fmt::format("there is no gated interface or network '{}' at this gateway (there are: "
                      "{})",
                      place, gated_places(ports_)));
    return out;
  };
  return is_large() ? aside(make) : make();
}

/// Always aside: all that is known is decided once more.
Gateway::Body Gateway::handle(const control::WhatIfRequest& request) {
  return aside([this, request]() -> Body {
    auto then = suppose(*scene_.state, request);
    if (!then) return error(control::ErrorKind::invalid, then.error().text);
    return outlook(*scene_.state, **then);
  });
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
  auto pages = std::make_shared<HistoryPages>(*history_, filter);
  auto first = patience_.wait_for([&pages] { return pages->next(); });
  if (!first) return error(control::ErrorKind::world, first.error().text);
  if (first->entries.empty() && !request.channel.empty() &&
      !scene_.state->find_channel(request.channel))
    return error(control::ErrorKind::invalid,
                 fmt::format("no event channel is called '{}', and the history knows none",
                             request.channel));
  if (!pages->more()) return std::move(*first);
  slices_ = [this, pages, first = std::move(*first)]() mutable -> std::optional<serve::Slice> {
    if (!first.entries.empty()) return serve::Slice{std::exchange(first, {}), true};
    auto page = patience_.wait_for([&pages] { return pages->next(); });
    if (!page) return serve::Slice{error(control::ErrorKind::world, page.error().text)};
    return serve::Slice{std::move(*page), pages->more()};
  };
  return {};
}

}  // namespace mlcca
