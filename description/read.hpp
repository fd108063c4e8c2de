// SPDX-License-Identifier: BSD-2-Clause
// The system description: XML in, core::System out, or every problem with the line it is on.
// The format and its limits are documented in system.xsd; nothing of libxml2 is visible here.
#pragma once
#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "core/system.hpp"

namespace mlcca::description {

/// One mistake in a description.
struct Problem {
  std::string file;
  int line = 0;         ///< 1.., or 0: the file as a whole
  std::string element;  ///< local name; empty: the document or its syntax
  std::string text;     ///< what is wrong and what would be right

  bool operator==(const Problem&) const = default;
};

/// "file:line: <Element>: text"; parts that are unknown are left out.
std::string to_string(const Problem& problem);

using Description = std::expected<core::System, std::vector<Problem>>;

/// Reads the regular file `path` (at most 16 MiB). The System refers to nothing outside itself, all
/// its indices are valid and every rule of system.xsd and rules.hpp holds. Otherwise all problems
/// of the first stage that found any are returned, ordered by line: syntax, schema and values of
/// attributes; then names and rules. What follows a syntax error, or stands in the same element
/// after one that does not belong there, is not examined. More than 1000 problems end with one that
/// says so. Looks up user names in the system's user database; opens no other file and no
/// connection.
Description read(const std::string& path);

/// The same for a text; `name` stands for the file in problems and origins.
Description read_memory(std::string_view xml, const std::string& name);

/// The text of system.xsd, as compiled into the program.
std::string_view schema();

}  // namespace mlcca::description
