// SPDX-License-Identifier: BSD-2-Clause
// Children are matched with the steps of the type in order. A step may be left when it has its
// least number of children.
#include "description/content.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "description/short_form.hpp"
#include "description/suggest.hpp"

namespace mlcca::description {
namespace {

const Child* child_named(const Step& step, std::string_view name) {
  for (const auto& child : step.children)
    if (child.name == name) return &child;
  return nullptr;
}

bool was_seen(const Content& content, std::size_t step) {
  return ((content.seen >> step) & 1U) != 0;
}

/// How many children the step has so far.
std::uint32_t taken(const Content& content, std::size_t step) {
  return step == content.step ? content.count : 0;
}

bool is_open(const Step& step, const Content& content, std::size_t number) {
  if (taken(content, number) >= step.most) return false;
  const bool begun = taken(content, number) > 0;
  return !step.needs_previous || begun || taken(content, number - 1) > 0;
}

/// Calls `visit(step, number)` for each step that may come next, until it returns true.
template <class Visit>
void for_each_next(const ElementType& type, const Content& content, const Visit& visit) {
  if (type.any_order) {
    for (std::size_t i = 0; i < type.steps.size(); ++i)
      if (!was_seen(content, i) && visit(type.steps[i], i)) return;
    return;
  }
  for (std::size_t i = content.step; i < type.steps.size(); ++i) {
    const auto& step = type.steps[i];
    if (is_open(step, content, i) && visit(step, i)) return;
    if (taken(content, i) < step.least) return;
  }
}

using Names = std::vector<std::string_view>;

Names names_of(const ElementType& type) {
  Names out;
  for (const auto& step : type.steps)
    for (const auto& child : step.children) out.push_back(child.name);
  return out;
}

Names next_names(const ElementType& type, const Content& content) {
  Names out;
  for_each_next(type, content, [&](const Step& step, std::size_t) {
    for (const auto& child : step.children) out.push_back(child.name);
    return false;
  });
  return out;
}

std::string listed(const Names& names) {
  return fmt::format("{}{}", names.size() > 1 ? "one of " : "", fmt::join(names, ", "));
}

/// The first of the children `before`, which are in order, that must come after a child called
/// `name`. Null if there is none, or if any order is allowed.
const Element* first_behind(const ElementType& type, std::string_view name,
                            std::span<const Element> before) {
  if (type.any_order) return nullptr;
  const auto step_of = [&](std::string_view child) {
    return std::ranges::find_if(
        type.steps, [&](const Step& step) { return child_named(step, child) != nullptr; });
  };
  const auto own = step_of(name);
  const auto found =
      std::ranges::find_if(before, [&](const Element& child) { return step_of(child.name) > own; });
  return found == before.end() ? nullptr : &*found;
}

std::string did_you_mean(std::string_view name, const Names& known) {
  const auto close = closest(name, known);
  return close.empty() ? "" : fmt::format("; did you mean {}?", close);
}

/// The steps in words: "Description"; for a choice "one of A, B", or "A, B in any order" if it may
/// be repeated.
std::vector<std::string> words_of_steps(const ElementType& type) {
  std::vector<std::string> out;
  for (const Step& step : type.steps) {
    Names names;
    for (const auto& child : step.children) names.push_back(child.name);
    const bool several = names.size() > 1;
    out.push_back(fmt::format("{}{}{}", several && step.most == 1 ? "one of " : "",
                              fmt::join(names, ", "),
                              several && step.most != 1 ? " in any order" : ""));
  }
  return out;
}

std::string order_of(const ElementType& type, std::string_view element) {
  const auto names = names_of(type);
  if (type.steps.size() == 1 && names.size() > 1)
    return fmt::format("{} has one of {}", element, fmt::join(names, ", "));
  const bool has_choice =
      std::ranges::any_of(type.steps, [](const Step& step) { return step.children.size() > 1; });
  if (has_choice && !type.any_order)
    return fmt::format("{} has {}", element, fmt::join(words_of_steps(type), ", then "));
  return fmt::format("{} has {}{}", element, fmt::join(names, ", "),
                     type.steps.size() == 1 || type.any_order ? "" : ", in this order");
}

}  // namespace

const Child* next_child(const ElementType& type, Content& content, std::string_view name) {
  const Child* found = nullptr;
  std::size_t at = 0;
  for_each_next(type, content, [&](const Step& step, std::size_t number) {
    found = child_named(step, name);
    at = number;
    return found != nullptr;
  });
  if (found == nullptr) return nullptr;
  if (type.any_order) {
    content.seen |= 1U << at;
    return found;
  }
  content.count = taken(content, at) + 1;
  content.step = at;
  return found;
}

bool is_complete(const ElementType& type, const Content& content) {
  for (std::size_t i = 0; i < type.steps.size(); ++i) {
    if (type.any_order ? !was_seen(content, i) && type.steps[i].least > 0
                       : i >= content.step && taken(content, i) < type.steps[i].least)
      return false;
  }
  return true;
}

bool is_container(const ElementType& type) {
  return std::ranges::any_of(type.steps, &Step::includes);
}

std::vector<std::string_view> containers() {
  Names out;
  for (const auto* type : element_types())
    if (is_container(*type)) out.push_back(type->name);
  return out;
}

std::string explain_child(const ElementType& type, const Content& content, std::string_view parent,
                          std::string_view name, std::span<const Element> before) {
  if (type.value != nullptr) return fmt::format("is not expected: {} is a plain value", parent);
  if (type.steps.empty()) return fmt::format("is not expected: {} is empty", parent);
  const auto names = names_of(type);
  const bool known = std::ranges::find(names, name) != names.end();
  if (!known && is_container(type))
    return fmt::format("is not known here; {}", known_names(name, names));
  const auto order = order_of(type, parent);
  if (!known) return fmt::format("is not known here: {}{}", order, did_you_mean(name, names));
  const auto next = next_names(type, content);
  if (const Element* const later = first_behind(type, name, before))
    return fmt::format("comes too late: it belongs before {} in line {}{}: {}", later->name,
                       later->line, next.empty() ? "" : ", and here may stand " + listed(next),
                       order);
  if (next.empty()) return fmt::format("is one too many or out of place: {}", order);
  const auto own = std::ranges::find_if(
      type.steps, [&](const Step& step) { return child_named(step, name) != nullptr; });
  // A child of a later step is refused because a child before it is missing, one of the current
  // step because that is full.
  const bool too_early = own - type.steps.begin() > static_cast<std::ptrdiff_t>(content.step);
  return too_early ? fmt::format("comes too early: {} belongs before it: {}", listed(next), order)
                   : fmt::format("is one too many: here may stand {}: {}", listed(next), order);
}

std::string explain_incomplete(const ElementType& type, const Content& content) {
  return fmt::format("is not complete: it needs {}", listed(next_names(type, content)));
}

std::string explain_key(const ElementType& type, std::string_view element, std::string_view key) {
  if (type.name == "Attribute" && key == "dynamic")
    return "attribute dynamic is only for a Provision: nothing else is a best case";
  const bool is_list = list_named(type.name) != nullptr;
  if (const auto attribute = with_short_name(key); attribute && is_list) {
    const auto& row = info(*attribute);
    if (row.composition == Composition::not_provided)
      return fmt::format("attribute {}: {}", key, not_provided_words(row.name));
    if (type.name == "PerHop")
      return fmt::format("attribute {}: {}", key, of_links_words(row.name));
  }
  if (type.keys.empty()) return fmt::format("attribute {} is not known: {} has none", key, element);
  Names names;
  for (const auto& k : type.keys) names.push_back(k.name);
  return fmt::format("attribute {} is not known: {} has {}{}{}", key, element,
                     fmt::join(names, ", "), did_you_mean(key, names),
                     is_list ? "; a UserAttribute has a value in an element Attribute" : "");
}

}  // namespace mlcca::description
