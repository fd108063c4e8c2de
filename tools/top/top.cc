// SPDX-License-Identifier: BSD-2-Clause
#include "tools/top/top.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>
#include <variant>

#include "base/clock.hpp"
#include "base/number.hpp"
#include "base/standard_streams.hpp"
#include "control/client.hpp"
#include "tools/json.hpp"
#include "tools/options.hpp"
#include "tools/render.hpp"
#include "tools/top/changes.hpp"
#include "tools/top/layout.hpp"
#include "tools/top/sample.hpp"
#include "tools/top/terminal.hpp"
#include "tools/top/view.hpp"

namespace mlcca::tools {
namespace {

using namespace mlcca::tools::top;  // NOLINT(google-build-using-namespace)
using Clock = std::chrono::steady_clock;

/// An answer that takes longer must not block the keys.
constexpr std::chrono::milliseconds kPatience{3000};
/// After this time mlccad may have closed an idle connection.
constexpr std::chrono::seconds kUsable{30};

/// Requests samples over one connection, and reconnects when it is lost.
class Watcher {
 public:
  explicit Watcher(const Options& options)
      : socket_(options.socket), patience_(std::min(options.patience, kPatience)) {}

  Result<void> poll() {
    if (Clock::now() - polled_ > kUsable) client_.reset();
    polled_ = Clock::now();
    Result<Sample> fresh = ask();
    if (!fresh) {
      client_.reset();
      before_.reset();
      lost_ = true;
      return std::unexpected(fresh.error());
    }
    if (!std::exchange(lost_, false)) before_ = std::move(now_);
    now_ = std::move(*fresh);
    return {};
  }

  /// A sample with channels and interfaces only.
  Result<Sample> counters() {
    if (auto connected = connect(); !connected) return std::unexpected(connected.error());
    Sample sample;
    auto done = ask_for(sample.channels, control::ChannelsRequest{});
    if (done) done = ask_for(sample.status, control::StatusRequest{});
    if (!done) return std::unexpected(done.error());
    return sample;
  }

  [[nodiscard]] bool has_any() const { return now_.has_value(); }
  [[nodiscard]] const Sample& now() const { return *now_; }
  [[nodiscard]] std::vector<Row> rows(const View& view) const {
    if (!now_) return {};
    const Sample* before = before_ ? &*before_ : nullptr;
    return arranged(
        view.by_network ? rows_by_network(before, *now_) : rows_by_subject(before, *now_), view);
  }

 private:
  Result<void> connect() {
    if (client_) return {};
    auto client = control::Client::connect(socket_, patience_);
    if (!client) return std::unexpected(client.error());
    client_.emplace(std::move(*client));
    return {};
  }

  /// A reload between two slices ends the answer with an error; the second attempt begins after it.
  template <class Answer, class Question>
  Result<void> ask_for(Answer& answer, Question question) {
    auto reply = client_->call({0, question});
    if (reply && std::holds_alternative<control::Error>(reply->body))
      reply = client_->call({0, std::move(question)});
    if (!reply) return std::unexpected(reply.error());
    if (const auto* error = std::get_if<control::Error>(&reply->body)) return fail(error->message);
    auto* body = std::get_if<Answer>(&reply->body);
    if (body == nullptr) return fail("mlccad answers something else: is it another version?");
    answer = std::move(*body);
    return {};
  }

  Result<Sample> ask() {
    if (auto connected = connect(); !connected) return std::unexpected(connected.error());
    Sample sample;
    auto done = ask_for(sample.channels, control::ChannelsRequest{});
    sample.at_ns = static_cast<std::uint64_t>(
        std::chrono::nanoseconds(Clock::now().time_since_epoch()).count());
    if (done) done = ask_for(sample.status, control::StatusRequest{});
    if (done) done = ask_for(sample.networks, control::NetworksRequest{});
    if (done) done = ask_for(sample.reservations, control::ReservationsRequest{});
    if (!done) return std::unexpected(done.error());
    return sample;
  }

  std::string socket_;
  std::chrono::milliseconds patience_;
  std::optional<control::Client> client_;
  Clock::time_point polled_;
  std::optional<Sample> before_;
  std::optional<Sample> now_;
  bool lost_ = true;
};

bool write(std::string_view text) { return printed("mlccactl", text); }

Exit complain(const Options& options, control::ErrorKind kind, const std::string& message) {
  const control::Error error{.kind = kind, .message = message, .details = {}};
  if (options.json) {
    if (!write(tools::to_json(control::Reply{0, error}))) return Exit::world;
  } else {
    to_stderr(render(error, options.error_color));
  }
  return kind == control::ErrorKind::invalid ? Exit::usage : Exit::world;
}

Heading heading(const Watcher& watcher, const Result<void>& polled, double delay) {
  Heading heading;
  if (watcher.has_any()) heading = heading_of(watcher.now().status);
  if (!polled) {
    heading.problem = polled.error().text;
    heading.alarming = true;
  }
  heading.interval = fmt::format("{:.3g} s", delay);
  const std::time_t now = std::time(nullptr);
  heading.time = fmt::format("{:%H:%M:%S}", fmt::localtime(now));
  return heading;
}

std::size_t columns_of_batch() {
  const char* columns = std::getenv("COLUMNS");  // NOLINT(concurrency-mt-unsafe)
  const int given = number_in<int>(columns == nullptr ? "" : columns).value_or(0);
  return given > 0 ? static_cast<std::size_t>(given) : Size{}.columns;
}

Exit in_batches(const Options& options, const TopArguments& arguments, Watcher& watcher,
                const View& view, Clock::duration delay) {
  const Size size{columns_of_batch(), 0};
  auto next = Clock::now();
  for (std::uint32_t n = 0; arguments.count == 0 || n < arguments.count; ++n) {
    next += delay;
    std::this_thread::sleep_until(next);
    const auto polled = watcher.poll();
    std::string text = n == 0 ? "" : "\n";
    for (const auto& line : screen(heading(watcher, polled, arguments.delay), watcher.rows(view),
                                   view, size, options.color))
      text += line + '\n';
    if (!write(text)) return Exit::world;
  }
  return Exit::fine;
}

/// Prints samples as JSON. Ends if mlccad does not answer, so that the reader knows that something
/// is missing and starts again.
Exit as_json(const Options& options, const TopArguments& arguments, Clock::duration delay) {
  Watcher watcher(options);
  Changes changes;
  auto next = Clock::now();
  for (std::uint32_t n = 0; arguments.count == 0 || n < arguments.count; ++n) {
    std::this_thread::sleep_until(next);
    next = Clock::now() + delay;
    const auto sample = watcher.counters();
    if (!sample) return complain(options, control::ErrorKind::world, sample.error().text);
    if (!write(changes.line(*sample, clock_ns(CLOCK_REALTIME)))) return Exit::world;
  }
  return Exit::fine;
}

Exit on_screen(const Options& options, const TopArguments& arguments, Watcher& watcher, View view,
               Clock::duration delay) {
  auto terminal = Terminal::take();
  if (!terminal) return complain(options, control::ErrorKind::world, terminal.error().text);
  Result<void> polled;
  std::string keys;
  auto next = Clock::now() + delay;
  std::uint32_t shown = 0;
  for (;;) {
    const Size size = Terminal::size();
    const auto rows = watcher.rows(view);
    const Heading above = heading(watcher, polled, arguments.delay);
    const std::size_t room = room_for_rows(above, size);
    view.first = std::min(view.first, rows.size() - std::min(rows.size(), room));
    if (!Terminal::draw(screen(above, rows, view, size, options.color))) return Exit::world;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(next - Clock::now());
    const auto happened = terminal->wait(std::max(left, std::chrono::milliseconds{0}));
    if (happened.gone) return Exit::world;
    if (happened.signal == SIGTSTP) {
      terminal->stop_and_go_on();
    } else if (happened.signal != 0 && happened.signal != SIGWINCH && happened.signal != SIGCONT) {
      terminal->end_by(happened.signal);
    }
    keys += happened.keys;
    view = after(std::move(view), keys, room);
    if (view.quit) return Exit::fine;
    if (Clock::now() < next) continue;
    next = Clock::now() + delay;
    if (view.paused) continue;
    polled = watcher.poll();
    if (++shown == arguments.count) return Exit::fine;
  }
}

}  // namespace

Exit follow(const Options& options, const TopArguments& arguments) {
  View view;
  view.by_network = arguments.by == "network";
  view.reverse = arguments.reverse;
  view.filter = arguments.filter;
  const auto sort = field_named(arguments.sort);
  if (!sort)
    return complain(options, control::ErrorKind::invalid,
                    fmt::format("--sort {}: must be one of {}", arguments.sort, field_names()));
  view.sort = *sort;
  const auto delay =
      std::chrono::ceil<Clock::duration>(std::chrono::duration<double>(arguments.delay));
  if (options.json) return as_json(options, arguments, delay);
  Watcher watcher(options);
  if (const auto polled = watcher.poll(); !polled)
    return complain(options, control::ErrorKind::world, polled.error().text);
  if (arguments.batch || !has_screen()) return in_batches(options, arguments, watcher, view, delay);
  return on_screen(options, arguments, watcher, view, delay);
}

}  // namespace mlcca::tools
