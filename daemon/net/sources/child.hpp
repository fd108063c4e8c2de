// SPDX-License-Identifier: BSD-2-Clause
// The other end of a conversation with mlcca-sources.
#pragma once
#include <sys/types.h>

#include <string>
#include <utility>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::net {

/// A process of ours; it is killed with its owner and collected later, without waiting.
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

  /// 0: none of ours.
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// Collects those that have ended.
  static void collect();

 private:
  void end();

  pid_t pid_ = 0;
};

struct Peer {
  Fd socket;    ///< SOCK_SEQPACKET, does not block
  Child child;  ///< none where systemd started it
};

/// Connects to a socket of that unit, at which systemd listens.
[[nodiscard]] Result<Peer> connect_to_helper(const std::string& path, const std::string& unit);
/// Starts the program with the other end of a socket as its standard input.
[[nodiscard]] Result<Peer> start_helper(const std::string& program);
/// Where mlcca-sources is, if it is named so.
[[nodiscard]] std::string find_helper();

}  // namespace mlcca::net
