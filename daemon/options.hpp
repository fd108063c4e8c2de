// SPDX-License-Identifier: BSD-2-Clause
// The command line of mlccad.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace mlcca {

struct Options {
  std::string description = "/etc/mlcca/system.xml";
  std::string gateway;  ///< name of this gateway in the description; empty: chosen by host name
  std::string socket = "/run/mlcca/control.sock";
  std::string bpf_root = "/run/mlcca/bpf";
  std::string state_directory = "/var/lib/mlcca";
  std::string group = "mlcca";
  /// How long verdicts stay in force without a heart-beat of the daemon, in ns; ~0 for ever. With 0
  /// the gates close as soon as the lack of a heart-beat is noticed.
  std::uint64_t grace_ns = 10'000'000'000;
  /// How long a starting daemon keeps in force what the previous one has left, in ns.
  std::uint64_t start_limit_ns = 30'000'000'000;
  /// The most time for reading a description, in ns. A reading that hangs (look-up of a user, file
  /// system) is given up then.
  std::uint64_t read_limit_ns = 60'000'000'000;
  /// Settings of mlcca-cluster. If the file exists, this gateway is in a cluster.
  std::string cluster_settings = "/etc/mlcca/cluster.conf";
  std::string cluster_socket = "/run/mlcca/cluster";
  bool in_cluster = false;
  std::uint64_t lease_ns = 10'000'000'000;  ///< lease of a gateway in a cluster, ns
  /// The gates drop nothing until an operator first changes them to enforce.
  bool initial_audit = false;
  std::vector<std::string> close;  ///< close these interfaces and exit
  bool close_mode = false;
  /// The directory whose gate.conf and conf.d name the interfaces that are meant.
  std::optional<std::string> named_in;
  bool check_only = false;  ///< read the description, report errors, exit
};

/// The result of reading the command line: go on with `options`, or exit with `status`.
struct Parsed {
  Options options;
  bool exit = false;
  int status = 0;
};

[[nodiscard]] Parsed parse_options(int argc, char** argv);

}  // namespace mlcca
