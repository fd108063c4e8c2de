// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's configuration protocol on CAN, by which a node with a UID of 64 bits gets a number of 7
// bits.
//
// The node sends 16 requests, stage 15 down to 0, with four bits of its UID each, the highest
// first. The broker answers each with the part of the UID received so far and the stage in the last
// four bits; at stage 0 with the complete UID, and with the number in the identifier. If several
// nodes ask at the same time, those whose bits differ from the answer stop, and begin again after
// the final answer.
//
// In FAMOUSO neither side has a timeout, so a node that fails in between blocks all later ones.
// Here the broker starts over after a second and announces that with an answer of zeros, which
// every node understands; and a node repeats its request.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "relay/famouso/frame.hpp"

namespace mlcca::relay {

/// A UID as on the wire, the highest octet first.
using Uid = std::array<std::uint8_t, 8>;
using NodeNumber = std::uint8_t;

/// Numbers are assigned from 0x7e down to 0; 0x7f is the broker.
inline constexpr NodeNumber kHighestNode = 0x7e;

/// The broker's side: assigns the numbers of one bus. Times are CLOCK_MONOTONIC in ns.
class NodeBroker {
 public:
  /// How long (ns) the broker waits for the next request of a node before it starts over.
  static constexpr std::uint64_t kPatience = 1'000'000'000;

  using Dealt = std::pair<Uid, NodeNumber>;

  /// `before`: earlier assignments. If the broker's own UID is not among them, it gets a number,
  /// the highest free one, as for every broker.
  explicit NodeBroker(const Uid& own, std::span<const Dealt> before = {});

  /// Takes a frame and returns the answer to send, if any.
  std::optional<Frame> take(const Frame& frame, std::uint64_t now);
  /// Returns the frame to send because a node has stopped its requests. To be called at due().
  std::optional<Frame> expire(std::uint64_t now);
  [[nodiscard]] std::optional<std::uint64_t> due() const;

  /// All assignments. They must survive restarts, because a node keeps its number.
  [[nodiscard]] std::span<const Dealt> dealt() const { return dealt_; }
  [[nodiscard]] std::optional<NodeNumber> number_of(const Uid& uid) const;
  /// The first node that got no number, because all are assigned; nullopt: there was none.
  [[nodiscard]] const std::optional<Uid>& without_number() const { return without_number_; }

 private:
  std::optional<NodeNumber> deal(const Uid& uid);
  void begin();

  std::vector<Dealt> dealt_;
  unsigned stage_ = 15;
  Uid so_far_{};
  std::uint64_t last_ = 0;  ///< when the latest request of the present node arrived
  std::optional<Uid> without_number_;
};

}  // namespace mlcca::relay
