// SPDX-License-Identifier: BSD-2-Clause
// The verb check: what to read, which form to write, and the exit status.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "tools/design/check/report.hpp"
#include "tools/design/check/write.hpp"
#include "tools/design/verbs.hpp"

namespace mlcca::tools::design {
namespace {

struct Options {
  std::vector<std::string> files;
  std::string format = "text";
  std::string output;  ///< empty: standard output
};

std::string written(const Report& report, const std::string& format, Color color) {
  if (format == "json") return write_json(report);
  if (format == "sarif") return write_sarif(report);
  if (format == "html") return write_html(report);
  return write_text(report, color);
}

Exit status_of(const Report& report) {
  if (!report.readable()) return Exit::usage;
  const auto totals = report.totals();
  return totals.errors + totals.warnings == 0 ? Exit::fine : Exit::refused;
}

Exit check(const Options& options, Color color) {
  const auto report = make_report(options.files, {});
  const auto text = written(report, options.format, color);
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    fmt::print(stderr, "mlccactl: write: {}\n", ::strerror(errno));
    return Exit::world;
  }
  return status_of(report);
}

}  // namespace

void add_check(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("check", "find what cannot work in the description of a system");
  const auto options = std::make_shared<Options>();
  verb->add_option("file", options->files,
                   "descriptions of systems, each checked on its own; files with a part as root "
                   "count as included in each of them")
      ->required()
      ->type_name("SYSTEM.xml...");
  verb->add_option("--format", options->format, "text, json, sarif (2.1.0) or html")
      ->check(CLI::IsMember({"text", "json", "sarif", "html"}))
      ->capture_default_str();
  verb->callback([&context, options] {
    if (context.json) options->format = "json";
    context.exit = check(*options, color_of(STDOUT_FILENO, context.no_color));
  });
}

}  // namespace mlcca::tools::design
