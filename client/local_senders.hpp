// SPDX-License-Identifier: BSD-2-Clause
// The senders of a program to the receivers on the gateway.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>

#include "base/handle.hpp"
#include "client/local_socket.hpp"

namespace mlcca::client {

/// Sends events to all receivers on the gateway, with one socket for each. If a receiver has lost
/// events, it gets a notice as soon as it has room again, even if no further event is sent.
class LocalSenders {
 public:
  using Octets = std::span<const std::uint8_t>;
  /// Senders that are open at a time; if more are needed, one is closed for each that is opened.
  /// The daemon accepts at most 32 receivers of one user for a channel.
  static constexpr std::size_t kMost = 256;

  /// Senders are added to `epoll` while they wait for room. It must outlive this object.
  explicit LocalSenders(const Fd& epoll) : epoll_(epoll) {}

  /// Sends an event to the address of a receiver (control::LocalAddress as text). Returns false if
  /// the event is lost.
  [[nodiscard]] bool send(const std::string& address, std::uint64_t subject, Octets event);
  /// Closes the senders to all other addresses. A receiver may have ended without notice, and the
  /// kernel may have given its name to another one.
  void keep_only(const std::set<std::string>& addresses);
  /// Handles room in the queue behind the descriptor. Returns false if no sender has it.
  [[nodiscard]] bool on_room(int fd);

 private:
  void wait_for_room(const LocalSender& sender) const;

  const Fd& epoll_;
  std::map<std::string, LocalSender, std::less<>> by_name_;
};

}  // namespace mlcca::client
