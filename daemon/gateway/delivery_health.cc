// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/delivery_health.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "base/many.hpp"
#include "core/model/medium.hpp"
#include "core/model/text.hpp"
#include "daemon/gates/counters.hpp"
#include "daemon/gateway/report_size.hpp"

namespace mlcca {
namespace {

/// The number of frames of one event where it enters: until all of them have come, none needs to
/// leave.
std::uint64_t event_frames(const core::State& state, const core::Verdict& v,
                           const core::GateRule& rule) {
  if (rule.entry.direction != core::Direction::ingress || v.route.empty() ||
      v.route.front().kind != core::Place::Kind::network)
    return 1;
  const core::Network& network = state.system().networks[v.route.front().index];
  const core::Publisher& publisher = state.members().publisher(v.publisher);
  const Value bytes = core::attributes_in(publisher, v.set)[Attribute::max_payload];
  return core::frames_per_event(network, network.binding_of(v.channel), bytes);
}

/// The latest drop may be one for excess, which is no reason for frames that differ from the grant.
Frames without_excess_as_reason(Frames frames) {
  if (frames.last_reason == core::FrameReason::excess) frames.last_reason.reset();
  return frames;
}

/// The rule of the gate by which the events of a delivery enter, if they are periodic; otherwise
/// nullptr.
const core::GateRule* watched_rule(const core::GateState& rules) {
  const auto own = std::ranges::find_if(
      rules, [](const core::GateRule& rule) { return rule.watching.period != 0; });
  return own == rules.end() ? nullptr : &*own;
}

const core::SharedRule* rule_of(const core::GateEntry& entry,
                                const std::vector<core::SharedRule>& shared) {
  const auto known =
      std::ranges::find(shared, entry, [](const core::SharedRule& one) { return one.rule.entry; });
  return known == shared.end() ? nullptr : &*known;
}

}  // namespace

DeliveryHealth::Shared DeliveryHealth::shared_of(std::size_t channel) const {
  return core::shared_rules(scene_.state->system(), scene_.state->members(), channel,
                            scene_.state->decisions()[channel].verdicts, scene_.self);
}

/// The gate supervises the subscriber with the shortest timeout. A subscriber with a longer one
/// misses events from the end of its own timeout until the end of the silence is reported.
DeliveryHealth::Supervision DeliveryHealth::supervision_of(const core::Verdict& verdict,
                                                           const core::GateState& rules,
                                                           const Shared& shared) const {
  Supervision found = seen_at_gate(rules, shared);
  if (!found.watch) return found;
  if (silences_.contains(verdict)) found.watch->missing_now = true;
  found.watch->silent_ns = silent_for(*found.watch);
  return found;
}

DeliveryHealth::Supervision DeliveryHealth::seen_at_gate(const core::GateState& rules,
                                                         const Shared& shared) const {
  const core::GateRule* const own = watched_rule(rules);
  if (own == nullptr) return {};
  if (const core::SharedRule* both = rule_of(own->entry, shared)) {
    core::GateRule rule = both->rule;
    rule.watching.silence = own->watching.silence;  // the timeout of this delivery
    Supervision found{gates_.watch({rule}), look_alikes_of(rules, shared)};
    if (found.watch) found.watch->shared = true;
    return found;
  }
  Supervision found{gates_.watch(rules), {}};
  if (found.watch || own->watching.silence == 0 || !gates_.is_gated(own->entry.port)) return found;
  found.lacking = own->watching.period > GATE_LONGEST_PERIOD
                      ? "its Period is longer than a gate can watch"
                      : fmt::format("the gate of {} watches as many publishers as it can",
                                    gates_.interface_name(own->entry.port));
  return found;
}

std::string DeliveryHealth::look_alikes_of(const core::GateState& rules,
                                           const Shared& shared) const {
  const core::GateRule* const own = watched_rule(rules);
  if (own == nullptr || own->watching.silence == 0) return {};
  const core::SharedRule* const both = rule_of(own->entry, shared);
  if (both == nullptr) return {};
  return "the gate cannot distinguish " + core::names_of(scene_.state->members(), both->publishers);
}

std::vector<std::string> DeliveryHealth::troubles_of(const core::Verdict& v,
                                                     const core::GateState& rules,
                                                     const Shared& shared,
                                                     const Supervision& supervision) const {
  if (core::goes_elsewhere(v, rules)) return {};
  Observed seen;
  seen.watch = supervision.watch;
  seen.not_supervised = supervision.lacking;
  if (const std::string* why = forwarding_.obstacle(v.channel)) seen.not_forwarded = *why;
  if (lacks_relay(v, rules))
    seen.not_forwarded =
        "mlcca-relay, which is to carry it, is not connected: start mlcca-relay.service";
  const core::GateRule* const in = way_in(rules);
  for (const core::GateRule& rule : rules) {
    if (!gates_.is_gated(rule.entry.port)) continue;
    if (rule.entry.direction == core::Direction::egress && carriers_.any_late())
      seen.late = late_line(v, gates_.network_of(rule.entry.port));
    seen.passages.push_back(
        {.network = gates_.network_of(rule.entry.port),
         .leaves = rule.entry.direction == core::Direction::egress,
         .is_shared = rule_of(rule.entry, shared) != nullptr,
         .frames = without_excess_as_reason(gates_.frames({rule})),
         .passed_before = passed_before(v.channel, rule.entry),
         .event_frames = event_frames(*scene_.state, v, rule),
         .latest = in == nullptr ? std::nullopt : latest_left(v.channel, in->entry, rule.entry),
         .excess = drops_.recent(rule.entry, Drop::excess),
         .misfits = drops_.recent(rule.entry, Drop::misfit),
         .would_be_misfits = drops_.recent(rule.entry, Drop::would_be_misfit),
         .would_exceed = drops_.recent(rule.entry, Drop::would_exceed)});
  }
  // Unknown frames are read only if no events come, because they may be the missing ones.
  if (in != nullptr && seen.watch && (seen.watch->missing_now || seen.watch->events == 0)) {
    const std::size_t port = in->entry.port;
    seen.unknown = drops_.recent_unknown(port);
    if (seen.unknown.frames != 0) seen.latest_unknown = gates_.latest_unknown(port);
  }
  return troubles(seen);
}

/// Whether the delivery crosses this gateway by the relay, and the relay has not asked what to
/// carry.
bool DeliveryHealth::lacks_relay(const core::Verdict& v, const core::GateState& rules) const {
  const core::Gateway& here = scene_.state->system().gateways[scene_.self];
  if (!here.relay || carriers_.has(*here.relay) ||
      (!v.route.empty() && v.route.front().kind == core::Place::Kind::gateway))
    return false;
  return std::ranges::any_of(rules, [&](const core::GateRule& rule) {
    return rule.entry.direction == core::Direction::egress && !rule.entry.source_port &&
           rule.entry.uid == *here.relay && !here.ports[rule.entry.port].sender;
  });
}

std::string DeliveryHealth::late_line(const core::Verdict& v, const std::string& to) const {
  const core::State& state = *scene_.state;
  const auto late = carriers_.late(
      {state.system().channels[v.channel].subject, state.members().publisher(v.publisher).name, to},
      clock_.monotonic_ns());
  if (!late) return {};
  return fmt::format(
      "the program that carries it to {} took up to {}, longer than the gateway states, for {}", to,
      core::format_value(Attribute::latency, late->longest_ns / 1'000 * 1'000),
      many(late->events, "event"));
}

const core::GateRule* DeliveryHealth::way_in(const core::GateState& rules) {
  const auto in =
      std::ranges::find(rules, core::Direction::ingress,
                        [](const core::GateRule& rule) { return rule.entry.direction; });
  return in == rules.end() ? nullptr : &*in;
}

void DeliveryHealth::note_leaving(std::size_t channel, const core::GateState& rules) {
  const core::GateRule* const in = way_in(rules);
  if (in == nullptr || !gates_.is_gated(in->entry.port)) return;
  for (const core::GateRule& rule : rules) {
    if (rule.entry.direction != core::Direction::egress || !gates_.is_gated(rule.entry.port))
      continue;
    // In this order, so that frames which leave in between are seen at the next poll.
    const std::uint64_t left = gates_.frames({rule}).passed;
    const std::uint64_t came = gates_.frames({*in}).passed;
    if (left == 0) continue;
    LatestLeft& latest = leaving_[channel][{in->entry, rule.entry}];
    // The counters of a slot that was created again start from 0.
    if (left != latest.out || came < latest.in) latest = {came, left};
  }
}

std::optional<LatestLeft> DeliveryHealth::latest_left(std::size_t channel,
                                                      const core::GateEntry& in,
                                                      const core::GateEntry& out) const {
  const auto of_channel = leaving_.find(channel);
  if (of_channel == leaving_.end()) return std::nullopt;
  const auto known = of_channel->second.find({in, out});
  if (known == of_channel->second.end()) return std::nullopt;
  return known->second;
}

void DeliveryHealth::forget(const std::function<void()>& pulse) {
  troubled_.clear();
  passed_before_.clear();
  leaving_.clear();
  for (std::size_t channel = 0; channel < scene_.state->decisions().size(); ++channel) {
    restart(channel);
    pulse();
  }
}

void DeliveryHealth::restart(std::size_t channel) {
  leaving_.erase(channel);
  Passed passed;
  for (const core::GateRule& rule : scene_.state->gate_state(scene_.self, channel))
    if (rule.entry.direction == core::Direction::ingress)
      if (const std::uint64_t frames = gates_.frames({rule}).passed; frames != 0)
        passed.emplace(rule.entry, frames);
  if (passed.empty())
    passed_before_.erase(channel);
  else
    passed_before_.insert_or_assign(channel, std::move(passed));
}

std::uint64_t DeliveryHealth::passed_before(std::size_t channel,
                                            const core::GateEntry& entry) const {
  const auto of_channel = passed_before_.find(channel);
  if (of_channel == passed_before_.end()) return 0;
  const auto known = of_channel->second.find(entry);
  return known == of_channel->second.end() ? 0 : known->second;
}

void DeliveryHealth::judge(const DropReports::Polled& polled) {
  const auto& [verdicts, rules] = polled;
  const std::size_t channel = verdicts.front()->channel;
  const Shared shared = shared_of(channel);
  // Granted verdicts come first.
  bool troubled = false;
  for (std::size_t i = 0; i < verdicts.size() && verdicts[i]->granted; ++i)
    note_leaving(channel, rules[i]);
  for (std::size_t i = 0; i < verdicts.size() && verdicts[i]->granted && !troubled; ++i)
    troubled =
        !troubles_of(*verdicts[i], rules[i], shared, supervision_of(*verdicts[i], rules[i], shared))
             .empty();
  if (troubled)
    troubled_.insert(channel);
  else
    troubled_.erase(channel);
}

void DeliveryHealth::add_to(std::vector<std::string>& lines) const {
  const core::State& state = *scene_.state;
  for (const std::size_t channel : troubled_) {
    if (channel >= state.decisions().size()) break;
    const Shared shared = shared_of(channel);
    for (const core::Verdict& v : state.decisions()[channel].verdicts) {
      if (!v.granted) continue;
      const auto rules = core::gate_state(state.system(), state.members(), v, scene_.self);
      const core::Publisher& publisher = state.members().publisher(v.publisher);
      for (const std::string& line :
           troubles_of(v, rules, shared, supervision_of(v, rules, shared)))
        lines.push_back(fmt::format("{} from {} ({}) to {}: {}",
                                    state.system().channels[channel].name,
                                    core::name_of(state.system(), publisher.place), publisher.name,
                                    core::name_of(state.system(), v.to), line));
    }
    // health_of() counts further reasons, and `channels` lists them.
    if (lines.size() > 2 * control::Health::kMostReasons) return;
  }
}

bool DeliveryHealth::is_large() const {
  constexpr std::size_t many = 32;  // more channels than this are many, as each is examined
  if (troubled_.size() > many) return true;
  return std::ranges::any_of(troubled_, [this](std::size_t channel) {
    return channel < scene_.state->decisions().size() &&
           scene_.state->decisions()[channel].verdicts.size() > kManyEnds;
  });
}

}  // namespace mlcca
