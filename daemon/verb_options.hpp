// SPDX-License-Identifier: BSD-2-Clause
// The options of programs that are verbs of mlccactl and need no daemon.
#pragma once
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <string>

#include "control/version.hpp"

namespace mlcca {

struct VerbOptions {
  bool as_json = false;
  std::string unused;
  bool no_color = false;

  /// Adds the options before and after the name of the verb, as mlccactl takes them. This object
  /// must outlive the parsing.
  void add_to(CLI::App& app, CLI::App& verb) {
    app.set_version_flag("--version", fmt::format("mlccactl {}", kVersion), "print the version");
    app.require_subcommand(1, 1);
    for (auto* at : {&app, &verb}) {
      at->set_help_flag("-h,--help", "print this help");
      at->add_flag("--json", as_json, "print JSON");
      // Options of mlccactl that have no effect here.
      at->add_flag("--no-color", no_color, "nothing here has colour")->group("");
      for (const char* option : {"--socket", "--timeout"})
        at->add_option(option, unused, "no daemon is asked")->group("");
    }
  }
};

}  // namespace mlcca
