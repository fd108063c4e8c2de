// SPDX-License-Identifier: BSD-2-Clause
// Converts names of a description into C++ identifiers and file names.
#pragma once
#include <map>
#include <set>
#include <string>
#include <string_view>

namespace mlcca::tools::design {

/// A type name: "emergency-switch" -> "EmergencySwitch", "CAN" -> "Can", "0xa4ef" ->
/// "Subject_a4ef". It begins with a capital letter and is no keyword and no macro of a standard
/// header. Different names can give the same result; see Names.
std::string type_name(std::string_view name);

/// A file name: "emergency-switch" -> "emergency_switch".
std::string file_name(std::string_view name);

/// A namespace: "switch" -> "switch_".
std::string small_name(std::string_view name);

/// Text of the description for one line of a comment, in quotes: no control characters and nothing
/// with a meaning for a compiler or editor. It never ends with a backslash.
std::string comment_text(std::string_view text);

/// Text of the description as a string literal in a message of the compiler.
std::string string_literal(std::string_view text);

/// Makes names unique: a second "Motor" becomes "Motor_2". Names that differ only in case count as
/// equal, because some file systems do not distinguish them.
class Names {
 public:
  /// Returns `wanted` or a variant that was not returned before.
  std::string take(const std::string& wanted);

 private:
  std::set<std::string> taken_;
  std::map<std::string, int> next_;  ///< the number to try next for a name that was taken before
};

}  // namespace mlcca::tools::design
