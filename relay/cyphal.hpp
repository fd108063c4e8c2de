// SPDX-License-Identifier: BSD-2-Clause
// Transfers of Cyphal/CAN 1.0 (Cyphal Specification, 4.2). Each frame ends with a tail octet: first
// frame (s), last frame (e), a toggle bit that is 1 in the first frame and alternates (t), and the
// transfer-ID (n):
//
//   setnnnnn
//
// An event that fits one frame is sent in one. To a longer one a CRC-16/CCITT-FALSE of two octets
// is appended, and it is cut into frames that are full except for the last one. CAN FD frames have
// only a few lengths: zeros are inserted before the CRC, or before the tail octet of a transfer of
// one frame. For example, 9 octets on classic CAN are sent as 00 01 02 03 04 05 06 a0, then 07 08,
// the CRC and 40.
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
inline constexpr std::uint8_t kNumbers = 0x1f;  ///< bits of the transfer-ID

/// CRC-16/CCITT-FALSE: polynomial 0x1021, initial value 0xffff; of "123456789" it is 0x29b1.
[[nodiscard]] std::uint16_t crc(Octets octets, std::uint16_t begun = 0xffff);

/// The frames of an event, each with its tail octet. `frame_octets`: the largest data length of a
/// frame, 8, or more on CAN FD, or less if the events are that short. `number`: the transfer-ID, of
/// which the lower 5 bits are used. Fails if the event does not fit a frame of less than 8 octets,
/// or needs more than kMostFrames.
[[nodiscard]] Result<std::vector<Event>> frames_of(Octets event, std::size_t frame_octets,
                                                   std::uint8_t number);

/// Counts of frames and transfers that were discarded.
struct Losses {
  std::uint64_t malformed = 0;   ///< frames that are invalid in Cyphal 1.0
  std::uint64_t duplicates = 0;  ///< transfers that were received before
  std::uint64_t incomplete = 0;  ///< transfers given up because a frame did not arrive, or not in
                                 ///< time, so that the CRC is wrong
  std::uint64_t crowded = 0;     ///< transfers given up because too many were incomplete
  auto operator<=>(const Losses&) const = default;
};

/// Reassembles events from the frames of transfers. The input is untrusted, so the memory is
/// bounded: if it is full, the source that was silent for longest is forgotten.
class Reassembly {
 public:
  /// A publisher, i.e. subject and node, by a number that the caller chooses.
  using Source = std::uint32_t;

  /// Bounds of memory and time.
  struct Limits {
    std::size_t sources = 1024;
    std::size_t octets = std::size_t{1} << 20;  ///< of all incomplete transfers together
    std::uint64_t lifetime_ns = 2'000'000'000;  ///< how long an incomplete transfer, or the
                                                ///< transfer-ID of a complete one, is kept
  };

  Reassembly() : Reassembly(Limits{}) {}
  explicit Reassembly(const Limits& limits) : limits_(limits) {}

  /// Takes one frame, and returns the event if the frame completes it. On CAN FD, padding zeros may
  /// follow the event. `now` (ns) must not decrease.
  std::optional<Event> take(Source source, Octets frame, std::uint64_t now);
  /// Gives up incomplete transfers that are older than Limits::lifetime_ns.
  void expire(std::uint64_t now);

  [[nodiscard]] const Losses& losses() const { return losses_; }
  /// What is stored at present; for tests of the bounds.
  [[nodiscard]] std::size_t sources() const { return sessions_.size(); }
  [[nodiscard]] std::size_t octets() const { return octets_; }

 private:
  /// The transfers of one publisher.
  struct Session {
    Event begun;  ///< content of the incomplete transfer so far
    bool is_begun = false;
    bool toggle = false;                 ///< toggle bit expected in the next frame
    std::uint8_t number = 0;             ///< transfer-ID of the incomplete transfer
    std::optional<std::uint8_t> latest;  ///< transfer-ID of the latest complete transfer
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
