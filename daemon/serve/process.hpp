// SPDX-License-Identifier: BSD-2-Clause
// The process at the other end of a connection, as it was when it connected.
#pragma once
#include <sys/types.h>

#include <memory>
#include <string>

#include "base/result.hpp"

namespace mlcca::serve {

class Process {
 public:
  Process() = default;
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  Process(Process&&) = delete;
  Process& operator=(Process&&) = delete;
  virtual ~Process() = default;

  [[nodiscard]] virtual bool is_in(gid_t group) const = 0;
  /// The systemd unit that the process runs in; empty if in none. The error: it has ended, so the
  /// unit cannot be found out any more.
  [[nodiscard]] virtual Result<std::string> unit() const = 0;
};

/// The process that has connected the socket `fd`. Its groups and its pidfd are taken now, because
/// its number may belong to another process later.
[[nodiscard]] std::shared_ptr<const Process> process_of(int fd, pid_t pid, gid_t primary);

}  // namespace mlcca::serve
