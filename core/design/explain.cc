// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/explain.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "base/many.hpp"
#include "core/can/level.hpp"
#include "core/can/of_system.hpp"
#include "core/can/schedule.hpp"
#include "core/design/finding_of.hpp"
#include "core/design/hints.hpp"
#include "core/design/late_hint.hpp"
#include "core/design/room.hpp"
#include "core/gates/relay_gate.hpp"
#include "core/mesh/mesh.hpp"
#include "core/model/medium.hpp"
#include "core/model/text.hpp"
#include "core/model/user_values.hpp"
#include "mlcca/arithmetic.hpp"
#include "mlcca/check.hpp"
#include "mlcca/compose.hpp"

namespace mlcca::core {
namespace {

/// Whether another row of the same network states a tighter limit of the bandwidth. If a network
/// states a bandwidth and its links are known, a reader needs only the tighter one.
bool has_tighter(const Verdict& v, const Row& row) {
  const auto is_limit = [](const Row& one) {
    return (one.against == Against::capacity || one.against == Against::medium_time) &&
           one.comparison.attribute == Attribute::bandwidth && is_unfit(one);
  };
  return is_limit(row) && std::ranges::any_of(v.rows, [&](const Row& other) {
           return other.place == row.place && is_limit(other) &&
                  (other.comparison.provided < row.comparison.provided ||
                   (other.comparison.provided == row.comparison.provided && &other < &row));
         });
}

/// Lists the places of a route: "robot-can, bridge, second-can".
std::string way_of(const System& system, const Route& route) {
  std::string text;
  for (const Place place : route) text += (text.empty() ? "" : ", ") + name_of(system, place);
  return text;
}

/// The name of the endpoint that states the required value; the subscriber if both do.
const std::string& asker(const Situation& s, const Verdict& v, const Row& row,
                         std::size_t subscriber) {
  const Publisher& publisher = s.members.publisher(v.publisher);
  const Subscriber& listener = s.members.subscriber(subscriber);
  const Value required = row.comparison.required;
  if (row.is_user()) {
    const UserValues& stated = user_values_in(listener, v.set);
    const bool own = std::ranges::any_of(
        stated, [&](const UserValue& u) { return u.attribute == row.user && u.value == required; });
    return own ? listener.name : publisher.name;
  }
  const Attribute a = row.comparison.attribute;
  const AttributeSet alone = requirement_between(attributes_in(publisher, v.set), {});
  const bool publishers = alone.has(a) && alone[a] == required;
  const AttributeSet stated = normalised_requirement(attributes_in(listener, v.set));
  const bool subscribers = stated.has(a) && stated[a] == required;
  return subscribers || !publishers ? listener.name : publisher.name;
}

/// States what is provided and the margin. A payload that is accepted is an upper limit and has no
/// margin; what is unbounded is said once.
std::string numbers_of(const System& system, const Row& row) {
  const Comparison& c = row.comparison;
  if (!c.known) return "none";
  std::string text = format_bound(system, row).bound;
  if (!row.is_user() && held_against(c.attribute) != c.attribute)
    text = std::string(info(held_against(c.attribute)).name) + " " + text;
  if (c.provided == kUnbounded && !row.is_user() && c.attribute == Attribute::omission)
    return "no bound for events of several frames";
  if (is_most(row) || c.provided == kUnbounded) return text;
  return text + " (" + format_margin(system, row) + ")";
}

/// The name of the attribute that must be stated or improved: for a Deadline the Latency, since
/// nobody provides a Deadline.
std::string provided_name(const System& system, const Row& row) {
  if (row.is_user()) return attribute_name(system, row);
  return info(held_against(row.comparison.attribute)).name;
}

/// Where a hop states what it provides of the attribute. PerHop has no user-defined attributes.
std::string stated_by(const System& system, const Row& row) {
  const Place place = row.place;
  const bool is_mesh = place.kind == Place::Kind::network && system.networks[place.index].mesh;
  if (!is_mesh) return name_of(system, place);
  return (row.is_user() ? "the Provision of " : "PerHop of ") + name_of(system, place);
}

/// Whether what a mesh provides is composed of what its links provide, because the mesh itself
/// states nothing worse.
bool follows_from_links(const System& system, const Row& row) {
  if (row.is_user() || row.place.kind != Place::Kind::network) return false;
  const Network& network = system.networks[row.place.index];
  const Attribute a = held_against(row.comparison.attribute);
  const AttributeSet& stated = network.provision;
  return network.mesh && network.mesh->per_hop.has(a) &&
         (!stated.has(a) || stated[a] != row.comparison.provided);
}

std::string no_path_hint(const Network& network) {
  if (network.mesh->nodes.empty()) return "describe the nodes of the mesh";
  if (!no_links_words(network).empty()) return kNoLinksHint;
  return "state the links that lead there, each in its direction, or a source that knows them; "
         "without a mesh-node an end may be at any node";
}

/// Whether long events are carried in fragments there.
bool is_of_fragments(const Network& network) {
  return network.carries_subjects() && network.kind != NetworkKind::ieee802154;
}

std::string echo_hint(const Verdict& v) {
  return v.obstacle_at.kind == Place::Kind::gateway
             ? "state the address of each publisher of the channel, or a Route over gateways that "
               "form no ring"
             : "let one gateway bring them there: change a Route";
}

std::string carrier_hint(const System& system, const Verdict& v) {
  const bool has_relay = system.gateways[v.obstacle_at.index].forwarder == Forwarder::relay;
  return std::string("add sender=\"USER\" to the Port that the events leave by") +
         (has_relay ? "" : ", or forward=\"relay\" to the Gateway: then mlcca-relay carries them");
}

/// Whether the omission is unbounded because events take several frames: such an event is lost with
/// any of its frames, and nothing bounds how many events in a row that affects.
bool is_unbounded_omission(const Row& row) {
  return !row.is_user() && row.comparison.attribute == Attribute::omission &&
         row.comparison.provided == kUnbounded;
}

/// What would make a hop provide what is required.
std::string hop_hint(const System& system, const Row& row, const std::string& required) {
  const std::string provided = provided_name(system, row);
  const std::string& place = name_of(system, row.place);
  if (!row.comparison.known)
    return "state " + provided + " of " + stated_by(system, row) +
           ": what is not stated is not given";
  if (is_unbounded_omission(row))
    return "send events that fit one frame of " + place + ", or let it lose none (Omission 0)";
  if (follows_from_links(system, row))
    return "each link has the " + provided +
           " that PerHop states: let it be better, take fewer links, or ask less";
  return "let " + place + " provide " + provided + " " + required +
         " or better, ask less, or take another route";
}

/// The hint for FD frames on buses that state no data bit rate; it covers all such buses of the
/// route.
std::string data_rate_hint(const System& system, const Verdict& v, const Publisher& publisher) {
  std::string hint;
  for (const Place hop : hops_of(v.route)) {
    if (hop.kind != Place::Kind::network) continue;
    const Network& network = system.networks[hop.index];
    const Binding* const binding = network.binding_of(v.channel);
    const bool lacking = binding != nullptr && binding->format != FrameFormat::classic &&
                         network.bus.bitrate != 0 && network.bus.data_bitrate == 0;
    if (lacking || hop == v.obstacle_at)
      hint += (hint.empty() ? "add data-bitrate to the Bus of Network " : " and of Network ") +
              network.name;
  }
  const AttributeSet& offered = attributes_in(publisher, v.set);
  const bool fits_classic =
      offered.has(Attribute::max_payload) && offered[Attribute::max_payload] <= kClassicBytes;
  return fits_classic ? hint + ", or let the Binding have format=\"classic\"" : hint;
}

/// Whether a Deadline is stated; false if it only follows from a Period.
bool states_deadline(const Situation& s, const Verdict& v, std::size_t subscriber) {
  if (attributes_in(s.members.publisher(v.publisher), v.set).has(Attribute::deadline)) return true;
  return subscriber != kNone &&
         attributes_in(s.members.subscriber(subscriber), v.set).has(Attribute::deadline);
}

}  // namespace

Finding& Explainer::new_finding(FindingId id, const Verdict& v) {
  Finding& f = findings_.emplace_back();
  f.id = id;
  f.origin = s_.members.publisher(v.publisher).origin;
  f.channel = static_cast<std::uint32_t>(v.channel);
  f.publisher = static_cast<std::uint32_t>(v.publisher);
  return f;
}

Finding& Explainer::new_finding(FindingId id, std::size_t channel) {
  Finding& f = findings_.emplace_back();
  f.id = id;
  f.origin = s_.system.channels[channel].origin;
  f.channel = static_cast<std::uint32_t>(channel);
  return f;
}

void Explainer::add(const Verdict& v) {
  if (v.outcome == Outcome::fit) return;
  if (v.outcome == Outcome::run_time) {
    add_run_time(v);
    return;
  }
  // Of two senders of one identifier both are named, see Inspection.
  const bool obstructed = v.obstacle != Obstacle::none && v.obstacle != Obstacle::sender_twice;
  if (obstructed) add_obstacle(v);
  if (obstructed && id_of(v.obstacle) != FindingId::no_traffic) return;
  for (const std::size_t subscriber : v.subscribers) add_pair(v, subscriber);
  for (const Row& row : v.rows) {
    if (!is_unfit(row) || has_tighter(v, row)) continue;
    if (row.against == Against::capacity) add_capacity(v, row);
    if (row.against == Against::overhearing) add_row(v, row, kNone);
    if (is_about_medium(row)) add_medium(v, row);
  }
}

void Explainer::add_obstacle(const Verdict& v) {
  const Publisher& publisher = s_.members.publisher(v.publisher);
  Finding& f = new_finding(id_of(v.obstacle), v);
  const std::string ends =
      publisher.name + " to " + s_.members.subscriber(v.subscribers.front()).name + ": ";
  f.subscriber = static_cast<std::uint32_t>(v.subscribers.front());
  f.text = ends + reason(s_.system, s_.members, v);
  const std::string& channel = s_.system.channels[v.channel].name;
  if (v.obstacle != Obstacle::no_route) {
    f.place = v.obstacle_at;
    f.has_place = true;
  }
  switch (v.obstacle) {
    case Obstacle::no_route:
      f.hint = "join the networks by a Gateway with a Port on each";
      break;
    case Obstacle::unbound:
      f.origin = s_.system.networks[v.obstacle_at.index].origin;
      f.hint = "add <Binding channel=\"" + channel + "\"> to Network " +
               name_of(s_.system, v.obstacle_at);
      break;
    case Obstacle::no_node:
      f.hint = publisher.node ? "give the publisher another node"
                              : "add attribute node to the publisher";
      break;
    case Obstacle::too_long:
      f.hint = is_of_fragments(s_.system.networks[v.obstacle_at.index])
                   ? "publish a smaller MaxPayload: no network carries longer events"
                   : "publish a smaller MaxPayload, or use a network with longer frames";
      break;
    case Obstacle::no_data_rate:
      f.origin = s_.system.networks[v.obstacle_at.index].origin;
      f.hint = data_rate_hint(s_.system, v, publisher);
      break;
    case Obstacle::no_path:
      f.hint = no_path_hint(s_.system.networks[v.obstacle_at.index]);
      break;
    case Obstacle::no_rate:
      f.hint =
          "add a Source that knows rates: nl80211, batman, olsr, wire, a file, or awds with "
          "metric=\"packet-pair\"";
      break;
    case Obstacle::links_absent:
      f.hint = "see 'mlccactl routes': its source of presence does not report these links";
      break;
    case Obstacle::links_must_last:
      f.hint = "wait until the links have lasted, or state a shorter hold-up of the Mesh";
      break;
    case Obstacle::relay_gated:
      for (const Place hop : hops_of(v.route))
        if (hop.kind == Place::Kind::network &&
            relay_gate(s_.system, hop.index, v.obstacle_at.index) != RelayGate::none)
          f.hint = relay_hint(s_.system, hop.index, v.obstacle_at.index);
      break;
    case Obstacle::echo:
      f.hint = echo_hint(v);
      break;
    case Obstacle::no_sender:
      f.hint = carrier_hint(s_.system, v);
      break;
    case Obstacle::renamed:
      f.hint = "let both Bindings have one PGN, one priority and classic frames";
      break;
    case Obstacle::untagged:
    case Obstacle::contradicted:
      f.hint = "state the tags as the broker deals them, in the order of requests, or dynamic";
      break;
    case Obstacle::no_traffic:
      f.hint = "state Period and MaxPayload, or Bandwidth, of the publisher";
      break;
    case Obstacle::no_period:
      f.hint = "state the shortest Period of the publisher";
      break;
    default:
      break;
  }
}

std::vector<std::string> Explainer::open_on_bus(const Verdict& v, Place hop) const {
  if (hop.kind != Place::Kind::network) return {};
  const Network& network = s_.system.networks[hop.index];
  const Binding* binding = network.binding_of(v.channel);
  if (binding == nullptr || network.kind != NetworkKind::can) return {};
  std::vector<std::string> open;
  if (binding->waits_for_tag()) open.push_back("the tag on " + network.name);
  if (binding->format != FrameFormat::classic && ledger_.schedule(hop.index) == nullptr)
    open.push_back("the data bit rate of " + network.name);
  return open;
}

void Explainer::add_run_time(const Verdict& v) {
  Finding& f = new_finding(FindingId::run_time, v);
  std::string what;
  const auto add = [&](const std::string& words) { what += (what.empty() ? "" : ", ") + words; };
  const auto point_to = [&](Place place) {
    if (!f.has_place) f.place = place;
    f.has_place = true;
  };
  for (const Row& row : v.rows) {
    if (row.comparison.outcome != Outcome::run_time) continue;
    if (row.against == Against::hop) point_to(row.place);
    const std::string name = attribute_name(s_.system, row);
    if (what.find(name) == std::string::npos)
      add(name + " " + format_value(s_.system, row, row.comparison.required));
  }
  if (const Row* const row = want_of_room(v)) {
    add(open_room_words(s_.system, *row));
    point_to(row->place);
    if (row->against == Against::schedule && row->comparison.attribute != Attribute::omission)
      f.hint = late_hint(s_, *ledger_.schedule(row->place.index), v, *row);
  }
  if (v.contested && what.empty())
    add("whether there is room for it beside what else is decided at run time");
  for (const Place hop : hops_of(v.route)) {
    for (const std::string& words : open_on_bus(v, hop)) {
      add(words);
      point_to(hop);
    }
  }
  f.text = s_.members.publisher(v.publisher).name + " to " + name_of(s_.system, v.to) + " over " +
           way_of(s_.system, v.route) + ": decided at run time (" + what + ")";
}

void Explainer::add_lower_set(std::size_t channel, std::size_t set, Outcome outcome) {
  if (set == 0) return;
  const EventChannel& c = s_.system.channels[channel];
  new_finding(FindingId::lower_set, channel).text =
      "channel " + c.name + ": the attribute set of priority " + std::to_string(c.priority) +
      " does not fit, that of priority " + std::to_string(c.lower[set - 1].priority) +
      (outcome == Outcome::run_time ? " would be used" : " is used");
}

void Explainer::add_open_set(std::size_t channel) {
  new_finding(FindingId::run_time, channel).text =
      "channel " + s_.system.channels[channel].name +
      ": which of its attribute sets is used is decided at run time, since that depends on best "
      "cases of other channels";
}

void Explainer::add_pair(const Verdict& v, std::size_t subscriber) {
  Verdict pair = undecided(s_, v.channel, v.publisher, {v.to, {subscriber}}, v.set);
  pair.route = v.route;
  const Ledger::Mark before = ledger_.mark();
  check_route(s_, ledger_, {}, pair);
  ledger_.roll_back(before);
  for (const Row& row : pair.rows) {
    if (!is_unfit(row) || row.against == Against::capacity || is_about_medium(row)) continue;
    if (pair.obstacle != Obstacle::none && is_left_open(row)) continue;
    // Free medium time is computed for all subscribers together, so its row is in `v`.
    if (row.against == Against::hop && is_said_by_another(v, row)) continue;
    if (is_said_by_another(pair, row)) continue;
    add_row(pair, row, subscriber);
  }
}

/// Whether the row's provision is unknown only because of an obstacle. It must not be reported as
/// not provided.
bool Explainer::is_left_open(const Row& row) const {
  if (row.comparison.known) return false;
  if (row.against == Against::end_to_end) return true;
  return row.against == Against::hop && row.place.kind == Place::Kind::network &&
         (ledger_.schedule(row.place.index) != nullptr ||
          s_.world.meshes[row.place.index] != nullptr);
}

void Explainer::add_row(const Verdict& v, const Row& row, std::size_t subscriber) {
  const System& system = s_.system;
  const Comparison& c = row.comparison;
  Finding& f = new_finding(id_of(row.against), v);
  const std::string& publisher = s_.members.publisher(v.publisher).name;
  f.attribute = attribute_name(system, row);
  const BoundWords words = format_bound(system, row);
  f.required = c.known ? words.limit : format_value(system, row, c.required);
  f.provided = c.known ? words.bound : "not provided";
  if (row.against == Against::hop || row.against == Against::overhearing) {
    f.place = row.place;
    f.has_place = true;
  }
  std::string listener = "its subscribers";
  if (subscriber != kNone) {
    const Subscriber& s = s_.members.subscriber(subscriber);
    f.subscriber = static_cast<std::uint32_t>(subscriber);
    f.origin = s.origin;
    listener = s.name;
  }
  const std::string numbers = numbers_of(system, row);
  const bool implied = !row.is_user() && c.attribute == Attribute::deadline &&
                       row.against != Against::traffic && !states_deadline(s_, v, subscriber);
  const std::string asked =
      f.attribute + " " + f.required + (implied ? " (implied by the Period)" : "");
  switch (row.against) {
    case Against::traffic:
      f.text = listener + " asks " + f.attribute + " " + f.required + " of " + publisher +
               ", which offers " + numbers;
      f.hint = c.known ? "let " + publisher + " offer " + f.attribute + " " + f.required +
                             ", or ask less"
                       : "state " + f.attribute + " of " + publisher;
      break;
    case Against::hop:
      f.text = publisher + " to " + listener + ": " + asked + " required by " +
               asker(s_, v, row, subscriber) + ", " + name_of(system, row.place) + " provides " +
               numbers;
      f.hint = hop_hint(system, row, f.required);
      break;
    case Against::overhearing:
      f.text = publisher + " to " + name_of(system, v.to) + ": " + f.attribute + " " + f.required +
               " required by subscribers on " + name_of(system, row.place) +
               ", which lies on the way and is given " + numbers;
      f.hint = "they receive the events too: fulfil them, or let them subscribe elsewhere";
      break;
    default:
      f.text = publisher + " to " + listener + ": " + asked + " required end to end by " +
               asker(s_, v, row, subscriber) + ", the way over " + way_of(system, v.route) +
               " provides " + numbers;
      f.hint = "let a hop provide better, take a shorter way, or ask less";
  }
}

void Explainer::add_medium(const Verdict& v, const Row& row) {
  const Comparison& c = row.comparison;
  const bool queue = row.against == Against::schedule && c.attribute == Attribute::omission;
  Finding& f = new_finding(queue ? FindingId::queue_too_short : id_of(row.against), v);
  const std::string& publisher = s_.members.publisher(v.publisher).name;
  f.place = row.place;
  f.has_place = true;
  if (queue) f.frames_of = static_cast<std::uint32_t>(row.end);
  f.attribute = queue ? "queue-length" : info(c.attribute).name;
  const BoundWords words = format_bound(c.attribute, c.provided, c.required);
  f.required = queue ? many(row.reserved, "frame") : words.limit;
  f.provided = queue ? many(row.room, "frame") : words.bound;
  if (row.against == Against::schedule) {
    f.text = "with " + publisher + ", " + schedule_text(s_.system, s_.members, row);
    if (queue)
      f.hint = queue_hint(row.reserved,
                          "mlccactl analyse-bus says what all messages of the bus "
                          "need together");
    else
      f.hint = late_hint(s_, *ledger_.schedule(row.place.index), v, row);
    return;
  }
  // Several stations of the mesh may receive the events, each over other links.
  std::string towards;
  for (const std::size_t s : v.subscribers)
    towards += (towards.empty() ? "" : ", ") + s_.members.subscriber(s).name;
  f.text = publisher + " needs " + f.required + " on " + name_of(s_.system, row.place) +
           ", whose links towards " + towards + " have time for " + f.provided;
  f.hint = "send less, or state a lower attribute set";
}

void Explainer::add_capacity(const Verdict& v, const Row& row) {
  Finding& f = new_finding(FindingId::capacity, v);
  const std::string& network = name_of(s_.system, row.place);
  const auto rate = [](Value value) { return format_value(Attribute::bandwidth, value); };
  f.place = row.place;
  f.has_place = true;
  f.attribute = info(Attribute::bandwidth).name;
  const BoundWords words = format_bound(s_.system, row);
  f.required = words.limit;
  f.provided = words.bound;
  const Value all = s_.system.provision_of(row.place)[Attribute::bandwidth];
  f.text = s_.members.publisher(v.publisher).name + " needs " + f.required + " on " + network;
  if (row.reserved == 0)
    f.text += ", which carries " + rate(all) + " in all";
  else
    f.text += ", where " + f.provided + " of " + rate(all) + " are left (" + rate(row.reserved) +
              " for other channels)";
  f.hint = "send less, or less often, or move channels to another route";
}

}  // namespace mlcca::core
