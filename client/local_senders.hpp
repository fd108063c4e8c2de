// SPDX-License-Identifier: BSD-2-Clause
// The senders of a program to the receivers on the gateway.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "base/handle.hpp"
#include "client/local_socket.hpp"
#include "control/messages.hpp"

namespace mlcca::client {

/// Sends events to all receivers on the gateway, with one socket for each. If a receiver has lost
/// events, it gets a notice as soon as it has room again, even if no further event is sent.
class LocalSenders {
 public:
  using Octets = std::span<const std::uint8_t>;
  /// Receivers to which a program sends; events to others are lost. The daemon accepts at most 64
  /// for a channel.
  static constexpr std::size_t kMost = 4096;
  /// Sockets that are open at a time; if more are needed, the one that was used longest ago is
  /// closed for each that is opened. The count of its receiver goes on when it is opened again.
  static constexpr std::size_t kMostOpen = 256;

  /// A receiver: the name of its socket and the user that has stated it. It keeps both when its key
  /// changes, and then goes on counting. The user belongs to it, because any user can state the
  /// name of another program's socket with a key of its own: what is sent there must not count as
  /// sent to that program.
  using Receiver = std::pair<std::string, std::optional<uid_t>>;
  /// The receiver at a local endpoint.
  [[nodiscard]] static Receiver receiver_of(const control::Endpoint& to);

  /// Senders are added to `epoll` while they wait for room. It must outlive this object.
  explicit LocalSenders(const Fd& epoll) : epoll_(epoll) {}

  /// How long (ns) a receiver that is gone is not looked for again, unless keep_only() is called.
  static constexpr std::uint64_t kPause = 1'000'000'000;

  /// Sends an event to a local endpoint.
  [[nodiscard]] LocalSender::Sent send(const control::Endpoint& to, std::uint64_t subject,
                                       Octets event);
  /// Does not send an event, and reports to the receiver that there was one.
  LocalSender::Sent withhold(const control::Endpoint& to, std::uint64_t subject);
  /// Whether something receives at a local endpoint.
  [[nodiscard]] bool reaches(const control::Endpoint& to, std::uint64_t subject);
  /// Forgets all other receivers, and which ones were gone. A receiver may have ended without
  /// notice, and the kernel may have given its name to another one.
  void keep_only(const std::set<Receiver>& receivers);
  /// Handles room in the queue behind the descriptor. Returns false if no sender has it.
  [[nodiscard]] bool on_room(int fd);

 private:
  struct One {
    LocalSender sender;
    bool owes = false;  ///< events were lost that the receiver does not know of
    std::uint64_t used = 0;
  };
  using Senders = std::map<Receiver, One>;

  Senders::iterator of(const control::Endpoint& to);
  Senders::iterator add(const Receiver& receiver, std::uint64_t key);
  bool open(Senders::iterator one);
  void make_room();
  LocalSender::Sent report(Senders::iterator one);
  LocalSender::Sent note_gone(const Receiver& receiver);
  [[nodiscard]] bool was_gone(const control::Endpoint& to);
  void wait_for_room(const LocalSender& sender) const;

  const Fd& epoll_;
  Senders senders_;
  std::map<Receiver, std::uint64_t>
      gone_;              ///< until when they count as gone, CLOCK_MONOTONIC in ns
  std::size_t open_ = 0;  ///< how many of them have an open socket
  std::uint64_t turn_ = 0;
};

}  // namespace mlcca::client
