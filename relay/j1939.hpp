// SPDX-License-Identifier: BSD-2-Clause
// Messages of J1939's transport protocol that are broadcast (SAE J1939-21, 5.10). A frame of PGN
// 0xEC00 announces a message of 9 to 1785 octets (BAM):
//
//   20 size[2] packets ff pgn[3]      low octets first
//
// Its packets follow in frames of PGN 0xEB00, 50 to 200 ms apart, the last one filled up with ff:
//
//   number data[7]                    numbers from 1 on
//
// A source sends one message after the other: packets do not say which one they are of.
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
    750'000'000;  ///< T1, ns: so long the next packet may take

/// Identifiers, without flags.
inline constexpr std::uint32_t kSource = 0xff;
[[nodiscard]] bool is_announcement(std::uint32_t id);
[[nodiscard]] bool is_packet(std::uint32_t id);
/// Of the frames that carry a message, from the identifier that a frame of its PGN has.
[[nodiscard]] std::uint32_t announcement_of(std::uint32_t id);
[[nodiscard]] std::uint32_t packet_of(std::uint32_t id);

/// The announcement, then the packets; empty: the transport protocol has no message of that size.
[[nodiscard]] std::vector<Data> frames_of(Octets event, std::uint32_t id);

struct Losses {
  std::uint64_t malformed = 0;   ///< announcements that contradict themselves
  std::uint64_t incomplete = 0;  ///< messages of which a packet did not come, or not in time
  auto operator<=>(const Losses&) const = default;
};

/// Puts messages together. It takes untrusted input: of each of the 256 sources it keeps one
/// message.
class Reassembly {
 public:
  struct Message {
    std::uint32_t id = 0;  ///< that a frame of its PGN would have, with the priority of the packets
    Event event;
  };
  /// The identifier of the message that is announced; nothing: none is.
  static std::optional<std::uint32_t> announced(std::uint32_t id, Octets data);

  /// What is announced; the caller says whether a follower takes it. What the source sent before
  /// is over. `now`, ns, never falls.
  void announce(std::uint32_t id, Octets data, bool wanted, std::uint64_t now);
  /// The message that this packet completes, if it does.
  std::optional<Message> take(std::uint32_t id, Octets data, std::uint64_t now);
  /// Gives up messages whose next packet takes longer than kTimeout.
  void expire(std::uint64_t now);

  [[nodiscard]] const Losses& losses() const { return losses_; }
  /// What is kept now, for tests of its bounds.
  [[nodiscard]] std::size_t sessions() const { return sessions_.size(); }

 private:
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

/// What is to be sent: of each source address one frame after the other, kPause apart.
class Sending {
 public:
  static constexpr std::size_t kMostWaiting = 8;  ///< messages of one source address

  struct Message {
    std::uint32_t announcement = 0;  ///< identifiers, with flags
    std::uint32_t packet = 0;
    std::vector<Data> frames;
  };

  /// False: too many wait.
  bool add(Message message);
  /// When the next frame is due, ns as of `clock` below; nothing: none waits.
  [[nodiscard]] std::optional<std::uint64_t> due() const;
  /// Sends what is due: `send(id, data)` says whether the network took it. A message whose frame it
  /// does not take is given up. `clock` says what time it is, ns: the pause begins when a frame has
  /// been sent, however long the process had to wait for a processor before.
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
  struct Source {
    std::deque<Message> waiting;
    std::size_t next = 0;  ///< frame of the first message
    std::uint64_t due = 0;
    void drop() {
      waiting.pop_front();
      next = 0;
    }
  };
  std::map<std::uint8_t, Source> sources_;  ///< by address
};

}  // namespace mlcca::relay::j1939
