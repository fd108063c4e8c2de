// SPDX-License-Identifier: BSD-2-Clause
// The design-time verbs. Each function adds a verb to the command line with a callback that carries
// it out.
#pragma once
#include <CLI/App.hpp>
#include <string>

#include "tools/exit.hpp"
#include "tools/table.hpp"

namespace mlcca::tools::design {

/// What every verb receives, and where it stores its exit status.
struct Context {
  bool json = false;
  bool no_color = false;                           ///< the option; see color_of()
  std::string socket = "/run/mlcca/control.sock";  ///< socket of mlccad, for verbs that ask it
  double timeout_s = 10;                           ///< limit in seconds for an answer of mlccad
  Exit exit = Exit::fine;
};

void add_analyse_bus(CLI::App& app, Context& context);
void add_check(CLI::App& app, Context& context);
void add_describe(CLI::App& app, Context& context);
void add_export(CLI::App& app, Context& context);
void add_format(CLI::App& app, Context& context);
void add_generate(CLI::App& app, Context& context);
void add_learn(CLI::App& app, Context& context);
void add_import(CLI::App& app, Context& context);
void add_new(CLI::App& app, Context& context);
void add_rollout(CLI::App& app, Context& context);

}  // namespace mlcca::tools::design
