// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/text.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "base/many.hpp"
#include "base/number.hpp"
#include "core/model/medium.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca::core {
namespace {

struct Unit {
  Value size;
  std::string_view name;
};
constexpr std::array<Unit, 4> kTime{
    {{1000000000, " s"}, {1000000, " ms"}, {1000, " us"}, {1, " ns"}}};
constexpr std::array<Unit, 4> kRate{
    {{1000000000, " GB/s"}, {1000000, " MB/s"}, {1000, " kB/s"}, {1, " B/s"}}};
constexpr std::array<Unit, 1> kPercent{{{10000000, " %"}}};
constexpr std::array<Unit, 1> kBytes{{{1, " bytes"}}};
constexpr std::array<Unit, 1> kCount{{{1, ""}}};

/// How values of the attributes with one unit of the table are shown to a person.
struct Reading {
  std::string_view unit;
  std::span<const Unit> units;
  const char* excess;  ///< follows the amount by which a requirement is missed
};
constexpr std::array<Reading, 5> kReadings{{{"ns", kTime, " too long"},
                                            {"bytes/s", kRate, " short"},
                                            {"1e-9", kPercent, " too much"},
                                            {"events", kCount, " too many"},
                                            {"bytes", kBytes, " short"}}};

constexpr const Reading* reading_of_unit(std::string_view unit) {
  return std::ranges::find(kReadings, unit, &Reading::unit);
}
static_assert(std::ranges::all_of(kAttributeTable, [](const AttributeInfo& row) {
  return reading_of_unit(row.unit) != kReadings.end();
}));

const Reading& reading_of(Attribute a) { return *reading_of_unit(info(a).unit); }

const Unit& unit_of(Attribute attribute, Value value) {
  const auto units = reading_of(attribute).units;
  for (const Unit& unit : units)
    if (value >= unit.size) return unit;
  return units.back();
}

/// The rounding step: a thousandth of the unit divided by `finer`, at least 1. A percentage keeps
/// the last digit that parts of 1e-9 can have.
Value step_of(const Unit& unit, Value finer) {
  return unit.name == " %" ? 1 : std::max<Value>(unit.size / 1000 / finer, 1);
}

Value rounded(Value value, Value step) {
  const Value rest = value % step;
  return value - rest + (rest + step / 2) / step * step;
}

std::string with_unit(Value value, const Unit& unit, Value finer = 1) {
  const Value step = step_of(unit, finer);
  Value whole = value / unit.size;
  Value rest = value % unit.size;
  if (step > 1) {
    rest = (rest + step / 2) / step * step;
    if (rest == unit.size) {
      ++whole;
      rest = 0;
    }
  }
  std::string text = std::to_string(whole);
  if (rest != 0) {
    std::string digits = std::to_string(rest);
    digits.insert(0, std::to_string(unit.size).size() - 1 - digits.size(), '0');
    digits.erase(digits.find_last_not_of('0') + 1);
    text += "." + digits;
  }
  return text.append(unit.name);
}

std::string title(Attribute a) { return info(a).name; }

std::string compared(const System& system, const Row& row, const std::string& place) {
  const Comparison& c = row.comparison;
  const BoundWords words = format_bound(system, row);
  std::string text = attribute_name(system, row) + " " + words.limit + " required, ";
  if (!c.known) return text + place + " provides none";
  text += place + " provides " + words.bound;
  if (c.dynamic) return text + " at best, decided at run time and not known now";
  return text + " (" + format_margin(system, row) + ")";
}

/// Which frames with a data phase the channel may have on the bus.
std::string_view forms_of(const System& system, const Verdict& v) {
  const Binding* binding = system.networks[v.obstacle_at.index].binding_of(v.channel);
  if (binding != nullptr && binding->format == FrameFormat::xl) return "are XL frames";
  if (binding != nullptr && binding->format == FrameFormat::fd) return "are FD frames";
  return "may be FD frames";
}

/// Why longer events of this channel are not fragmented although the profile can do so; empty
/// otherwise.
std::string why_in_one_frame(const System& system, const Verdict& v) {
  const Network& network = system.networks[v.obstacle_at.index];
  const Binding* const binding = network.binding_of(v.channel);
  const Fragmentation* const several = traits_of(network.profile).fragmentation;
  if (binding == nullptr || several == nullptr || several->obstacle == nullptr) return {};
  const std::string_view why = several->obstacle(*binding);
  return why.empty() ? "" : ": " + std::string(why);
}

/// Names what the event does not fit, "a frame of can0". For networks of datagrams the limit is
/// added, since no binding states it.
std::string what_is_too_short(const System& system, const Verdict& v) {
  const Network& network = system.networks[v.obstacle_at.index];
  const bool one_frame = !network.carries_subjects() || network.kind == NetworkKind::ieee802154;
  std::string what = (one_frame ? "a frame of " : "the fragments of ") + network.name;
  if (network.carries_subjects())
    what += ": at most " + format_value(Attribute::max_payload, event_bytes(network));
  return what;
}

/// What the description lacks, so that gateways cannot compute what they hold together.
std::string why_unknown(const System& system, const Verdict& v) {
  const Network& network = system.networks[v.obstacle_at.index];
  if (network.kind == NetworkKind::can && network.bus.bitrate == 0)
    return ": the description states no bit rate of it";
  if (network.mesh && network.mesh->nodes.empty()) return ": the description states no nodes of it";
  return {};
}

std::string obstacle_text(const System& system, const Members& members, const Verdict& v,
                          const std::string& problem) {
  const auto at = [&] { return name_of(system, v.obstacle_at); };
  const auto& publisher = members.publisher(v.publisher);
  switch (v.obstacle) {
    case Obstacle::none:
      return {};
    case Obstacle::no_route:
      return "no route from " + name_of(system, publisher.place) + " to " + name_of(system, v.to) +
             " within " + std::to_string(kMaxHops) + " hops";
    case Obstacle::unavailable:
      return at() + " is not available" + (problem.empty() ? "" : ": " + problem);
    case Obstacle::unbound:
      return "the channel has no identifier on " + at();
    case Obstacle::no_node:
      if (!publisher.node)
        return "publisher " + publisher.name + " states no node, which " + at() + " needs";
      return "publisher " + publisher.name + " has node " + std::to_string(*publisher.node) +
             ", and nodes of " + at() + " are 0 to " +
             std::to_string(traits_of(system.networks[v.obstacle_at.index].profile).last_node);
    case Obstacle::too_long:
      return "an event of " +
             format_value(Attribute::max_payload,
                          attributes_in(publisher, v.set)[Attribute::max_payload]) +
             " does not fit " + what_is_too_short(system, v) + why_in_one_frame(system, v);
    case Obstacle::no_traffic:
      return "publisher " + publisher.name +
             " states neither Period with MaxPayload nor Bandwidth, and the capacity of " + at() +
             " is shared";
    case Obstacle::no_data_rate:
      return "frames of channel " + system.channels[v.channel].name + " " +
             std::string(forms_of(system, v)) + ", and " + at() +
             " has no bit rate for their data phase";
    case Obstacle::no_period:
      return "publisher " + publisher.name + " states no Period, and response times on " + at() +
             " depend on it";
    case Obstacle::no_path:
      if (const auto& mesh = system.networks[v.obstacle_at.index].mesh; mesh && mesh->nodes.empty())
        return "no nodes of " + at() + " are described: it is unknown where events enter and leave";
      if (std::string words = no_links_words(system.networks[v.obstacle_at.index]); !words.empty())
        return words;
      return "no links are known that lead through " + at();
    case Obstacle::no_rate:
      return "rate unknown: no source knows what the links that lead through " + at() + " carry";
    case Obstacle::links_absent:
      return "links that would lead through " + at() +
             " are known, and the source that knows which are there does not report them";
    case Obstacle::links_must_last:
      return "links that lead through " + at() + " were lost, and must last " +
             format_value(Attribute::latency, system.networks[v.obstacle_at.index].mesh->hold_up) +
             " before they count again";
    case Obstacle::relay_gated:
      return "gateway " + at() +
             " has its gate on a radio of the mesh, where it drops what its "
             "node would relay on the way";
    case Obstacle::no_sender:
      return "events cross " + at() + " by a program, and there is none: " +
             (system.gateways[v.obstacle_at.index].forwarder == Forwarder::relay
                  ? "install mlcca-relay, whose user it runs as, or state a sender of its Port"
                  : "state a sender of its Port, or forward=\"relay\" of the Gateway");
    case Obstacle::renamed:
      return "can-gw carries a message of several frames as it is, and the channel has another "
             "PGN, "
             "priority or frame format on the other side of " +
             at();
    case Obstacle::untagged:
      return "waiting for its tag on " + at() + ": the broker has not dealt it yet";
    case Obstacle::contradicted:
      return problem.empty() ? "its tag on " + at() + " is contradicted by the broker" : problem;
    case Obstacle::withdrawn:
      return "withdrawn by an operator until it is reinstated";
    case Obstacle::unlisted:
      return at() + " admits no channel " + format_subject(system.channels[v.channel].subject) +
             " that is not described: its Unlisted would have to allow it";
    case Obstacle::sender_twice:
      return "events of the channel reach " + at() +
             " by another route already: two senders of one identifier";
    case Obstacle::echo:
      if (v.obstacle_at.kind == Place::Kind::gateway)
        return "gateway " + at() +
               " could not distinguish these events from those that another gateway brings, and "
               "would carry both: they would arrive twice, or go round";
      return "events of the publisher reach " + at() + " by another route already: they would " +
             "arrive twice";
    case Obstacle::cluster:
      if (!problem.empty()) return "waits for " + problem;
      return "waits for the store: other gateways use " + at() +
             " too, and this is not reserved there";
    case Obstacle::disagreed:
      if (!problem.empty()) return "waits for " + problem;
      return "waits for gateway " + at() + ", which does not carry it now";
    case Obstacle::crowded:
      return "other gateways use " + at() +
             " too, and not all that is promised there fits as it is now";
    case Obstacle::others_unknown:
      return "it is not known what other gateways hold of " + at() + why_unknown(system, v);
  }
  return {};
}

}  // namespace

std::string format_value(Attribute attribute, Value value) {
  if (value == kUnbounded) return "unbounded";
  return with_unit(value, unit_of(attribute, value));
}

BoundWords format_bound(Attribute attribute, Value bound, Value limit) {
  if (bound == limit || bound == kUnbounded || limit == kUnbounded)
    return {format_value(attribute, bound), format_value(attribute, limit)};
  const Unit& of_bound = unit_of(attribute, bound);
  const Unit& of_limit = unit_of(attribute, limit);
  const auto differ = [&](Value finer) {
    return rounded(bound, step_of(of_bound, finer)) != rounded(limit, step_of(of_limit, finer));
  };
  Value finer = 1;
  while (!differ(finer)) finer *= 10;  // ends at the latest when steps have become 1
  return {with_unit(bound, of_bound, finer), with_unit(limit, of_limit, finer)};
}

BoundWords format_bound(const System& system, const Row& row) {
  const Comparison& c = row.comparison;
  if (!row.is_user()) return format_bound(c.attribute, c.provided, c.required);
  return {format_value(system, row, c.provided), format_value(system, row, c.required)};
}

std::string format_span(Value ns) {
  constexpr std::array<std::pair<Value, const char*>, 4> units = {
      {{24UL * 3600, "d"}, {3600, "h"}, {60, "min"}, {1, "s"}}};
  const Value seconds = ns / 1'000'000'000;
  std::size_t first = 0;
  while (first + 1 < units.size() && seconds < units.at(first).first) ++first;
  const auto [size, name] = units.at(first);
  std::string text = std::to_string(seconds / size) + " " + name;
  if (first + 1 == units.size()) return text;
  const auto [smaller, its_name] = units.at(first + 1);
  const Value rest = seconds % size / smaller;
  return rest == 0 ? text : text + " " + std::to_string(rest) + " " + its_name;
}

std::string format_margin(const Comparison& c) {
  if (!c.known) return "not provided";
  if (c.required == c.provided) return "exactly met";
  const bool better = info(c.attribute).better == Better::smaller ? c.provided < c.required
                                                                  : c.provided > c.required;
  const Value by = c.required > c.provided ? c.required - c.provided : c.provided - c.required;
  if (c.provided == kUnbounded) return better ? "no limit" : "unbounded";
  return format_value(c.attribute, by) + (better ? " to spare" : reading_of(c.attribute).excess);
}

std::string attribute_name(const System& system, const Row& row) {
  return row.is_user() ? system.user_attributes[row.user].name : title(row.comparison.attribute);
}

std::string unit_name(const System& system, const Row& row) {
  if (!row.is_user()) return info(row.comparison.attribute).unit;
  const UserAttribute& attribute = system.user_attributes[row.user];
  if (attribute.magnitude == 0) return attribute.unit;
  return "1e" + std::to_string(attribute.magnitude) +
         (attribute.unit.empty() ? "" : " " + attribute.unit);
}

UserAttribute of_unit(std::string_view name) {
  UserAttribute out;
  out.unit = name;
  if (!name.starts_with("1e")) return out;
  constexpr int most = 30;  // the range that descriptions allow
  const std::size_t end = std::min(name.find(' '), name.size());
  const auto magnitude = number_in<int>(name.substr(2, end - 2));
  if (!magnitude || *magnitude < -most || *magnitude > most) return out;
  out.magnitude = *magnitude;
  out.unit = name.substr(std::min(end + 1, name.size()));
  return out;
}

std::string format_user_value(const UserAttribute& attribute, Value value) {
  if (value == kUnbounded) return "unbounded";
  std::string digits = std::to_string(value);
  if (attribute.magnitude > 0 && value != 0) {
    digits.append(static_cast<std::size_t>(attribute.magnitude), '0');
  } else if (attribute.magnitude < 0) {
    const auto places = static_cast<std::size_t>(-attribute.magnitude);
    if (digits.size() <= places) digits.insert(0, places + 1 - digits.size(), '0');
    digits.insert(digits.size() - places, 1, '.');
    digits.erase(digits.find_last_not_of('0') + 1);
    if (digits.ends_with('.')) digits.pop_back();
  }
  return attribute.unit.empty() ? digits : digits + " " + attribute.unit;
}

std::string format_value(const System& system, const Row& row, Value value) {
  return row.is_user() ? format_user_value(system.user_attributes[row.user], value)
                       : format_value(row.comparison.attribute, value);
}

std::string format_margin(const System& system, const Row& row) {
  const Comparison& c = row.comparison;
  if (is_most(row) && c.provided != c.required)
    return format_value(c.attribute, c.margin()) +
           (c.provided < c.required ? " to spare" : " too long");
  if (!row.is_user()) return format_margin(c);
  if (!c.known) return "not provided";
  if (c.required == c.provided) return "exactly met";
  const UserAttribute& attribute = system.user_attributes[row.user];
  if (c.provided == kUnbounded || c.required == kUnbounded) return "unbounded";
  const std::string by = format_user_value(attribute, c.margin());
  if (satisfies(attribute.better, c.provided, c.required)) return by + " to spare";
  return by + (attribute.better == Better::smaller ? " too much" : " short");
}

std::string format_subject(Subject subject) {
  static constexpr std::string_view digits = "0123456789abcdef";
  std::string text = "0x0000000000000000";
  for (std::size_t i = 17; i > 1; --i, subject >>= 4) text[i] = digits[subject & 15];
  return text;
}

std::string_view to_text(NetworkKind kind) { return words::kNetworkKinds.of(kind); }
std::string_view to_text(Profile profile) { return words::kProfiles.of(profile); }
std::string_view to_text(mesh::SourceKind kind) { return words::kSourceKinds.of(kind); }
std::string_view to_text(mesh::RateKind kind) { return words::kRateKinds.of(kind); }
std::string_view to_text(mesh::Lack lack) { return words::kLacks.of(lack); }

std::string name_of(const mesh::Source& source) {
  const std::string& where = source.interface.empty() ? source.endpoint : source.interface;
  return std::string(to_text(source.kind)) + (where.empty() ? "" : " " + where);
}

const std::string& name_of(const System& system, Place place) {
  return place.kind == Place::Kind::network ? system.networks[place.index].name
                                            : system.gateways[place.index].name;
}

std::string no_links_words(const Network& network) {
  const auto& mesh = network.mesh;
  if (!mesh || mesh->nodes.empty() || !mesh->links.empty() || !mesh->sources.empty()) return {};
  return "no link of mesh " + network.name +
         " can ever be known: it has nodes, and neither Link nor Source";
}

std::string where(const System& system, const Members& members, const Verdict& verdict,
                  const Row& row) {
  switch (row.against) {
    case Against::hop:
      return name_of(system, row.place);
    case Against::end_to_end:
      return "end to end";
    case Against::traffic:
      return "publisher " + members.publisher(verdict.publisher).name + " for " +
             members.subscriber(row.end).name;
    case Against::overhearing:
      return "listeners on " + name_of(system, row.place);
    case Against::capacity:
      return "capacity of " + name_of(system, row.place);
    case Against::schedule:
      return "response times on " + name_of(system, row.place);
    case Against::medium_time:
      return "time left on " + name_of(system, row.place);
  }
  return {};
}

std::string names_of(const Members& members, const std::vector<std::size_t>& publishers) {
  constexpr std::size_t most = 4;
  const std::size_t named = publishers.size() > most ? most - 1 : publishers.size();
  std::string text;
  for (std::size_t i = 0; i < named; ++i) {
    if (i != 0) text += i + 1 == publishers.size() ? " and " : ", ";
    text += members.publisher(publishers[i]).name;
  }
  if (named == publishers.size()) return text;
  return text + " and " + std::to_string(publishers.size() - named) + " more";
}

namespace {

/// Names the frames of a schedule row: their bus, and the publisher or gateway they belong to.
std::string frames_of(const System& system, const Members& members, const Row& row) {
  if ((row.end & Row::kOfGateway) != 0)
    return "the frames taken by gateway " + system.gateways[row.end & ~Row::kOfGateway].name +
           " on " + name_of(system, row.place);
  const Publisher& late = members.publisher(row.end);
  return "the frames of " + late.name + " (" + system.channels[late.channel].name + ") on " +
         name_of(system, row.place);
}

}  // namespace

std::string schedule_text(const System& system, const Members& members, const Row& row) {
  const std::string frames = frames_of(system, members, row);
  const Comparison& c = row.comparison;
  if (c.attribute == Attribute::omission)
    return frames + " could find the queue of their gateway full and be lost: it holds " +
           many(row.room, "frame") + ", and up to " + std::to_string(row.reserved) +
           (row.reserved == 1 ? " waits in it" : " wait in it");
  if (c.required == 0 && c.provided != kUnbounded)
    return "no time is left for " + frames + ": they take up to " +
           format_value(Attribute::latency, c.provided) +
           " there, and the rest of their way may take all that they are allowed";
  if (c.provided == kUnbounded) return frames + " could wait without a bound";
  const BoundWords words = format_bound(Attribute::latency, c.provided, c.required);
  return frames + " could take " + words.bound + " of the " + words.limit +
         " they may take at most";
}

std::string reaction(const Verdict& verdict) {
  const auto sum = worst_case_reaction(verdict);
  if (!sum) return {};
  const AttributeSet terms = reaction_terms(verdict);
  const auto term = [&terms](Attribute a) { return title(a) + " " + format_value(a, terms[a]); };
  return format_value(Attribute::latency, *sum) + " = (" + term(Attribute::omission) + " + 1) x " +
         term(Attribute::period) + " + " + term(Attribute::latency) + " + " +
         term(Attribute::jitter);
}

std::string reason(const System& system, const Members& members, const Verdict& v,
                   const std::string& problem) {
  if (v.obstacle != Obstacle::none) return obstacle_text(system, members, v, problem);
  const Row* row = deciding_row(v);
  if (row == nullptr) return "nothing is required of the route";
  const BoundWords words = format_bound(system, *row);
  if (row->against == Against::capacity && !v.granted)
    return words.limit + " needed on " + name_of(system, row->place) + ", " + words.bound +
           " left (" + format_value(Attribute::bandwidth, row->reserved) + " promised to others)";
  if (row->against == Against::schedule) return schedule_text(system, members, *row);
  if (row->against == Against::medium_time && !v.granted)
    return words.limit + " needed on " + name_of(system, row->place) +
           ", whose links have time for " + words.bound;
  std::string place = where(system, members, v, *row);
  if (row->against == Against::end_to_end) place = "the route";
  if (row->against == Against::overhearing)
    return compared(system, *row, "the way to " + name_of(system, row->place)) +
           ", and subscribers there would receive it";
  return compared(system, *row, place);
}

}  // namespace mlcca::core
