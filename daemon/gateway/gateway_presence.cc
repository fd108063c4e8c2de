// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/gateway_presence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "core/model/carrier.hpp"
#include "core/model/presence.hpp"
#include "core/model/text.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

/// After this many of its own announcements were not requested, this gateway forwards nothing that
/// another one could forward. Others wait longer (core::presence_lasts), so this gateway stops
/// first.
constexpr std::uint64_t kOwnLosses = 2;
/// ns between two checks whether a channel needs the relay, while it is not connected.
constexpr std::uint64_t kRelayChecks = 1'000'000'000;

}  // namespace

void GatewayPresence::start() {
  asked_ = relay_seen_ = parts_.clock.monotonic_ns();
  since_.clear();
}

std::optional<std::size_t> GatewayPresence::known(const std::string& name) const {
  const auto& gateways = system().gateways;
  const auto found = std::ranges::find(gateways, name, &core::Gateway::name);
  if (found == gateways.end()) return std::nullopt;
  return static_cast<std::size_t>(found - gateways.begin());
}

bool GatewayPresence::is_available(std::size_t network) const {
  return parts_.scene.state->world().conditions[network].available;
}

bool GatewayPresence::is_announced(std::uint64_t now) const {
  return sub_floor(now, asked_) <= mul_saturating(self().presence, kOwnLosses);
}

void GatewayPresence::note_networks(std::uint64_t now) {
  std::map<Pair, std::uint64_t> since;
  for (std::size_t g = 0; g < system().gateways.size(); ++g)
    for (const std::size_t n : core::presence_networks(system(), parts_.scene.self, g)) {
      if (g == parts_.scene.self || !is_available(n)) continue;
      Pair pair{system().gateways[g].name, system().networks[n].name};
      const auto before = since_.find(pair);
      since.emplace(std::move(pair), before == since_.end() ? now : before->second);
    }
  since_ = std::move(since);
  // Announcing begins now: there was no time yet to ask for an announcement.
  if (interval_ == 0) asked_ = relay_seen_ = std::max(asked_, now);
  interval_ = self().presence;
  lacks_relay_ = self().presence != 0 && lacks_relay(now);
}

std::optional<std::uint64_t> GatewayPresence::there_until(std::size_t gateway) const {
  const core::Gateway& one = system().gateways[gateway];
  const auto other = others_.find(one.name);
  std::optional<std::uint64_t> until;
  for (const std::size_t n : core::presence_networks(system(), parts_.scene.self, gateway)) {
    const auto since = since_.find({one.name, system().networks[n].name});
    if (since == since_.end()) continue;
    Value here =
        add_saturating(since->second, core::presence_lasts(one.presence, parts_.control.grace()));
    if (other != others_.end())
      if (const auto at = other->second.until.find(since->first.second);
          at != other->second.until.end())
        here = std::max(here, at->second);
    until = std::max(until.value_or(0), here);
  }
  return until;
}

bool GatewayPresence::is_silent(std::size_t gateway, std::uint64_t now) const {
  const auto until = there_until(gateway);
  return until && now >= *until;
}

std::optional<std::string> GatewayPresence::failure_of(std::size_t gateway,
                                                       std::uint64_t now) const {
  if (is_silent(gateway, now)) return "nothing is received of it";
  const auto other = others_.find(system().gateways[gateway].name);
  if (other != others_.end() && !other->second.forwards) return "it says that it cannot forward";
  return std::nullopt;
}

bool GatewayPresence::relays(const core::Route& route) const {
  for (std::size_t i = 1; i + 1 < route.size(); ++i) {
    if (route[i] != core::Place{core::Place::Kind::gateway, parts_.scene.self}) continue;
    const core::Port* const out = self().port_on(route[i + 1].index);
    return out != nullptr &&
           !core::are_joined_by_kernel(self(), system().networks[route[i - 1].index],
                                       system().networks[route[i + 1].index]) &&
           core::sender_at(self(), *out) == self().relay;
  }
  return false;
}

/// Considers all shortest routes, not only the one that is taken now: otherwise the result would
/// depend on itself.
bool GatewayPresence::needs_relay() const {
  const core::State& state = *parts_.scene.state;
  const auto may_relay = [&](const core::Verdict& v) {
    const auto& routes =
        state.topology().routes(state.members().publisher(v.publisher).place, v.to);
    return v.granted && std::ranges::any_of(routes, [&](const core::Route& route) {
             return route.size() == routes.front().size() && relays(route);
           });
  };
  return std::ranges::any_of(state.decisions(), [&](const core::Decision& decision) {
    return std::ranges::any_of(decision.verdicts, may_relay);
  });
}

bool GatewayPresence::lacks_relay(std::uint64_t now) {
  if (!self().relay || parts_.carriers.has(*self().relay)) {
    relay_seen_ = now;
    return false;
  }
  if (sub_floor(now, relay_seen_) <= mul_saturating(self().presence, kOwnLosses)) return false;
  if (now - relay_checked_ >= kRelayChecks) {
    relay_checked_ = now;
    relay_needed_ = needs_relay();
  }
  return relay_needed_;
}

std::optional<std::string> GatewayPresence::inability() const {
  for (std::size_t g = 0; g < system().gateways.size(); ++g) {
    if (g == parts_.scene.self || core::presence_networks(system(), parts_.scene.self, g).empty())
      continue;
    for (const core::Port& port : self().ports)
      if (system().gateways[g].port_on(port.network) != nullptr && !is_available(port.network))
        return system().networks[port.network].name + " is not available here";
  }
  if (lacks_relay_) return "mlcca-relay is not connected";
  return std::nullopt;
}

std::optional<std::string> GatewayPresence::own_failure(std::uint64_t now) const {
  if (!is_announced(now))
    return "mlcca-famouso --subscriptions does not ask what to announce, so others may take its "
           "place";
  if (auto why = inability()) return why;
  for (const auto& [name, other] : others_) {
    const auto gateway = known(name);
    if (!gateway || !other.forwards) continue;
    // The other gateway may have said that before it could receive the latest announcements.
    if (!other.lacks_this || *other.lacks_this < kOwnLosses) continue;
    if (is_silent(*gateway, now)) continue;  // that statement is old
    return fmt::format("{} receives nothing of it, and forwards instead", name);
  }
  return std::nullopt;
}

GatewayPresence::Failures GatewayPresence::failures(std::uint64_t now) const {
  Failures out(system().gateways.size());
  if (self().presence == 0) return out;
  bool any = false;
  for (std::size_t g = 0; g < out.size(); ++g) {
    if (g == parts_.scene.self || core::presence_networks(system(), parts_.scene.self, g).empty())
      continue;
    any = true;
    // Without the program that announces, nothing is received either: what was known last counts.
    if (is_announced(now))
      out[g] = failure_of(g, now);
    else if (last_.size() == out.size())
      out[g] = last_[g];
  }
  if (any) out[parts_.scene.self] = own_failure(now);
  return out;
}

control::Presence GatewayPresence::announce() {
  const std::uint64_t now = parts_.clock.monotonic_ns();
  asked_ = now;
  for (auto& [name, other] : others_)
    if (other.lacks_this) ++*other.lacks_this;
  control::Presence out;
  out.gateway = self().name;
  out.interval_ns = self().presence;
  out.lasts_ns = core::presence_lasts(self().presence, parts_.control.grace());
  // Closed gates do not count as a failure of this gateway, but others must know of them. What is
  // decided takes effect when the gates open.
  out.forwards = parts_.control.is_open() && !parts_.control.lapsed() && !own_failure(now);
  std::set<std::string> networks;
  for (std::size_t g = 0; g < system().gateways.size(); ++g) {
    const auto shared = core::presence_networks(system(), parts_.scene.self, g);
    if (g == parts_.scene.self || shared.empty()) continue;
    out.others.push_back(system().gateways[g].name);
    if (is_silent(g, now)) out.not_received.push_back(system().gateways[g].name);
    for (const std::size_t n : shared) networks.insert(system().networks[n].name);
  }
  out.networks.assign(networks.begin(), networks.end());
  return out;
}

Result<void> GatewayPresence::receive(const control::PresenceRequest& message) {
  const auto gateway = known(message.gateway);
  const auto& networks = system().networks;
  if (!gateway || *gateway == parts_.scene.self)
    return fail(fmt::format("'{}' is not described as another gateway", message.gateway));
  const auto shared = core::presence_networks(system(), parts_.scene.self, *gateway);
  if (std::ranges::none_of(shared,
                           [&](std::size_t n) { return networks[n].name == message.network; }))
    return fail(fmt::format("{} does not announce itself to this gateway on '{}'", message.gateway,
                            message.network));
  const Value interval = system().gateways[*gateway].presence;
  if (message.lasts_ns < core::presence_lasts(interval, 0) ||
      message.lasts_ns > core::presence_lasts(interval, core::kLongestPresenceGrace))
    return fail(fmt::format("{} says that it is there for {} ns, which its presence does not give",
                            message.gateway, message.lasts_ns));
  Other& other = others_[message.gateway];
  other.until[message.network] = add_saturating(parts_.clock.monotonic_ns(), message.lasts_ns);
  other.forwards = message.forwards;
  if (std::ranges::find(message.not_received, self().name) == message.not_received.end())
    other.lacks_this.reset();
  else if (!other.lacks_this)
    other.lacks_this = 0;
  return {};
}

void GatewayPresence::apply(core::State& state) {
  const std::uint64_t now = parts_.clock.monotonic_ns();
  note_networks(now);
  const Failures failed = failures(now);
  if (is_announced(now)) last_ = failed;
  std::map<std::string, std::string> lines;
  for (std::size_t g = 0; g < failed.size(); ++g) {
    state.set_failed(g, failed[g].has_value());
    if (!failed[g]) continue;
    const std::string& name = state.system().gateways[g].name;
    const std::string line =
        g == parts_.scene.self
            ? fmt::format("gateway {} leaves to others what they can forward: {}", name, *failed[g])
            : fmt::format("gateway {} has failed: {}", name, *failed[g]);
    if (!failed_.contains(name)) parts_.log.warning(Kind::gateway, line, {.network = name});
    lines.emplace(name, line);
  }
  for (const auto& [name, line] : failed_)
    if (!lines.contains(name))
      parts_.log.notice(Kind::gateway, fmt::format("gateway {} forwards again", name),
                        {.network = name});
  failed_ = std::move(lines);
}

bool GatewayPresence::can_carry() {
  const std::size_t own = parts_.scene.self;
  for (std::size_t g = 0; g < system().gateways.size(); ++g) {
    std::size_t shared = 0;
    bool available = true;
    for (const core::Port& port : self().ports) {
      if (g == own || system().gateways[g].port_on(port.network) == nullptr) continue;
      ++shared;
      available = available && is_available(port.network);
    }
    if (shared > 1 && !available) return false;
  }
  return !self().relay || parts_.carriers.has(*self().relay) || !needs_relay_now();
}

/// Checked at most once a second, so a relay that is away for a short time is missed.
bool GatewayPresence::needs_relay_now() {
  const std::uint64_t now = parts_.clock.monotonic_ns();
  if (now - relay_checked_ >= kRelayChecks) {
    relay_checked_ = now;
    relay_needed_ = needs_relay();
  }
  return relay_needed_;
}

std::vector<std::string> GatewayPresence::problems() const {
  std::vector<std::string> out;
  out.reserve(failed_.size());
  for (const auto& [name, line] : failed_) out.push_back(line);
  return out;
}

}  // namespace mlcca
