// SPDX-License-Identifier: BSD-2-Clause
// The event channels of a file as text values, their validation and their differences.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tools/design/describe/markup.hpp"
#include "tools/design/describe/quantity.hpp"

namespace mlcca::tools::design {

/// An <Attributes> element with its priority, which is 0 if it states none.
struct AttributeSetText {
  int priority = 0;
  bool has_priority = false;  ///< the file states the priority
  std::vector<Quantity> attributes;
};

/// The values of an EventChannel element.
struct ChannelText {
  std::string name;  ///< empty: the channel is known by its subject
  std::string subject;
  std::string description;
  std::string safe_side;  ///< "drop", "deliver" or empty
  std::vector<AttributeSetText> sets;
};

/// All EventChannel elements in the order of the file.
std::vector<const Node*> channel_nodes(const Markup& markup);

ChannelText read_channel(const Markup& markup, const Node& node);

/// The unit of the UserAttribute `name` that the file declares; nullopt if it declares none.
std::optional<description::Unit> declared_unit(const Markup& markup, std::string_view name);

/// What is wrong with a text for the field; an empty result if nothing is. An empty text is right
/// for optional fields.
std::string problem_of_subject(std::string_view text);
std::string problem_of_name(std::string_view text);
std::string problem_of_description(std::string_view text);
std::string problem_of_safe_side(std::string_view text);
std::string problem_of_priority(int priority);

/// Problems of channels that the schema does not find: wrong values, and names or subjects that two
/// channels share. Each begins with "line N: ". The channel with index `about` is checked
/// completely, of the others only name and subject.
std::vector<std::string> problems_of(const Markup& markup, std::size_t about);

/// The first publisher, subscriber or binding of the file that refers to the channel by a name or
/// subject that the edit has removed, with "line N: " in front; empty if there is none.
std::string lost_reference(const Markup& markup, const ChannelText& before,
                           const ChannelText& after);

/// A difference between two states of a channel, such as "Period", "50 ms", "40 ms". An absent
/// value is empty.
struct ValueChange {
  std::string what;
  std::string before;
  std::string after;
};
std::vector<ValueChange> changes(const ChannelText& before, const ChannelText& after);

}  // namespace mlcca::tools::design
