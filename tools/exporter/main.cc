// SPDX-License-Identifier: BSD-2-Clause
// mlcca-exporter: makes metrics for Prometheus from answers of mlccad. The first connection to
// mlcca-exporter.socket starts it; it has no privilege and opens no network socket itself.
#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <poll.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string>
#include <utility>

#include "base/at_once.hpp"
#include "base/clock.hpp"
#include "base/command_line.hpp"
#include "base/standard_streams.hpp"
#include "control/version.hpp"
#include "tools/exporter/http.hpp"
#include "tools/exporter/scrapes.hpp"

namespace mlcca::exporter {
namespace {

constexpr std::uint64_t kAlive = 1'000'000'000;  // ns between signs of life to systemd

void say(const std::string& text) {
  write_at_once(STDERR_FILENO, "mlcca-exporter: " + text + '\n');
}

std::string cause() { return std::strerror(errno); }  // NOLINT(concurrency-mt-unsafe): one thread

/// The socket that systemd has passed.
Result<Fd> listening_socket() {
  const int given = ::sd_listen_fds(1);
  if (given != 1)
    return fail(fmt::format("{} sockets from systemd instead of one: start mlcca-exporter.socket",
                            std::max(given, 0)));
  Fd socket(SD_LISTEN_FDS_START);
  if (::sd_is_socket(socket.get(), AF_UNSPEC, SOCK_STREAM, 1) <= 0)
    return fail("the socket from systemd is no stream socket that listens");
  ::fcntl(socket.get(), F_SETFL, O_NONBLOCK);  // NOLINT(*-vararg)
  return socket;
}

Result<void> run(Settings settings) {
  auto listening = listening_socket();
  if (!listening) return std::unexpected(listening.error());
  sigset_t ends;
  sigemptyset(&ends);
  for (const int signal : {SIGTERM, SIGINT}) sigaddset(&ends, signal);
  ::sigprocmask(SIG_BLOCK, &ends, nullptr);
  const Fd signals(::signalfd(-1, &ends, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!signals) return fail("signalfd: " + cause());
  Scrapes scrapes(std::move(settings), say, monotonic_ns);
  // The next scrape needs as much memory as this one. Returning pages to the kernel would cost more
  // time than writing to them.
  constexpr int kept = 32 << 20;  // bytes
  ::mallopt(M_MMAP_THRESHOLD, kept);
  ::mallopt(M_TRIM_THRESHOLD, kept);
  const auto http = Http::serve(*listening, [&] { return scrapes.page(); });
  if (!http) return std::unexpected(http.error());
  notify("READY=1");
  std::uint64_t alive_at = 0;
  for (;;) {
    std::array<pollfd, 2> waiting{pollfd{.fd = (*http)->fd(), .events = POLLIN, .revents = 0},
                                  pollfd{.fd = signals.get(), .events = POLLIN, .revents = 0}};
    if (::poll(waiting.data(), waiting.size(), (*http)->patience()) < 0 && errno != EINTR)
      return fail("poll: " + cause());
    if (waiting[1].revents != 0) return {};
    (*http)->turn();
    if (scrapes.has_work() && (*http)->is_idle()) scrapes.work();
    if (const std::uint64_t now = monotonic_ns(); now - alive_at >= kAlive) {
      alive_at = now;
      notify("WATCHDOG=1");
    }
  }
}

int main(int argc, char** argv) {
  constexpr unsigned longest = 60;
  constexpr std::size_t most = 100'000;
  Settings settings;
  CLI::App app{"mlcca-exporter - what mlccad says, as metrics of Prometheus", "mlcca-exporter"};
  app.set_version_flag("--version", kVersion);
  app.add_option("--socket", settings.socket, "control socket of mlccad")->capture_default_str();
  app.add_option("--timeout", settings.timeout_s, "seconds that mlccad has for an answer: 1 to 60")
      ->check(CLI::Range(1U, longest))
      ->capture_default_str();
  app.add_option("--deliveries", settings.most.deliveries,
                 "so many deliveries get series of their own, refused ones first: 0 to 100000")
      ->check(CLI::Range(std::size_t{0}, most))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& wrong) {
    return end_of_parsing(app, wrong, 2, EXIT_FAILURE);
  }
  if (const auto served = run(std::move(settings)); !served) {
    say(served.error().text);
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace mlcca::exporter

int main(int argc, char** argv) {
  mlcca::keep_standard_streams();
  ::signal(SIGPIPE, SIG_IGN);  // NOLINT(cert-err33-c): a reader that has gone
  try {
    return mlcca::exporter::main(argc, argv);
  } catch (const std::exception& e) {
    mlcca::exporter::say(e.what());
  }
  return EXIT_FAILURE;
}
