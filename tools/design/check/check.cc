// SPDX-License-Identifier: BSD-2-Clause
// The verb check: its arguments, the output form, and the exit status.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <expected>
#include <memory>
#include <string>
#include <vector>

#include "base/standard_streams.hpp"
#include "tools/design/check/progress.hpp"
#include "tools/design/check/report.hpp"
#include "tools/design/check/watch.hpp"
#include "tools/design/check/write.hpp"
#include "tools/design/output.hpp"
#include "tools/design/say.hpp"
#include "tools/design/verbs.hpp"

namespace mlcca::tools::design {
namespace {

// Moves the cursor to the corner and clears the screen and the scroll-back buffer.
constexpr const char* kClear = "\x1b[H\x1b[2J\x1b[3J";

struct Options {
  std::vector<std::string> files;
  std::string format = "text";
  std::string output;  ///< empty: standard output
  bool force = false;
  bool watch = false;
};

Exit complain(Exit status, const std::string& text) {
  return say(Refusal{status, text, {}}, false);
}

class Check {
 public:
  Check(const Options& options, Color color) : options_(options), color_(color) {}

  Exit run() {
    if (options_.watch) return watch();
    const auto delivered = deliver(examine());
    return delivered ? *delivered : delivered.error();
  }

 private:
  [[nodiscard]] Report examine() const {
    const auto depth = options_.format == "html" ? Depth::deliveries : Depth::findings;
    if (::isatty(STDERR_FILENO) == 0) return make_report(options_.files, {}, depth);
    ProgressLine line(std::chrono::steady_clock::now, to_stderr);
    return make_report(
        options_.files, [&](std::string_view what, double done) { line.show(what, done); }, depth);
  }

  [[nodiscard]] std::string written(const Report& report) const {
    if (options_.format == "json") return write_json(report);
    if (options_.format == "sarif") return write_sarif(report);
    if (options_.format == "html") return write_html(report);
    return write_text(report, options_.output.empty() ? color_ : Color::no);
  }

  /// The exit status of a report; as error, that of a report that could not be written.
  using Delivery = std::expected<Exit, Exit>;

  [[nodiscard]] Delivery deliver(const Report& report) {
    const auto& output = options_.output;
    if (!output.empty() && is_one_of(output, report.files()))
      return std::unexpected(complain(
          Exit::usage, output + ": is a file that is checked; the report would replace it"));
    const auto text = written(report);
    if (output.empty()) {
      const auto said = say(text);
      if (said != Exit::fine) return std::unexpected(said);
      return status_of(report);
    }
    const auto done = write_output(output, text, existing_if(options_.force || is_ours_));
    if (!done) return std::unexpected(complain(Exit::world, done.error().text));
    is_ours_ = true;
    return status_of(report);
  }

  // --- watching ----------------------------------------------------------------------------------

  Exit watch() {
    auto watch = FileWatch::open();
    if (!watch) return complain(Exit::world, watch.error().text);
    std::vector<std::string> files = options_.files;
    for (bool first = true;; first = false) {
      const auto since = file_time();
      if (auto followed = watch->follow(files, since); !followed)
        return complain(Exit::world, followed.error().text);
      const auto report = examine();
      const auto status = show(report, first);
      // Later the cause may be temporary, such as a full disk; at the start the command is wrong.
      if (first && !status) return status.error();
      // The included files are known only after reading.
      files = options_.files;
      for (auto& file : report.files()) files.push_back(std::move(file));
      const auto missed = watch->follow(files, since);
      if (!missed) return complain(Exit::world, missed.error().text);
      if (*missed) continue;
      const auto woken = watch->wait();
      if (!woken) return complain(Exit::world, woken.error().text);
      if (*woken == Woken::ended) return status ? *status : status.error();
    }
  }

  /// Writes the report; with --output also the text for the person who watches.
  [[nodiscard]] Delivery show(const Report& report, bool first) {
    const bool for_person = options_.format == "text" || !options_.output.empty();
    if (for_person) {
      const bool terminal = ::isatty(STDOUT_FILENO) != 0;
      std::string text;
      if (terminal)
        text = kClear;
      else if (!first)
        text = "--- checked again\n";
      if (!options_.output.empty()) text += write_text(report, color_);
      if (const auto said = say(text); said != Exit::fine) return std::unexpected(said);
    }
    return deliver(report);
  }

  const Options& options_;
  Color color_;
  bool is_ours_ = false;  ///< the output has been written once
};

}  // namespace

void add_check(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("check", "find what cannot work in the description of a system");
  const auto options = std::make_shared<Options>();
  verb->add_option("file", options->files,
                   "descriptions of systems, each checked on its own; files with a part as root "
                   "count as included in each of them")
      ->required()
      ->type_name("SYSTEM.xml...");
  auto* format = verb->add_option("--format", options->format, "text, json, sarif (2.1.0) or html")
                     ->check(CLI::IsMember({"text", "json", "sarif", "html"}))
                     ->capture_default_str();
  auto* output = verb->add_option("--output", options->output,
                                  "a new file, instead of standard output, which is also -")
                     ->type_name("FILE");
  add_force(*verb, output, options->force);
  verb->add_flag("--watch", options->watch,
                 "check again whenever one of the files is saved, until interrupted");
  verb->callback([&context, options, format] {
    if (context.json && format->count() != 0 && options->format != "json")
      throw CLI::ValidationError("--json goes without --format " + options->format);
    if (context.json) options->format = "json";
    options->output = path_of_output(options->output);
    const bool page = options->format == "sarif" || options->format == "html";
    if (options->watch && page && options->output.empty())
      throw CLI::ValidationError("--watch", options->format + " needs --output");
    context.exit = Check(*options, color_of(STDOUT_FILENO, context.no_color)).run();
  });
}

}  // namespace mlcca::tools::design
