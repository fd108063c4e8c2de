// SPDX-License-Identifier: BSD-2-Clause
// mlccactl: each verb is a row of the table below; asking, printing and the exit status are common.
#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "control/client.hpp"
#include "tools/design_verbs.hpp"
#include "tools/json.hpp"
#include "tools/options.hpp"
#include "tools/render.hpp"

namespace {

using namespace mlcca;         // NOLINT(google-build-using-namespace)
using namespace mlcca::tools;  // NOLINT(google-build-using-namespace)
using control::Reply;

/// Exit::world, said on standard error, when standard output cannot be written.
Exit print(const std::string& text, Exit status) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0)
    return status;
  fmt::print(stderr, "mlccactl: write: {}\n", ::strerror(errno));
  return Exit::world;
}

Exit print_error(const Options& options, const control::Error& error) {
  const bool for_the_user =
      error.kind == control::ErrorKind::invalid || error.kind == control::ErrorKind::unreadable;
  const auto status = for_the_user ? Exit::usage : Exit::world;
  if (options.json) return print(to_json(Reply{0, error}), status);
  fmt::print(stderr, "{}", render(error, options.error_color));
  return status;
}

/// What we found out ourselves.
Exit print_error(const Options& options, control::ErrorKind kind, const std::string& message) {
  return print_error(options, control::Error{.kind = kind, .message = message, .details = {}});
}

bool all_granted(const control::Channels& channels) {
  for (const auto& channel : channels.channels)
    if (!channel.granted) return false;
  return !channels.channels.empty();
}

/// Prints the reply to a Question; only some ask for a verdict.
template <class Question>
Exit print_reply(const Options& options, const Reply& reply) {
  constexpr bool explains = std::is_same_v<Question, control::ExplainRequest>;
  constexpr bool decides = explains || std::is_base_of_v<control::ChannelRequest, Question>;
  if (const auto* error = std::get_if<control::Error>(&reply.body))
    return print_error(options, *error);
  const auto* channels = std::get_if<control::Channels>(&reply.body);
  const auto status =
      decides && channels != nullptr && !all_granted(*channels) ? Exit::refused : Exit::fine;
  if (options.json) return print(to_json(reply), status);
  if (decides && channels != nullptr)
    return print(explain(*channels, options.color, explains), status);
  return print(
      std::visit([&](const auto& body) { return render(body, options.color); }, reply.body),
      status);
}

template <class Question>
Exit ask(const Options& options, Question question) {
  auto client = control::Client::connect(options.socket, options.patience);
  if (!client) return print_error(options, control::ErrorKind::world, client.error().text);
  const auto reply = client->call({0, std::move(question)});
  if (!reply) return print_error(options, control::ErrorKind::world, reply.error().text);
  return print_reply<Question>(options, *reply);
}

template <class Question>
Exit ask_plain(const Options& options, const Arguments&) {
  return ask(options, Question{});
}

template <class Question>
Exit ask_delivery(const Options& options, const Arguments& arguments) {
  auto request = delivery(arguments);
  if (!request) return print_error(options, control::ErrorKind::invalid, request.error().text);
  return ask(options, Question{std::move(*request)});
}

Exit ask_release(const Options& options, const Arguments& arguments) {
  return ask(options, control::ReleaseRequest{.channel = arguments.channel,
                                              .admission = arguments.admission.value_or(0)});
}

Exit ask_explain(const Options& options, const Arguments& arguments) {
  return ask(options, control::ExplainRequest{arguments.channel});
}

Exit ask_mode(const Options& options, const Arguments& arguments) {
  return ask(options, control::ModeRequest{arguments.mode});
}

Exit monitor(const Options& options, const Arguments&) {
  auto client = control::Client::connect(options.socket, options.patience);
  if (!client) return print_error(options, control::ErrorKind::world, client.error().text);
  const auto reply = client->call({0, control::MonitorRequest{}});
  if (!reply) return print_error(options, control::ErrorKind::world, reply.error().text);
  if (const auto* error = std::get_if<control::Error>(&reply->body))
    return print_error(options, *error);
  for (;;) {
    const auto event = client->next_event();
    if (!event) return print_error(options, control::ErrorKind::world, event.error().text);
    const auto text = options.json ? to_json(Reply{0, *event}) : render(*event, options.color);
    if (const auto status = print(text, Exit::fine); status != Exit::fine) return status;
  }
}

constexpr std::array kVerbs = {
    Verb{"status", "what the gateway does and sees", Takes::nothing,
         ask_plain<control::StatusRequest>},
    Verb{"networks", "the networks: what they provide, what of it is reserved", Takes::nothing,
         ask_plain<control::NetworksRequest>},
    Verb{"channels", "every delivery with its verdict and its frames", Takes::nothing,
         ask_plain<control::ChannelsRequest>},
    Verb{"query", "would this be admitted? changes nothing", Takes::delivery,
         ask_delivery<control::Query>},
    Verb{"admit", "admit a new publisher or subscriber of a channel", Takes::delivery,
         ask_delivery<control::Admit>},
    Verb{"release", "take admissions back", Takes::admission, ask_release},
    Verb{"explain", "why a channel is granted or refused, attribute by attribute", Takes::channel,
         ask_explain},
    Verb{"monitor", "print events as they happen", Takes::nothing, monitor},
    Verb{"mode", "enforce, or audit: count what would be dropped and drop nothing", Takes::mode,
         ask_mode},
    Verb{"reload", "read the description again, all or nothing", Takes::nothing,
         ask_plain<control::ReloadRequest>},
};

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): without memory there is nothing left to do
int main(int argc, char** argv) {
  if (is_design_time({argv, static_cast<std::size_t>(argc)}))
    return static_cast<int>(become_design(argv));
  const auto parsed = parse(kVerbs, argc, argv);
  if (const auto* exit = std::get_if<Exit>(&parsed)) return static_cast<int>(*exit);
  const auto& command = std::get<Command>(parsed);
  return static_cast<int>(command.verb->run(command.options, command.arguments));
}
