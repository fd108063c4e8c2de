// SPDX-License-Identifier: BSD-2-Clause
// mlcca-relay: carries granted events between the networks of a gateway that the kernel does not
// join. It runs as a user of its own without capabilities, and the gates admit its frames by that
// user.
#include <sched.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <thread>

#include "base/at_once.hpp"
#include "base/clock.hpp"
#include "base/command_line.hpp"
#include "base/many.hpp"
#include "base/number.hpp"
#include "control/version.hpp"
#include "relay/carrier.hpp"
#include "relay/grants.hpp"
#include "relay/pace.hpp"
#include "relay/run.hpp"

namespace mlcca::relay {
namespace {

constexpr int kPriority = 10;  // of SCHED_FIFO: below the drivers' threads, above all usual
                               // programs
constexpr std::uint64_t kReport = 10'000'000'000;  // ns
constexpr std::uint64_t kAlive = 1'000'000'000;    // ns between signs of life
constexpr int kRound = 1000;  // ms between two rounds for what is due without an event

std::string microseconds_in(std::uint64_t ns) {
  constexpr std::uint64_t in_a_micro = 1000;
  return std::to_string(ns / in_a_micro) + " us";
}

/// Requests real-time scheduling and locked memory as far as the limits allow, and returns a text
/// that says which was given. Without them delays are longer on a busy machine.
std::string make_prompt() {
  std::string out;
  ::prctl(PR_SET_TIMERSLACK, 1UL);  // else a pause of usual priority is 50 us longer
  sched_param priority{};
  priority.sched_priority = kPriority;
  if (::sched_setscheduler(0, SCHED_FIFO, &priority) != 0)
    out = std::string("normal priority (SCHED_FIFO: ") + std::strerror(errno) +
          ")";  // NOLINT(concurrency-mt-unsafe)
  else
    out = "SCHED_FIFO " + std::to_string(kPriority);
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0) return out + ", memory not locked";
  return out + ", memory locked";
}

class Program {
 public:
  explicit Program(const std::string& socket)
      : epoll_(::epoll_create1(EPOLL_CLOEXEC)),
        carrier_({.open = open_layer,
                  .watch = [this](std::uint32_t ifindex, int fd) { watch(ifindex, fd); },
                  .log = say,
                  .unix_ns = [] { return unix_ns(); }}),
        grants_(socket, ::geteuid(),
                {.all = [this](const auto& transfers) { carrier_.set_all(transfers); },
                 .of_subject = [this](std::uint64_t subject,
                                      const auto& some) { carrier_.set(subject, some); },
                 .log = say}) {}

  int run();

 private:
  /// The data of an epoll event is an interface index or one of these values, which are greater
  /// than any index.
  static constexpr std::uint64_t kGrants = std::uint64_t{1} << 32U;
  static constexpr std::uint64_t kSignals = kGrants + 1;

  void add(int fd, std::uint64_t what) const {
    epoll_event event{.events = EPOLLIN, .data = {.u64 = what}};
    if (::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event) != 0)
      say(std::string("epoll: ") + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
  }
  void watch(std::uint32_t ifindex, int fd) {
    if (fd >= 0) {
      add(fd, ifindex);
      return;
    }
    grants_.ask_all();  // an interface was closed, perhaps for a moment only
  }
  bool on_signal();
  std::optional<unsigned> handle(std::span<const epoll_event> events);
  void say_all() const;
  void report(std::uint64_t now);
  void report_delays(std::uint64_t now);

  Fd epoll_;
  Fd signals_;
  Carrier carrier_;
  Grants grants_;
  Pace pace_;
  std::uint64_t alive_at_ = 0;
  std::uint64_t reported_at_ = 0;
  std::uint64_t reported_ = 0;  ///< lost or late events at the last report
};

/// Returns false if the program is to end.
bool Program::on_signal() {
  signalfd_siginfo signal{};
  if (::read(signals_.get(), &signal, sizeof signal) != sizeof signal) return true;
  if (signal.ssi_signo != SIGUSR1) return false;
  say_all();
  return true;
}

void Program::say_all() const {
  say(many(carrier_.transfers(), "transfer") + " on " + many(carrier_.interfaces(), "interface"));
  carrier_.each([](const control::Transfer& transfer, const Carried& carried) {
    say(transfer.channel + " of " + transfer.publisher + ": " + transfer.from.interface + " to " +
        transfer.to.interface + ": " + many(carried.events, "event") + ", " +
        std::to_string(carried.dropped) + " dropped, " + std::to_string(carried.late) +
        " late, longest " + microseconds_in(carried.longest_ns));
  });
  const Losses lost = carrier_.losses();
  say("not received: " + std::to_string(lost.malformed) + " malformed, " +
      std::to_string(lost.incomplete) + " incomplete, " + std::to_string(lost.crowded) +
      " crowded out, " + std::to_string(lost.too_long) + " too long, " +
      std::to_string(lost.in_socket) + " dropped in a full socket; " + std::to_string(lost.unsent) +
      " not sent to the end");
}

/// Logs at most one line in ten seconds, if something was lost or late since the last one.
void Program::report(std::uint64_t now) {
  if (now - reported_at_ < kReport) return;
  reported_at_ = now;
  std::uint64_t dropped = 0;
  std::uint64_t late = 0;
  std::uint64_t longest = 0;
  carrier_.each([&](const control::Transfer&, const Carried& carried) {
    dropped += carried.dropped;
    late += carried.late;
    longest = std::max(longest, carried.longest_ns);
  });
  const std::uint64_t lost = carrier_.losses().all();
  if (dropped + late + lost > reported_)
    say(many(dropped, "event was", "events were") + " not taken by a network, " +
        many(late, "was", "were") + " late (longest " + microseconds_in(longest) + "), " +
        many(lost, "was", "were") + " not received completely; SIGUSR1 lists them");
  reported_ = dropped + late + lost;
}

/// Reports each transfer with late events to the daemon, at most once in ten seconds; the daemon
/// raises an exception for it.
void Program::report_delays(std::uint64_t now) {
  carrier_.take_delays(now, kReport, [this](const control::Transfer& transfer, const Delay& delay) {
    grants_.report({.subject = transfer.subject,
                    .publisher = transfer.publisher,
                    .from = transfer.from.network,
                    .to = transfer.to.network,
                    .late = delay.late,
                    .longest_ns = delay.longest_ns});
  });
}

/// Handles what is ready. Returns the number of interfaces among it; nothing if the program is to
/// end.
std::optional<unsigned> Program::handle(std::span<const epoll_event> events) {
  unsigned interfaces = 0;
  for (const epoll_event& event : events) {
    const std::uint64_t what = event.data.u64;
    if (what == kSignals) {
      if (!on_signal()) return std::nullopt;
    } else if (what == kGrants) {
      grants_.turn();
    } else {
      carrier_.receive(static_cast<std::uint32_t>(what));
      ++interfaces;
    }
  }
  return interfaces;
}

int Program::run() {
  sigset_t mask;
  sigemptyset(&mask);
  for (const int signal : {SIGTERM, SIGINT, SIGUSR1}) sigaddset(&mask, signal);
  ::sigprocmask(SIG_BLOCK, &mask, nullptr);
  signals_ = Fd(::signalfd(-1, &mask, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!epoll_ || !signals_) {
    say("no descriptors are left");
    return EXIT_FAILURE;
  }
  add(signals_.get(), kSignals);
  add(grants_.fd(), kGrants);
  notify("READY=1\nSTATUS=" + make_prompt());
  std::array<epoll_event, 64> events{};
  for (;;) {
    const int n = ::epoll_wait(epoll_.get(), events.data(), events.size(), kRound);
    const auto ready = handle(std::span(events).first(n < 0 ? 0 : static_cast<std::size_t>(n)));
    if (!ready) return EXIT_SUCCESS;
    const std::uint64_t now = monotonic_ns();
    if (now - alive_at_ >= kAlive) {
      alive_at_ = now;
      notify("WATCHDOG=1");
      report(now);
      report_delays(now);
      carrier_.retry();
      carrier_.expire();
    }
    const auto pause = pace_.after_round(*ready, now, carrier_.shortest_latency());
    if (pause != 0) std::this_thread::sleep_for(std::chrono::nanoseconds(pause));
  }
}

int main(int argc, char** argv) {
  std::string socket = "/run/mlcca/control.sock";
  CLI::App app{
      "mlcca-relay - carries granted events between networks that the kernel does not join",
      "mlcca-relay"};
  app.set_version_flag("--version", kVersion);
  app.add_option("--socket", socket, "control socket of mlccad")->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& end) {
    return end_of_parsing(app, end, kWrongUse, EXIT_FAILURE);
  }
  return Program(socket).run();
}

}  // namespace
}  // namespace mlcca::relay

int main(int argc, char** argv) {
  return mlcca::relay::run_program("mlcca-relay", mlcca::relay::main, argc, argv);
}
