// SPDX-License-Identifier: BSD-2-Clause
// The system description: XML in, core::System out, or every problem with the line it is on.
// The format and its limits are documented in system.xsd; nothing of libxml2 is visible here.
#pragma once
#include <cstdint>
#include <expected>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/sha256.hpp"
#include "core/design/findings.hpp"
#include "core/model/system.hpp"

namespace mlcca::description {

/// One mistake in a description.
struct Problem {
  std::string file;
  int line = 0;         ///< 1.., or 0: the file as a whole
  std::string element;  ///< local name; empty: the document or its syntax
  std::string text;     ///< what is wrong and what would be right
  core::FindingId id = core::FindingId::rule;

  bool operator==(const Problem&) const = default;
};

/// "file:line: <Element>: text"; parts that are unknown are left out.
std::string to_string(const Problem& problem);

using Description = std::expected<core::System, std::vector<Problem>>;

/// Told about every MiB how many bytes are read, of how many in the files that are known so far.
/// May be empty.
using Progress = std::function<void(std::uint64_t bytes_read, std::uint64_t bytes_total)>;

/// Whose user names count: those of this machine, or any, because the description is for another.
enum class Users : std::uint8_t { of_this_machine, any };

/// What is found out about a description, as far as it can be read.
struct Examined {
  core::System system;            ///< only its files unless readable
  std::vector<Problem> problems;  ///< ordered by file as they appear, then by line
  bool readable = false;          ///< every file could be read and fits the schema
};

/// Reads the regular file paths[0], whose root is a System, and the files that it includes (at most
/// 256 MiB together). The roots of further paths are parts of a System: they count as if they were
/// included at its end. If readable, all indices of the System are valid, and the problems are
/// those of values of attributes, names and rules (system.xsd, rules.hpp); what a problem is about
/// may be missing in the System. If not, they are those of files, syntax and schema; what follows a
/// syntax error, or stands in the same element after one that does not belong there, is not
/// examined. More than 1000 problems end with one that says so. Looks up user names in the system's
/// user database; opens no other file and no connection. `paths` must not be empty.
Examined examine(const std::vector<std::string>& paths, const Progress& progress = {},
                 Users users = Users::of_this_machine);

/// Whether the root of the file is a part of a System. False for what is no XML, too.
bool is_part(const std::string& path);

/// The System of the file `path` and what it includes; any problem is an error. See examine().
/// `digest`, where there is one, gets that of the contents of the files: the same on all machines.
/// `bundle`, where there is one as well, gets all of them in one text, or nothing if they are too
/// long for that (bundle.hpp).
Description read(const std::string& path, Users users = Users::of_this_machine,
                 Sha256::Digest* digest = nullptr, std::string* bundle = nullptr);
/// The same of such a text. No file is opened.
Description read_bundle(std::string_view bundle, Users users, Sha256::Digest& digest);

/// The same for a text; `name` stands for the file in problems and origins. Includes are looked up
/// in the folder `base`, or refused if that is empty.
Description read_memory(std::string_view xml, const std::string& name, const std::string& base = {},
                        Users users = Users::of_this_machine);

/// Whether one file, whose root is a System or a part of one, can be read and fits the schema, with
/// the files that it includes. Values, names and rules are not examined.
std::vector<Problem> check_part(const std::string& path);

/// The text of system.xsd, as compiled into the program.
std::string_view schema();

}  // namespace mlcca::description
