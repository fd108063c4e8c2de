// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/generate/header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "core/text.hpp"
#include "mlcca/user_check.hpp"
#include "tools/design/generate/attributes.hpp"
#include "tools/design/generate/checks.hpp"
#include "tools/design/generate/names.hpp"

namespace mlcca::tools::design {
namespace {

using core::Place;

const char* word_of(der::Role role) {
  return role == der::Role::publisher ? "Publisher" : "Subscriber";
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

/// "" where there is one set, else "Priority5" or "PriorityMinus5".
std::string set_suffix(const std::vector<EndSet>& sets, std::size_t i) {
  if (i == 0) return {};
  const int priority = sets[i].priority;
  return fmt::format("Priority{}{}", priority < 0 ? "Minus" : "",
                     priority < 0 ? -priority : priority);
}

class Writer {
 public:
  Writer(const core::System& system, const core::Topology& topology, const Unit& unit)
      : system_(system), unit_(unit), pairs_(pairs_of(system, topology, unit)) {
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
  /// What the types of a list cannot hold becomes the error of the whole header.
  void check_limits(const std::string& whose, const AttributeSet& set,
                    const core::UserValues& values) {
    static_assert(der::kMaxUserAttributes == detail::kMaxUserAttributes);
    if (values.size() > der::kMaxUserAttributes)
      problem_ = fmt::format(
          "{}: has {} user-defined attributes: generated code and DER hold at most {} in one list; "
          "state fewer there",
          whose, values.size(), der::kMaxUserAttributes);
    constexpr Value most_omissions = 0xffffffff;  // of mlcca::Omission
    if (set[Attribute::omission] > most_omissions)
      problem_ = fmt::format("{}: Omission {}: generated code holds at most {}", whose,
                             set[Attribute::omission], most_omissions);
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
    add("/// Why an exception handler is called.\n"
        "enum class ChannelException : uint8_t {{\n"
        "  refused,    ///< the channel was not admitted\n"
        "  withdrawn,  ///< it was, and the network can no longer carry it\n"
        "  switched,   ///< another of its attribute sets is in force now\n"
        "  violated,   ///< an event was late, lost or could not be sent as specified\n"
        "}};\n\n");
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

  /// "EmergencySwitch"; with the name of the end where the unit has several of the channel.
  [[nodiscard]] std::string spec_stem(End end) const {
    const auto channel = channel_of(system_, end);
    const auto same = std::ranges::count_if(
        unit_.ends, [&](End other) { return channel_of(system_, other) == channel; });
    return type_name(same == 1 ? system_.channels[channel].name : name_of(system_, end));
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
    for (const auto& pair : pairs_)
      for (const auto& hop : pair.hops) needed.insert(hop.place);
    for (const auto place : needed) {
      const bool network = place.kind == Place::Kind::network;
      const auto& name = core::name_of(system_, place);
      const auto type = names_.take(type_name(name));
      places_.emplace(place, type);
      const auto& set = system_.provision_of(place);
      const auto& user =
          network ? system_.networks[place.index].user : system_.gateways[place.index].user;
      add("/// What {} {} provides.\nstruct {} {{\n  using provision = {};\n}};\n\n",
          network ? "network" : "gateway", comment_text(name), type, listed(name, set, user));
    }
  }

  /// The ends of others that are on the other side of a channel.
  void peers() {
    // Nor a type of others one that their attributes name.
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
    if (!end) return "mlcca::AttributeList<>";
    const auto& types = types_.at({end->role, end->index});
    return types[std::min(set, types.size() - 1)] + "::attributes";
  }

  [[nodiscard]] std::string route(const std::vector<RouteHop>& hops) const {
    std::string out;
    for (const auto& hop : hops) {
      const bool network = hop.place.kind == Place::Kind::network;
      out += fmt::format("{}mlcca::{}<{}::provision{}>", out.empty() ? "" : ", ",
                         network ? "Network" : "Gateway", places_.at(hop.place),
                         hop.frames == 1 ? std::string() : fmt::format(", {}", hop.frames));
    }
    return fmt::format("mlcca::RouteOf<{}>", out);
  }

  [[nodiscard]] bool states_jitter(const Pair& pair, std::size_t set) const {
    if (!pair.publisher) return false;
    const auto sets = sets_of(system_, *pair.publisher);
    return sets[std::min(set, sets.size() - 1)].attributes->has(Attribute::jitter);
  }

  struct CheckText {
    std::string comment;
    std::string name;
    std::string expression;
  };

  [[nodiscard]] std::vector<CheckText> checks_of(const Pair& pair, std::size_t set) const {
    std::vector<CheckText> out;
    const auto end = pair.publisher ? *pair.publisher : *pair.subscriber;
    const auto& channel = system_.channels[channel_of(system_, end)].name;
    const auto stem = type_name(channel);
    const auto from = pair.publisher ? comment_text(name_of(system_, *pair.publisher)) : "nobody";
    const auto to = pair.subscriber ? comment_text(name_of(system_, *pair.subscriber)) : "nobody";
    const auto between = fmt::format("Channel {}, from {} to {}", comment_text(channel), from, to);
    if (pair.publisher && pair.subscriber)
      out.push_back({between + ": what is sent against what is asked.", stem + "Traffic",
                     fmt::format("mlcca::CheckTraffic<{}, {}>", list(pair.publisher, set),
                                 list(pair.subscriber, set))});
    const auto both =
        fmt::format("mlcca::Union<{}, {}>", list(pair.publisher, set), list(pair.subscriber, set));
    // Check knows no source: only a route adds its Jitter to that of the network.
    if (pair.hops.size() == 1 && pair.hops.front().frames == 1 && !states_jitter(pair, set))
      out.push_back({between + ": on the network between them.",
                     stem + "On" + places_.at(pair.hops.front().place),
                     fmt::format("mlcca::Check<{}, {}::provision>", both,
                                 places_.at(pair.hops.front().place))});
    else if (!pair.hops.empty())
      out.push_back({between + ": each hop, and end to end.", stem + "Route",
                     fmt::format("mlcca::CheckRoute<{}, {}>", both, route(pair.hops))});
    else if (!pair.connected)
      out.push_back({between + ": there is no way; `mlccactl check` says so too.", {}, {}});
    return out;
  }

  /// The checks as text: those that are always made, and those of preferred attribute sets.
  struct CheckTexts {
    std::string always;
    std::string preferred;
    Names names;
    std::set<std::string> seen;
  };

  static void add_check(CheckTexts& texts, const CheckText& check, bool always) {
    const bool checks = !check.expression.empty();
    if (checks && !texts.seen.insert(check.expression).second) return;
    auto& to = always ? texts.always : texts.preferred;
    to += fmt::format("// {}\n", check.comment);
    if (checks)
      to += fmt::format("using {} = {};\n", texts.names.take(check.name), check.expression);
  }

  void checks() {
    CheckTexts texts;
    // A check must not hide a type that the checks behind it name.
    texts.names = names_;
    for (const auto& pair : pairs_) {
      const auto sets =
          sets_of(system_, pair.publisher ? *pair.publisher : *pair.subscriber).size();
      // The set of the lowest priority must fit: it is what is left when the network gets worse.
      for (std::size_t set = sets; set-- > 0;)
        for (const auto& check : checks_of(pair, set)) add_check(texts, check, set + 1 == sets);
    }
    add("// Refused by the compiler when a network cannot carry what is asked of it.\n"
        "namespace checks {{\n\n{}\n",
        texts.always);
    if (!texts.preferred.empty())
      add("// The attribute sets that are preferred: a network may lack them.\n"
          "#ifdef MLCCA_CHECK_EVERY_SET\n{}#endif\n\n",
          texts.preferred);
    add("}}  // namespace checks\n\n");
  }

  const core::System& system_;
  const Unit& unit_;
  std::vector<Pair> pairs_;
  Names names_;
  UserTypes user_;
  std::map<Place, std::string> places_;
  /// Of each end, the type of each of its sets.
  std::map<std::pair<der::Role, std::size_t>, std::vector<std::string>> types_;
  Header out_;
  std::string problem_;  ///< empty: none
};

}  // namespace

std::string system_namespace(const core::System& system) { return small_name(system.name); }

Result<Header> header_of(const core::System& system, const core::Topology& topology,
                         const Unit& unit) {
  return Writer(system, topology, unit).run();
}

}  // namespace mlcca::tools::design
