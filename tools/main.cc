// SPDX-License-Identifier: BSD-2-Clause
// mlccactl: each verb is a row of the table below; all of them connect, print and exit alike.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <expected>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "base/clock.hpp"
#include "base/standard_streams.hpp"
#include "control/client.hpp"
#include "tools/audit.hpp"
#include "tools/bandwidth.hpp"
#include "tools/json.hpp"
#include "tools/options.hpp"
#include "tools/other_programs.hpp"
#include "tools/render.hpp"
#include "tools/report.hpp"
#include "tools/requests.hpp"
#include "tools/sign_of_life.hpp"
#include "tools/values.hpp"

namespace {

using namespace mlcca;         // NOLINT(google-build-using-namespace)
using namespace mlcca::tools;  // NOLINT(google-build-using-namespace)
using control::Reply;

/// Prints to standard output and returns `status`; Exit::world if that fails.
Exit print(const std::string& text, Exit status) {
  return printed("mlccactl", text) ? status : Exit::world;
}

Exit print_error(const Options& options, const control::Error& error) {
  const bool for_the_user =
      error.kind == control::ErrorKind::invalid || error.kind == control::ErrorKind::unreadable;
  const auto status = for_the_user ? Exit::usage : Exit::world;
  if (options.json) return print(to_json(Reply{0, error}), status);
  to_stderr(render(error, options.error_color));
  return status;
}

/// Prints an error that mlccactl found itself.
Exit print_error(const Options& options, control::ErrorKind kind, const std::string& message) {
  return print_error(options, control::Error{.kind = kind, .message = message, .details = {}});
}

bool all_granted(const control::Channels& channels) {
  for (const auto& channel : channels.channels)
    if (!channel.granted) return false;
  return !channels.channels.empty();
}

bool a_delivery_loses(const Reply& reply) {
  const auto* what_if = std::get_if<control::WhatIf>(&reply.body);
  return what_if != nullptr && std::ranges::any_of(what_if->outlooks, loses);
}

/// Prints the reply to a Question. Only some questions make the exit status depend on a verdict.
template <class Question>
Exit print_reply(const Options& options, const Reply& reply) {
  constexpr bool explains = std::is_same_v<Question, control::ExplainRequest>;
  constexpr bool decides = explains || std::is_base_of_v<control::ChannelRequest, Question> ||
                           std::is_same_v<Question, control::AnnounceRequest>;
  if (const auto* error = std::get_if<control::Error>(&reply.body))
    return print_error(options, *error);
  const auto* channels = std::get_if<control::Channels>(&reply.body);
  const bool refused = decides && channels != nullptr && !all_granted(*channels);
  const auto status = refused || a_delivery_loses(reply) ? Exit::refused : Exit::fine;
  if (options.json) return print(to_json(reply), status);
  if (decides && channels != nullptr)
    return print(explain(*channels, options.color, explains), status);
  return print(
      std::visit([&](const auto& body) { return render(body, options.color); }, reply.body),
      status);
}

/// Sends a request over a connection of its own.
template <class Question>
Result<Reply> answer_to(const Options& options, Question question) {
  auto client = control::Client::connect(options.socket, options.patience);
  if (!client) return std::unexpected(client.error());
  return client->call({0, std::move(question)});
}

/// As answer_to(), but prints the error if there is no answer.
template <class Question>
std::expected<Reply, Exit> reply_to(const Options& options, Question question) {
  auto reply = answer_to(options, std::move(question));
  if (!reply)
    return std::unexpected(print_error(options, control::ErrorKind::world, reply.error().text));
  return std::move(*reply);
}

template <class Question>
Exit ask(const Options& options, Question question) {
  const auto reply = reply_to(options, std::move(question));
  return reply ? print_reply<Question>(options, *reply) : reply.error();
}

template <class Question>
Exit ask_plain(const Options& options, const Arguments&) {
  return ask(options, Question{});
}

/// Sends a request that was made from the arguments, or prints why it could not be made.
template <class Question>
Exit ask_made(const Options& options, Result<Question> request) {
  if (!request) return print_error(options, control::ErrorKind::invalid, request.error().text);
  return ask(options, std::move(*request));
}

Exit ask_query(const Options& options, const Arguments& arguments) {
  return ask_made(options, query(arguments));
}

Exit ask_what_if(const Options& options, const Arguments& arguments) {
  return ask_made(options, what_if(arguments));
}

Exit ask_history(const Options& options, const Arguments& arguments) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return ask_made(
      options,
      history(arguments, static_cast<std::uint64_t>(std::chrono::nanoseconds(now).count())));
}

Exit ask_reservations(const Options& options, const Arguments& arguments) {
  return ask(options, control::ReservationsRequest{arguments.place});
}

/// Prints what the gates contain, with what the status reports of their interfaces.
Exit ask_gate(const Options& options, const Arguments& arguments) {
  auto client = control::Client::connect(options.socket, options.patience);
  if (!client) return print_error(options, control::ErrorKind::world, client.error().text);
  const auto reply = client->call({0, control::GateRequest{arguments.place}});
  if (!reply) return print_error(options, control::ErrorKind::world, reply.error().text);
  const auto* gates = std::get_if<control::Gates>(&reply->body);
  if (gates == nullptr) return print_reply<control::GateRequest>(options, *reply);
  const auto second = client->call({0, control::StatusRequest{}});
  if (!second) return print_error(options, control::ErrorKind::world, second.error().text);
  const auto* status = std::get_if<control::Status>(&second->body);
  if (status == nullptr) return print_reply<control::StatusRequest>(options, *second);
  return print(options.json ? to_json(*gates, status->interfaces)
                            : render(*gates, status->interfaces, options.color),
               Exit::fine);
}

Exit ask_renew(const Options& options, const Arguments& arguments) {
  return ask(options, control::RenewRequest{.admission = arguments.admission.value_or(0),
                                            .key = arguments.key});
}

Exit print_event(const Options& options, const control::Event& event) {
  return print(options.json ? to_json(Reply{0, event}) : render(event, options.color), Exit::fine);
}

std::set<std::uint64_t> admissions_of(const control::Channels& channels) {
  std::set<std::uint64_t> ids;
  for (const auto& channel : channels.channels)
    if (channel.admission != 0) ids.insert(channel.admission);
  return ids;
}

/// Prints the events of admissions that the connection holds. Ends when none is left or standard
/// input, a pipe, is closed.
Exit hold(const Options& options, control::Client& client, std::set<std::uint64_t> admissions) {
  const bool known = !admissions.empty();
  const int input = is_pipe(STDIN_FILENO) ? STDIN_FILENO : -1;
  for (;;) {
    const auto event = client.next_event_unless(input);
    if (!event) return print_error(options, control::ErrorKind::world, event.error().text);
    if (!*event) {
      if (discard_input(input)) continue;
      return Exit::fine;
    }
    if (const auto status = print_event(options, **event); status != Exit::fine) return status;
    if ((*event)->kind != "released") continue;
    for (const auto admission : (*event)->admissions) admissions.erase(admission);
    if (known && admissions.empty()) return Exit::refused;
  }
}

Exit ask_admit(const Options& options, const Arguments& arguments) {
  const auto request = admit(arguments);
  if (!request) return print_error(options, control::ErrorKind::invalid, request.error().text);
  auto client = control::Client::connect(options.socket, options.patience);
  if (!client) return print_error(options, control::ErrorKind::world, client.error().text);
  const auto reply = client->call({0, *request});
  if (!reply) return print_error(options, control::ErrorKind::world, reply.error().text);
  const auto status = print_reply<control::Admit>(options, *reply);
  const auto* channels = std::get_if<control::Channels>(&reply->body);
  if (channels == nullptr || status != Exit::fine || request->lease_ns == 0) return status;
  auto admissions = admissions_of(*channels);
  if (!options.json) {
    const auto said = print(lease_note(*request, admissions), Exit::fine);
    if (said != Exit::fine) return said;
  }
  return request->hold ? hold(options, *client, std::move(admissions)) : status;
}

/// Prints the events of a connection until it ends.
Exit print_events(const Options& options, control::Client& client) {
  for (;;) {
    const auto event = client.next_event();
    if (!event) return print_error(options, control::ErrorKind::world, event.error().text);
    if (const auto status = print_event(options, *event); status != Exit::fine) return status;
  }
}

Exit ask_announce(const Options& options, const Arguments& arguments) {
  const auto request = announce(arguments);
  if (!request) return print_error(options, control::ErrorKind::invalid, request.error().text);
  auto client = control::Client::connect(options.socket, options.patience);
  if (!client) return print_error(options, control::ErrorKind::world, client.error().text);
  const auto reply = client->call({0, *request});
  if (!reply) return print_error(options, control::ErrorKind::world, reply.error().text);
  const auto status = print_reply<control::AnnounceRequest>(options, *reply);
  const bool taken_up = std::holds_alternative<control::Channels>(reply->body);
  return arguments.follow && taken_up && status != Exit::world ? print_events(options, *client)
                                                               : status;
}

Exit ask_release(const Options& options, const Arguments& arguments) {
  return ask(options, control::ReleaseRequest{.channel = arguments.channel,
                                              .admission = arguments.admission.value_or(0),
                                              .key = arguments.key});
}

/// Prints what would stop and asks for confirmation. Returns an exit status if no person can be
/// asked or the person declines, nullopt to go on.
std::optional<Exit> ask_back(const Options& options, const std::string& what,
                             const char* question) {
  if (::isatty(STDIN_FILENO) == 0 || options.json)
    return print_error(
        options, control::ErrorKind::invalid,
        "no person can be asked to confirm this (no terminal, or --json): state --yes");
  to_stderr(fmt::format("{}{} [y/N] ", what, question));
  std::array<char, 16> answer{};
  const bool read = std::fgets(answer.data(), answer.size(), stdin) != nullptr;
  const std::string_view said(answer.data());
  if (read && (said == "y\n" || said == "yes\n")) return std::nullopt;
  to_stderr(read ? "nothing was changed\n" : "\nnothing was changed\n");
  return Exit::refused;
}

/// Uses a connection for each request: the person may take longer to answer than the daemon keeps
/// an idle connection.
Exit ask_withdraw(const Options& options, const Arguments& arguments) {
  // With --json and --yes the reply itself says what has stopped.
  if (!arguments.yes || !options.json) {
    const auto now = reply_to(options, control::ExplainRequest{arguments.channel});
    if (!now) return now.error();
    const auto* channels = std::get_if<control::Channels>(&now->body);
    if (channels == nullptr) return print_reply<control::WithdrawRequest>(options, *now);
    const auto what = what_stops(*channels, arguments.channel, options.error_color);
    if (!arguments.yes) {
      if (const auto ended = ask_back(options, what, "Withdraw it?")) return *ended;
      return ask(options, control::WithdrawRequest{arguments.channel});
    }
    // What stops is printed only after the daemon has accepted the request.
    const auto done = reply_to(options, control::WithdrawRequest{arguments.channel});
    if (!done) return done.error();
    if (std::holds_alternative<control::Done>(done->body)) to_stderr(what);
    return print_reply<control::WithdrawRequest>(options, *done);
  }
  return ask(options, control::WithdrawRequest{arguments.channel});
}

Exit ask_reinstate(const Options& options, const Arguments& arguments) {
  return ask(options, control::ReinstateRequest{arguments.channel});
}

Exit ask_explain(const Options& options, const Arguments& arguments) {
  return ask(options, control::ExplainRequest{arguments.channel});
}

Exit ask_mode(const Options& options, const Arguments& arguments) {
  return ask_made(options, mode(arguments));
}

Exit ask_audit(const Options& options, const Arguments& arguments) {
  if (!arguments.xml) return ask(options, control::AuditRequest{});
  if (options.json)
    return print_error(options, control::ErrorKind::invalid,
                       "--xml goes without --json, which has the same in \"add\"");
  const auto reply = reply_to(options, control::AuditRequest{});
  if (!reply) return reply.error();
  const auto* const found = std::get_if<control::Audit>(&reply->body);
  if (found == nullptr) return print_reply<control::AuditRequest>(options, *reply);
  return print(additions(*found), Exit::fine);
}

Exit print_bandwidth(const Options& options, const Arguments& arguments) {
  const auto answer = bandwidth(arguments.bandwidth);
  if (!answer) return print_error(options, control::ErrorKind::invalid, answer.error().text);
  return print(options.json ? answer->json : answer->text,
               answer->fits ? Exit::fine : Exit::refused);
}

Exit monitor(const Options& options, const Arguments&) {
  auto client = control::Client::connect(options.socket, options.patience);
  if (!client) return print_error(options, control::ErrorKind::world, client.error().text);
  const auto reply = client->call({0, control::MonitorRequest{.exact_kinds = true}});
  if (!reply) return print_error(options, control::ErrorKind::world, reply.error().text);
  if (const auto* error = std::get_if<control::Error>(&reply->body))
    return print_error(options, *error);
  return print_events(options, *client);
}

Exit watch(const Options& options, const Arguments& arguments) {
  return follow(options, arguments.top);
}

/// Asks one question of the page and adds the answer. All use one connection, whose requests the
/// daemon answers in order.
template <class Question>
std::optional<Exit> add_answer(const Options& options, control::Client& client, const char* verb,
                               Question question,
                               std::vector<std::pair<std::string, std::string>>& to) {
  const auto reply = client.call({0, std::move(question)});
  if (!reply) return print_error(options, control::ErrorKind::world, reply.error().text);
  if (const auto* error = std::get_if<control::Error>(&reply->body))
    return print_error(options, *error);
  to.emplace_back(verb, to_json(*reply));
  return std::nullopt;
}

Exit print_report(const Options& options, const Arguments& arguments) {
  if (!arguments.html || options.json)
    return print_error(
        options, control::ErrorKind::invalid,
        "the report is a page of HTML, without --json: mlccactl report --html > FILE");
  auto client = control::Client::connect(options.socket, options.patience);
  if (!client) return print_error(options, control::ErrorKind::world, client.error().text);
  constexpr std::uint32_t entries = 200;
  std::vector<std::pair<std::string, std::string>> answers;
  const auto add = [&](const char* verb, auto question) {
    return add_answer(options, *client, verb, std::move(question), answers);
  };
  if (const auto exit = add("status", control::StatusRequest{})) return *exit;
  if (const auto exit = add("channels", control::ChannelsRequest{})) return *exit;
  if (const auto exit = add("networks", control::NetworksRequest{})) return *exit;
  if (const auto exit = add("routes", control::RoutesRequest{})) return *exit;
  if (const auto exit = add("audit", control::AuditRequest{})) return *exit;
  if (const auto exit = add("reservations", control::ReservationsRequest{})) return *exit;
  if (const auto exit = add("history", control::HistoryRequest{.limit = entries})) return *exit;
  using Part = std::pair<const char*, const char*>;
  for (const auto& [name, part] : {Part{"cluster-status", ""}, Part{"cluster-members", "members"},
                                   Part{"cluster-reservations", "reservations"}})
    if (const auto exit =
            add(name, control::ClusterRequest{.part = part, .network = {}, .gateway = {}}))
      return *exit;
  return print(report_page(answers, clock_ns(CLOCK_REALTIME)), Exit::fine);
}

/// The exit statuses of monitoring plugins: OK 0, WARNING 1, CRITICAL 2, UNKNOWN 3.
Exit exit_of(control::HealthState health) {
  switch (health) {
    case control::HealthState::healthy:
      return Exit{0};
    case control::HealthState::degraded:
      return Exit{1};
    case control::HealthState::closed:
      return Exit{2};
    case control::HealthState::unknown:
      break;
  }
  return Exit{3};
}

/// Prints "unknown" as one line on standard output: monitoring systems show nothing else.
Exit unknown_health(const Options& options, const control::Error& why) {
  constexpr auto state = control::HealthState::unknown;
  return print(options.json ? to_json(Reply{0, why})
                            : check_line({.state = state, .reasons = {why.message}}),
               exit_of(state));
}

/// Prints only the health of an answer.
template <class Answer, class Question>
Exit check(const Options& options, Question question) {
  const auto reply = answer_to(options, std::move(question));
  if (!reply)
    return unknown_health(
        options, {.kind = control::ErrorKind::world, .message = reply.error().text, .details = {}});
  if (const auto* error = std::get_if<control::Error>(&reply->body))
    return unknown_health(options, *error);
  const auto* answer = std::get_if<Answer>(&reply->body);
  if (answer == nullptr) return print_reply<Question>(options, *reply);
  return print(options.json ? to_json(answer->health) : check_line(answer->health),
               exit_of(answer->health.state));
}

Exit ask_status(const Options& options, const Arguments& arguments) {
  if (arguments.check) return check<control::Status>(options, control::StatusRequest{});
  return ask(options, control::StatusRequest{});
}

/// Drains this gateway; for another one the daemon refuses and says why, so nothing is asked.
Exit ask_drain(const Options& options, const Arguments& arguments) {
  if (!arguments.yes || !options.json) {
    const auto now = reply_to(options, control::ClusterRequest{});
    if (!now) return now.error();
    const auto* cluster = std::get_if<control::Cluster>(&now->body);
    if (cluster == nullptr) return print_reply<control::ClusterRequest>(options, *now);
    const bool other = !arguments.gateway.empty() && arguments.gateway != cluster->gateway;
    if (!cluster->system.empty() && !other) {
      const auto what = what_closes(*cluster, arguments.until_restart, options.error_color);
      if (arguments.yes)
        to_stderr(what);
      else if (const auto ended = ask_back(options, what, "Drain it?"))
        return *ended;
    }
  }
  return ask(options, control::DrainRequest{arguments.gateway, arguments.until_restart});
}

Exit ask_cluster(const Options& options, const Arguments& arguments) {
  const auto request = cluster(arguments);
  if (!request) return print_error(options, control::ErrorKind::invalid, request.error().text);
  if (arguments.part == "drain") return ask_drain(options, arguments);
  if (arguments.part == "join") return ask(options, control::JoinRequest{arguments.gateway});
  if (arguments.check) return check<control::Cluster>(options, *request);
  return ask(options, *request);
}

constexpr std::array kVerbs = {
    Verb{"status", "what the gateway does and sees, and what is wrong", Takes::check, ask_status},
    Verb{"networks", "the networks: what they provide, what of it is reserved", Takes::nothing,
         ask_plain<control::NetworksRequest>},
    Verb{"channels", "every delivery with its verdict and its frames", Takes::nothing,
         ask_plain<control::ChannelsRequest>},
    Verb{"routes", "the routes between networks, the links of the meshes, the rules of can-gw",
         Takes::nothing, ask_plain<control::RoutesRequest>},
    Verb{"reservations", "what has been promised to whom, and what is left", Takes::place,
         ask_reservations},
    Verb{"subscriptions", "who may subscribe over networks, and what is subscribed further on",
         Takes::nothing, ask_plain<control::SubscriptionsRequest>},
    Verb{"cluster", "gateways that share networks through a store: state, members, drain, join",
         Takes::cluster, ask_cluster},
    Verb{"gate", "what the gates hold: control traffic, channels, limits, counters", Takes::gate,
         ask_gate},
    Verb{"query", "would this be admitted? changes nothing", Takes::delivery, ask_query},
    Verb{"what-if", "who would lose, who would gain? changes nothing", Takes::changes, ask_what_if},
    Verb{"announce", "announce a program as the publisher or subscriber that is described for it",
         Takes::announcement, ask_announce},
    Verb{"admit", "admit a new publisher or subscriber of a channel", Takes::reservation,
         ask_admit},
    Verb{"renew", "start the lease of an admission again", Takes::lease, ask_renew},
    Verb{"release", "end run-time admissions", Takes::admission, ask_release},
    Verb{"withdraw", "refuse everything of a channel, also what is described", Takes::withdrawal,
         ask_withdraw},
    Verb{"reinstate", "undo withdraw", Takes::channel, ask_reinstate},
    Verb{"explain", "why a channel is granted or refused, attribute by attribute", Takes::channel,
         ask_explain},
    Verb{"history", "what was decided, and why", Takes::past, ask_history},
    Verb{"report", "the gateway as it is now, as one page of HTML", Takes::form, print_report},
    Verb{"monitor", "print events as they happen", Takes::nothing, monitor},
    Verb{"top", "a live screen: rates, jitter, loss, drops, what is reserved and used",
         Takes::screen, watch},
    Verb{"audit", "what was refused, or would have been: by whom, since when, what to add",
         Takes::findings, ask_audit},
    Verb{"mode", "enforce, or audit: count what would be dropped and drop nothing", Takes::mode,
         ask_mode},
    Verb{"reload", "read the description again, all or nothing", Takes::nothing,
         ask_plain<control::ReloadRequest>},
    Verb{"bandwidth", "what a chain of radio links carries; asks no daemon", Takes::links,
         print_bandwidth},
};

Exit run(int argc, char** argv) {
  if (const auto* other = program_for({argv, static_cast<std::size_t>(argc)}); other != nullptr)
    return become(*other, argv);
  const auto parsed = parse(kVerbs, argc, argv);
  if (const auto* exit = std::get_if<Exit>(&parsed)) return *exit;
  const auto& command = std::get<Command>(parsed);
  return command.verb->run(command.options, command.arguments);
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): without memory there is nothing left to do
int main(int argc, char** argv) {
  keep_standard_streams();
  return end_program("mlccactl", static_cast<int>(run(argc, argv)), static_cast<int>(Exit::world));
}
