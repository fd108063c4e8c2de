// SPDX-License-Identifier: BSD-2-Clause
// Where the verbs with the option --output write, and one rule for what is there already.
#pragma once
#include <CLI/App.hpp>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace mlcca::tools::design {

/// What is done with a regular file that exists.
enum class Existing : std::uint8_t {
  refuse,  ///< of a verb that makes a draft, which people change
  ask,     ///< refuse, and name --force
  replace,
};
/// Of a verb with the option --force.
[[nodiscard]] constexpr Existing existing_if(bool force) {
  return force ? Existing::replace : Existing::ask;
}

/// Adds --force, which replaces a file that exists, to a verb whose option --output is `output`.
void add_force(CLI::App& verb, CLI::Option* output, bool& force);

/// Makes an argument or option that names a description refuse "-": the files that a description
/// includes are beside its own.
void refuse_standard_input(CLI::Option* file);

/// The path that --output states; empty if that is standard output, as "-" is.
[[nodiscard]] std::string path_of_output(const std::string& output);

/// Whether a file can be created or replaced there; if not, why. It writes nothing.
Result<void> can_write(const std::string& path, Existing existing);

/// Writes the file `path` atomically: a reader sees the old content or the new. A device or pipe is
/// written directly. An error if it exists and must not be replaced.
Result<void> write_output(const std::string& path, std::string_view text, Existing existing);

/// Whether `path` is the same file as one of `files`, also under another name.
bool is_one_of(const std::string& path, const std::vector<std::string>& files);

}  // namespace mlcca::tools::design
