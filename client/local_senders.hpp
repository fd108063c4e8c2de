// SPDX-License-Identifier: BSD-2-Clause
// To all receivers on the gateway that a program sends to. What a receiver has lost is said to it
// as soon as it has room again, without another event.
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

class LocalSenders {
 public:
  using Octets = std::span<const std::uint8_t>;
  /// With more of them sockets are opened again and again. One user has 32 receivers of a channel
  /// at most.
  static constexpr std::size_t kMost = 256;

  /// Its sockets are added to `epoll` while they wait for room. It must outlive this.
  explicit LocalSenders(const Fd& epoll) : epoll_(epoll) {}

  /// False: the event is lost to that receiver.
  [[nodiscard]] bool send(const std::string& address, std::uint64_t subject, Octets event);
  /// A receiver may be gone without a word, and its name another one's.
  void keep_only(const std::set<std::string>& addresses);
  /// One of its sockets has room. False: it has none of that number.
  [[nodiscard]] bool on_room(int fd);

 private:
  void wait_for_room(const LocalSender& sender) const;

  const Fd& epoll_;
  std::map<std::string, LocalSender, std::less<>> by_name_;
};

}  // namespace mlcca::client
