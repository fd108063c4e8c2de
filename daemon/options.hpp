// SPDX-License-Identifier: BSD-2-Clause
// What the command line of mlccad says.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace mlcca {

struct Options {
  std::string description = "/etc/mlcca/system.xml";
  std::string gateway;  ///< which gateway of the description this is; empty: by host name
  std::string socket = "/run/mlcca/control.sock";
  std::string bpf_root = "/run/mlcca/bpf";
  std::string state_directory = "/var/lib/mlcca";
  std::string group = "mlcca";
  /// How long verdicts stay in force without a heart-beat of the daemon; ~0 for ever, 0 as soon as
  /// it is noticed.
  std::uint64_t grace_ns = 10'000'000'000;
  /// How long a daemon that starts keeps in force what the one before it has left.
  std::uint64_t start_limit_ns = 30'000'000'000;
  /// How long a description may take to be read; what hangs (a look-up of a user, a file system)
  /// is given up then.
  std::uint64_t read_limit_ns = 60'000'000'000;
  /// Of mlcca-cluster: where that file is, this gateway is one of a cluster.
  std::string cluster_settings = "/etc/mlcca/cluster.conf";
  std::string cluster_socket = "/run/mlcca/cluster";
  bool in_cluster = false;
  std::uint64_t lease_ns = 10'000'000'000;  ///< for which a gateway of a cluster may be silent
  /// The gates drop nothing until an operator has had them enforce for the first time.
  bool initial_audit = false;
  std::vector<std::string> close;  ///< close these interfaces and exit
  bool close_mode = false;
  /// Where gate.conf and conf.d name the interfaces that are meant.
  std::optional<std::string> named_in;
  bool check_only = false;  ///< read the description, say what is wrong, exit
};

/// Result of reading the command line: go on, or exit with the status.
struct Parsed {
  Options options;
  bool exit = false;
  int status = 0;
};

[[nodiscard]] Parsed parse_options(int argc, char** argv);

}  // namespace mlcca
