// SPDX-License-Identifier: BSD-2-Clause
// Datagram sockets for events between programs on the same gateway, without any network in between.
//
// A datagram of AF_UNIX goes from the publisher's program directly to the subscriber's. It has the
// key of the receiver, the subject, the numbers of the sender and of the event, and the event
// (control/local_address.hpp). Abstract addresses have no permissions, so any program could send
// there. Therefore a socket filter drops datagrams with another key before they are queued, and
// SCM_CREDENTIALS states the user that sent the others, so that no program can pose as a publisher.
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

/// The longest event, in bytes.
inline constexpr std::size_t kMostLocalBytes = 65'535;

/// A received datagram.
struct LocalEvent {
  std::uint64_t subject = 0;
  uid_t from = 0;
  std::uint64_t unix_ns = 0;             ///< when the kernel received it; 0: unknown
  std::uint64_t missed = 0;              ///< events of the same sender that were lost before it
  bool is_notice = false;                ///< it reports `missed` only and is no event
  std::span<const std::uint8_t> octets;  ///< points into the buffer of receive()
};

/// Receives the events of one channel. Each channel has a socket of its own, so that its publishers
/// take no room from other channels. The kernel queues net.unix.max_dgram_qlen datagrams for the
/// receiver, and from each sender as many as fit its SO_SNDBUF.
class LocalReceiver {
 public:
  using OnEvent = std::function<void(const LocalEvent&)>;

  /// Opens a receiver with a random key and a name that the kernel chooses.
  static Result<LocalReceiver> open();

  [[nodiscard]] int fd() const { return socket_.get(); }
  /// Name and key as text, see control::LocalAddress; empty: it receives nothing any more.
  [[nodiscard]] const std::string& address() const { return address_; }
  /// Replaces the key, so that the datagrams of senders that know the former one are dropped. The
  /// name stays, and so do the datagrams already queued. If no key can be set, the socket is closed
  /// and address() is empty.
  void change_key();
  /// Subject of the channel that it receives; 0: unknown yet.
  [[nodiscard]] std::uint64_t subject() const { return subject_; }
  void set_subject(std::uint64_t subject) { subject_ = subject; }

  using Buffer = std::span<std::uint8_t>;
  static constexpr std::size_t kBuffer = 24 + kMostLocalBytes;
  /// Receives at most `most` events without waiting, and calls `on_event` for each. Returns how
  /// many datagrams were taken. `buffer` must have kBuffer bytes.
  std::size_t receive(std::size_t most, Buffer buffer, const OnEvent& on_event);

  using Octets = std::span<const std::uint8_t>;
  /// Sends an event to this receiver from the same program, which subscribes to what it publishes.
  /// An unconnected socket that sends to itself may queue more than others can (they are limited by
  /// net.unix.max_dgram_qlen, 10 by default unless systemd has raised it). Returns false if the
  /// event is lost.
  [[nodiscard]] bool send_to_itself(std::uint64_t subject, Octets event);
  /// Counts an event of the same program that is not sent.
  void lose_to_itself() { ++to_itself_.next; }

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

/// Sends events to one receiver. Datagrams that the receiver has not read count against SO_SNDBUF
/// of the socket that sent them; with a socket of its own, a receiver that does not read cannot
/// keep events from the others.
class LocalSender {
 public:
  using Octets = std::span<const std::uint8_t>;
  /// The result of sending an event or a notice.
  enum class Sent : std::uint8_t {
    sent,
    full,  ///< the queue has no room: the event is lost
    gone,  ///< no socket receives at this address any more
  };

  /// A sender without a socket, which counts from 0.
  static Result<LocalSender> to(const control::LocalAddress& to);
  /// As to(), connected to the receiver. Fails if nothing receives there.
  static Result<LocalSender> open(const control::LocalAddress& to);
  /// Connects to the receiver. Fails if nothing receives there, or if no descriptors are left.
  Result<void> open();
  /// Closes the socket. The count goes on when it is opened again.
  void close() { socket_.reset(); }
  [[nodiscard]] int fd() const { return socket_.get(); }  ///< -1: no socket is open
  /// Whether open() found that nothing receives there.
  [[nodiscard]] bool is_gone() const { return is_gone_; }
  /// Uses the new key of the receiver.
  void use_key(std::uint64_t key) { to_.key = key; }
  [[nodiscard]] Sent send(std::uint64_t subject, Octets event);
  /// The subject of notices, until an event of another one is sent.
  void use_subject(std::uint64_t subject) { subject_ = subject; }
  /// Counts an event that is not sent, for example because no socket could be opened.
  Sent lose(std::uint64_t subject);
  /// Reports to the receiver how many events were sent so far, so that it can count losses. If the
  /// result is `full`, the receiver does not know them yet.
  [[nodiscard]] Sent send_notice();

 private:
  LocalSender(control::LocalAddress to, LocalCount count) : to_(std::move(to)), count_(count) {}

  Fd socket_;
  control::LocalAddress to_;
  LocalCount count_;
  bool is_gone_ = false;       ///< nothing received there when it was opened
  std::uint64_t subject_ = 0;  ///< of the latest event
};

}  // namespace mlcca::client
