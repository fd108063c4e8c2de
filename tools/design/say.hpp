// SPDX-License-Identifier: BSD-2-Clause
// Output of the design-time verbs: results on standard output, refusals in the form of mlccactl.
#pragma once
#include <expected>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/exit.hpp"

namespace mlcca::tools::design {

/// Why a verb did nothing.
struct Refusal {
  Exit exit = Exit::usage;
  std::string message;
  std::vector<std::string> details;  ///< lines; empty if the message says everything
};

/// The end of a verb: an exit status or a refusal.
using Finished = std::expected<Exit, Refusal>;
[[nodiscard]] inline std::unexpected<Refusal> refuse(Exit exit, std::string message) {
  return std::unexpected(Refusal{exit, std::move(message), {}});
}

/// Prints to standard output. Exit::fine, or Exit::world after an error message if that fails.
[[nodiscard]] Exit say(std::string_view text);

/// Prints a refusal to standard error, or with `json` as {"error": {"kind", "message", "details"}}
/// to standard output. Returns the exit status of the refusal, or Exit::world if that fails.
[[nodiscard]] Exit say(const Refusal& refused, bool json);

/// Prints each as a line "note: …" to standard error.
void print_notes(const std::vector<std::string>& notes);

/// The exit status of a verb; a refusal is printed.
[[nodiscard]] inline Exit finish(const Finished& done, bool json) {
  return done ? *done : say(done.error(), json);
}

}  // namespace mlcca::tools::design
