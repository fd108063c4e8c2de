// SPDX-License-Identifier: BSD-2-Clause
// Changes of one event channel, each as a replacement of the bytes that it concerns.
#pragma once
#include <optional>
#include <string>
#include <variant>

#include "tools/design/describe/channel.hpp"

namespace mlcca::tools::design {

/// A field that is one text; an empty one removes what may be absent.
struct SetField {
  enum class Which : std::uint8_t { subject, name, description, safe_side };
  Which which = Which::subject;
  std::string text;
};
/// One attribute of the set of that priority; without a priority, of the only set. A set that is
/// not there is made first, as a copy of the one that is preferred until then.
struct SetAttribute {
  Quantity quantity;
  std::optional<int> priority;
};
struct UnsetAttribute {
  std::string name;
  std::optional<int> priority;
};
/// A whole set, with what stands in it.
struct RemoveSet {
  int priority = 0;
};
using Edit = std::variant<SetField, SetAttribute, UnsetAttribute, RemoveSet>;

/// Carries it out in the channel that is number `channel` of the text. The error names what is not
/// there, or what the priority leaves open; the text is then as it was.
Result<void> apply(Markup& markup, std::size_t channel, const Edit& edit);

/// An event-channel file with that subject and nothing else.
std::string new_channel_file(const std::string& subject);

}  // namespace mlcca::tools::design
