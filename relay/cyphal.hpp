// SPDX-License-Identifier: BSD-2-Clause
// Transfers of Cyphal/CAN 1.0 (Cyphal Specification, 4.2). Each frame ends with a tail octet: first
// frame (s), last frame (e), a toggle that is 1 in the first frame and changes with each (t), and
// the number of the transfer:
//
//   setnnnnn
//
// An event that fits a frame goes in one. A longer one is followed by a CRC-16/CCITT-FALSE of two
// octets and cut into frames that are full but for the last one. On CAN FD, where a frame has one
// of few lengths, zeros stand before the CRC, or before the tail octet of a transfer of one frame.
// For example 9 octets on classic CAN: 00 01 02 03 04 05 06 a0, then 07 08 and the CRC and 40.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "base/result.hpp"

namespace mlcca::relay::cyphal {

using Octets = std::span<const std::uint8_t>;
using Event = std::vector<std::uint8_t>;

inline constexpr std::size_t kMostFrames = 4096;
inline constexpr std::uint8_t kNumbers = 0x1f;  ///< of transfers: these bits

/// Polynomial 0x1021, begun with 0xffff; of the octets of "123456789" it is 0x29b1.
[[nodiscard]] std::uint16_t crc(Octets octets, std::uint16_t begun = 0xffff);

/// The frames of an event, each with its tail octet. `frame_octets`: 8, more where frames are of
/// CAN FD, or less where events are so short. Error: the event is longer than a frame of less than
/// 8 octets carries, or needs more than kMostFrames.
[[nodiscard]] Result<std::vector<Event>> frames_of(Octets event, std::size_t frame_octets,
                                                   std::uint8_t number);

struct Losses {
  std::uint64_t malformed = 0;   ///< frames that are none of Cyphal 1.0
  std::uint64_t duplicates = 0;  ///< transfers that were there before
  std::uint64_t incomplete = 0;  ///< transfers of which a frame did not come, or not in time: their
                                 ///< CRC is wrong
  std::uint64_t crowded = 0;     ///< transfers that were given up since too many were begun
  auto operator<=>(const Losses&) const = default;
};

/// Puts transfers together. It takes untrusted input: its memory is bounded. Where it is full, the
/// source that was silent longest is forgotten.
class Reassembly {
 public:
  /// Of one publisher, as the caller distinguishes them: subject and node.
  using Source = std::uint32_t;

  struct Limits {
    std::size_t sources = 1024;
    std::size_t octets = std::size_t{1} << 20;  ///< of transfers that are not complete, together
    std::uint64_t lifetime_ns = 2'000'000'000;  ///< of a transfer that is not complete, and of the
                                                ///< number of one that was
  };

  Reassembly() : Reassembly(Limits{}) {}
  explicit Reassembly(const Limits& limits) : limits_(limits) {}

  /// The event that this frame completes, if it does; on CAN FD zeros may follow it. `now` never
  /// falls.
  std::optional<Event> take(Source source, Octets frame, std::uint64_t now);
  /// Gives up transfers that are older than Limits::lifetime_ns.
  void expire(std::uint64_t now);

  [[nodiscard]] const Losses& losses() const { return losses_; }
  /// What is kept now, for tests of its bounds.
  [[nodiscard]] std::size_t sources() const { return sessions_.size(); }
  [[nodiscard]] std::size_t octets() const { return octets_; }

 private:
  struct Session {
    Event begun;  ///< of the transfer that is not complete
    bool is_begun = false;
    bool toggle = false;                 ///< of its next frame
    std::uint8_t number = 0;             ///< of that transfer
    std::optional<std::uint8_t> latest;  ///< number of the latest complete one
    std::uint64_t completed_at = 0;
    std::uint64_t latest_at = 0;
  };
  using All = std::map<Source, Session>;

  Session& session_of(Source source, std::uint64_t now);
  [[nodiscard]] bool is_repeated(const Session& session, std::uint8_t number,
                                 std::uint64_t now) const;
  std::optional<Event> take_rest(Session& session, Octets content, bool last, std::uint64_t now);
  void give_up(Session& session, std::uint64_t& why);
  bool make_room(std::size_t octets, const Session& beside);

  Limits limits_;
  All sessions_;
  std::size_t octets_ = 0;
  Losses losses_;
};

}  // namespace mlcca::relay::cyphal
