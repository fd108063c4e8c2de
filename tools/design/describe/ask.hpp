// SPDX-License-Identifier: BSD-2-Clause
// The dialogue of `describe` on a terminal, with a question for each field of a channel.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "tools/design/describe/edit.hpp"

namespace mlcca::tools::design {

/// A terminal with a person. Prompts go to standard error, so that standard output can be
/// redirected.
class Terminal {
 public:
  /// Whether standard input and standard error are a terminal.
  static bool is_there();

  static void say(const std::string& line);
  /// Asks and returns the answer without surrounding blanks; nullopt at the end of input (Ctrl-D).
  std::optional<std::string> ask(const std::string& question);

 private:
  std::string unread_;
};

/// Asks for every field of channel number `channel`, with the present value as default, and makes
/// each change at once. An invalid answer is explained and asked for again. False if the input
/// ended; the caller must then discard the text.
bool ask_for_changes(Terminal& terminal, Markup& markup, std::size_t channel);

/// Asks for yes (the default) or no; false also at the end of input.
bool confirm(Terminal& terminal, const std::string& question);

/// A random subject: 64 bits from the kernel, not 0.
Result<std::string> random_subject();

/// An error if the file declares the attribute of the quantity with another unit.
Result<void> check_declared(const Markup& markup, const Quantity& quantity);

}  // namespace mlcca::tools::design
