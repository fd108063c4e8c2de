// SPDX-License-Identifier: BSD-2-Clause
// Events between programs on the gateway, where no network is in between: datagrams of AF_UNIX from
// the publisher's program to the subscriber's. A datagram is the key of the receiver, the subject,
// both big-endian, and the event. An abstract address has no permissions, so every program can
// send there: the kernel drops what begins with another key before it is queued, and says of the
// rest which user has sent it, so that nobody can pose as a publisher.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::client {

class LocalSocket {
 public:
  using Octets = std::span<const std::uint8_t>;
  using OnEvent = std::function<void(std::uint64_t subject, uid_t from, Octets event)>;

  /// The longest event, bytes.
  static constexpr std::size_t kMostBytes = 65'535;

  /// With a random key, bound to a name that the kernel chooses.
  static Result<LocalSocket> open();

  [[nodiscard]] int fd() const { return socket_.get(); }
  /// Its name and its key, see control::LocalAddress.
  [[nodiscard]] const std::string& address() const { return address_; }

  /// At most `most` events, without waiting. How many came.
  std::size_t receive(std::size_t most, const OnEvent& on_event);
  /// False: it is no address, the receiver is gone, or its queue is full, and the event is lost to
  /// it.
  bool send(const std::string& address, std::uint64_t subject, Octets event);

 private:
  LocalSocket(Fd socket, std::string address)
      : socket_(std::move(socket)), address_(std::move(address)), buffer_(kHeader + kMostBytes) {}
  static constexpr std::size_t kHeader = 16;

  Fd socket_;
  std::string address_;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace mlcca::client
