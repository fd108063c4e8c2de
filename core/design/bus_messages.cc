// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/bus_messages.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

#include "core/admission/route_check.hpp"
#include "core/can/analysis.hpp"
#include "core/design/bus_responses.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core {
namespace {

bool is_unknown(const AttributeSet& provision) {
  constexpr Attribute latency = Attribute::latency;
  return !provision.has(latency) || provision.is_dynamic(latency) ||
         provision[latency] == kUnbounded;
}

/// The hops before hop number `hop` whose delay is unknown.
std::vector<Place> unknown_before(const Verdict& v, std::size_t hop) {
  const auto places = hops_of(v.route);
  std::vector<Place> out;
  for (std::size_t i = 0; i < std::min(hop, v.hops.size()); ++i)
    if (is_unknown(v.hops[i].provision)) out.push_back(places[i]);
  return out;
}

/// The longest jitter with which it can be granted: with more it would be late for all subscribers
/// behind the bus. kNever (no limit) without a time limit, or if a hop states a Jitter above its
/// Latency, since nothing can be concluded from that.
can::Time most_jitter(const Members& members, const Verdict& v, std::size_t hop) {
  Value latest = kUnbounded;
  for (const Attribute a : {Attribute::deadline, Attribute::latency})
    if (v.requirement.has(a)) latest = std::min(latest, v.requirement[a]);
  if (latest == kUnbounded) return can::kNever;
  for (std::size_t i = 0; i < std::min(hop, v.hops.size()); ++i) {
    const AttributeSet& gives = v.hops[i].provision;
    if (gives.has(Attribute::jitter) &&
        (!gives.has(Attribute::latency) || gives[Attribute::jitter] > gives[Attribute::latency]))
      return can::kNever;
  }
  const Value source = attributes_in(members.publisher(v.publisher), v.set)[Attribute::jitter];
  return add_saturating(source, latest);
}

/// What is unknown of the route to a bus before the run time.
struct WayThere {
  std::vector<Place> unknown;
  can::Time most_jitter = 0;
};
WayThere way_to(const Members& members, const Verdict& v, std::size_t hop) {
  WayThere way{unknown_before(v, hop), 0};
  if (!way.unknown.empty()) way.most_jitter = most_jitter(members, v, hop);
  return way;
}

bool is_in_vain(const Verdict& v, std::size_t network) {
  return std::ranges::any_of(v.rows, [&](const Row& row) {
    return row.against == Against::schedule && row.place == Place{Place::Kind::network, network};
  });
}

/// The response that the check found for the refused message itself, its jitter included.
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

/// The number of frames that the check found waiting in its queue, if the queue is too short for
/// them.
std::optional<std::uint32_t> refused_frames(const Verdict& v, const can::Schedule& bus,
                                            std::size_t network, const can::Message& message) {
  for (const Row& row : v.rows) {
    const bool lost = row.against == Against::schedule && is_unfit(row) &&
                      row.place == Place{Place::Kind::network, network} &&
                      row.comparison.attribute == Attribute::omission;
    if (!lost) continue;
    const auto waits = [&](const can::Message& other) {
      return other.queue == message.queue && Ledger::publisher_of(other.key) == row.end;
    };
    if (row.end == v.publisher || std::ranges::any_of(bus.messages(), waits))
      return static_cast<std::uint32_t>(row.reserved);
  }
  return std::nullopt;
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

/// Combines two messages of one flow: the stricter values count, as on the bus.
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

void BusMessages::add_contested(const Decision& decision) {
  std::ranges::copy_if(decision.verdicts, std::back_inserter(refused_), [](const Verdict& v) {
    return !v.granted && v.outcome == Outcome::run_time;
  });
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
    WayThere way = way_to(situation.members, v, i);
    messages_.push_back({.network = places[i].index,
                         .publisher = v.publisher,
                         .from = flow.from,
                         .message = std::nullopt,
                         .sent = std::nullopt,
                         .set = v.set,
                         .outcome = v.outcome,
                         .held = true,
                         .present = true,
                         .granted_response = std::nullopt,
                         .granted_jitter = 0,
                         .refused_response = std::nullopt,
                         .refused_jitter = 0,
                         .refused_frames = std::nullopt,
                         .in_vain = false,
                         .unknown = std::move(way.unknown),
                         .most_jitter = way.most_jitter,
                         .before = bus_before(situation.system, ledger, v, i)});
  }
}

/// Adds a message, or combines it with that of the same flow for another place: the stricter values
/// count. If it is held for one place only, it is sent with the values for that one.
void BusMessages::put(BusMessage next) {
  const auto [at, fresh] = known_.try_emplace(order_of(next), messages_.size());
  if (fresh) {
    messages_.push_back(std::move(next));
    return;
  }
  BusMessage& there = messages_[at->second];
  there.several = true;
  if (there.held == next.held)
    join(there.sent, next.sent);
  else if (next.held)
    there.sent = next.sent;
  // What is refused for one place still crosses the bus for the others, if granted for any.
  if (there.outcome == Outcome::unfit)
    there.outcome = next.outcome;
  else if (next.outcome != Outcome::unfit)
    there.outcome = worse(there.outcome, next.outcome);
  // What is granted for one place harms nobody here, for whatever reason it is refused for another.
  if (there.held == next.held)
    there.in_vain = there.in_vain || next.in_vain;
  else if (next.held)
    there.in_vain = next.in_vain;
  there.held = there.held || next.held;
  there.present = there.present || next.present;
  if (there.held) {
    there.refused_response.reset();
    there.refused_frames.reset();
  } else if (next.refused_response) {
    there.refused_response = next.refused_response;
    there.refused_jitter = next.refused_jitter;
  }
  if (!there.held && next.refused_frames) there.refused_frames = next.refused_frames;
  for (const Place place : next.unknown)
    if (std::ranges::find(there.unknown, place) == there.unknown.end())
      there.unknown.push_back(place);
  there.most_jitter = std::max(there.most_jitter, next.most_jitter);
  join(there.message, next.message);
}

void BusMessages::add_refused(const Situation& situation, Ledger& ledger, Verdict v) {
  const Publisher& publisher = situation.members.publisher(v.publisher);
  if (hops_of(v.route).empty()) {
    // No route leads there, but what is published is on the publisher's own network all the same.
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
  for (const TriedMessage& t : tried) {
    WayThere way = way_to(situation.members, again, t.hop);
    put({.network = places[t.hop].index,
         .publisher = v.publisher,
         .from = flow_on(situation.system, v.publisher, again.route, t.hop).from,
         .message = t.message,
         .sent = t.message,
         .set = v.set,
         .outcome = v.outcome,
         .held = false,
         .present = places[t.hop] == publisher.place,
         .granted_response = std::nullopt,
         .granted_jitter = 0,
         .refused_response =
             t.message ? refused_response(v, places[t.hop].index, *t.message) : std::nullopt,
         .refused_jitter = t.message ? t.message->jitter : 0,
         .refused_frames = t.message ? refused_frames(v, *ledger.schedule(places[t.hop].index),
                                                      places[t.hop].index, *t.message)
                                     : std::nullopt,
         .in_vain = is_in_vain(v, places[t.hop].index),
         .unknown = std::move(way.unknown),
         .most_jitter = way.most_jitter,
         .before = bus_before(situation.system, ledger, again, t.hop)});
  }
}

/// Fills in the messages and response times of what is granted.
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

using Form = std::optional<can::Message> BusMessage::*;

bool is_from_elsewhere(const BusMessage& m) { return m.from != Flow::kOwn; }

void find_all_known(InspectedBuses& buses) {
  buses.forms_known.assign(buses.assumptions.size(), true);
  for (std::size_t n = 0; n < buses.varying.size(); ++n)
    if (!buses.varying[n].empty()) buses.forms_known[n] = false;
  for (const BusMessage& m : buses.messages)
    if (m.is_counted() && !m.sent) buses.forms_known[m.network] = false;
  buses.all_known = buses.forms_known;
  for (const BusMessage& m : buses.messages)
    if (m.is_counted() && !m.unknown.empty()) buses.all_known[m.network] = false;
}

/// Computes `guarded`, before it is known where messages may be later than admission found.
void find_guarded(InspectedBuses& buses) {
  buses.guarded.assign(buses.assumptions.size(), true);
  // Whether more messages can be there than if all best cases hold.
  std::vector<bool> more = buses.all_known;
  more.flip();
  for (const BusMessage& m : buses.messages)
    if (m.is_counted() && !m.present) more[m.network] = true;
  for (const BusMessage& m : buses.messages) {
    if (m.present && !m.held) buses.guarded[m.network] = false;
    // The stricter of two deadlines holds only while the place that needs it is granted.
    if (m.several && m.is_counted() && m.outcome != Outcome::fit) buses.guarded[m.network] = false;
    // If it is refused at run time it is sent all the same, and others may be granted in its place.
    const bool may_be_refused = m.held && m.outcome != Outcome::fit && !is_from_elsewhere(m);
    if (may_be_refused && more[m.network]) buses.guarded[m.network] = false;
  }
}

/// Sets the jitter of messages to what they inherit from the bus before, in one of their two forms.
class Inheritance {
 public:
  Inheritance(InspectedBuses& buses, Form form)
      : buses_(buses), form_(form), responses_(buses.messages.size()) {}

  void run() {
    constexpr unsigned most_rounds = 256;  // each makes something later
    std::vector<bool> stale(buses_.assumptions.size(), true);
    for (unsigned round = 0; std::ranges::find(stale, true) != stale.end(); ++round) {
      for (std::size_t n = 0; n < stale.size(); ++n) {
        if (stale[n] && buses_.assumptions[n]) analyse_bus(n);
        stale[n] = false;
      }
      for (BusMessage& m : buses_.messages)
        if (takes_over(m, round < most_rounds)) stale[m.network] = true;
    }
  }

 private:
  [[nodiscard]] bool is_of_all() const { return form_ == &BusMessage::message; }

  void analyse_bus(std::size_t network) {
    std::vector<std::size_t> here;
    std::vector<can::Message> on_bus;
    std::vector<Standing> standing;
    for (std::size_t i = 0; i < buses_.messages.size(); ++i) {
      const BusMessage& m = buses_.messages[i];
      if (m.network != network || !(m.*form_)) continue;
      here.push_back(i);
      on_bus.push_back(*(m.*form_));
      on_bus.back().key = i;
      standing.push_back(is_of_all() ? Standing{} : standing_of(buses_, m));
    }
    const auto found = responses_beside(*buses_.assumptions[network], on_bus, standing,
                                        is_of_all() ? Known::all : known_of(buses_, network));
    for (std::size_t i = 0; i < here.size(); ++i) responses_[here[i]] = found[i].response;
  }

  [[nodiscard]] const BusMessage* before(const BusMessage& m) const {
    if (!m.before) return nullptr;
    const std::tuple wanted(m.before->network, m.publisher, m.before->from);
    const auto last = std::ranges::lower_bound(buses_.messages, wanted, {}, order_of);
    const bool found = last != buses_.messages.end() && order_of(*last) == wanted && (*last).*form_;
    return found ? &*last : nullptr;
  }

  /// Returns whether something on its bus may be later now.
  bool takes_over(BusMessage& m, bool bounded) {
    const BusMessage* const last = m.*form_ ? before(m) : nullptr;
    if (last == nullptr) return false;
    const bool guarded_before = is_of_all() || buses_.guarded[last->network];
    bool changed = false;
    if (!guarded_before && !buses_.all_known[last->network] && m.is_counted()) {
      changed = buses_.all_known[m.network] || buses_.forms_known[m.network];
      buses_.all_known[m.network] = buses_.forms_known[m.network] = false;
    }
    const can::Response& r = responses_[static_cast<std::size_t>(last - buses_.messages.data())];
    const Value jitter =
        r.bounded && bounded ? add_saturating(r.response, m.before->added) : can::kNever;
    if (jitter > (m.*form_)->jitter) {
      (m.*form_)->jitter = jitter;
      changed = true;
    }
    if (changed && !guarded_before && m.is_counted()) buses_.guarded[m.network] = false;
    return changed;
  }

  InspectedBuses& buses_;
  Form form_;
  std::vector<can::Response> responses_;
};

}  // namespace

void inherit_jitter(InspectedBuses& buses) {
  find_all_known(buses);
  find_guarded(buses);
  const auto is_whole = [](const BusMessage& m) { return m.held && m.outcome != Outcome::unfit; };
  if (std::ranges::all_of(buses.messages, is_whole)) return;
  Inheritance(buses, &BusMessage::message).run();
  Inheritance(buses, &BusMessage::sent).run();
}

}  // namespace mlcca::core
