// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/generate/header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "core/can/of_system.hpp"
#include "core/mesh/roles.hpp"
#include "core/model/text.hpp"
#include "mlcca/user_check.hpp"
#include "tools/design/generate/attributes.hpp"
#include "tools/design/generate/checks.hpp"
#include "tools/design/generate/names.hpp"
#include "tools/design/generate/reasons.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

using core::Place;
constexpr Value kMostOmissions = 0xffffffff;  // limit of mlcca::Omission
constexpr std::string_view kEmptyList = "mlcca::AttributeList<>";

const char* word_of(der::Role role) {
  return role == der::Role::publisher ? "Publisher" : "Subscriber";
}

const char* word_of(Place place) {
  return place.kind == Place::Kind::network ? "network" : "gateway";
}

const char* word_of(Better better) { return better == Better::smaller ? "smaller" : "larger"; }

const char* word_of(Composition composition) {
  switch (composition) {
    case Composition::sum:
      return "sum";
    case Composition::slowest:
      return "slowest";
    case Composition::survival:
      return "survival";
    case Composition::consecutive:
      return "consecutive";
    case Composition::smallest:
    case Composition::not_provided:
    case Composition::shared_medium:
      break;
  }
  return "smallest";
}

class Writer {
 public:
  Writer(const core::System& system, const Decisions& decisions, const Unit& unit)
      : system_(system),
        decisions_(decisions),
        unit_(unit),
        pairs_(pairs_of(system, decisions.members(), unit)) {
    for (const End end : unit.ends) ++ends_of_channel_[channel_of(system, end)];
    names_.take("ChannelException");
  }

  Result<Header> run() {
    head();
    user_attributes();
    for (const auto end : unit_.ends)
      if (auto done = spec(end); !done) return std::unexpected(done.error());
    places();
    peers();
    checks();
    add("}}  // namespace {}\n}}  // namespace {}\n", unit_.scope, system_namespace(system_));
    if (!problem_.empty()) return fail(problem_);
    return std::move(out_);
  }

 private:
  /// Makes it the error of the header if the generated types cannot hold a list.
  void check_limits(const std::string& whose, const AttributeSet& set,
                    const core::UserValues& values) {
    static_assert(der::kMaxUserAttributes == detail::kMaxUserAttributes);
    if (values.size() > der::kMaxUserAttributes)
      problem_ = fmt::format(
          "{}: has {} user-defined attributes: generated code and DER hold at most {} in one list; "
          "state fewer there",
          whose, values.size(), der::kMaxUserAttributes);
    if (set[Attribute::omission] > kMostOmissions)
      problem_ = fmt::format("{}: Omission {}: generated code holds at most {}", whose,
                             set[Attribute::omission], kMostOmissions);
  }

  std::string listed(const std::string& whose, const AttributeSet& set,
                     const core::UserValues& values) {
    check_limits(whose, set, values);
    return attribute_list(set, values, user_);
  }

  template <class... T>
  void add(fmt::format_string<T...> format, T&&... values) {
    out_.text += fmt::format(format, std::forward<T>(values)...);
  }

  void head() {
    add("// {}: change the description, not this file.\n", kMark);
    add("// System {}, {} {}.\n", comment_text(system_.name), unit_.about,
        comment_text(unit_.name));
    add("#pragma once\n#include <stddef.h>\n#include <stdint.h>\n\n"
        "#include \"mlcca/der_encode.hpp\"\n#include \"mlcca/static_check.hpp\"\n\n");
    add("namespace {} {{\nnamespace {} {{\n\nusing namespace mlcca::literals;\n\n",
        system_namespace(system_), unit_.scope);
    out_.text += kChannelExceptionText;
  }

  void user_attributes() {
    for (std::size_t i = 0; i < system_.user_attributes.size(); ++i) {
      const auto& attribute = system_.user_attributes[i];
      const auto type = names_.take(type_name(attribute.name));
      user_.emplace(static_cast<std::uint32_t>(i), type);
      const auto unit = attribute.unit.empty() ? std::string("1") : attribute.unit;
      add("/// User-defined attribute {}, in steps of 1e{} {}.\n", comment_text(attribute.name),
          attribute.magnitude, comment_text(unit));
      add("template <mlcca::Value V>\nstruct {0} : mlcca::UserAttribute<{0}, V, "
          "mlcca::Better::{1}, mlcca::Composition::{2}> {{}};\n\n",
          type, word_of(attribute.better), word_of(attribute.composition));
    }
  }

  /// A name such as "EmergencySwitch", from the channel; from the end if the unit has several ends
  /// of it.
  [[nodiscard]] std::string spec_stem(End end) const {
    const auto channel = channel_of(system_, end);
    return type_name(ends_of_channel_.at(channel) == 1 ? system_.channels[channel].name
                                                       : name_of(system_, end));
  }

  Result<void> spec(End end) {
    const auto& channel = system_.channels[channel_of(system_, end)];
    const auto sets = sets_of(system_, end);
    const auto stem = spec_stem(end);
    auto& types = types_[{end.role, end.index}];
    for (std::size_t i = 0; i < sets.size(); ++i) {
      const auto name = names_.take(stem + "Spec" + set_suffix(sets, i));
      types.push_back(name);
      const auto file = fmt::format("{}_{}.der", unit_.stem, name);
      check_limits(name_of(system_, end), *sets[i].attributes, *sets[i].user);
      if (!problem_.empty()) return fail(problem_);
      auto blob = der_of(system_, end.role, channel.subject, *sets[i].attributes, *sets[i].user);
      if (!blob)
        return fail(
            fmt::format("{} {}: {}", word_of(end.role), name_of(system_, end), blob.error().text));
      out_.blobs.push_back({file, std::move(*blob)});
      add("/// {} {} of channel {}{}{}.\n", word_of(end.role), comment_text(name_of(system_, end)),
          comment_text(channel.name), channel.description.empty() ? "" : ": ",
          channel.description.empty() ? "" : comment_text(channel.description));
      users_of(name, *sets[i].user);
      spec_struct(end, name, sets, i);
      add("/// Its run-time representation, as in the file {}.\n"
          "constexpr auto k{}Der = mlcca::der::encode({}{{}});\n\n",
          file, name, name);
    }
    return {};
  }

  void users_of(const std::string& spec, const core::UserValues& values) {
    if (values.empty()) return;
    add("constexpr mlcca::der::UserAttribute k{}Users[] = {{\n", spec);
    for (const auto& value : sorted_by_name(system_, values))
      add("    {{\"{}\", {}}},\n", system_.user_attributes[value.attribute].name,
          number(value.value));
    add("}};\n");
  }

  void spec_struct(End end, const std::string& name, const std::vector<EndSet>& sets,
                   std::size_t i) {
    const auto& set = sets[i];
    const bool publishes = end.role == der::Role::publisher;
    add("struct {} {{\n", name);
    add("  static constexpr uint64_t subject = {}ULL;\n",
        core::format_subject(system_.channels[channel_of(system_, end)].subject));
    if (system_.channels[channel_of(system_, end)].arrival == core::Arrival::sporadic)
      add("  static constexpr bool sporadic = true;\n");
    if (sets.size() > 1)
      add("  static constexpr int16_t priority = {};  // of {} attribute sets\n", set.priority,
          sets.size());
    add("  using attributes = {};\n", listed(name_of(system_, end), *set.attributes, *set.user));
    add("  static constexpr mlcca::der::Channel channel() {{\n"
        "    return mlcca::der::Channel(mlcca::der::Role::{}, subject, attributes::set(){});\n"
        "  }}\n",
        publishes ? "publisher" : "subscriber",
        set.user->empty() ? std::string() : fmt::format(", k{}Users, {}", name, set.user->size()));
    if (i == 0) {
      add("\n  // To be written by the application, in {}_callbacks.cpp.\n", unit_.stem);
      if (!publishes) add("  static void notify(const uint8_t* event, size_t size);\n");
      add("  static void exception(ChannelException why);\n");
      if (!publishes) out_.callbacks.push_back({name, true});
      out_.callbacks.push_back({name, false});
    }
    add("}};\n");
  }

  void places() {
    std::set<Place> needed = {unit_.place};
    std::set<Place> used;
    each_hop([&](const Pair&, const RouteHop& hop) {
      needed.insert(hop.place);
      if (hop.gives.provision == system_.provision_of(hop.place)) used.insert(hop.place);
    });
    for (const auto place : needed) {
      const auto& name = core::name_of(system_, place);
      const auto type = names_.take(type_name(name));
      const auto text = listed(name, system_.provision_of(place), user_of(place));
      places_.emplace(place, type);
      // A place without a provision gets a type only if a check refers to it.
      if (text == kEmptyList && !used.contains(place)) continue;
      add("/// What {} {} provides.\nstruct {} {{\n  using provision = {};\n}};\n\n",
          word_of(place), comment_text(name), type, text);
    }
    each_hop([&](const Pair& pair, const RouteHop& hop) { computed(pair, hop); });
  }

  [[nodiscard]] const core::UserValues& user_of(Place place) const {
    return place.kind == Place::Kind::network ? system_.networks[place.index].user
                                              : system_.gateways[place.index].user;
  }

  template <class Then>
  void each_hop(const Then& then) const {
    for (const auto& pair : pairs_)
      for (std::size_t set = 0; set < set_count(pair); ++set)
        for (const auto& hop : hops_of(pair, set)) then(pair, hop);
  }

  [[nodiscard]] std::string listed(const RouteHop& hop) {
    AttributeSet gives = hop.gives.provision;
    // An Omission beyond the type's limit is worse than any requirement, so it is left out. A
    // Latency without bound stays: without one, the Period would promise it
    // (normalised_provision()).
    if (gives[Attribute::omission] > kMostOmissions && gives != system_.provision_of(hop.place))
      gives.clear(Attribute::omission);
    return listed(core::name_of(system_, hop.place), gives, user_of(hop.place));
  }

  /// Adds a struct for a hop that gives a channel something else than it states.
  void computed(const Pair& pair, const RouteHop& hop) {
    const auto& stated = system_.provision_of(hop.place);
    if (hop.gives.provision == stated) return;
    const auto channel = channel_of(system_, *pair.publisher);
    auto text = listed(hop);
    auto& type = computed_[{hop.place, channel, text}];
    if (!type.empty()) return;
    const auto& name = core::name_of(system_, hop.place);
    const auto& channel_name = system_.channels[channel].name;
    type = names_.take(places_.at(hop.place) + "For" + type_name(channel_name));
    std::string which;
    for (std::size_t i = 0; i < kAttributes; ++i) {
      const auto a = attribute_at(i);
      const auto& gives = hop.gives.provision;
      if (!gives.has(a) ||
          (stated.has(a) && stated[a] == gives[a] && stated.is_dynamic(a) == gives.is_dynamic(a)))
        continue;
      which += fmt::format("{}{}", which.empty() ? "" : ", ", info(a).name);
    }
    add("/// What {} {} gives events of channel {}.\n/// Computed: {},\n/// {}.\n"
        "struct {} {{\n  using provision = {};\n}};\n\n",
        word_of(hop.place), comment_text(name), comment_text(channel_name), which,
        computed_from(hop), type, text);
  }

  [[nodiscard]] std::string computed_from(const RouteHop& hop) const {
    const auto& network = system_.networks[hop.place.index];
    if (network.mesh && core::mesh::is_measured(*network.mesh))
      return "from PerHop, for one link at best: the links are measured at run time";
    if (network.mesh)
      return std::string("from the links of the mesh as they are described; Bandwidth is what ") +
             (hop.left ? "other channels leave" : "they carry alone");
    if (hop.late)
      return fmt::format(
          "from {}: the channel is refused there, and Latency and Jitter are what its deadline\n"
          "/// allows, not response times",
          print_bitrate(core::can::timing_of(network).bitrate));
    if (!hop.granted)
      return fmt::format(
          "from {} and the response times of the messages that are granted: the channel\n"
          "/// is refused, but not for these",
          print_bitrate(core::can::timing_of(network).bitrate));
    return fmt::format("from {} and the response times of all messages that are granted",
                       print_bitrate(core::can::timing_of(network).bitrate));
  }

  /// The name of the type for a hop.
  [[nodiscard]] std::string type_of(const Pair& pair, const RouteHop& hop) {
    if (hop.gives.provision == system_.provision_of(hop.place)) return places_.at(hop.place);
    return computed_.at({hop.place, channel_of(system_, *pair.publisher), listed(hop)});
  }

  [[nodiscard]] std::size_t set_count(const Pair& pair) const {
    const auto end = pair.publisher ? *pair.publisher : *pair.subscriber;
    return sets_of(system_, end).size();
  }

  /// The delivery of a pair; nullptr if it has only one end.
  [[nodiscard]] const Decisions::Delivery* delivery(const Pair& pair, std::size_t set) const {
    if (!pair.publisher || !pair.subscriber) return nullptr;
    return &decisions_.of(pair.publisher->index, place_of(system_, *pair.subscriber), set);
  }

  [[nodiscard]] std::vector<RouteHop> hops_of(const Pair& pair, std::size_t set) const {
    const auto* found = delivery(pair, set);
    return found == nullptr ? std::vector<RouteHop>() : found->hops;
  }

  /// Adds types for the ends of other units on the other side of a channel.
  void peers() {
    // These types must also not have the name of a type that their attributes use.
    Names names = names_;
    std::string text;
    for (const auto& pair : pairs_)
      for (const auto& end : {pair.publisher, pair.subscriber}) {
        if (!end || types_.contains({end->role, end->index})) continue;
        const auto sets = sets_of(system_, *end);
        auto& types = types_[{end->role, end->index}];
        for (std::size_t i = 0; i < sets.size(); ++i) {
          const auto name = names.take(type_name(name_of(system_, *end)) + set_suffix(sets, i));
          types.push_back("peer::" + name);
          text += fmt::format(
              "/// {} {} of channel {}.\nstruct {} {{\n  using attributes = {};\n}};\n\n",
              word_of(end->role), comment_text(name_of(system_, *end)),
              comment_text(system_.channels[channel_of(system_, *end)].name), name,
              listed(name_of(system_, *end), *sets[i].attributes, *sets[i].user));
        }
      }
    if (!text.empty()) add("namespace peer {{\n\n{}}}  // namespace peer\n\n", text);
  }

  [[nodiscard]] std::string list(std::optional<End> end, std::size_t set) const {
    if (!end) return std::string(kEmptyList);
    const auto& types = types_.at({end->role, end->index});
    return types[std::min(set, types.size() - 1)] + "::attributes";
  }

  [[nodiscard]] std::string route(const Pair& pair, const std::vector<RouteHop>& hops) {
    std::string out;
    for (const auto& hop : hops)
      out += fmt::format(
          "{}mlcca::{}<{}::provision{}>", out.empty() ? "" : ", ",
          hop.gives.gateway ? "Gateway" : "Network", type_of(pair, hop),
          hop.gives.frames == 1 ? std::string() : fmt::format(", {}", hop.gives.frames));
    return fmt::format("mlcca::RouteOf<{}>", out);
  }

  [[nodiscard]] bool states_jitter(const Pair& pair, std::size_t set) const {
    if (!pair.publisher) return false;
    const auto sets = sets_of(system_, *pair.publisher);
    return sets[std::min(set, sets.size() - 1)].attributes->has(Attribute::jitter);
  }

  /// A check: an alias of an expression, or a refusal.
  struct CheckText {
    std::string comment;
    std::string name;
    std::string expression;
    std::string refusal;
  };

  [[nodiscard]] std::vector<CheckText> checks_of(const Pair& pair, std::size_t set) {
    std::vector<CheckText> out;
    const auto end = pair.publisher ? *pair.publisher : *pair.subscriber;
    const auto channel_index = channel_of(system_, end);
    const auto& channel = system_.channels[channel_index].name;
    const auto stem = type_name(channel);
    const auto from = pair.publisher ? comment_text(name_of(system_, *pair.publisher)) : "nobody";
    const auto to = pair.subscriber ? comment_text(name_of(system_, *pair.subscriber)) : "nobody";
    const auto between = fmt::format("Channel {}, from {} to {}", comment_text(channel), from, to);
    const bool in_use = set == decisions_.set_of(channel_index);
    if (in_use) add_errors_of_channel(out, channel_index, between, !pair.publisher);
    const auto* found = delivery(pair, set);
    if (found == nullptr) return out;
    if (decisions_.has_open_set(channel_index) && in_use) {
      if (!found->granted) out.push_back(refused(pair, *found, between));
      return out;
    }
    out.push_back({between + ": what is sent against what is asked.",
                   stem + "Traffic",
                   fmt::format("mlcca::CheckTraffic<{}, {}>", list(pair.publisher, set),
                               list(pair.subscriber, set)),
                   {}});
    const auto both =
        fmt::format("mlcca::Union<{}, {}>", list(pair.publisher, set), list(pair.subscriber, set));
    const auto& hops = found->hops;
    // mlcca::Check does not consider the source: only a route adds its Jitter to that of the
    // network.
    if (hops.size() == 1 && hops.front().gives.frames == 1 && !states_jitter(pair, set)) {
      const auto type = type_of(pair, hops.front());
      out.push_back({between + ": on the network between them.",
                     stem + "On" + type,
                     fmt::format("mlcca::Check<{}, {}::provision>", both, type),
                     {}});
    } else if (!hops.empty()) {
      out.push_back({between + ": each hop, and end to end.",
                     stem + "Route",
                     fmt::format("mlcca::CheckRoute<{}, {}>", both, route(pair, hops)),
                     {}});
    }
    if (!found->granted &&
        !is_refused_by_types(system_, pair.publisher->index, pair.subscriber->index, set, hops))
      out.push_back(refused(pair, *found, between));
    return out;
  }

  [[nodiscard]] CheckText refused(const Pair& pair, const Decisions::Delivery& delivery,
                                  const std::string& between) const {
    return {between + ": refused for more than these two.",
            {},
            {},
            refusal_of(system_, *delivery.errors, pair.publisher->index, pair.subscriber->index)};
  }

  /// Adds refusals of the channel itself, or of a subscriber without any publisher.
  void add_errors_of_channel(std::vector<CheckText>& out, std::size_t channel,
                             const std::string& between, bool alone) const {
    for (const auto& f : decisions_.errors_of(channel)) {
      const bool whole = f.id == core::FindingId::sender_twice || f.id == core::FindingId::too_many;
      if (whole || (alone && f.id == core::FindingId::no_publisher))
        out.push_back({between + ": refused as a whole.",
                       {},
                       {},
                       fmt::format("{}: {}", core::code_of(f.id), f.text)});
    }
  }

  /// The checks as text: those in the attribute set in use, and those in the other sets.
  struct CheckTexts {
    std::string always;
    std::string others;
    Names names;
    std::set<std::string> seen;
  };

  static void add_check(CheckTexts& texts, const CheckText& check, bool always) {
    if (!texts.seen.insert(check.expression + check.refusal).second) return;
    auto& to = always ? texts.always : texts.others;
    to += fmt::format("// {}\n", check.comment);
    if (check.refusal.empty())
      to += fmt::format("using {} = {};\n", texts.names.take(check.name), check.expression);
    else
      to += fmt::format("static_assert(false, {});\n", string_literal(check.refusal));
  }

  void checks() {
    CheckTexts texts;
    // The name of a check must not hide a type that later checks use.
    texts.names = names_;
    for (const bool always : {true, false})
      for (const auto& pair : pairs_) {
        const auto end = pair.publisher ? *pair.publisher : *pair.subscriber;
        for (std::size_t set = set_count(pair); set-- > 0;) {
          if ((set == decisions_.set_of(channel_of(system_, end))) != always) continue;
          for (const auto& check : checks_of(pair, set)) add_check(texts, check, always);
        }
      }
    add("// Refused by the compiler when a network cannot carry what is asked of it: what\n"
        "// `mlccactl check` refuses.\n"
        "namespace checks {{\n\n{}\n",
        texts.always);
    if (!texts.others.empty())
      add("// The attribute sets that are not in use: a network may lack them.\n"
          "#ifdef MLCCA_CHECK_EVERY_SET\n{}#endif\n\n",
          texts.others);
    add("}}  // namespace checks\n\n");
  }

  const core::System& system_;
  const Decisions& decisions_;
  const Unit& unit_;
  std::vector<Pair> pairs_;
  std::map<std::size_t, std::size_t> ends_of_channel_;  ///< of the unit
  Names names_;
  UserTypes user_;
  std::map<Place, std::string> places_;
  /// The types for computed provisions, by place, channel and the provision as text.
  std::map<std::tuple<Place, std::size_t, std::string>, std::string> computed_;
  /// For each end the types of its attribute sets.
  std::map<std::pair<der::Role, std::size_t>, std::vector<std::string>> types_;
  Header out_;
  std::string problem_;  ///< empty: none
};

}  // namespace

std::string system_namespace(const core::System& system) { return small_name(system.name); }

Result<Header> header_of(const core::System& system, const Decisions& decisions, const Unit& unit) {
  return Writer(system, decisions, unit).run();
}

}  // namespace mlcca::tools::design
