// SPDX-License-Identifier: BSD-2-Clause
// What the programs of the relay have in common.
#pragma once
#include <unistd.h>

#include <cstdlib>
#include <exception>
#include <string>

#include "daemon/manager.hpp"

namespace mlcca::relay {

/// A line for the journal.
inline void say(const std::string& text) { write_at_once(STDERR_FILENO, text + '\n'); }

/// The exit status of a program; what it throws is said.
template <class Main>
int run_program(const char* name, Main main, int argc, char** argv) {
  try {
    return main(argc, argv);
  } catch (const std::exception& error) {
    say(std::string(name) + ": " + error.what());
    return EXIT_FAILURE;
  }
}

}  // namespace mlcca::relay
