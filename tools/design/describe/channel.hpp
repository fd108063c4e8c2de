// SPDX-License-Identifier: BSD-2-Clause
// The event channels of a file, as a person sees them, and what is changed of one.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tools/design/describe/markup.hpp"
#include "tools/design/describe/quantity.hpp"

namespace mlcca::tools::design {

/// The <Attributes> of a priority; without one it is 0.
struct AttributeSetText {
  int priority = 0;
  bool has_priority = false;  ///< the file states it
  std::vector<Quantity> attributes;
};

struct ChannelText {
  std::string name;  ///< empty: called by its subject
  std::string subject;
  std::string description;
  std::string safe_side;  ///< drop, deliver, or empty
  std::vector<AttributeSetText> sets;
};

/// Every EventChannel element, in the order of the file.
std::vector<const Node*> channel_nodes(const Markup& markup);

ChannelText read_channel(const Markup& markup, const Node& node);

/// The unit of the UserAttribute `name` that the same file declares.
std::optional<description::Unit> declared_unit(const Markup& markup, std::string_view name);

/// What is wrong with a text for that field; an empty text if nothing. Empty is right where a field
/// may be absent.
std::string problem_of_subject(std::string_view text);
std::string problem_of_name(std::string_view text);
std::string problem_of_description(std::string_view text);
std::string problem_of_safe_side(std::string_view text);
std::string problem_of_priority(int priority);

/// What is wrong with the channels of a file and not seen by the schema: values, and names and
/// subjects that two of them share. Each with "line N: " in front; `about` is checked in full, of
/// the others only name and subject.
std::vector<std::string> problems_of(const Markup& markup, std::size_t about);

/// The first publisher, subscriber or binding of the file that calls the channel by a name or a
/// subject that it had before and has no more, with "line N: " in front; empty if there is none.
std::string lost_reference(const Markup& markup, const ChannelText& before,
                           const ChannelText& after);

/// A difference between two states of a channel: "Period", "50 ms", "40 ms". Empty: absent.
struct Change {
  std::string what;
  std::string before;
  std::string after;
};
std::vector<Change> changes(const ChannelText& before, const ChannelText& after);

}  // namespace mlcca::tools::design
