// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/delivery_events.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <utility>

#include "base/many.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/drops.hpp"
#include "daemon/gateway/report.hpp"

namespace mlcca {
namespace {

/// The kind of event for a delivery that was granted and is not any more.
Kind withdrawal_of(const core::Verdict& v) {
  if (v.obstacle == core::Obstacle::withdrawn) return Kind::revoked;
  return v.obstacle == core::Obstacle::unavailable ? Kind::network_down : Kind::withdrawn;
}

}  // namespace

std::vector<core::AdmissionId> DeliveryEvents::admissions_of(const core::Verdict& v) const {
  const core::Members& members = scene_.state->members();
  return core::each_once(members.admission_of_publisher(v.publisher),
                         std::span<const std::size_t>(v.subscribers),
                         [&](std::size_t s) { return members.admission_of_subscriber(s); });
}

bool DeliveryEvents::concerns(const core::Verdict& v, core::AdmissionId id) const {
  const core::Members::Admitted ends = scene_.state->members().admitted(id);
  return ends.publisher == v.publisher ||
         (ends.subscriber &&
          std::ranges::find(v.subscribers, *ends.subscriber) != v.subscribers.end());
}

void DeliveryEvents::verdict(Kind kind, const core::Verdict& v, const std::string& line) {
  const core::EventChannel& channel = scene_.state->system().channels[v.channel];
  log_.write({.kind = kind,
              .priority = v.granted ? 6 : 4,
              .message = line,
              .subject = channel.subject,
              .channel = channel.name,
              .network = core::name_of(scene_.state->system(), v.to),
              .from = core::name_of(scene_.state->system(),
                                    scene_.state->members().publisher(v.publisher).place),
              .publisher = scene_.state->members().publisher(v.publisher).name,
              .admissions = admissions_of(v),
              .network_down = kind == Kind::network_down
                                  ? core::name_of(scene_.state->system(), v.obstacle_at)
                                  : std::string()});
}

void DeliveryEvents::silence(const core::Verdict& v, const gate_event& event,
                             const std::string& publishers) {
  const core::EventChannel& channel = scene_.state->system().channels[v.channel];
  const core::Publisher& publisher = scene_.state->members().publisher(v.publisher);
  const Value period = std::max<Value>(core::attributes_in(publisher, v.set)[Attribute::period], 1);
  const std::string what =
      fmt::format("{} ({}) of {}", channel.name, core::format_subject(channel.subject), publishers);
  const auto time = core::format_value(Attribute::latency, event.silent / 1'000 * 1'000);
  const bool missing = event.kind == GATE_E_MISSING;
  Note note{.kind = missing ? Kind::missing : Kind::restored,
            .priority = missing ? 4 : 5,
            .subject = channel.subject,
            .channel = channel.name,
            .network = core::name_of(scene_.state->system(), v.to),
            .from = core::name_of(scene_.state->system(), publisher.place),
            .publisher = publisher.name,
            .admissions = admissions_of(v)};
  note.silent_ns = event.silent;
  // Half a period late counts as missing only if no event follows.
  note.missing = missing ? event.silent / period : (event.silent + period / 2) / period - 1;
  if (missing)
    note.message = fmt::format(
        "{} towards {}: {} {}, {} missing where {} may be", what, note.network,
        event.never != 0 ? "nothing has come since the gate lets it in, for"
                         : "nothing has come for",
        time, many(note.missing, "event is", "events are"), v.requirement[Attribute::omission]);
  else
    note.message =
        fmt::format("{} towards {} comes again: for {} it stayed out, or came with breaks", what,
                    note.network, time);
  log_.write(std::move(note));
}

DeliveryEvents::Contract DeliveryEvents::as_reported(const core::State& state,
                                                     const core::Verdict& v) {
  Contract reported;
  reported.set = v.set;
  if (!v.granted) {
    reported.text = verdict_line(state, v);
    return reported;
  }
  const core::Publisher& publisher = state.members().publisher(v.publisher);
  reported.offered = core::attributes_in(publisher, v.set);
  reported.required = v.requirement;
  reported.user_offered = core::user_values_in(publisher, v.set);
  reported.user_required = v.user_requirement;
  for (const core::Place place : v.route)
    reported.text += core::name_of(state.system(), place) + " ";
  return reported;
}

DeliveryEvents::Reported DeliveryEvents::reported_of(const core::State& state) const {
  Reported reported;
  for (const core::Decision& decision : state.decisions()) {
    for (const core::Verdict& v : decision.verdicts)
      reported.emplace(std::pair(core::format_subject(state.system().channels[v.channel].subject),
                                 state.delivery_of(v)),
                       as_reported(state, v));
    pulse_();
  }
  return reported;
}

void DeliveryEvents::outcome(const Granted& before, const Reported& reported) {
  Granted lost = before;
  for (const core::Decision& decision : scene_.state->decisions()) {
    for (const core::Verdict& v : decision.verdicts) {
      const std::string subject =
          core::format_subject(scene_.state->system().channels[v.channel].subject);
      const core::Delivery delivery = scene_.state->delivery_of(v);
      const auto known = lost.find(subject);
      const bool was = known != lost.end() && std::erase(known->second.deliveries, delivery) != 0;
      const auto known_before = reported.find({subject, delivery});
      if (known_before != reported.end() && known_before->second == as_reported(*scene_.state, v))
        continue;
      const Kind not_granted = was ? withdrawal_of(v) : Kind::refused;
      verdict(v.granted ? Kind::granted : not_granted, v, verdict_line(*scene_.state, v));
      pulse_();
    }
    pulse_();
  }
  for (const auto& [subject, grants] : lost)
    for (const core::Delivery& delivery : grants.deliveries) {
      gone(subject, delivery);
      pulse_();
    }
}

std::string DeliveryEvents::why_gone(std::optional<std::size_t> channel,
                                     const core::Delivery& delivery) const {
  if (delivery.admission != 0)
    return is_recorded_(delivery.admission)
               ? fmt::format("the description has no place for admission {}, which is left out",
                             delivery.admission)
               : "another gateway has admitted its publisher, and it is carried again when that "
                 "gateway asks for it";
  const core::Members& members = scene_.state->members();
  const bool is_publisher_there =
      channel && std::ranges::any_of(members.publishers_of(*channel), [&](std::size_t p) {
        return members.admission_of_publisher(p) == 0 &&
               members.publisher(p).name == delivery.publisher;
      });
  return is_publisher_there ? "no subscriber of it is described or admitted there now"
                            : "the description has it no more";
}

/// Reports a delivery that was granted and of which an end no longer exists: it is no longer
/// described, or its admission is no longer allowed or not here any more. Left-out admissions are
/// not reported here.
void DeliveryEvents::gone(const std::string& subject, const core::Delivery& delivery) {
  const auto channel = scene_.state->find_channel(subject);
  const std::string name = channel ? scene_.state->system().channels[*channel].name : subject;
  log_.warning(Kind::removed,
               fmt::format("{} ({}) of {} to {} is removed: {}", name, subject, delivery.publisher,
                           delivery.to, why_gone(channel, delivery)),
               {.subject = core::parse_subject(subject).value_or(0),
                .channel = name,
                .network = delivery.to,
                .publisher = delivery.publisher,
                .admissions = delivery.admission != 0 ? std::vector{delivery.admission}
                                                      : std::vector<core::AdmissionId>{}});
}

/// Reports what has changed of a delivery that was granted before, and still is.
void DeliveryEvents::continued(const core::Verdict& v, const core::Verdict& old) {
  if (v.set != old.set)
    verdict(v.set > old.set ? Kind::degraded : Kind::upgraded, v,
            switch_line(*scene_.state, v, old.set));
  else if (v.route != old.route)
    verdict(Kind::rerouted, v, reroute_line(*scene_.state, v, old.route));
}

void DeliveryEvents::changes(const std::vector<core::DecisionChange>& changes) {
  for (const core::DecisionChange& change : changes) {
    for (const core::Verdict& v : scene_.state->decisions()[change.channel].verdicts) {
      const core::Verdict* old = core::same_delivery(change.before, v);
      const bool was = old != nullptr && old->granted;
      if (v.granted && !was) verdict(Kind::granted, v, verdict_line(*scene_.state, v));
      if (!v.granted && was) verdict(withdrawal_of(v), v, verdict_line(*scene_.state, v));
      if (v.granted && was) continued(v, *old);
      pulse_();
    }
  }
}

void DeliveryEvents::dropped(const core::Verdict& v, Fate fate, std::uint64_t frames) {
  const core::EventChannel& c = scene_.state->system().channels[v.channel];
  const core::Publisher& publisher = scene_.state->members().publisher(v.publisher);
  const std::string which = v.granted ? fmt::format("that named {} ({}) and differ from the grant",
                                                    c.name, core::format_subject(c.subject))
                                      : "of " + verdict_line(*scene_.state, v);
  log_.warning(Kind::dropped, dropped_line(fate, frames, which),
               {.subject = c.subject,
                .channel = c.name,
                .network = core::name_of(scene_.state->system(), publisher.place),
                .publisher = publisher.name,
                .frames = frames});
}

void DeliveryEvents::dropped_before(std::size_t channel, Fate fate, std::uint64_t frames) {
  const core::EventChannel& c = scene_.state->system().channels[channel];
  log_.warning(Kind::dropped,
               dropped_line(fate, frames,
                            fmt::format("of {} ({}) before it was granted", c.name,
                                        core::format_subject(c.subject))),
               {.subject = c.subject, .channel = c.name, .frames = frames});
}

void DeliveryEvents::excess(const std::vector<const core::Verdict*>& verdicts, Fate fate,
                            std::uint64_t frames) {
  const core::Verdict& first = *verdicts.front();
  const core::EventChannel& channel = scene_.state->system().channels[first.channel];
  std::vector<std::string> who;
  std::vector<core::AdmissionId> ids;
  for (const core::Verdict* v : verdicts) {
    const std::string& name = scene_.state->members().publisher(v->publisher).name;
    if (std::ranges::find(who, name) == who.end()) who.push_back(name);
    std::ranges::copy(admissions_of(*v), std::back_inserter(ids));
  }
  std::ranges::sort(ids);
  const auto twice = std::ranges::unique(ids);
  ids.erase(twice.begin(), twice.end());
  const core::Publisher& publisher = scene_.state->members().publisher(first.publisher);
  const AttributeSet& said = core::attributes_in(publisher, first.set);
  const Attribute what = said.has(Attribute::period) ? Attribute::period : Attribute::bandwidth;
  log_.warning(Kind::policed,
               fmt::format("{} sent {} of {} ({}) more than was admitted{}: {} said {} {}",
                           fmt::join(who, " or "), many(frames, "frame"), channel.name,
                           core::format_subject(channel.subject),
                           fate == Fate::passed ? ", passed in audit mode" : "",
                           who.size() > 1 ? who.front() : "it", info(what).name,
                           core::format_value(what, said[what])),
               {.subject = channel.subject,
                .channel = channel.name,
                .network = core::name_of(scene_.state->system(), first.to),
                .from = core::name_of(scene_.state->system(), publisher.place),
                .publisher = who.size() == 1 ? who.front() : "",
                .admissions = ids,
                .frames = frames});
}

}  // namespace mlcca
