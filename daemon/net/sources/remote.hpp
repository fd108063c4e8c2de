// SPDX-License-Identifier: BSD-2-Clause
// A source that untrusted peers write. It is read by a separate process without any rights
// (mlcca-sources).
#pragma once
#include <cstdint>
#include <string>

#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

/// How a process that reads a source is reached.
struct Helper {
  /// Where systemd starts a process for each connection. The listener must belong to root or to our
  /// user.
  std::string socket = "/run/mlcca/sources";
  /// The program to start if there is no such socket. Empty: mlcca-sources beside this program, one
  /// directory above, or in ../libexec/mlcca.
  std::string program;
  std::uint64_t timeout = 15'000'000'000;  ///< ns without a message; then it counts as hanging
  std::uint64_t pause = 1'000'000;         ///< µs before another process is started
};

/// Opens such a source. Its facts are checked against the bounds again. A process that ends, sends
/// nothing for 15 s or sends what is not understood is reported as a problem. Another one is
/// started a second later, and after each further failure twice as late, up to 32 s.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_remote(const core::mesh::Source& source,
                                                              const core::mesh::Mesh& mesh,
                                                              sd_event* loop,
                                                              LinkSource::Report report,
                                                              Helper helper = {});

}  // namespace mlcca::net
