// SPDX-License-Identifier: BSD-2-Clause
// Names of a description as C++ identifiers and file names.
#pragma once
#include <map>
#include <set>
#include <string>
#include <string_view>

namespace mlcca::tools::design {

/// "emergency-switch" -> "EmergencySwitch", "CAN" -> "Can", "0xa4ef" -> "Subject_a4ef": starts with
/// a large letter, is no keyword and no macro of a standard header. Different names can give the
/// same.
std::string type_name(std::string_view name);

/// "emergency-switch" -> "emergency_switch", for file names.
std::string file_name(std::string_view name);

/// The same for namespaces: "switch" -> "switch_".
std::string small_name(std::string_view name);

/// Text of the description on one line of a comment: no control characters, nothing that a compiler
/// or an editor takes for more than text. Ends with a quote, never with a backslash.
std::string comment_text(std::string_view text);

/// The same as a literal for a compiler's message.
std::string string_literal(std::string_view text);

/// Hands out each name once: a second "Motor" is "Motor_2". Names that differ in case only count as
/// equal, because some file systems do not distinguish them.
class Names {
 public:
  std::string take(const std::string& wanted);

 private:
  std::set<std::string> taken_;
  std::map<std::string, int> next_;  ///< number to try, of a name that was wanted before
};

}  // namespace mlcca::tools::design
