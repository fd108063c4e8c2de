// SPDX-License-Identifier: BSD-2-Clause
// Questions on a terminal, one for each field of a channel.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "tools/design/describe/edit.hpp"

namespace mlcca::tools::design {

/// A person at a keyboard: prompts go to standard error, so that standard output can be redirected.
class Terminal {
 public:
  /// Standard input and standard error are a terminal.
  static bool is_there();

  static void say(const std::string& line);
  /// The answer without blanks around it; nullopt at the end of the input (Ctrl-D).
  std::optional<std::string> ask(const std::string& question);

 private:
  std::string unread_;
};

/// Asks for every field of channel number `channel`, with the present value as default, and carries
/// each answer out at once. A wrong answer is explained and asked for again. False when the input
/// ends: the text is not to be used then.
bool ask_for_changes(Terminal& terminal, Markup& markup, std::size_t channel);

/// "yes" by default; false for no, and at the end of the input.
bool confirm(Terminal& terminal, const std::string& question);

/// A subject that no other channel has: 64 random bits of the kernel, not 0.
Result<std::string> random_subject();

/// What stands against that quantity in a file that declares its attribute with another unit.
Result<void> check_declared(const Markup& markup, const Quantity& quantity);

}  // namespace mlcca::tools::design
