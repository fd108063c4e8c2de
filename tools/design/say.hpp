// SPDX-License-Identifier: BSD-2-Clause
// What the verbs of design time say: results on standard output, refusals as mlccactl puts them.
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
  std::vector<std::string> details;  ///< each a line; empty: the message says it all
};

/// How a verb ends.
using Finished = std::expected<Exit, Refusal>;
[[nodiscard]] inline std::unexpected<Refusal> refuse(Exit exit, std::string message) {
  return std::unexpected(Refusal{exit, std::move(message), {}});
}

/// To standard output. Exit::fine, or Exit::world where it cannot be written, which has been said.
Exit say(std::string_view text);

/// To standard error, or as {"error": {"kind", "message", "details"}} to standard output. The exit
/// status of the refusal.
Exit say(const Refusal& refused, bool json);
/// The exit status, of what was refused after it was said.
inline Exit finish(const Finished& done, bool json) {
  return done ? *done : say(done.error(), json);
}

}  // namespace mlcca::tools::design
