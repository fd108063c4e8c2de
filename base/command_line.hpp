// SPDX-License-Identifier: BSD-2-Clause
// How a program ends when its command line asks for no more than a text, or cannot be used.
#pragma once
#include <sstream>

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

}  // namespace mlcca
