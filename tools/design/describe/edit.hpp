// SPDX-License-Identifier: BSD-2-Clause
// Changes of an event channel. Each replaces only the bytes that it concerns.
#pragma once
#include <optional>
#include <string>
#include <variant>

#include "tools/design/describe/channel.hpp"

namespace mlcca::tools::design {

/// Sets a text field; an empty text removes an optional field.
struct SetField {
  enum class Which : std::uint8_t { subject, name, description, safe_side };
  Which which = Which::subject;
  std::string text;
};
/// Sets an attribute in the set of that priority (without one, in the only set). A set that does
/// not exist is created as a copy of the one with the highest priority.
struct SetAttribute {
  Quantity quantity;
  std::optional<int> priority;
};
/// Removes an attribute from the set of that priority (without one, from the only set).
struct UnsetAttribute {
  std::string name;
  std::optional<int> priority;
};
/// Removes an attribute set with its content.
struct RemoveSet {
  int priority = 0;
};
using Edit = std::variant<SetField, SetAttribute, UnsetAttribute, RemoveSet>;

/// Makes a change in the channel with index `channel`. An error says what does not exist, or that
/// the set is ambiguous; the text is unchanged then.
Result<void> apply(Markup& markup, std::size_t channel, const Edit& edit);

/// The text of an event-channel file that has only this subject.
std::string new_channel_file(const std::string& subject);

}  // namespace mlcca::tools::design
