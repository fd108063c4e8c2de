// SPDX-License-Identifier: BSD-2-Clause
// mlcca-doctor, which `mlccactl doctor` starts: examines a CAN interface before it is trusted, and
// states what could not be tested. It asks no daemon and changes no setting.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "base/command_line.hpp"
#include "base/standard_streams.hpp"
#include "daemon/verb_options.hpp"
#include "tools/doctor/examine.hpp"

namespace {

using namespace mlcca;  // NOLINT(google-build-using-namespace): the program itself

constexpr int kFine = 0;
constexpr int kFailed = 1;
constexpr int kUsage = 2;
constexpr int kWorld = 3;

constexpr unsigned kLongestWait = 3600;
constexpr const char* kFooter =
    "Sends frames only with --send. Exit status: 0 everything is ok or was not tested, 1 something "
    "failed, or with --send nothing could be tried by it, 2 usage or no such CAN interface, 3 it "
    "cannot be read.";

void say(const std::string& text) { to_stderr("mlccactl: " + text + '\n'); }

int run(const doctor::Request& request, bool as_json) {
  if (const auto why = doctor::why_no_controller(request.interface)) {
    say(*why);
    return kUsage;
  }
  const auto lines = doctor::examine(request, say);
  if (!lines) {
    say(lines.error().text);
    return kWorld;
  }
  if (!printed("mlccactl",
               as_json ? doctor::to_json(request.interface, *lines) : doctor::to_text(*lines)))
    return kWorld;
  if (doctor::any_failed(*lines)) return kFailed;
  if (!request.send || doctor::was_tried(*lines)) return kFine;
  say("nothing could be tried by sending");
  return kFailed;
}

int parse_and_run(int argc, char** argv) {
  doctor::Request request;
  request.bpf_root = "/run/mlcca/bpf";
  std::string id = "1FFFFFFF";
  VerbOptions options;
  unsigned fifo_depth = 0;
  CLI::App app("Examines a CAN interface before it is trusted.", "mlccactl");
  auto* verb = app.add_subcommand("doctor", "examine a CAN controller before it is trusted");
  options.add_to(app, *verb);
  verb->add_option("--can", request.interface, "the interface")->type_name("NAME")->required();
  auto* send = verb->add_flag("--send", request.send, "send frames on the bus; without, only read");
  verb->add_option("--id", id,
                   "identifier of these frames, hexadecimal: 11 bits up to 7FF, else 29")
      ->type_name("ID")
      ->capture_default_str()
      ->needs(send);
  auto* depth = verb->add_option("--fifo-depth", fifo_depth, "what the description says of it")
                    ->type_name("N")
                    ->check(CLI::Range(1, 64))
                    ->needs(send);
  verb->add_option("--bus-off", request.bus_off_seconds,
                   "wait so long for a person who shorts CAN_H and CAN_L")
      ->type_name("SECONDS")
      ->check(CLI::Range(1U, kLongestWait))
      ->needs(send);
  verb->add_option("--bpf-root", request.bpf_root, "where mlccad pins its gates")
      ->type_name("PATH")
      ->capture_default_str();
  verb->footer(kFooter);
  const auto wrong = [](const std::string& text) {
    return fmt::format("mlccactl: {}\nmlccactl doctor --help says more.\n", text);
  };
  app.failure_message(
      [&](const CLI::App*, const CLI::Error& error) { return wrong(error.what()); });
  refuse_empty_values(*verb);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return end_of_parsing(app, error, kUsage, kWorld);
  }
  if (depth->count() != 0) request.fifo_depth = fifo_depth;
  const auto identifier = doctor::read_identifier(id);
  if (!identifier) {
    to_stderr(wrong(identifier.error().text));
    return kUsage;
  }
  request.id = *identifier;
  return run(request, options.as_json);
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): without memory there is nothing left to do
int main(int argc, char** argv) {
  keep_standard_streams();
  return end_program("mlccactl", parse_and_run(argc, argv), kWorld);
}
