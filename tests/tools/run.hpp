// SPDX-License-Identifier: BSD-2-Clause
// Runs the built mlccactl as a user would.
#pragma once
#include <string>
#include <vector>

namespace mlcca::test {

struct Outcome {
  int status = -1;  ///< exit status, or -1: ended by a signal
  std::string out;
  std::string error;
};

/// mlccactl of the build tree that this test is from, with an environment of only `environment`.
/// An `out` replaces the captured standard output, a file descriptor `input` the empty standard
/// input.
Outcome run_mlccactl(std::vector<std::string> arguments, std::vector<std::string> environment = {},
                     const char* out = nullptr, int input = -1);

}  // namespace mlcca::test
