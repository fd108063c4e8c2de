// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/describe/edit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "description/short_form.hpp"
#include "tools/design/describe/layout.hpp"
#include "tools/design/describe/lists.hpp"
#include "tools/escape.hpp"

namespace mlcca::tools::design {
namespace {

std::string short_name_of(const Quantity& quantity) {
  for (std::size_t i = 0; i < kAttributes; ++i)
    if (quantity.name == kAttributeTable[i].name) return description::short_name(attribute_at(i));
  return {};
}

/// Adds a quantity to a new list: as XML attribute, or as element if the short form cannot express
/// it.
void state(NewElement& list, const Quantity& quantity) {
  if (const auto value = short_value(list.name, quantity))
    list.attributes += fmt::format(" {}=\"{}\"", short_name_of(quantity), *value);
  else
    list.children.push_back(attribute_element(quantity));
}

/// Makes changes in a channel. Each step searches the elements again, because a change moves them.
class Editor {
 public:
  Editor(Markup& markup, std::size_t channel) : markup_(markup), channel_(channel) {}

  Result<void> operator()(const SetField& edit) {
    // Compares the value, not its notation in the file, which may have references or comments.
    if (present(edit.which) == edit.text) return {};
    switch (edit.which) {
      case SetField::Which::subject:
        replace_text(markup_, *node().child("SubjectUID"), edit.text);
        break;
      case SetField::Which::name:
        set_attribute(markup_, node(), "name", edit.text);
        break;
      case SetField::Which::safe_side:
        set_attribute(markup_, node(), "safe-side", edit.text);
        break;
      case SetField::Which::description:
        set_description(edit.text);
    }
    return {};
  }

  Result<void> operator()(const SetAttribute& edit) {
    auto set = set_of(edit.priority, true);
    if (!set) return std::unexpected(set.error());
    set_ = *set;
    name_ = edit.quantity.name;
    const auto now = read_channel(markup_, node()).sets.at(set_).attributes;
    const auto found = std::ranges::find(now, name_, &Quantity::name);
    if (found == now.end())
      add(edit.quantity);
    else if (!is_same(*found, edit.quantity))
      change(*found, edit.quantity);
    return {};
  }

  Result<void> operator()(const UnsetAttribute& edit) {
    auto set = set_of(edit.priority, false);
    if (!set) return std::unexpected(set.error());
    set_ = *set;
    name_ = edit.name;
    const auto now = attributes_of(markup_, *sets().at(set_));
    const auto found =
        std::ranges::find(now, name_, [](const Listed& l) { return l.quantity.name; });
    if (found == now.end())
      return fail(fmt::format("there is no {} that could be removed", edit.name));
    if (found->element != nullptr)
      remove(markup_, *found->element);
    else
      set_attribute(markup_, *sets().at(set_), std::string(found->key->name), "");
    return {};
  }

  Result<void> operator()(const RemoveSet& edit) {
    auto set = set_of(edit.priority, false);
    if (!set) return std::unexpected(set.error());
    remove(markup_, *sets().at(*set));
    return {};
  }

 private:
  [[nodiscard]] std::string present(SetField::Which which) const {
    const auto channel = read_channel(markup_, node());
    switch (which) {
      case SetField::Which::subject:
        return channel.subject;
      case SetField::Which::name:
        return channel.name;
      case SetField::Which::description:
        return channel.description;
      case SetField::Which::safe_side:
        break;
    }
    return channel.safe_side;
  }

  [[nodiscard]] const Node& node() const { return *channel_nodes(markup_).at(channel_); }

  [[nodiscard]] std::vector<const Node*> sets() const {
    std::vector<const Node*> found;
    for (const auto& child : node().children)
      if (child.name == "Attributes") found.push_back(&child);
    return found;
  }

  /// The Attribute element of that name in the present set; nullptr if there is none.
  [[nodiscard]] const Node* attribute() const {
    for (const auto& child : sets().at(set_)->children) {
      const auto* name = child.name == "Attribute" ? child.child("Name") : nullptr;
      if (name != nullptr && markup_.text_of(*name) == name_) return &child;
    }
    return nullptr;
  }

  void set_description(const std::string& text) {
    const auto* old = node().child("Description");
    if (old != nullptr && text.empty())
      remove(markup_, *old);
    else if (old != nullptr)
      replace_text(markup_, *old, text);
    else if (!text.empty())
      insert_after(markup_, *node().child("SubjectUID"), leaf("Description", text));
  }

  /// The index of the set with that priority; with `make`, a missing one is created.
  Result<std::size_t> set_of(std::optional<int> priority, bool make) {
    const auto sets = read_channel(markup_, node()).sets;
    if (!priority && sets.size() == 1) return std::size_t{0};
    if (!priority && sets.size() > 1) {
      std::vector<int> known;
      known.reserve(sets.size());
      for (const auto& set : sets) known.push_back(set.priority);
      return fail(fmt::format("there are several attribute sets, of priority {}: say which",
                              fmt::join(known, ", ")));
    }
    const auto found = std::ranges::find(sets, priority.value_or(0), &AttributeSetText::priority);
    if (found != sets.end()) return static_cast<std::size_t>(found - sets.begin());
    if (!make) return fail("there is no such attribute set");
    return make_set(sets, priority);
  }

  std::size_t make_set(const std::vector<AttributeSetText>& sets, std::optional<int> priority) {
    NewElement element{.name = "Attributes", .text = {}, .children = {}, .attributes = {}};
    if (priority) element.attributes = fmt::format(" priority=\"{}\"", *priority);
    // The new set gets all attributes of the preferred one: without a requirement it would be
    // granted on any network.
    if (!sets.empty())
      for (const auto& quantity :
           std::ranges::max_element(sets, {}, &AttributeSetText::priority)->attributes)
        state(element, quantity);
    if (sets.empty()) {
      const auto* before = node().child("Description");
      if (before == nullptr) before = node().child("SubjectUID");
      insert_after(markup_, *before, element);
      return 0;
    }
    // With alternatives, every set must state its priority, also the one that was alone before.
    for (std::size_t i = 0; i < sets.size(); ++i)
      if (!sets[i].has_priority)
        set_attribute(markup_, *this->sets().at(i), "priority", std::to_string(sets[i].priority));
    insert_after(markup_, *this->sets().back(), element);
    return sets.size();
  }

  void add(const Quantity& quantity) {
    const auto& set = *sets().at(set_);
    if (const auto value = keeps_to_elements(set) ? std::nullopt : short_value(set.name, quantity))
      set_attribute(markup_, set, short_name_of(quantity), *value);
    else if (set.children.empty())
      insert_first(markup_, set, attribute_element(quantity));
    else
      insert_after(markup_, set.children.back(), attribute_element(quantity));
  }

  /// Whether the list states built-in attributes, all of them in the paper's form.
  [[nodiscard]] bool keeps_to_elements(const Node& set) const {
    const auto all = attributes_of(markup_, set);
    return std::ranges::none_of(all, [](const Listed& l) { return l.key != nullptr; }) &&
           std::ranges::any_of(all,
                               [](const Listed& l) { return names_built_in(l.quantity.name); });
  }

  void change(const Quantity& from, const Quantity& to) {
    if (attribute() == nullptr) {
      const auto& set = *sets().at(set_);
      const auto value = short_value(set.name, to);
      set_attribute(markup_, set, short_name_of(to), value.value_or(""));
      if (!value) insert_first(markup_, *sets().at(set_), attribute_element(to));
      return;
    }
    if (from.value != to.value) replace_text(markup_, *attribute()->child("Value"), to.value);
    if (attribute()->child("Dimension") == nullptr) {
      const auto dimension = dimension_element(to.dimension);
      if (!dimension.children.empty())
        insert_after(markup_, *attribute()->child("Name"), dimension);
      return;
    }
    if (from.dimension.unit != to.dimension.unit)
      change_unit(from.dimension.unit, to.dimension.unit);
    if (from.dimension.magnitude != to.dimension.magnitude)
      change_magnitude(std::to_string(to.dimension.magnitude));
  }

  [[nodiscard]] const Node& dimension() const { return *attribute()->child("Dimension"); }

  void change_magnitude(const std::string& text) {
    if (const auto* old = dimension().child("Magnitude"))
      replace_text(markup_, *old, text);
    else if (const auto* unit = dimension().child("SIUnit"))
      insert_after(markup_, *unit, leaf("Magnitude", text));
    else
      insert_first(markup_, dimension(), leaf("Magnitude", text));
  }

  void change_unit(const description::Unit& from, const description::Unit& to) {
    if (dimension().child("SIUnit") == nullptr) {
      insert_first(markup_, dimension(), unit_element(to));
      return;
    }
    for (std::size_t i = 0; i < to.size(); ++i)
      if (from.at(i) != to.at(i)) change_exponent(kBaseElements.at(i), std::to_string(to.at(i)));
  }

  void change_exponent(const char* base, const std::string& text) {
    const auto& unit = *dimension().child("SIUnit");
    if (const auto* old = unit.child(base))
      replace_text(markup_, *old, text);
    else if (unit.children.empty())
      insert_first(markup_, unit, leaf(base, text));
    else
      insert_after(markup_, unit.children.back(), leaf(base, text));
  }

  Markup& markup_;
  std::size_t channel_;
  std::size_t set_ = 0;  ///< index of the set that is changed
  std::string name_;
};

}  // namespace

Result<void> apply(Markup& markup, std::size_t channel, const Edit& edit) {
  return std::visit(Editor(markup, channel), edit);
}

std::string new_channel_file(const std::string& subject) {
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<EventChannel>\n"
      "  <SubjectUID>{}</SubjectUID>\n"
      "</EventChannel>\n",
      escaped(subject));
}

}  // namespace mlcca::tools::design
