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
  /// The unit of systemd that it runs in; empty: in none. Error: it has ended, so that nobody can
  /// say any more.
  [[nodiscard]] virtual Result<std::string> unit() const = 0;
};

/// Who has connected the socket `fd`. Its groups and its identity are taken now; its number may be
/// another process's later.
[[nodiscard]] std::shared_ptr<const Process> process_of(int fd, pid_t pid, gid_t primary);

}  // namespace mlcca::serve
