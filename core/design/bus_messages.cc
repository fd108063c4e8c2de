// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/bus_messages.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "core/admission/route_check.hpp"
#include "core/can/analysis.hpp"
#include "core/design/let_through.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core {
namespace {

bool is_unknown(const AttributeSet& provision) {
  constexpr Attribute latency = Attribute::latency;
  return !provision.has(latency) || provision.is_dynamic(latency) ||
         provision[latency] == kUnbounded;
}

/// Hops before the one of that number whose delay nobody knows.
std::vector<Place> unknown_before(const Verdict& v, std::size_t hop) {
  const auto places = hops_of(v.route);
  std::vector<Place> out;
  for (std::size_t i = 0; i < std::min(hop, v.hops.size()); ++i)
    if (is_unknown(v.hops[i].provision)) out.push_back(places[i]);
  return out;
}

bool is_in_vain(const Verdict& v, std::size_t network) {
  return std::ranges::any_of(v.rows, [&](const Row& row) {
    return row.against == Against::schedule && row.place == Place{Place::Kind::network, network};
  });
}

/// What the check found the message itself to take, its jitter included.
std::optional<Value> refused_response(const Verdict& v, std::size_t network,
                                      const can::Message& message) {
  const auto row = std::ranges::find_if(v.rows, [&](const Row& one) {
    return one.against == Against::schedule && one.end == v.publisher &&
           one.place == Place{Place::Kind::network, network} &&
           one.comparison.attribute == Attribute::deadline;
  });
  if (row == v.rows.end()) return std::nullopt;
  const Comparison& c = row->comparison;
  if (c.provided == kUnbounded) return can::kNever;
  return c.required == 0 ? add_saturating(c.provided, message.jitter) : c.provided;
}

bool is_bus(const Ledger& ledger, Place place) {
  return place.kind == Place::Kind::network && ledger.schedule(place.index) != nullptr;
}

std::optional<BusMessage::Before> bus_before(const System& system, const Ledger& ledger,
                                             const Verdict& v, std::size_t hop) {
  const auto places = hops_of(v.route);
  Value added = 0;
  for (std::size_t i = hop; i-- > 0;) {
    if (is_bus(ledger, places[i]))
      return BusMessage::Before{.network = places[i].index,
                                .from = flow_on(system, v.publisher, v.route, i).from,
                                .added = added};
    if (i >= v.hops.size()) continue;
    const AttributeSet& gives = v.hops[i].provision;
    for (const Attribute a : {Attribute::jitter, Attribute::latency})
      if (gives.has(a) && gives[a] != kUnbounded) {
        added = add_saturating(added, gives[a]);
        break;
      }
  }
  return std::nullopt;
}

auto order_of(const BusMessage& m) { return std::tuple(m.network, m.publisher, m.from); }

/// Two of one flow: the stricter of both, as for the bus.
void join(std::optional<can::Message>& there, const std::optional<can::Message>& next) {
  if (!there || !next) {
    if (!there) there = next;
    return;
  }
  const can::Time delay = std::min(there->deadline - there->jitter, next->deadline - next->jitter);
  there->jitter = std::max(there->jitter, next->jitter);
  there->deadline = add_saturating(there->jitter, delay);
}

}  // namespace

void BusMessages::add(const Situation& situation, const Ledger& ledger, const Decision& decision) {
  for (const Verdict& v : decision.verdicts) add(situation, ledger, v);
}

void BusMessages::add(const Situation& situation, const Ledger& ledger, const Verdict& v) {
  if (!v.granted) {
    refused_.push_back(v);
    return;
  }
  const auto places = hops_of(v.route);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!is_bus(ledger, places[i])) continue;
    const Flow flow = flow_on(situation.system, v.publisher, v.route, i);
    messages_.push_back({.network = places[i].index,
                         .publisher = v.publisher,
                         .from = flow.from,
                         .message = std::nullopt,
                         .sent = std::nullopt,
                         .set = v.set,
                         .outcome = v.outcome,
                         .held = true,
                         .let_through = true,
                         .granted_response = std::nullopt,
                         .granted_jitter = 0,
                         .refused_response = std::nullopt,
                         .in_vain = false,
                         .unknown = unknown_before(v, i),
                         .before = bus_before(situation.system, ledger, v, i)});
  }
}

/// Where a message is there already, for another place: the stricter of both. What is held for one
/// is sent for that one.
void BusMessages::put(BusMessage next) {
  const auto [at, fresh] = known_.try_emplace(order_of(next), messages_.size());
  if (fresh) {
    messages_.push_back(std::move(next));
    return;
  }
  BusMessage& there = messages_[at->second];
  if (there.held == next.held)
    join(there.sent, next.sent);
  else if (next.held)
    there.sent = next.sent;
  there.outcome = worse(there.outcome, next.outcome);
  there.held = there.held || next.held;
  there.let_through = there.let_through || next.let_through;
  there.in_vain = there.in_vain || next.in_vain;
  if (next.refused_response) there.refused_response = next.refused_response;
  for (const Place place : next.unknown)
    if (std::ranges::find(there.unknown, place) == there.unknown.end())
      there.unknown.push_back(place);
  join(there.message, next.message);
}

void BusMessages::add_refused(const Situation& situation, Ledger& ledger, Verdict v) {
  const Publisher& publisher = situation.members.publisher(v.publisher);
  if (hops_of(v.route).empty()) {
    // Nothing leads there, and what is published is on the publisher's own network all the same.
    if (publisher.place.kind != Place::Kind::network || v.to == publisher.place) return;
    v.route = {publisher.place};
  }
  std::vector<TriedMessage> tried;
  Situation trying = situation;
  trying.tried = &tried;
  Verdict again = undecided(trying, v.channel, v.publisher, {v.to, v.subscribers}, v.set);
  again.route = v.route;
  const Ledger::Mark before = ledger.mark();
  check_route(trying, ledger, targets_of(situation.members, v.channel), again);
  ledger.roll_back(before);
  const auto places = hops_of(again.route);
  for (std::size_t i = 0; i < places.size(); ++i)
    if (is_bus(ledger, places[i]) && std::ranges::find(tried, i, &TriedMessage::hop) == tried.end())
      tried.push_back({i, std::nullopt});
  for (const TriedMessage& t : tried)
    put({.network = places[t.hop].index,
         .publisher = v.publisher,
         .from = flow_on(situation.system, v.publisher, again.route, t.hop).from,
         .message = t.message,
         .sent = t.message,
         .set = v.set,
         .outcome = v.outcome,
         .held = false,
         .let_through = places[t.hop] == publisher.place,
         .granted_response = std::nullopt,
         .granted_jitter = 0,
         .refused_response =
             t.message ? refused_response(v, places[t.hop].index, *t.message) : std::nullopt,
         .in_vain = is_in_vain(v, places[t.hop].index),
         .unknown = unknown_before(again, t.hop),
         .before = bus_before(situation.system, ledger, again, t.hop)});
}

/// The messages and response times of what is granted.
void BusMessages::take_granted(const Ledger& ledger) {
  std::map<std::size_t, std::map<std::uint64_t, std::pair<const can::Message*, can::Response>>>
      on_bus;
  for (BusMessage& m : std::exchange(messages_, {})) {
    const can::Schedule& bus = *ledger.schedule(m.network);
    const auto [there, fresh] = on_bus.try_emplace(m.network);
    if (fresh) {
      const auto responses = can::analyse(bus.assumptions(), bus.messages());
      for (std::size_t i = 0; i < responses.size(); ++i)
        there->second[bus.messages()[i].key] = {&bus.messages()[i], responses[i]};
    }
    const auto held = there->second.find(Ledger::key_of({m.publisher, m.network, m.from}));
    if (held != there->second.end()) {
      const auto& [message, response] = held->second;
      m.message = m.sent = *message;
      m.granted_jitter = message->jitter;
      m.granted_response = response.bounded ? response.response : can::kNever;
    }
    put(std::move(m));
  }
}

std::vector<BusMessage> BusMessages::take(const Situation& situation, Ledger& ledger) {
  take_granted(ledger);
  for (Verdict& v : refused_) add_refused(situation, ledger, std::move(v));
  refused_.clear();
  known_.clear();
  std::ranges::stable_sort(messages_, {}, order_of);
  return std::exchange(messages_, {});
}

namespace {

using Buses = std::vector<std::optional<can::Assumptions>>;
using Form = std::optional<can::Message> BusMessage::*;

/// Response times of the messages of one bus, in that form.
void analyse_bus(const std::vector<BusMessage>& messages, const Buses& buses, std::size_t network,
                 Form form, std::vector<can::Response>& responses) {
  std::vector<std::size_t> here;
  std::vector<can::Message> on_bus;
  std::vector<bool> let_through;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (messages[i].network != network || !(messages[i].*form)) continue;
    here.push_back(i);
    on_bus.push_back(*(messages[i].*form));
    on_bus.back().key = i;
    let_through.push_back(form == &BusMessage::message || messages[i].let_through);
  }
  const auto found = responses_beside(*buses[network], on_bus, let_through);
  for (std::size_t i = 0; i < here.size(); ++i) responses[here[i]] = found[i];
}

/// The jitter that a message has from the bus before; 0 if there is none.
Value inherited(const std::vector<BusMessage>& messages,
                const std::vector<can::Response>& responses, Form form, const BusMessage& m) {
  if (!m.before) return 0;
  const std::tuple wanted(m.before->network, m.publisher, m.before->from);
  const auto last = std::ranges::lower_bound(messages, wanted, {}, order_of);
  if (last == messages.end() || order_of(*last) != wanted || !((*last).*form)) return 0;
  const can::Response& r = responses[static_cast<std::size_t>(last - messages.begin())];
  return r.bounded ? add_saturating(r.response, m.before->added) : can::kNever;
}

void inherit(std::vector<BusMessage>& messages, const Buses& buses, Form form) {
  constexpr unsigned most_rounds = 256;  // each makes something later
  std::vector<can::Response> responses(messages.size());
  std::vector<bool> stale(buses.size(), true);
  for (unsigned round = 0; std::ranges::find(stale, true) != stale.end(); ++round) {
    for (std::size_t n = 0; n < buses.size(); ++n) {
      if (stale[n] && buses[n]) analyse_bus(messages, buses, n, form, responses);
      stale[n] = false;
    }
    for (BusMessage& m : messages) {
      if (!(m.*form)) continue;
      const Value jitter = inherited(messages, responses, form, m);
      if (jitter <= (m.*form)->jitter) continue;
      (m.*form)->jitter = round < most_rounds ? jitter : can::kNever;
      stale[m.network] = true;
    }
  }
}

}  // namespace

void inherit_jitter(std::vector<BusMessage>& messages, const Buses& buses) {
  const auto is_whole = [](const BusMessage& m) { return m.held && m.outcome != Outcome::unfit; };
  if (std::ranges::all_of(messages, is_whole)) return;
  inherit(messages, buses, &BusMessage::message);
  inherit(messages, buses, &BusMessage::sent);
}

}  // namespace mlcca::core
