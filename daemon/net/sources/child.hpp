// SPDX-License-Identifier: BSD-2-Clause
// The other end of a conversation with mlcca-sources.
#pragma once
#include <sys/types.h>

#include <string>
#include <utility>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::net {

/// A child process. It is killed with its owner, and waited for later without blocking.
class Child {
 public:
  Child() = default;
  explicit Child(pid_t pid) : pid_(pid) {}
  Child(Child&& other) noexcept : pid_(std::exchange(other.pid_, 0)) {}
  Child& operator=(Child&& other) noexcept {
    if (this != &other) end();
    pid_ = std::exchange(other.pid_, 0);
    return *this;
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() { end(); }

  /// 0: not a child of ours.
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// Waits for those children that have ended.
  static void collect();

 private:
  void end();

  pid_t pid_ = 0;
};

/// A connection to mlcca-sources.
struct Peer {
  Fd socket;    ///< SOCK_SEQPACKET, non-blocking
  Child child;  ///< empty if systemd started it
};

/// Connects to the socket of a systemd unit.
[[nodiscard]] Result<Peer> connect_to_helper(const std::string& path, const std::string& unit);
/// Starts the program with the other end of a socket as its standard input.
[[nodiscard]] Result<Peer> start_helper(const std::string& program);
/// The path of mlcca-sources, if a program of that name is found.
[[nodiscard]] std::string find_helper();

}  // namespace mlcca::net
