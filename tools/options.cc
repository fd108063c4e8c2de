// SPDX-License-Identifier: BSD-2-Clause
// Parses the command line with CLI11. The library and its exceptions stay in this file.
#include "tools/options.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <utility>

#include "base/command_line.hpp"
#include "base/number.hpp"
#include "base/standard_streams.hpp"
#include "control/client.hpp"
#include "control/version.hpp"
#include "tools/other_programs.hpp"

namespace mlcca::tools {
namespace {

constexpr const char* kDefaultSocket = "/run/mlcca/control.sock";
constexpr const char* kFooter =
    "Exit status: 0 granted or fine, 1 refused, 2 usage or unreadable input,\n"
    "3 no daemon or the outside world failed.";
constexpr const char* kFooterOfStatus =
    "Exit status: 0 fine, 2 usage, 3 no daemon or the outside world failed.\n"
    "With --check: 0 healthy, 1 degraded, 2 closed, 3 unknown; 2 without a line on\n"
    "standard output: usage.";
constexpr const char* kOfAllVerbs =
    "Before the verb or behind it, as 'mlccactl --help' explains: --socket PATH,\n"
    "--timeout SECONDS, --json, --no-color.\n\n";
constexpr unsigned kMaxNode = 253;  // the largest of all profiles
constexpr unsigned kMaxPriority = 127;
constexpr unsigned kMaxPacket = 65535;
constexpr unsigned kMaxEntries = 10'000;  // of the history

constexpr double kShortestDelay = 0.1;  // s
constexpr unsigned kMostTables = 1'000'000'000;

/// Checks a number of seconds, NaN included, which CLI::Range would accept.
std::string check_seconds(const std::string& text, double least, double most) {
  const auto seconds = number_in<double>(text);
  return seconds && *seconds >= least && *seconds <= most
             ? ""
             : fmt::format("must be {} to {} seconds", least, most);
}

std::string check_timeout(const std::string& text) { return check_seconds(text, 0.001, 86400); }

void add_channel(CLI::App& app, Arguments& to) {
  app.add_option("channel", to.channel, "name of an event channel, or its 0x subject")
      ->required()
      ->type_name("CHANNEL");
}

void add_delivery(CLI::App& app, Arguments& to) {
  auto* channel =
      app.add_option("channel", to.channel, "name of an event channel, or its 0x subject")
          ->type_name("CHANNEL");
  app.add_option(
         "--subject", to.subject,
         "in place of CHANNEL: one that is not described, where networks allow it (Unlisted)")
      ->type_name("0xSUBJECT")
      ->excludes(channel);
  app.parse_complete_callback([&to] {
    if (to.channel.empty() && to.subject.empty()) throw CLI::RequiredError("channel");
  });
  app.add_option("--identifier", to.identifiers,
                 "identifier of such a channel on a CAN network, as in robot-can=0x123: with three "
                 "hexadecimal digits 11 bits, else 29; or etag, PGN, subject-id, COB-ID")
      ->type_name("NETWORK=ID")
      ->allow_extra_args(false);
  app.add_option("--from", to.from, "network or gateway of a new publisher")->type_name("PLACE");
  app.add_option("--to", to.to, "network or gateway of a new subscriber")->type_name("PLACE");
  app.add_option("--from-node", to.from_node, "node of that mesh where the new publisher is")
      ->type_name("NODE");
  app.add_option("--to-node", to.to_node, "node of that mesh where the new subscriber is")
      ->type_name("NODE");
  app.add_option("--require", to.require, "what the new subscriber requires, such as Omission=2")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  app.add_option("--offer", to.offer, "what the new publisher offers, such as Period=50ms")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  app.add_option("--node", to.node,
                 "node of the new publisher: FAMOUSO 0 to 126, J1939 (source address) 0 to 253, "
                 "Cyphal 0 to 127")
      ->type_name("N")
      ->check(CLI::Range(0U, kMaxNode));
  app.add_option("--priority", to.priority, "FAMOUSO priority of its events, 0 (highest) to 127")
      ->type_name("N")
      ->check(CLI::Range(0U, kMaxPriority));
  app.add_option("--address", to.address,
                 "IPv4 or MAC address that the new publisher sends from, on an Ethernet-like "
                 "network: gates distinguish it by that")
      ->type_name("ADDRESS");
  app.add_option("--user", to.user, "user that may send, for a publisher on this gateway");
  app.add_option("--subscriber", to.subscriber, "name of the new subscriber, for reports");
  app.add_option("--publisher", to.publisher, "name of the new publisher, for reports");
}

void add_reservation(CLI::App& app, Arguments& to) {
  add_delivery(app, to);
  app.add_option("--key", to.key,
                 "a name of your own for this admission: asked again it is not admitted twice");
  app.add_option("--lease", to.lease, "release it unless it is renewed in this time, such as 30s")
      ->type_name("TIME");
  app.add_flag("--hold", to.hold,
               "stay, renew the lease (10s by default) and print what happens to it, until Ctrl-C "
               "or the end of a pipe on standard input");
}

void add_announcement(CLI::App& app, Arguments& to) {
  add_channel(app, to);
  app.add_option("role", to.role, "what the program is in this channel")
      ->required()
      ->type_name("publisher|subscriber")
      ->check(CLI::IsMember({"publisher", "subscriber"}));
  app.add_option("--name", to.end, "name of that publisher or subscriber, where it may be several");
  app.add_option("--state", to.state,
                 "what the program was made with, such as Period=50ms: refused if it is more than "
                 "what is described")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  app.add_flag("--follow", to.follow, "stay and print the events of the channel, until Ctrl-C");
}

CLI::Option* add_id(CLI::App& app, Arguments& to) {
  return app
      .add_option("--id,--admission", to.admission, "one admission, as admit and explain name it")
      ->type_name("N")
      ->check(CLI::Range(std::uint64_t{1}, ~std::uint64_t{0}));
}

void add_id_or_key(CLI::App& app, Arguments& to) {
  add_id(app, to);
  app.add_option("--key", to.key, "one admission, by the key that admit was given");
}

void add_admission(CLI::App& app, Arguments& to) {
  auto* group = app.add_option_group("what");
  group->add_option("channel", to.channel, "all run-time admissions of this channel")
      ->type_name("CHANNEL");
  add_id_or_key(*group, to);
  group->require_option(1);
}

void add_lease(CLI::App& app, Arguments& to) {
  auto* group = app.add_option_group("what");
  add_id_or_key(*group, to);
  group->require_option(1);
}

void add_changes(CLI::App& app, Arguments& to) {
  auto* group = app.add_option_group("what");
  group
      ->add_option("--link", to.links,
                   "a link of a mesh at this rate, 0: gone; such as laptop,relay=6Mbit/s")
      ->type_name("[NETWORK/]FROM,TO=RATE")
      ->allow_extra_args(false);
  group->add_option("--without", to.without, "a network or gateway that is not there")
      ->type_name("NAME")
      ->allow_extra_args(false);
  group->require_option(1, 2);
  app.add_flag("--one-way", to.one_way, "the links only from FROM to TO, not both ways");
}

void add_past(CLI::App& app, Arguments& to) {
  app.add_option("--channel", to.channel, "of this channel only")->type_name("CHANNEL");
  app.add_option("--kind", to.kind, "such as withdrawn, as monitor names it");
  app.add_option("--since", to.since, "such as '2026-11-21 14:00:00', today, -1h, '10 min ago'")
      ->type_name("TIME");
  app.add_option("--until", to.until, "as --since; now by default")->type_name("TIME");
  app.add_option("--limit", to.limit, "the newest ones, 1 to 10000; 100 by default")
      ->type_name("N")
      ->check(CLI::Range(1U, kMaxEntries));
}

void add_links(CLI::App& app, BandwidthArguments& to) {
  app.add_option(
         "rate", to.rates,
         "rate of each link of the way, such as 24Mbit/s, or with the share of lost packets "
         "24Mbit/s:0.01")
      ->required()
      ->type_name("RATE");
  app.add_option("--packet", to.packet, "payload of a packet, 1 to 65535, 1400 by default")
      ->type_name("BYTES")
      ->check(CLI::Range(1U, kMaxPacket));
  app.add_option("--header", to.header, "sent with each packet; 36 on 802.11, 0 by default")
      ->type_name("BYTES")
      ->check(CLI::Range(0U, kMaxPacket));
  app.add_option("--overhead-us", to.overhead,
                 "time for each packet beside its bits: gaps, preamble, acknowledgement")
      ->type_name("TIME");
  app.add_option("--loss", to.loss, "lost packets of links that state none, such as 0.01 or 1%")
      ->type_name("SHARE");
  app.add_option("--limit", to.limit, "of the medium's time that may be taken, 0.8 by default")
      ->type_name("SHARE");
  app.add_option("--background", to.background, "of the medium's time that others take")
      ->type_name("SHARE");
  app.add_option("--domain", to.domain,
                 "which links share the medium: single-domain, all of them, or 2-hop, those whose "
                 "ends are at most two links apart")
      ->type_name("KIND");
  app.add_option("--demand", to.demand, "does this much fit? exit status 1 if not")
      ->type_name("RATE");
}

void add_screen(CLI::App& app, TopArguments& to) {
  app.add_option("-d,--delay", to.delay, "seconds between two polls, 0.1 to 3600; 1 by default")
      ->type_name("SECONDS")
      ->check([](const std::string& text) { return check_seconds(text, kShortestDelay, 3600); });
  app.add_flag("-b,--batch", to.batch,
               "print one table after the other, as without a terminal or with TERM=dumb");
  app.add_option("-n,--count", to.count, "end after this number of tables")
      ->type_name("N")
      ->check(CLI::Range(1U, kMostTables));
  app.add_option("--by", to.by, "a row for each delivery of a subject, or for each network")
      ->type_name("subject|network")
      ->check(CLI::IsMember({"subject", "network"}));
  app.add_option("--sort", to.sort,
                 "name, route, verdict, rate, jitter, loss, drops, reserved, used; rate by default")
      ->type_name("COLUMN");
  app.add_flag("--reverse", to.reverse, "the smallest first, and names from z to a");
  app.add_option("--filter", to.filter, "only rows that contain this text");
}

void add_cluster(CLI::App& app, Arguments& to) {
  const char* const what =
      "status: how this gateway stands; members: who is there; reservations: what they have taken; "
      "drain: this gateway gives back what it has reserved and closes what it shares, until join";
  app.add_option("part", to.part, what)
      ->required()
      ->type_name("status|members|reservations|drain|join")
      ->check(CLI::IsMember({"status", "members", "reservations", "drain", "join"}));
  app.add_option("gateway,--gateway", to.gateway,
                 "reservations of this gateway; drain and join: this one, where the verb is run")
      ->type_name("GATEWAY");
  app.add_option("--network", to.network, "reservations of this network")->type_name("NETWORK");
  app.add_flag("--check", to.check,
               "status: one line for a monitoring system; exit status 0 healthy, 1 degraded, 2 "
               "shared networks are closed, 3 unknown");
  app.add_flag("-y,--yes", to.yes, "drain: do not ask for confirmation");
  app.add_flag("--until-restart", to.until_restart,
               "drain: until mlccad is started again, for a machine that is switched off");
}

void add_arguments(CLI::App& app, Takes takes, Arguments& to) {
  switch (takes) {
    case Takes::nothing:
      break;
    case Takes::check:
      app.add_flag("--check", to.check,
                   "one line for a monitoring system; exit status 0 healthy, 1 degraded, 2 closed, "
                   "3 unknown, since no daemon answers");
      app.footer(kFooterOfStatus);
      break;
    case Takes::form:
      app.add_flag("--html", to.html, "one file that loads nothing, with everything in it");
      break;
    case Takes::channel:
      add_channel(app, to);
      break;
    case Takes::withdrawal:
      add_channel(app, to);
      app.add_flag("-y,--yes", to.yes, "do not ask for confirmation");
      break;
    case Takes::delivery:
      add_delivery(app, to);
      break;
    case Takes::announcement:
      add_announcement(app, to);
      break;
    case Takes::reservation:
      add_reservation(app, to);
      break;
    case Takes::admission:
      add_admission(app, to);
      break;
    case Takes::lease:
      add_lease(app, to);
      break;
    case Takes::place:
      app.add_option("place", to.place, "only this network or gateway")->type_name("PLACE");
      break;
    case Takes::gate:
      app.add_option("place", to.place, "only this interface or network")->type_name("PLACE");
      // Another program carries it out (is_read_back()); it is an option here only for the help.
      app.add_flag("--verify", to.verify,
                   "read back what is in force, without the daemon: see --verify --help");
      break;
    case Takes::changes:
      add_changes(app, to);
      break;
    case Takes::past:
      add_past(app, to);
      break;
    case Takes::mode:
      app.add_option("mode", to.mode, "enforce: drop what is not admitted; audit: only count it")
          ->required()
          ->type_name("enforce|audit")
          ->check(CLI::IsMember({"enforce", "audit"}));
      app.add_option("--when-clean", to.when_clean,
                     "enforce not now, but when nothing would have been dropped for this time, "
                     "such as 24h")
          ->type_name("TIME");
      break;
    case Takes::findings:
      app.add_option("report", to.report, "what was refused, or would have been")
          ->required()
          ->type_name("report")
          ->check(CLI::IsMember({"report"}));
      app.add_flag("--xml", to.xml, "only the elements that a description would need for it");
      break;
    case Takes::cluster:
      add_cluster(app, to);
      break;
    case Takes::links:
      add_links(app, to.bandwidth);
      break;
    case Takes::screen:
      add_screen(app, to.top);
      break;
  }
}

/// Formats the help of option groups: their heading says that one of the options is required.
class OptionsOfGroups : public CLI::Formatter {
 public:
  std::string make_expanded(const CLI::App* group) const override {
    std::string text = CLI::Formatter::make_expanded(group);
    // The heading of CLI11: "  [Exactly 1 of the following options is required]".
    constexpr std::string_view last = "required]\n";
    const auto said = text.find(last);
    if (!group->get_name().empty() || said == std::string::npos) return text;
    text.erase(0, said + last.size());
    if (text.starts_with("  Options:\n")) text.erase(0, text.find('\n') + 1);
    return fmt::format("\n{} of these is needed:\n{}",
                       group->get_require_option_max() == 1 ? "One" : "At least one", text);
  }
};

/// The error message `what` with a hint at the help of the verb, or of mlccactl if there is no
/// verb.
std::string wrong(const CLI::App& app, std::string_view what) {
  const auto verbs = app.get_subcommands();
  return fmt::format("mlccactl: {}\n'mlccactl {}--help' says more.\n", what,
                     verbs.empty() ? "" : verbs.front()->get_name() + " ");
}

std::string no_verb(std::span<const Verb> verbs, std::string_view instead) {
  std::vector<std::string_view> names;
  for (const auto& verb : verbs) names.emplace_back(verb.name);
  for (const auto& verb : kOtherVerbs) names.emplace_back(verb.name);
  return fmt::format("{}: must be one of {}",
                     instead.empty() ? "no verb" : fmt::format("unknown verb '{}'", instead),
                     fmt::join(names, ", "));
}

/// What is wrong about arguments that no option took; empty if there are none.
std::string leftover(const CLI::App& app, const Command& command, std::span<const Verb> verbs) {
  auto extra = app.remaining(true);
  std::erase(extra, "--");
  const std::string first = extra.empty() ? "" : extra.front();
  if (command.verb == nullptr && !first.starts_with('-')) return no_verb(verbs, first);
  return extra.empty() ? "" : fmt::format("unexpected argument '{}'", first);
}

}  // namespace

std::variant<Command, Exit> parse(std::span<const Verb> verbs, int argc, const char* const* argv) {
  Command command;
  auto& options = command.options;
  options.socket = kDefaultSocket;
  bool no_color = false;
  double seconds = std::chrono::duration<double>(control::kPatience).count();

  CLI::App app("Queries and controls mlccad, the gateway service that lets no unfit data pass.",
               "mlccactl");
  app.formatter(std::make_shared<OptionsOfGroups>());
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
  refuse_empty_values(app);
  app.footer(kFooter);
  app.require_subcommand(0, 1);
  app.allow_extras();
  app.failure_message(
      [&app](const CLI::App*, const CLI::Error& error) { return wrong(app, error.what()); });
  for (const auto& verb : verbs) {
    auto* sub = app.add_subcommand(verb.name, verb.help);
    sub->fallthrough();
    sub->callback([&command, &verb] { command.verb = &verb; });
    add_arguments(*sub, verb.takes, command.arguments);
    refuse_empty_values(*sub, {"--filter"});
    sub->footer(kOfAllVerbs + sub->get_footer());
  }
  // Only for the help: main() has already started the programs for these verbs.
  for (const auto& verb : kOtherVerbs) app.add_subcommand(verb.name, verb.help);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return Exit{static_cast<std::uint8_t>(
        end_of_parsing(app, error, static_cast<int>(Exit::usage), static_cast<int>(Exit::world)))};
  }
  if (const auto complaint = leftover(app, command, verbs); !complaint.empty()) {
    to_stderr(wrong(app, complaint));
    return Exit::usage;
  }
  options.patience =
      std::chrono::ceil<std::chrono::milliseconds>(std::chrono::duration<double>(seconds));
  options.color = color_of(STDOUT_FILENO, no_color);
  options.error_color = color_of(STDERR_FILENO, no_color);
  return command;
}

}  // namespace mlcca::tools
