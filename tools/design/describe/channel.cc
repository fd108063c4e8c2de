// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/describe/channel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "base/number.hpp"
#include "control/utf8.hpp"
#include "description/values.hpp"
#include "tools/design/describe/lists.hpp"

namespace mlcca::tools::design {
namespace {

void collect(const Node& node, std::vector<const Node*>& found) {
  if (node.name == "EventChannel") {
    found.push_back(&node);
    return;
  }
  for (const auto& child : node.children) collect(child, found);
}

/// The first node, in document order, that is wanted; nullptr if there is none.
template <class Wanted>
const Node* find_node(const Node& node, const Wanted& wanted) {
  if (wanted(node)) return &node;
  for (const auto& child : node.children)
    if (const auto* found = find_node(child, wanted)) return found;
  return nullptr;
}

std::string text_of(const Markup& markup, const Node* node) {
  return node == nullptr ? std::string() : markup.text_of(*node);
}

std::string text_of(const Markup& markup, const MarkupAttribute* attribute) {
  return attribute == nullptr ? std::string() : markup.text_of(*attribute);
}

int number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  return number_in<int>(text).value_or(0);  // the schema limits its range
}

AttributeSetText read_set(const Markup& markup, const Node& node) {
  AttributeSetText result;
  if (const auto* priority = node.attribute("priority")) {
    result.has_priority = true;
    result.priority = number(markup.text_of(*priority));
  }
  for (auto& listed : attributes_of(markup, node))
    result.attributes.push_back(std::move(listed.quantity));
  return result;
}

std::uint64_t subject_number(std::string_view text) {
  return text.starts_with("0x") ? prefixed_number_in<std::uint64_t>(text).value_or(0) : 0;
}

std::string problem_of(const description::ValueType& type, std::string_view text) {
  return description::is_valid(type, text) ? std::string() : description::explain(type, text);
}

/// Adds the problems of a set: wrong values and duplicate attributes.
void add_problems(const Markup& markup, const Node& set, std::vector<std::string>& problems) {
  std::set<std::string> seen;
  for (const auto& [quantity, element, key, line] : attributes_of(markup, set)) {
    if (const auto problem = design::problem_of(quantity); !problem.empty())
      problems.push_back(fmt::format("line {}: {}", line, problem));
    if (!seen.insert(quantity.name).second)
      problems.push_back(
          fmt::format("line {}: {} stands here a second time: state it once", line, quantity.name));
  }
}

/// "Period", or "Period of the set of priority 5".
std::string title(const std::string& name, const AttributeSetText& set) {
  return set.has_priority ? fmt::format("{} of the set of priority {}", name, set.priority) : name;
}

void add_changes(const AttributeSetText& before, const AttributeSetText& after,
                 std::vector<ValueChange>& out) {
  for (const auto& old : before.attributes) {
    const auto now = std::ranges::find(after.attributes, old.name, &Quantity::name);
    if (now == after.attributes.end())
      out.push_back({title(old.name, before), to_words(old), {}});
    else if (!is_same(old, *now))
      out.push_back({title(old.name, after), to_words(old), to_words(*now)});
  }
  for (const auto& now : after.attributes)
    if (std::ranges::find(before.attributes, now.name, &Quantity::name) == before.attributes.end())
      out.push_back({title(now.name, after), {}, to_words(now)});
}

}  // namespace

std::vector<const Node*> channel_nodes(const Markup& markup) {
  std::vector<const Node*> found;
  collect(markup.root(), found);
  return found;
}

ChannelText read_channel(const Markup& markup, const Node& node) {
  ChannelText result{.name = text_of(markup, node.attribute("name")),
                     .subject = text_of(markup, node.child("SubjectUID")),
                     .description = text_of(markup, node.child("Description")),
                     .safe_side = text_of(markup, node.attribute("safe-side")),
                     .sets = {}};
  for (const auto& child : node.children)
    if (child.name == "Attributes") result.sets.push_back(read_set(markup, child));
  return result;
}

std::optional<description::Unit> declared_unit(const Markup& markup, std::string_view name) {
  for (const auto& child : markup.root().children)
    if (child.name == "UserAttribute" && text_of(markup, child.attribute("name")) == name)
      return dimension_of(markup, child.child("Dimension")).unit;
  return std::nullopt;
}

std::string problem_of_subject(std::string_view text) {
  auto problem = problem_of(description::type::kSubject, text);
  if (problem.empty() && subject_number(text) == 0)
    problem = "0 means no subject: choose another number";
  return problem;
}

std::string problem_of_name(std::string_view text) {
  return text.empty() ? std::string() : problem_of(description::type::kName, text);
}

std::string problem_of_description(std::string_view text) {
  if (control::to_utf8(text) != text) return "the text is not UTF-8";
  if (std::ranges::any_of(text, [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
    return "the text has control characters; it is one line";
  return problem_of(description::type::kText, text);
}

std::string problem_of_safe_side(std::string_view text) {
  return text.empty() ? std::string() : problem_of(description::type::kSafeSide, text);
}

std::string problem_of_priority(int priority) {
  return problem_of(description::type::kSetPriority, std::to_string(priority));
}

std::vector<std::string> problems_of(const Markup& markup, std::size_t about) {
  std::vector<std::string> problems;
  const auto channels = channel_nodes(markup);
  const auto& own = *channels[about];
  const auto channel = read_channel(markup, own);
  if (const auto problem = problem_of_subject(channel.subject); !problem.empty())
    problems.push_back(fmt::format("line {}: SubjectUID: {}", own.line, problem));
  std::map<int, int> priorities;
  for (const auto& child : own.children) {
    if (child.name != "Attributes") continue;
    add_problems(markup, child, problems);
    const int priority = read_set(markup, child).priority;
    if (!priorities.try_emplace(priority, child.line).second)
      problems.push_back(fmt::format(
          "line {}: a second attribute set of priority {}: each has a priority of its own",
          child.line, priority));
  }
  for (const auto* other : channels) {
    if (other == &own) continue;
    const auto name = text_of(markup, other->attribute("name"));
    if (!name.empty() && name == channel.name)
      problems.push_back(
          fmt::format("line {}: the name {} is already taken in line {}: names are unique",
                      own.line, name, other->line));
    const auto subject = text_of(markup, other->child("SubjectUID"));
    if (subject_number(subject) == subject_number(channel.subject))
      problems.push_back(
          fmt::format("line {}: SubjectUID {} is already that of the channel in line {}: subjects "
                      "are unique",
                      own.line, channel.subject, other->line));
  }
  return problems;
}

std::string lost_reference(const Markup& markup, const ChannelText& before,
                           const ChannelText& after) {
  const bool renamed = !before.name.empty() && before.name != after.name;
  const auto subject = subject_number(before.subject);
  const bool moved = subject != 0 && subject != subject_number(after.subject);
  const auto* found = find_node(markup.root(), [&](const Node& node) {
    const auto called = text_of(markup, node.attribute("channel"));
    return (renamed && called == before.name) || (moved && subject_number(called) == subject);
  });
  if (found == nullptr) return {};
  return fmt::format(
      "line {}: {} refers to the channel as {}: state the new name or subject there first",
      found->line, found->name, text_of(markup, found->attribute("channel")));
}

std::vector<ValueChange> changes(const ChannelText& before, const ChannelText& after) {
  std::vector<ValueChange> out;
  const auto compare = [&](const char* what, const std::string& old, const std::string& now) {
    if (old != now) out.push_back({what, old, now});
  };
  compare("subject", before.subject, after.subject);
  compare("name", before.name, after.name);
  compare("description", before.description, after.description);
  compare("safe side", before.safe_side, after.safe_side);
  // A set without priority is the only one, before and after.
  if (before.sets.size() == 1 && !before.sets.front().has_priority) {
    const auto now = std::ranges::find(after.sets, 0, &AttributeSetText::priority);
    if (now != after.sets.end() && now->has_priority)
      out.push_back({"priority of the set that had none", {}, "0"});
  }
  const auto with = [](const ChannelText& channel, int priority) {
    const auto found = std::ranges::find(channel.sets, priority, &AttributeSetText::priority);
    return found == channel.sets.end()
               ? AttributeSetText{.priority = priority, .has_priority = false, .attributes = {}}
               : *found;
  };
  std::vector<int> priorities;
  for (const auto* channel : {&before, &after})
    for (const auto& set : channel->sets)
      if (std::ranges::find(priorities, set.priority) == priorities.end())
        priorities.push_back(set.priority);
  for (const int priority : priorities)
    add_changes(with(before, priority), with(after, priority), out);
  return out;
}

}  // namespace mlcca::tools::design
