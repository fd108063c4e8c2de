// SPDX-License-Identifier: BSD-2-Clause
// Functions that the programs of the relay share.
#pragma once
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <exception>
#include <string>

#include "base/at_once.hpp"
#include "base/standard_streams.hpp"

namespace mlcca::relay {

/// Writes a line to the standard error, which is the journal of the service.
inline void say(const std::string& text) { write_at_once(STDERR_FILENO, text + '\n'); }

constexpr int kWrongUse = 2;  ///< the exit status if the command line cannot be used

/// Runs the program's main function and returns its exit status; an exception is logged.
template <class Main>
int run_program(const char* name, Main main, int argc, char** argv) {
  keep_standard_streams();
  ::signal(SIGPIPE, SIG_IGN);  // NOLINT(cert-err33-c): a log without a reader
  try {
    return main(argc, argv);
  } catch (const std::exception& error) {
    say(std::string(name) + ": " + error.what());
    return EXIT_FAILURE;
  }
}

}  // namespace mlcca::relay
