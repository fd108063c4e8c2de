// SPDX-License-Identifier: BSD-2-Clause
// How a program ends when its command line asks for no more than a text, or cannot be used.
#pragma once
#include <algorithm>
#include <initializer_list>
#include <sstream>
#include <string>
#include <string_view>

#include "base/standard_streams.hpp"

namespace mlcca {

/// Prints what CLI11 (`app` after the exception `end`) has to say: the help or the version to
/// standard output, what is wrong to standard error. Returns the exit status: 0, `usage` if the
/// command line is wrong, or `unwritten` if standard output cannot be written.
template <class App, class ParseError>
[[nodiscard]] int end_of_parsing(const App& app, const ParseError& end, int usage, int unwritten) {
  std::ostringstream out;
  std::ostringstream error;
  const int status = app.exit(end, out, error);
  to_stderr(error.str());
  if (!printed(app.get_name(), out.str())) return unwritten;
  return status == 0 ? 0 : usage;
}

/// Makes the options and arguments of a command of CLI11 refuse an empty value, which a variable of
/// a shell that is not set leaves. `but` are those for which it has a meaning.
template <class Command>
void refuse_empty_values(Command& command, std::initializer_list<std::string_view> but = {}) {
  for (auto* option : command.get_options())
    if (option->get_type_size_max() != 0 && std::ranges::find(but, option->get_name()) == but.end())
      option->check([](const std::string& text) {
        return text.empty() ? std::string("must not be empty") : std::string();
      });
  // Groups of options are commands without a name.
  for (auto* group : command.get_subcommands([](const Command*) { return true; }))
    if (group->get_name().empty()) refuse_empty_values(*group, but);
}

}  // namespace mlcca
