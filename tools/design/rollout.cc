// SPDX-License-Identifier: BSD-2-Clause
// mlccactl rollout: brings one description to all gateways of a cluster. It is read here with its
// included files and given to mlccad, which has every gateway check it.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): sigtimedwait() of POSIX
#include <time.h>    // NOLINT(modernize-deprecated-headers): timespec of POSIX

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "base/many.hpp"
#include "base/sha256.hpp"
#include "base/standard_streams.hpp"
#include "control/client.hpp"
#include "description/bundle.hpp"
#include "description/kinds.hpp"
#include "description/read.hpp"
#include "tools/design/check/report.hpp"
#include "tools/design/check/write.hpp"
#include "tools/design/say.hpp"
#include "tools/design/verbs.hpp"
#include "tools/json.hpp"
#include "tools/render.hpp"

namespace mlcca::tools::design {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kPart = 48'000;   // bytes of one request
constexpr auto kPoll = 300ms;           // between two polls
constexpr std::size_t kMostShown = 20;  // findings

struct RolloutArguments {
  std::string system;
  std::vector<std::string> off;
  std::uint64_t wait_s = 150;
  bool back = false;
  bool accept = false;
  bool cancel = false;
  bool force = false;
};

/// While it lives, Ctrl-C does not end the program, but gives up the rollout.
class HeldSignal {
 public:
  HeldSignal() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    ::pthread_sigmask(SIG_BLOCK, &signals, &before_);
  }
  HeldSignal(const HeldSignal&) = delete;
  HeldSignal& operator=(const HeldSignal&) = delete;
  HeldSignal(HeldSignal&&) = delete;
  HeldSignal& operator=(HeldSignal&&) = delete;
  ~HeldSignal() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t before_{};
};

class RollOut {
 public:
  RollOut(const RolloutArguments& arguments, const Context& context)
      : a_(arguments), context_(context) {}

  Exit run() { return finish(carry_out(), context_.json); }

 private:
  Finished carry_out() {
    if (int{!a_.system.empty()} + int{a_.back} + int{a_.accept} + int{a_.cancel} != 1)
      return refuse(Exit::usage,
                    "say which description: SYSTEM.xml, or --back, or --accept; or --cancel");
    std::string text;
    if (!a_.system.empty()) {
      if (auto read = read_text(text); !read) return read;
      if (auto fine = check(); !fine) return fine;
    }
    auto client = control::Client::connect(context_.socket,
                                           std::chrono::duration_cast<std::chrono::milliseconds>(
                                               std::chrono::duration<double>(context_.timeout_s)));
    if (!client) return refuse(Exit::world, client.error().text);
    std::optional<HeldSignal> held;
    if (!a_.cancel) held.emplace();
    auto begun = hand_over(*client, text);
    if (!begun) return std::unexpected(begun.error());
    const auto* const state = std::get_if<control::Rollout>(&begun->body);
    if (state == nullptr) return print(*begun, Exit::fine);
    return a_.cancel ? follow_end(*client, *state) : follow(*client, state->number, held);
  }

  /// Finds what `mlccactl check` finds. Errors are a reason against it.
  [[nodiscard]] Finished check() const {
    const Report report = make_report({a_.system}, {});
    const Totals totals = report.totals();
    if (totals.warnings != 0)
      to_stderr(fmt::format("note: {} of 'mlccactl check {}'\n", many(totals.warnings, "warning"),
                            a_.system));
    if (totals.errors == 0 || a_.force) return Exit::fine;
    Refusal refusal{Exit::refused,
                    fmt::format("{}: it is not rolled out: 'mlccactl check' finds {}; --force "
                                "rolls it out all the same",
                                a_.system, many(totals.errors, "error")),
                    {}};
    for_each_finding(report, [&refusal](const ReportedFinding& finding) {
      if (core::info(finding.id).severity != core::Severity::error) return;
      if (refusal.details.size() < kMostShown)
        refusal.details.push_back(line_of(finding, Color::no));
    });
    if (totals.errors > kMostShown)
      refusal.details.push_back(fmt::format("and {} more", totals.errors - kMostShown));
    return std::unexpected(std::move(refusal));
  }

  Finished read_text(std::string& text) const {
    Sha256::Digest digest{};
    const auto system = description::read(a_.system, description::Users::any, &digest, &text);
    if (!system) {
      Refusal refusal{Exit::usage, a_.system + ": it is not rolled out", {}};
      for (const auto& problem : description::shortened(system.error()))
        refusal.details.push_back(description::to_string(problem));
      return std::unexpected(std::move(refusal));
    }
    if (text.empty())
      return refuse(Exit::usage, fmt::format("{}: with what it includes it has more than {} bytes, "
                                             "and cannot be rolled out",
                                             a_.system, description::kMaxBundle));
    return Exit::fine;
  }

  using Answer = std::expected<control::Reply, Refusal>;

  static Answer ask(control::Client& client, decltype(control::Request::body) body) {
    auto reply = client.call({0, std::move(body)});
    if (!reply) return refuse(Exit::world, reply.error().text);
    if (const auto* error = std::get_if<control::Error>(&reply->body))
      return std::unexpected(
          Refusal{error->kind == control::ErrorKind::invalid ? Exit::usage : Exit::world,
                  error->message, error->details});
    return std::move(*reply);
  }

  Answer hand_over(control::Client& client, const std::string& text) const {
    control::RolloutRequest request{.part = {},
                                    .more = false,
                                    .without = a_.off,
                                    .back = a_.back,
                                    .accept = a_.accept,
                                    .force = a_.force,
                                    .cancel = a_.cancel};
    std::size_t at = 0;
    for (; text.size() - at > kPart; at += kPart) {
      auto taken = ask(client, control::RolloutRequest{
                                   .part = text.substr(at, kPart), .more = true, .without = {}});
      if (!taken) return taken;
    }
    request.part = text.substr(at);
    return ask(client, std::move(request));
  }

  [[nodiscard]] Finished print(const control::Reply& reply, Exit exit) const {
    std::string text;
    if (context_.json)
      text = tools::to_json(reply);
    else if (const auto* state = std::get_if<control::Rollout>(&reply.body))
      text = tools::render(*state, Color::no);
    else if (const auto* done = std::get_if<control::Done>(&reply.body))
      text = tools::render(*done, Color::no);
    const Exit said = say(text);
    return said == Exit::fine ? exit : said;
  }

  /// Waits for the next poll. True if the user has pressed Ctrl-C meanwhile.
  static bool is_interrupted() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    constexpr timespec pause{.tv_sec = 0, .tv_nsec = std::chrono::nanoseconds(kPoll).count()};
    return ::sigtimedwait(&signals, nullptr, &pause) == SIGINT;
  }

  /// Waits until nothing is being rolled out any more. Exit::refused if what was to be given up has
  /// come into force all the same.
  Finished follow_end(control::Client& client, const control::Rollout& given_up) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(a_.wait_s);
    const std::string target = given_up.next.empty() ? given_up.current : given_up.next;
    const bool was_open = given_up.open && given_up.next.empty();
    for (;;) {
      auto reply = ask(client, control::RolloutStateRequest{});
      if (!reply) return std::unexpected(reply.error());
      const auto* const state = std::get_if<control::Rollout>(&reply->body);
      if (state == nullptr) return refuse(Exit::world, "mlccad answered with something else");
      const bool is_over =
          state->next.empty() && (state->open || state->current.empty()) &&
          (state->state.empty() || state->state == "in-force" || state->state == "refused");
      if (is_over)
        return print(*reply, !was_open && state->current == target ? Exit::refused : Exit::fine);
      if (std::chrono::steady_clock::now() >= end)
        return refuse(Exit::world, fmt::format("after {} s it is not given up: {}", a_.wait_s,
                                               progress_of(*state)));
      std::this_thread::sleep_for(kPoll);
    }
  }

  /// Prints changes of the state until the rollout has ended. Ctrl-C gives it up.
  Finished follow(control::Client& client, std::uint64_t number,
                  std::optional<HeldSignal>& held) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(a_.wait_s);
    std::string said;
    for (;;) {
      auto reply = ask(client, control::RolloutStateRequest{});
      if (!reply) return std::unexpected(reply.error());
      const auto* const state = std::get_if<control::Rollout>(&reply->body);
      if (state == nullptr || state->number != number)
        return refuse(Exit::world, "another rollout has begun at this gateway");
      if (state->state == "in-force") return print(*reply, Exit::fine);
      if (state->state == "refused") return print(*reply, Exit::refused);
      const std::string line = progress_of(*state);
      if (line != said && !context_.json) to_stderr(line + '\n');
      said = line;
      if (std::chrono::steady_clock::now() >= end)
        return refuse(Exit::world,
                      fmt::format("after {} s: {}: 'mlccactl history --kind rollout' will say what "
                                  "became of it",
                                  a_.wait_s, line));
      if (!is_interrupted()) continue;
      held.reset();
      to_stderr("it is given up (Ctrl-C again: without waiting for the end)\n");
      auto given_up = ask(client, control::RolloutRequest{.cancel = true});
      // It may have ended just now.
      if (!given_up && given_up.error().exit != Exit::world)
        return std::unexpected(given_up.error());
    }
  }

  static std::string progress_of(const control::Rollout& state) {
    const std::string who = fmt::format("{}", fmt::join(state.waiting, ", "));
    if (state.state == "judged")
      return who.empty() ? "all gateways have voted" : "judged; not yet by " + who;
    if (state.state == "switching")
      return who.empty() ? "all gateways are in it: it opens in a second"
                         : "comes into force; not there yet: " + who;
    return state.state;
  }

  const RolloutArguments& a_;
  const Context& context_;
};

}  // namespace

void add_rollout(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("rollout", "one description for all gateways of a cluster");
  auto a = std::make_shared<RolloutArguments>();
  verb->add_option("system", a->system, "the description of a system")->type_name("SYSTEM.xml");
  verb->add_option("--off", a->off, "a gateway that is off: it is not asked, and must not send")
      ->type_name("GATEWAY")
      ->allow_extra_args(false);
  verb->add_option("--wait", a->wait_s, "how long it is followed")
      ->type_name("SECONDS")
      ->capture_default_str();
  verb->add_flag("--back", a->back, "the description before the one that is in force");
  verb->add_flag("--accept", a->accept,
                 "this gateway takes up the description that is in force in the cluster");
  verb->add_flag("--force", a->force,
                 "although 'check' finds errors, or what is granted now would be refused");
  verb->add_flag("--cancel", a->cancel,
                 "give up the description that is being rolled out, as long as that is possible");
  verb->callback([a, &context] { context.exit = RollOut(*a, context).run(); });
}

}  // namespace mlcca::tools::design
