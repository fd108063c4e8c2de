// SPDX-License-Identifier: BSD-2-Clause
// Events between programs on the gateway, where no network is in between: datagrams of AF_UNIX from
// the publisher's program to the subscriber's. A datagram is the key of the receiver, the subject,
// the number of the sender and that of the event (control/local_address.hpp), and the event. An
// abstract address has no permissions, so every program can send there: the kernel drops what
// begins with another key before it is queued, and says of the rest which user has sent it, so that
// nobody can pose as a publisher.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "client/local_numbers.hpp"
#include "control/local_address.hpp"

namespace mlcca::client {

/// The longest event, bytes.
inline constexpr std::size_t kMostLocalBytes = 65'535;

/// As it came.
struct LocalEvent {
  std::uint64_t subject = 0;
  uid_t from = 0;
  std::uint64_t unix_ns = 0;  ///< when the kernel received it; 0: not said
  std::uint64_t missed = 0;   ///< so many of this sender before it were lost
  bool is_notice = false;     ///< it says of those alone, and is no event
  std::span<const std::uint8_t> octets;
};

/// Of one channel: what its publishers send takes no room from other channels. The kernel keeps
/// net.unix.max_dgram_qlen events of all of them, and of each as many as its SO_SNDBUF has room
/// for.
class LocalReceiver {
 public:
  using OnEvent = std::function<void(const LocalEvent&)>;

  /// With a random key, bound to a name that the kernel chooses.
  static Result<LocalReceiver> open();

  [[nodiscard]] int fd() const { return socket_.get(); }
  /// Its name and its key, see control::LocalAddress; empty: it receives nothing any more.
  [[nodiscard]] const std::string& address() const { return address_; }
  /// Whoever knows the former key sends in vain from now on. Its name stays, and what the kernel
  /// has queued. Without another key it receives nothing any more.
  void change_key();
  /// Of the channel that it receives; 0: not known yet.
  [[nodiscard]] std::uint64_t subject() const { return subject_; }
  void set_subject(std::uint64_t subject) { subject_ = subject; }

  using Buffer = std::span<std::uint8_t>;
  static constexpr std::size_t kBuffer = 24 + kMostLocalBytes;
  /// At most `most` events, without waiting. How many came. Of `buffer` it takes kBuffer octets.
  std::size_t receive(std::size_t most, Buffer buffer, const OnEvent& on_event);

  using Octets = std::span<const std::uint8_t>;
  /// Of a program that publishes what it subscribes itself. The kernel keeps more of that than of
  /// what others send (net.unix.max_dgram_qlen, 10 where systemd has not set it). False: the event
  /// is lost.
  [[nodiscard]] bool send_to_itself(std::uint64_t subject, Octets event);

 private:
  LocalReceiver(Fd socket, control::LocalAddress own, LocalCount count)
      : socket_(std::move(socket)),
        own_(std::move(own)),
        address_(control::to_text(own_)),
        to_itself_(count) {}
  [[nodiscard]] LocalEvent read(Octets datagram, uid_t from, std::uint64_t unix_ns);
  static constexpr std::size_t kHeader = kBuffer - kMostLocalBytes;

  Fd socket_;
  control::LocalAddress own_;
  std::string address_;
  std::uint64_t subject_ = 0;
  LocalNumbers numbers_;
  LocalCount to_itself_;
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
  static Result<LocalSender> open(const control::LocalAddress& to);
  [[nodiscard]] int fd() const { return socket_.get(); }
  /// The receiver has another one now.
  void use_key(std::uint64_t key) { key_ = key; }
  [[nodiscard]] Sent send(std::uint64_t subject, Octets event);
  /// Says to the receiver how many there were before. Where that is full, too, it does not know
  /// yet.
  [[nodiscard]] Sent send_notice();

 private:
  LocalSender(Fd socket, std::uint64_t key, LocalCount count)
      : socket_(std::move(socket)), key_(key), count_(count) {}

  Fd socket_;
  std::uint64_t key_;
  LocalCount count_;
  std::uint64_t subject_ = 0;  ///< of the latest event
};

}  // namespace mlcca::client
