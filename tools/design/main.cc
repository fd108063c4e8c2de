// SPDX-License-Identifier: BSD-2-Clause
// mlcca-design carries out the design-time verbs, started by mlccactl. It is a separate program
// because it needs libxml2, and mlccactl should be small and start at once on a gateway.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>

#include "base/command_line.hpp"
#include "base/standard_streams.hpp"
#include "control/version.hpp"
#include "tools/design/output.hpp"
#include "tools/design/verbs.hpp"

namespace {

using namespace mlcca;                 // NOLINT(google-build-using-namespace)
using namespace mlcca::tools::design;  // NOLINT(google-build-using-namespace)
using tools::Exit;

constexpr int kWorld = static_cast<int>(Exit::world);

constexpr std::string_view kOfAll = "2 usage or unreadable input, 3 the outside world failed.";
constexpr std::string_view kWrites =
    "2 usage or unreadable input,\n3 the output exists, or the outside world failed.";

/// The exit statuses of a verb, for its help.
struct Statuses {
  std::string_view verb;
  std::string_view own;  ///< 0, and 1 if it has that
  std::string_view rest;
};
constexpr Statuses kStatuses[] = {
    {"analyse-bus", "0 all deadlines are met, 1 one can be missed or is not known", kOfAll},
    {"check", "0 neither errors nor warnings, 1 there are some", kWrites},
    {"describe", "0 done, 1 ended at a question", kOfAll},
    {"export", "0 done", kWrites},
    {"format", "0 done", kWrites},
    {"generate", "0 done", kOfAll},
    {"import", "0 done", kWrites},
    {"new", "0 done, 1 ended at a question", kWrites},
    {"rollout", "0 it is in force, or given up as asked, 1 refused", kOfAll},
};

/// Adds what holds for all verbs.
void complete(CLI::App& verb) {
  const std::string& name = verb.get_name();
  if (name == "describe")  // which removes what is given as empty
    refuse_empty_values(verb, {"--name", "--description"});
  else
    refuse_empty_values(verb);
  if (name != "import" && name != "learn" && name != "new")
    for (auto* argument : verb.get_options())
      if (argument->get_positional()) refuse_standard_input(argument);
  verb.footer(fmt::format(
      "Before the verb or behind it, as 'mlccactl --help' explains: {}--json,\n--no-color.\n\n{}",
      name == "rollout" ? "--socket PATH, --timeout SECONDS, " : "", verb.get_footer()));
}

int run(int argc, char** argv) {
  Context context;
  CLI::App app("Checks and describes systems, and generates code for them.", "mlccactl");
  app.set_version_flag("--version", fmt::format("mlccactl {}", kVersion), "print the version");
  app.set_help_flag("-h,--help", "print this help");
  // For rollout, which asks mlccad, and for learn if no frame arrived.
  app.add_option("--socket", context.socket)->envname("MLCCA_SOCKET")->group("");
  app.add_option("--timeout", context.timeout_s)->check(CLI::Range(0.001, 86400.0))->group("");
  app.add_flag("--json", context.json, "print JSON");
  app.add_flag("--no-color", context.no_color, "no colour on a terminal, as with NO_COLOR");
  app.footer(fmt::format("Exit status: 0 done, 1 refused or found something, {}", kOfAll));
  app.require_subcommand(1, 1);
  app.failure_message([&app](const CLI::App*, const CLI::Error& error) {
    const auto verbs = app.get_subcommands();
    return fmt::format("mlccactl: {}\n'mlccactl {}--help' says more.\n", error.what(),
                       verbs.empty() ? "" : verbs.front()->get_name() + " ");
  });
  add_analyse_bus(app, context);
  add_check(app, context);
  add_describe(app, context);
  add_export(app, context);
  add_format(app, context);
  add_generate(app, context);
  add_learn(app, context);
  add_import(app, context);
  add_new(app, context);
  add_rollout(app, context);
  for (auto* verb : app.get_subcommands([](const CLI::App*) { return true; })) verb->fallthrough();
  for (const auto& of : kStatuses)
    app.get_subcommand(std::string(of.verb))
        ->footer(fmt::format("Exit status: {}, {}", of.own, of.rest));
  refuse_empty_values(app);
  for (auto* verb : app.get_subcommands([](const CLI::App*) { return true; })) complete(*verb);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return end_of_parsing(app, error, static_cast<int>(Exit::usage), kWorld);
  }
  return static_cast<int>(context.exit);
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): without memory there is nothing left to do
int main(int argc, char** argv) {
  keep_standard_streams();
  return end_program("mlccactl", run(argc, argv), kWorld);
}
