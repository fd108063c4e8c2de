// SPDX-License-Identifier: BSD-2-Clause
// Broadcast messages of J1939's transport protocol (SAE J1939-21, 5.10). A frame of PGN 0xEC00
// announces a message of 9 to 1785 octets (BAM):
//
//   20 size[2] packets ff pgn[3]      low octets first
//
// Its packets follow in frames of PGN 0xEB00, 50 to 200 ms apart; the last one is padded with ff:
//
//   number data[7]                    numbers from 1 on
//
// A source sends one message at a time, because packets do not identify their message.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "base/result.hpp"

namespace mlcca::relay::j1939 {

using Octets = std::span<const std::uint8_t>;
using Event = std::vector<std::uint8_t>;
using Data = std::array<std::uint8_t, 8>;

inline constexpr std::size_t kLeast = 9;
inline constexpr std::size_t kMost = 1785;
inline constexpr std::uint64_t kPause = 50'000'000;  ///< ns between two frames of a source
inline constexpr std::uint64_t kTimeout =
    750'000'000;  ///< timeout T1 in ns: the longest time until the next packet

/// Fields and kinds of identifiers, without flags.
inline constexpr std::uint32_t kSource = 0xff;
[[nodiscard]] bool is_announcement(std::uint32_t id);
[[nodiscard]] bool is_packet(std::uint32_t id);
/// The identifiers of the frames that carry a message, made from the identifier that a frame of its
/// PGN would have.
[[nodiscard]] std::uint32_t announcement_of(std::uint32_t id);
[[nodiscard]] std::uint32_t packet_of(std::uint32_t id);

/// The data of the announcement and of the packets; empty if the transport protocol has no messages
/// of this size.
[[nodiscard]] std::vector<Data> frames_of(Octets event, std::uint32_t id);

/// Counts of frames and messages that were discarded.
struct Losses {
  std::uint64_t malformed = 0;   ///< announcements that are inconsistent
  std::uint64_t incomplete = 0;  ///< messages given up because a packet did not arrive, or not in
                                 ///< time
  auto operator<=>(const Losses&) const = default;
};

/// Reassembles messages. The input is untrusted: at most one message is kept for each of the 256
/// source addresses.
class Reassembly {
 public:
  struct Message {
    std::uint32_t id = 0;  ///< identifier that a frame of its PGN would have, with the priority of
                           ///< the packets
    Event event;
  };
  /// The identifier of the message that this frame announces; nullopt if it announces none.
  static std::optional<std::uint32_t> announced(std::uint32_t id, Octets data);

  /// Takes an announcement. `wanted`: a follower takes the message. A former message of the source
  /// is given up. `now` (ns) must not decrease.
  void announce(std::uint32_t id, Octets data, bool wanted, std::uint64_t now);
  /// Takes a packet, and returns the message if the packet completes it.
  std::optional<Message> take(std::uint32_t id, Octets data, std::uint64_t now);
  /// Gives up messages whose next packet is overdue by kTimeout.
  void expire(std::uint64_t now);

  [[nodiscard]] const Losses& losses() const { return losses_; }
  /// What is stored at present; for tests of the bounds.
  [[nodiscard]] std::size_t sessions() const { return sessions_.size(); }

 private:
  /// An incomplete message of one source address.
  struct Session {
    std::uint32_t id = 0;
    std::size_t size = 0;
    std::uint8_t next = 1;
    std::uint64_t latest_at = 0;
    Event begun;
  };
  std::map<std::uint8_t, Session> sessions_;  ///< by source address
  Losses losses_;
};

/// The messages to send: for each source address one frame after another, kPause apart.
class Sending {
 public:
  static constexpr std::size_t kMostWaiting = 8;  ///< messages of one source address

  struct Message {
    std::uint32_t announcement = 0;  ///< both identifiers include the flags
    std::uint32_t packet = 0;
    std::vector<Data> frames;
  };

  /// Queues a message. Returns false if too many wait at its source address.
  bool add(Message message);
  /// When the next frame is due, in ns of the `clock` of run(); nullopt if none waits.
  [[nodiscard]] std::optional<std::uint64_t> due() const;
  /// Sends the frames that are due. `send(id, data)` returns whether the network took the frame;
  /// otherwise the message is given up. `clock()` returns the time in ns. It is read after sending,
  /// so that the pause is kept even if the process was delayed before.
  template <class Clock, class Send>
  void run(const Clock& clock, const Send& send) {
    for (auto& [address, source] : sources_) {
      if (source.waiting.empty() || source.due > clock()) continue;
      const Message& message = source.waiting.front();
      const std::uint32_t id = source.next == 0 ? message.announcement : message.packet;
      const bool taken = send(id, message.frames[source.next]);
      source.due = clock() + kPause;
      if (!taken || ++source.next == message.frames.size()) source.drop();
    }
  }

 private:
  /// The messages of one source address that wait.
  struct Source {
    std::deque<Message> waiting;
    std::size_t next = 0;  ///< index of the next frame of the first message
    std::uint64_t due = 0;
    void drop() {
      waiting.pop_front();
      next = 0;
    }
  };
  std::map<std::uint8_t, Source> sources_;  ///< by source address
};

}  // namespace mlcca::relay::j1939
