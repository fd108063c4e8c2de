// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/late_hint.hpp"

#include <algorithm>
#include <cstdint>

#include "core/can/level.hpp"
#include "core/can/of_system.hpp"
#include "core/design/hints.hpp"
#include "core/model/text.hpp"
#include "core/model/topology.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core {
namespace {

bool is_too_much_jitter(const can::Schedule& bus, can::Message message, Value jitter) {
  message.jitter = jitter;
  return can::unusable(bus.assumptions(), message) == can::Unusable::jitter ||
         (message.period != 0 && jitter / message.period >= can::kMaxInstances);
}

/// The late publisher or the new one, if the tag of its frames on the bus is unknown; null
/// otherwise.
const Publisher* untagged_of(const Situation& s, const Verdict& v, const Row& row) {
  for (const std::size_t number : {std::size_t{row.end}, v.publisher}) {
    const Publisher& p = s.members.publisher(number);
    const Binding* const binding = s.system.networks[row.place.index].binding_of(p.channel);
    if (binding != nullptr && binding->waits_for_tag()) return &p;
  }
  return nullptr;
}

std::string without_promise(const System& system, const Row& row, Value promised) {
  return "state no Latency of " + name_of(system, row.place) +
         ", or one that its bit rate can keep: it promises " +
         format_value(Attribute::latency, promised);
}

/// The hint if the stated Latency of the bus is the limit; empty otherwise.
std::string promise_of(const System& system, const Row& row) {
  const AttributeSet& provision = system.networks[row.place.index].provision;
  if (!provision.has(Attribute::latency) ||
      provision[Attribute::latency] != row.comparison.required)
    return {};
  return without_promise(system, row, row.comparison.required);
}

/// The hint if the bus states less than the frames of one event take; empty otherwise.
std::string unkept_promise(const System& system, const Row& row, const can::Message& own) {
  const AttributeSet& provision = system.networks[row.place.index].provision;
  if (!provision.has(Attribute::latency) || own.transmission <= provision[Attribute::latency])
    return {};
  return without_promise(system, row, provision[Attribute::latency]) +
         ", and the frames of one event take " + format_value(Attribute::latency, own.transmission);
}

/// The hint if a Jitter limits the time more than a Latency does, since the delay of a bus counts
/// as both; empty otherwise.
std::string jitter_hint(const System& system, const Verdict& v, const Row& row) {
  const std::string bus = name_of(system, row.place);
  const AttributeSet& gives = system.networks[row.place.index].provision;
  if (gives.has(Attribute::latency) && gives.has(Attribute::jitter) &&
      gives[Attribute::jitter] < gives[Attribute::latency] &&
      row.comparison.required <= gives[Attribute::jitter])
    return "state a larger Jitter of " + bus +
           ", or none: what it delays counts as Jitter too, and " +
           format_value(Attribute::jitter, gives[Attribute::jitter]) + " is what it promises";
  if (!v.requirement.has(Attribute::jitter)) return {};
  const Value jitter = v.requirement[Attribute::jitter];
  for (const Attribute a : {Attribute::deadline, Attribute::latency})
    if (v.requirement.has(a) && v.requirement[a] <= jitter) return {};
  if (row.comparison.required > jitter) return {};
  return "allow more Jitter: what a bus delays counts as Jitter, and " +
         format_value(Attribute::jitter, jitter) + " is required";
}

/// The hint if the gateways on the route use most of the time; empty otherwise.
std::string gateways_hint(const System& system, const Verdict& v, const std::string& late) {
  Value asked = kUnbounded;
  for (const Attribute a : {Attribute::deadline, Attribute::latency})
    if (v.requirement.has(a)) asked = std::min(asked, v.requirement[a]);
  Value taken = 0;
  for (const Place hop : hops_of(v.route))
    if (const AttributeSet& gives = system.provision_of(hop);
        hop.kind == Place::Kind::gateway && gives.has(Attribute::latency))
      taken = add_saturating(taken, gives[Attribute::latency]);
  if (asked == kUnbounded || taken <= asked / 2) return {};
  return "allow " + late + " more time, or let the gateways on its way take less: they take " +
         format_value(Attribute::latency, taken) + " of its " +
         format_value(Attribute::latency, asked);
}

/// The hint if the pauses of a sender between frames are the cause; empty otherwise.
std::string pauses_hint(const std::string& late, const can::Message& own, const Row& row) {
  const bool bounded = row.comparison.provided != kUnbounded;
  const Value taken = add_saturating(own.transmission, own.pauses);
  if (own.pauses == 0 || taken <= (bounded ? row.comparison.required : own.period)) return {};
  const std::string most = format_value(Attribute::latency, taken);
  return (bounded ? "allow " + late + " more time" : "let " + late + " send less often") +
         ", or let its events fit one frame: the transport protocol sends " +
         std::to_string(own.frames) + " frames for each, which take up to " + most +
         " with the pauses between them" +
         (bounded
              ? ""
              : ", and the next event comes after " + format_value(Attribute::period, own.period));
}

/// The hint if the cause is in the message itself or in its requirements; empty otherwise.
std::string own_hint(const System& system, const Verdict& v, const Row& row,
                     const can::Message& own, const std::string& late) {
  std::string hint = unkept_promise(system, row, own);
  if (hint.empty() && row.end == v.publisher) hint = jitter_hint(system, v, row);
  return hint.empty() ? pauses_hint(late, own, row) : hint;
}

// The hint for a message that waits for others: a better identifier, if there is one.
std::string identifier_hint(const can::Schedule& bus, const std::optional<can::Message>& newcomer,
                            const std::optional<can::Message>& own, const std::string& late) {
  // With several identifiers the lowest priority determines how long it waits.
  const auto goes_before = [&](const can::Message& m) {
    return m.priority < std::max(own->priority, own->lowest_priority);
  };
  if (own && std::ranges::none_of(bus.messages(), goes_before) &&
      !(newcomer && goes_before(*newcomer)))
    return "allow " + late +
           " more time, send smaller events, or use a faster bus: no identifier there is better "
           "than its own";
  return "give " + late +
         " a better identifier if there is an order for all (mlccactl analyse-bus --assign), send "
         "less often, or allow more time";
}

/// Whether everything that is described for a bus, granted or not, takes more time than it has:
/// what its own publishers send there, and what is subscribed on it. It stops at the first message
/// that is too much.
bool is_asked_too_much(const Situation& s, std::size_t network, const can::Timing& timing) {
  const Place bus{Place::Kind::network, network};
  const auto subscribed_there = [&](std::size_t channel) {
    return std::ranges::any_of(s.members.subscribers_of(channel), [&](std::size_t subscriber) {
      return s.members.subscriber(subscriber).place == bus;
    });
  };
  std::uint64_t all = 0;
  for (std::size_t c = 0; c < s.system.channels.size(); ++c)
    for (const std::size_t number : s.members.publishers_of(c)) {
      if (s.members.publisher(number).place != bus && !subscribed_there(c)) continue;
      const auto m = can::message_of(s.system, s.members.publisher(number), 0, network, timing);
      if (m && m->period != 0)
        all = add_saturating(all, mul_div_up(m->transmission, mesh::kWhole, m->period));
      if (all > mesh::kWhole) return true;
    }
  return false;
}

// The hint if another node claims the newcomer's address; empty otherwise.
std::string address_hint(const Situation& s, const can::Schedule& bus, const Verdict& v,
                         const Row& row, const can::Message& newcomer) {
  constexpr std::uint32_t address = 0xff;  // the address bits of can::Message::sender
  if (newcomer.sender == can::kNoSender) return {};
  const Publisher& publisher = s.members.publisher(v.publisher);
  for (const can::Message& m : bus.messages()) {
    if (m.sender == can::kNoSender || ((m.sender ^ newcomer.sender) & address) != 0 ||
        Ledger::is_of_other(m.key))
      continue;
    const Publisher& other = s.members.publisher(Ledger::publisher_of(m.key));
    if ((other.place == row.place) == (publisher.place == row.place)) continue;
    return address_words(publisher.name, other.name, m.sender, name_of(s.system, row.place)) +
           "; give one of them another node";
  }
  return {};
}

// The hint if the messages together need more time than the bus has; empty otherwise.
std::string overload_hint(const can::Schedule& bus, const std::optional<can::Message>& newcomer) {
  const std::uint64_t all =
      bus.utilisation_ppm() +
      (newcomer ? mul_div_up(newcomer->transmission, mesh::kWhole, newcomer->period) : 0);
  if (all <= mesh::kWhole) return {};
  const std::uint64_t tenths = all / (mesh::kWhole / 1000);
  return "send less often, or use a faster bus: what is granted there and these frames would "
         "take " +
         std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " % of the time";
}

}  // namespace

std::string late_hint(const Situation& s, const can::Schedule& bus, const Verdict& v,
                      const Row& row) {
  const can::Timing& timing = bus.assumptions().timing;
  const auto message_of = [&](std::size_t publisher, std::size_t set) {
    return can::message_of(s.system, s.members.publisher(publisher), set, row.place.index, timing);
  };
  const std::string& late = s.members.publisher(row.end).name;
  const auto newcomer = message_of(v.publisher, v.set);
  if (newcomer)
    if (std::string hint = address_hint(s, bus, v, row, *newcomer); !hint.empty()) return hint;
  if (std::string hint = overload_hint(bus, newcomer); !hint.empty()) return hint;
  const auto own = row.end == v.publisher ? newcomer : message_of(row.end, v.set);
  if (own)
    if (std::string hint = own_hint(s.system, v, row, *own, late); !hint.empty()) return hint;
  const Value jitter = attributes_in(s.members.publisher(row.end), v.set)[Attribute::jitter];
  if (own && row.comparison.provided == kUnbounded && is_too_much_jitter(bus, *own, jitter))
    return "state a smaller Jitter of " + late + ": " + format_value(Attribute::jitter, jitter) +
           " is more than what is analysed";
  if (row.comparison.provided == kUnbounded)
    return "send less often: what goes before these frames can take all of the bus";
  if (row.comparison.required == 0)
    return "allow more time, or let the rest of the way take less: state shorter times of it";
  if (row.end == v.publisher)
    if (std::string hint = gateways_hint(s.system, v, late); !hint.empty()) return hint;
  if (own && own->transmission > row.comparison.required)
    return "allow " + late +
           " more time, let it send smaller events, or use a faster bus: its frames "
           "alone take " +
           format_value(Attribute::latency, own->transmission);
  if (const Publisher* const untagged = untagged_of(s, v, row))
    return "state the ETag of channel " + s.system.channels[untagged->channel].name + " on " +
           name_of(s.system, row.place) +
           " in place of dynamic: as long as it is not known, it counts as the first one for "
           "others and as the last one for " +
           untagged->name;
  if (std::string promise = promise_of(s.system, row); !promise.empty()) return promise;
  if (is_asked_too_much(s, row.place.index, timing))
    return "send less often, or use a faster bus: all that is described for " +
           name_of(s.system, row.place) +
           " takes more than all of its time, so another order of identifiers only lets others be "
           "late";
  return identifier_hint(bus, newcomer, own, late);
}

}  // namespace mlcca::core
