// SPDX-License-Identifier: BSD-2-Clause
// CLI11 lives here, and so do its exceptions.
#include "tools/options.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "control/client.hpp"
#include "control/version.hpp"
#include "tools/design_verbs.hpp"
#include "tools/values.hpp"

namespace mlcca::tools {
namespace {

constexpr const char* kDefaultSocket = "/run/mlcca/control.sock";
constexpr const char* kFooter =
    "Exit status: 0 granted or fine, 1 refused, 2 usage or unreadable input,\n"
    "3 no daemon or the outside world failed.";
constexpr unsigned kMaxFamouso = 127;

void add_channel(CLI::App& app, Arguments& to) {
  app.add_option("channel", to.channel, "name of an event channel, or its 0x subject")
      ->required()
      ->type_name("CHANNEL");
}

void add_delivery(CLI::App& app, Arguments& to) {
  add_channel(app, to);
  app.add_option("--from", to.from, "network or gateway of a new publisher")->type_name("PLACE");
  app.add_option("--to", to.to, "network or gateway of a new subscriber")->type_name("PLACE");
  app.add_option("--require", to.require, "what the new subscriber requires, such as Omission=2")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  app.add_option("--offer", to.offer, "what the new publisher offers, such as Period=50ms")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  app.add_option("--node", to.node, "FAMOUSO node of the new publisher, 0 to 126")
      ->type_name("N")
      ->check(CLI::Range(0U, kMaxFamouso));
  app.add_option("--priority", to.priority, "FAMOUSO priority of its events, 0 (highest) to 127")
      ->type_name("N")
      ->check(CLI::Range(0U, kMaxFamouso));
  app.add_option("--user", to.user, "user that may send, for a publisher on this gateway");
  app.add_option("--subscriber", to.subscriber, "name of the new subscriber, for reports");
  app.add_option("--publisher", to.publisher, "name of the new publisher, for reports");
}

void add_arguments(CLI::App& app, Takes takes, Arguments& to) {
  switch (takes) {
    case Takes::nothing:
      break;
    case Takes::channel:
      add_channel(app, to);
      break;
    case Takes::delivery:
      add_delivery(app, to);
      break;
    case Takes::admission: {
      auto* group = app.add_option_group("what");
      group->add_option("channel", to.channel, "all admissions of this channel")
          ->type_name("CHANNEL");
      group->add_option("--id", to.admission, "one admission, as admit and explain name it")
          ->type_name("N")
          ->check(CLI::Range(std::uint64_t{1}, ~std::uint64_t{0}));
      group->require_option(1);
      break;
    }
    case Takes::mode:
      app.add_option("mode", to.mode, "enforce: drop what is not admitted; audit: only count it")
          ->required()
          ->type_name("enforce|audit")
          ->check(CLI::IsMember({"enforce", "audit"}));
      break;
  }
}

std::string wrong(std::string_view what) {
  return fmt::format("mlccactl: {}\nmlccactl --help and mlccactl VERB --help say more.\n", what);
}

std::string no_verb(std::span<const Verb> verbs, std::string_view instead) {
  std::vector<std::string_view> names;
  for (const auto& verb : verbs) names.emplace_back(verb.name);
  for (const auto& verb : kDesignVerbs) names.emplace_back(verb.name);
  return fmt::format("{}: must be one of {}",
                     instead.empty() ? "no verb" : fmt::format("unknown verb '{}'", instead),
                     fmt::join(names, ", "));
}

Result<std::vector<control::Attribute>> attributes(const std::vector<std::string>& texts,
                                                   Role role) {
  std::vector<control::Attribute> result;
  for (const auto& text : texts) {
    auto attribute = parse_attribute(text, role);
    if (!attribute) return std::unexpected(std::move(attribute).error());
    if (std::ranges::find(result, attribute->name, &control::Attribute::name) != result.end())
      return fail(fmt::format("{}: {} is given twice", text, attribute->name));
    result.push_back(std::move(*attribute));
  }
  return result;
}

/// What is wrong about the arguments that nothing took; empty: nothing.
std::string leftover(const CLI::App& app, const Command& command, std::span<const Verb> verbs) {
  auto extra = app.remaining(true);
  std::erase(extra, "--");
  const std::string first = extra.empty() ? "" : extra.front();
  if (command.verb == nullptr && !first.starts_with('-')) return no_verb(verbs, first);
  return extra.empty() ? "" : fmt::format("unexpected argument '{}'", first);
}

/// CLI::Range would let nan through.
std::string check_timeout(const std::string& text) {
  double seconds = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), seconds);
  const bool whole = read.ec == std::errc{} && read.ptr == text.data() + text.size();
  return whole && seconds >= 0.001 && seconds <= 86400 ? "" : "must be 0.001 to 86400 seconds";
}

}  // namespace

std::variant<Command, Exit> parse(std::span<const Verb> verbs, int argc, const char* const* argv) {
  Command command;
  auto& options = command.options;
  options.socket = kDefaultSocket;
  bool no_color = false;
  double seconds = std::chrono::duration<double>(control::kPatience).count();

  CLI::App app("Asks and steers mlccad, the gateway that lets no unfit data pass.", "mlccactl");
  app.set_version_flag("--version", fmt::format("mlccactl {}", kVersion), "print the version");
  app.set_help_flag("-h,--help", "print this help");
  app.add_option("--socket", options.socket, "control socket of mlccad")
      ->envname("MLCCA_SOCKET")
      ->type_name("PATH")
      ->capture_default_str();
  app.add_option("--timeout", seconds, "how long mlccad may take to answer")
      ->type_name("SECONDS")
      ->check(check_timeout)
      ->capture_default_str();
  app.add_flag("--json", options.json, "print JSON, one object a line");
  app.add_flag("--no-color", no_color, "no colour on a terminal, as with NO_COLOR");
  app.footer(kFooter);
  app.require_subcommand(0, 1);
  app.allow_extras();
  app.failure_message([](const CLI::App*, const CLI::Error& error) { return wrong(error.what()); });
  for (const auto& verb : verbs) {
    auto* sub = app.add_subcommand(verb.name, verb.help);
    sub->fallthrough();
    sub->callback([&command, &verb] { command.verb = &verb; });
    add_arguments(*sub, verb.takes, command.arguments);
  }
  // For the help: main() has given them to their program before.
  for (const auto& verb : kDesignVerbs) app.add_subcommand(verb.name, verb.help);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? Exit::fine : Exit::usage;
  }
  if (const auto complaint = leftover(app, command, verbs); !complaint.empty()) {
    fmt::print(stderr, "{}", wrong(complaint));
    return Exit::usage;
  }
  options.patience =
      std::chrono::ceil<std::chrono::milliseconds>(std::chrono::duration<double>(seconds));
  options.color = color_of(STDOUT_FILENO, no_color);
  options.error_color = color_of(STDERR_FILENO, no_color);
  return command;
}

Result<control::ChannelRequest> delivery(const Arguments& from) {
  auto required = attributes(from.require, Role::required);
  if (!required) return std::unexpected(std::move(required).error());
  auto offered = attributes(from.offer, Role::offered);
  if (!offered) return std::unexpected(std::move(offered).error());
  return control::ChannelRequest{.channel = from.channel,
                                 .from = from.from,
                                 .to = from.to,
                                 .offered = std::move(*offered),
                                 .required = std::move(*required),
                                 .node = from.node,
                                 .priority = from.priority,
                                 .user = from.user,
                                 .subscriber = from.subscriber,
                                 .publisher = from.publisher};
}

}  // namespace mlcca::tools
