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
#include <string_view>
#include <utility>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "control/local_address.hpp"

namespace mlcca::client {

/// The longest event, bytes.
inline constexpr std::size_t kMostLocalBytes = 65'535;

/// As it came.
struct LocalEvent {
  std::uint64_t subject = 0;
  uid_t from = 0;
  std::uint64_t unix_ns = 0;  ///< when the kernel received it; 0: not said
  std::span<const std::uint8_t> octets;
};

class LocalReceiver {
 public:
  using OnEvent = std::function<void(const LocalEvent&)>;

  /// With a random key, bound to a name that the kernel chooses.
  static Result<LocalReceiver> open();

  [[nodiscard]] int fd() const { return socket_.get(); }
  /// Its name and its key, see control::LocalAddress.
  [[nodiscard]] const std::string& address() const { return address_; }

  /// At most `most` events, without waiting. How many came.
  std::size_t receive(std::size_t most, const OnEvent& on_event);

  using Octets = std::span<const std::uint8_t>;
  /// Of a program that publishes what it subscribes itself. The kernel keeps more of that than of
  /// what others send (net.unix.max_dgram_qlen, 10 where systemd has not set it). False: the event
  /// is lost.
  [[nodiscard]] bool send_to_itself(std::uint64_t subject, Octets event);

 private:
  LocalReceiver(Fd socket, control::LocalAddress own)
      : socket_(std::move(socket)),
        own_(std::move(own)),
        address_(control::to_text(own_)),
        buffer_(kHeader + kMostLocalBytes) {}
  static constexpr std::size_t kHeader = 16;

  Fd socket_;
  control::LocalAddress own_;
  std::string address_;
  std::vector<std::uint8_t> buffer_;
};

/// To one receiver, by a socket of its own. What a receiver does not read takes from the room of
/// the socket that it was sent by (SO_SNDBUF): sent by one socket, it would keep events from the
/// others.
class LocalSender {
 public:
  using Octets = std::span<const std::uint8_t>;
  enum class Sent : std::uint8_t {
    sent,
    full,  ///< the event is lost to it
    gone,  ///< nobody receives there any more
  };

  /// Error: it is no address, or nobody receives there.
  static Result<LocalSender> open(std::string_view address);
  [[nodiscard]] Sent send(std::uint64_t subject, Octets event);

 private:
  LocalSender(Fd socket, std::uint64_t key) : socket_(std::move(socket)), key_(key) {}

  Fd socket_;
  std::uint64_t key_;
};

}  // namespace mlcca::client
