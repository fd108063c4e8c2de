// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/options.hpp"

#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <optional>

#include "base/command_line.hpp"
#include "base/number.hpp"
#include "control/version.hpp"
#include "core/cluster/lease.hpp"

namespace mlcca {
namespace {

/// Reads a time such as "10s", "500ms", "0" or "forever", in ns.
std::optional<std::uint64_t> parse_time(const std::string& text) {
  constexpr std::uint64_t longest = 86'400;  // a day in seconds
  if (text == "forever") return ~std::uint64_t{0};
  if (text == "0") return 0;
  std::string_view rest = text;
  const auto number = take_number<std::uint32_t>(rest);
  if (!number) return std::nullopt;
  if (rest == "ms" && *number <= longest * 1000) return *number * std::uint64_t{1'000'000};
  if (rest == "s" && *number <= longest) return *number * std::uint64_t{1'000'000'000};
  return std::nullopt;
}

/// Whether a file certainly does not exist. A file that cannot be looked up may exist.
bool is_absent(const std::string& file) {
  struct stat found{};
  return ::lstat(file.c_str(), &found) < 0 && (errno == ENOENT || errno == ENOTDIR);
}

}  // namespace

Parsed parse_options(int argc, char** argv) {
  Parsed parsed;
  Options& o = parsed.options;
  std::string grace = "10s";
  std::string start_limit = "30s";
  std::string read_limit = "60s";
  std::string lease = "10s";
  std::string initial_mode = "enforce";
  const auto is_time = [](const std::string& text) {
    return parse_time(text) ? std::string()
                            : "a time such as 10s or 500ms, 0 or forever (not " + text + ")";
  };
  CLI::App app{"mlccad - lets no data pass over a network that cannot carry it", "mlccad"};
  app.set_version_flag("--version", kVersion);
  app.add_option("-d,--description", o.description, "system description (XML)")
      ->capture_default_str();
  app.add_option("-g,--gateway", o.gateway,
                 "name of this gateway in the description (default: the one whose host is this "
                 "machine's host name, or the only one)");
  app.add_option("--socket", o.socket, "control socket")->capture_default_str();
  app.add_option("--bpf-root", o.bpf_root, "bpffs for programs and maps")->capture_default_str();
  app.add_option("--state-directory", o.state_directory, "run-time admissions are kept here")
      ->envname("STATE_DIRECTORY")
      ->capture_default_str();
  app.add_option("--group", o.group, "members may admit, release, reload and change the mode")
      ->capture_default_str();
  app.add_option(
         "--grace", grace,
         "how long verdicts stay when this daemon dies or hangs: 10s, 500ms, 0 (as soon as it "
         "is noticed), forever")
      ->check(is_time)
      ->capture_default_str();
  app.add_option(
         "--start-limit", start_limit,
         "how long a daemon that starts keeps the verdicts of the one before it: 30s, 500ms, "
         "0 (for the grace only)")
      ->check([&](const std::string& text) {
        return text == "forever" ? "a start has an end: a time such as 30s or 500ms, or 0"
                                 : is_time(text);
      })
      ->capture_default_str();
  app.add_option(
         "--cluster-settings", o.cluster_settings,
         "settings of mlcca-cluster: where there is that file, this gateway shares networks "
         "with others")
      ->capture_default_str();
  app.add_option("--cluster-socket", o.cluster_socket, "socket of mlcca-cluster")
      ->capture_default_str();
  app.add_option("--lease", lease,
                 "how long what it has reserved of shared networks lasts without the store: 2s to "
                 "3600s")
      ->check([](const std::string& text) {
        const auto ns = parse_time(text);
        return ns && *ns >= core::cluster::kLeastLease && *ns <= core::cluster::kMostLease
                   ? std::string()
                   : "a time from 2s to 3600s (not " + text + ")";
      })
      ->capture_default_str();
  app.add_option("--initial-mode", initial_mode,
                 "audit: drop nothing, and count what would be dropped, over restarts until the "
                 "first 'mlccactl mode enforce'; enforce")
      ->check(CLI::IsMember({"enforce", "audit"}))
      ->capture_default_str();
  app.add_option("--read-limit", read_limit,
                 "how long a description may take to be read, with look-ups of its users: 60s, "
                 "500ms")
      ->check([&](const std::string& text) {
        return text == "forever" ? "what hangs is given up: a time such as 60s or 500ms"
                                 : is_time(text);
      })
      ->capture_default_str();
  auto* close =
      app.add_option("--close", o.close,
                     "close these interfaces in the kernel and exit; one that does not exist "
                     "is left to the udev rule")
          ->expected(0, 64);
  app.add_option("--named-in", o.named_in,
                 "with --close: the interfaces that gate.conf and conf.d/*.conf of this directory "
                 "name; of those behind --close, the others are left alone")
      ->needs(close);
  app.add_flag("--check", o.check_only,
               "read the description, say what is wrong, and exit; with --close: read the files of "
               "--named-in, say what they name and what is wrong, and exit");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    parsed.exit = true;
    parsed.status = end_of_parsing(app, e, 2, 1);
  }
  if (const auto ns = parse_time(grace)) o.grace_ns = *ns;
  if (const auto ns = parse_time(start_limit)) o.start_limit_ns = *ns;
  if (const auto ns = parse_time(read_limit)) o.read_limit_ns = *ns;
  if (const auto ns = parse_time(lease)) o.lease_ns = *ns;
  o.initial_audit = initial_mode == "audit";
  o.in_cluster = !is_absent(o.cluster_settings);
  o.close_mode = close->count() > 0;
  std::erase(o.close, "");  // CLI11 represents an option without values by an empty one
  return parsed;
}

}  // namespace mlcca
