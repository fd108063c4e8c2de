// SPDX-License-Identifier: BSD-2-Clause
// Reads a system description: returns a core::System, or all problems with their lines. system.xsd
// documents the format and its limits. libxml2 is not visible here.
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

/// A problem of a description.
struct Problem {
  std::string file;
  int line = 0;         ///< from 1 on; 0: the file in general
  std::string element;  ///< local name; empty: the document or its syntax
  std::string text;     ///< what is wrong, and what would be right
  core::FindingId id = core::FindingId::rule;

  bool operator==(const Problem&) const = default;
};

/// "file:line: <Element>: text" without the parts that are unknown.
std::string to_string(const Problem& problem);

using Description = std::expected<core::System, std::vector<Problem>>;

/// Called about once per MiB with the number of bytes read, and with the total size of the files
/// known so far. May be empty.
using Progress = std::function<void(std::uint64_t bytes_read, std::uint64_t bytes_total)>;

/// Whether user names are looked up on this machine. `any`: the description is for another machine,
/// and every name is accepted.
enum class Users : std::uint8_t { of_this_machine, any };

/// The result of examining a description, as far as it can be read.
struct Examined {
  core::System system;            ///< only its file names unless `readable`
  std::vector<Problem> problems;  ///< ordered by file as they are opened, then by line
  bool readable = false;          ///< every file could be read and conforms to the schema
};

/// Reads the regular file paths[0], whose root is a System, and the files that it includes (at most
/// 256 MiB together). The roots of further paths are parts of a System and count as if they were
/// included at its end; `paths` must not be empty.
/// If the result is readable, all indices of the System are valid, and the problems are those of
/// values of attributes, names and rules (system.xsd, rules.hpp); the parts concerned may be
/// missing in the System. If not, they are problems of files, syntax and schema; text behind a
/// syntax error, or behind a wrong child in the same element, is not examined. After 1000 problems
/// one more says that there are others. User names are looked up in the system's user database. No
/// other file and no connection is opened.
Examined examine(const std::vector<std::string>& paths, const Progress& progress = {},
                 Users users = Users::of_this_machine);

/// Whether the root of the file is a part of a System; false as well if it is no XML.
bool is_part(const std::string& path);

/// Reads the System in the file `path` and the files that it includes; any problem makes it fail.
/// See examine(). `digest`, if not null, gets the digest of the contents of the files, which is the
/// same on all machines. `bundle`, if not null as well, gets all files in one text (bundle.hpp), or
/// an empty text if that would be too long.
Description read(const std::string& path, Users users = Users::of_this_machine,
                 Sha256::Digest* digest = nullptr, std::string* bundle = nullptr);
/// Reads such a bundle. No file is opened.
Description read_bundle(std::string_view bundle, Users users, Sha256::Digest& digest);

/// Reads a text; `name` is the file name in problems and origins. Includes are looked up in the
/// folder `base`; if that is empty, they are refused.
Description read_memory(std::string_view xml, const std::string& name, const std::string& base = {},
                        Users users = Users::of_this_machine);

/// Checks one file, whose root is a System or a part of one, and the files that it includes:
/// whether they can be read and conform to the schema. Values, names and rules are not examined.
std::vector<Problem> check_part(const std::string& path);

/// The text of system.xsd, as compiled into the program.
std::string_view schema();

}  // namespace mlcca::description
