// SPDX-License-Identifier: BSD-2-Clause
// mlcca-cluster: the process between mlccad and the store that gateways share. It alone has the key
// of the gateway's certificate, and it interprets nothing that it carries.
#include <netdb.h>
#include <sys/socket.h>
#include <systemd/sd-event.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <memory>
#include <string>
#include <utility>

#include "base/at_once.hpp"
#include "base/command_line.hpp"
#include "base/handle.hpp"
#include "base/listen.hpp"
#include "base/loop_timer.hpp"
#include "base/standard_streams.hpp"
#include "base/system_error.hpp"
#include "cluster/bridge.hpp"
#include "cluster/daemon_server.hpp"
#include "cluster/http.hpp"
#include "cluster/sandbox.hpp"
#include "cluster/settings.hpp"
#include "control/version.hpp"

namespace mlcca::cluster {
namespace {

constexpr int kWrongUse = 2;
constexpr std::uint64_t kAlive = 1'000'000;  // µs between signs of life to the service manager
constexpr mode_t kOwnerAlone = 0600;

void say(const std::string& text) { write_at_once(STDERR_FILENO, "mlcca-cluster: " + text + '\n'); }

struct Options {
  std::string settings = "/etc/mlcca/cluster.conf";
  std::string socket = "/run/mlcca/cluster";
  bool check = false;
};

/// The folder in which systemd puts the files of LoadCredential, or the default folder.
std::string credentials() {
  const char* folder = std::getenv("CREDENTIALS_DIRECTORY");  // NOLINT(concurrency-mt-unsafe)
  return folder != nullptr && *folder == '/' ? folder : "/etc/mlcca/cluster";
}

/// Resolves a name once: the C library loads the modules for name resolution at the first call,
/// which the sandbox would not permit later. "localhost" needs no network.
void prepare_names() {
  addrinfo* found = nullptr;
  if (::getaddrinfo("localhost", nullptr, nullptr, &found) == 0) ::freeaddrinfo(found);
}

Result<void> serve(const Options& options, const Settings& settings) {
  auto listening = handed_over(SOCK_SEQPACKET);
  if (listening && !*listening) listening = listen_at(options.socket, SOCK_SEQPACKET, kOwnerAlone);
  if (!listening) return std::unexpected(listening.error());
  if (auto prepared = prepare_http(); !prepared) return prepared;
  prepare_names();
  sigset_t ends;
  sigemptyset(&ends);
  for (const int signal : {SIGTERM, SIGINT}) sigaddset(&ends, signal);
  ::sigprocmask(SIG_BLOCK, &ends, nullptr);
  sd_event* raw = nullptr;
  if (const int e = sd_event_new(&raw); e < 0) return system_error("event loop", -e);
  const std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop(raw);
  for (const int signal : {SIGTERM, SIGINT})
    if (const int e = sd_event_add_signal(raw, nullptr, signal, nullptr, nullptr); e < 0)
      return system_error("signals", -e);
  Bridge bridge(raw, settings,
                {.open = [raw, &settings](
                             const auto& endpoint) { return open_http(raw, settings, endpoint); },
                 .log = say});
  if (auto started = bridge.start(); !started) return started;
  DaemonServer server(raw, std::move(*listening), bridge, say);
  if (auto started = server.start(); !started) return started;
  LoopTimer alive;
  const auto report = [&alive] {
    notify("WATCHDOG=1");
    alive.set(kAlive);
  };
  if (auto started = alive.start(raw, report); !started) return started;
  if (auto entered = enter_sandbox(); !entered) return entered;
  notify("READY=1");
  if (const int e = sd_event_loop(raw); e < 0) return system_error("event loop", -e);
  return {};
}

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"mlcca-cluster - the way of mlccad to the store that gateways share",
               "mlcca-cluster"};
  app.set_version_flag("--version", kVersion);
  app.add_option("--settings", options.settings, "file of settings")->capture_default_str();
  app.add_option("--socket", options.socket, "socket for mlccad, where systemd has made none")
      ->capture_default_str();
  app.add_flag("--check", options.check,
               "read the settings, the certificates and the key, and end");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& wrong) {
    return end_of_parsing(app, wrong, kWrongUse, EXIT_FAILURE);
  }
  const auto settings = read_settings(options.settings, credentials());
  if (!settings) {
    write_at_once(STDERR_FILENO, settings.error().text + '\n');
    return kWrongUse;
  }
  if (options.check) {
    const auto checked = check_credentials(*settings);
    if (!checked) write_at_once(STDERR_FILENO, checked.error().text + '\n');
    return checked ? EXIT_SUCCESS : kWrongUse;
  }
  if (const auto served = serve(options, *settings); !served) {
    say(served.error().text);
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace mlcca::cluster

int main(int argc, char** argv) {
  mlcca::keep_standard_streams();
  ::signal(SIGPIPE, SIG_IGN);  // NOLINT(cert-err33-c): a peer that has gone
  try {
    return mlcca::cluster::main(argc, argv);
  } catch (const std::exception& error) {
    mlcca::cluster::say(error.what());
  }
  return EXIT_FAILURE;
}
