// SPDX-License-Identifier: BSD-2-Clause
// A source that untrusted peers write, read by a process of its own without any rights
// (mlcca-sources).
#pragma once
#include <cstdint>
#include <string>

#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

/// How a process that reads a source is come by.
struct Helper {
  /// Where systemd starts one for each connection. It must be root who listens, or we.
  std::string socket = "/run/mlcca/sources";
  /// Started by us where there is no such socket; empty: mlcca-sources beside this program, above,
  /// or in
  /// ../libexec/mlcca.
  std::string program;
  std::uint64_t timeout = 15'000'000'000;  ///< ns without a message after which it hangs
  std::uint64_t pause = 1'000'000;         ///< µs before another one
};

/// Its facts are held against the bounds again. A process that ends, sends nothing for 15 s or
/// sends what is not understood is a problem; another one is started a second later, after each
/// further failure twice as late, up to 32 s.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_remote(const core::mesh::Source& source,
                                                              const core::mesh::Mesh& mesh,
                                                              sd_event* loop,
                                                              LinkSource::Report report,
                                                              Helper helper = {});

}  // namespace mlcca::net
