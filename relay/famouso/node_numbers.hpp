// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's configuration protocol on CAN: how a node with a UID of 64 bits gets a number of 7
// bits.
//
// The node asks in 16 stages, 15 down to 0, with four bits of its UID each, the highest first. The
// broker answers with what it has of the UID so far, and in the last four bits with the stage; at
// stage 0 with the whole UID, and the number in the identifier. Of nodes that ask at the same time
// those whose bits are others fall silent, and begin again after that answer.
//
// In FAMOUSO neither side has a time limit: a node that dies in the middle blocks all later ones.
// Here the broker starts over after a second and says so, by an answer of zeros, which every node
// understands; and a node asks again.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "relay/famouso/frame.hpp"

namespace mlcca::relay {

/// As it is on the wire, the highest octet first.
using Uid = std::array<std::uint8_t, 8>;
using NodeNumber = std::uint8_t;

/// 0x7e down to 0 are dealt; 0x7f is the broker as such.
inline constexpr NodeNumber kHighestNode = 0x7e;

/// Deals the numbers of one bus.
class NodeBroker {
 public:
  /// A stage that no request has followed for so long is given up, ns.
  static constexpr std::uint64_t kPatience = 1'000'000'000;

  using Dealt = std::pair<Uid, NodeNumber>;

  /// Knows the numbers that were dealt before, and deals one to itself where it has none: the
  /// highest, as every broker does.
  explicit NodeBroker(const Uid& own, std::span<const Dealt> before = {});

  /// What is to be sent in answer, if anything.
  std::optional<Frame> take(const Frame& frame, std::uint64_t now);
  /// What is to be sent since nobody went on. Call it at due().
  std::optional<Frame> expire(std::uint64_t now);
  [[nodiscard]] std::optional<std::uint64_t> due() const;

  /// To be kept over restarts: a number stays its node's.
  [[nodiscard]] std::span<const Dealt> dealt() const { return dealt_; }
  [[nodiscard]] std::optional<NodeNumber> number_of(const Uid& uid) const;

 private:
  std::optional<NodeNumber> deal(const Uid& uid);
  void begin();

  std::vector<Dealt> dealt_;
  unsigned stage_ = 15;
  Uid so_far_{};
  std::uint64_t last_ = 0;  ///< when a request of the present node came
};

/// Asks for a number.
class NodeClient {
 public:
  /// Without an answer it begins again after this, then twice as long, up to the longest, ns.
  static constexpr std::uint64_t kFirstWait = 250'000'000;
  static constexpr std::uint64_t kLongestWait = 8'000'000'000;

  /// A UID of zeros has no number.
  explicit NodeClient(const Uid& uid) : uid_(uid) {}

  /// The first request.
  Frame start(std::uint64_t now);
  /// What is to be sent next, if anything.
  std::optional<Frame> take(const Frame& frame, std::uint64_t now);
  /// The request again, when due() has passed.
  std::optional<Frame> expire(std::uint64_t now);
  [[nodiscard]] std::uint64_t due() const { return due_; }

  [[nodiscard]] std::optional<NodeNumber> number() const { return number_; }

 private:
  [[nodiscard]] Frame request() const;
  Frame restart(std::uint64_t now);
  [[nodiscard]] bool agrees(const Frame& answer) const;

  Uid uid_;
  unsigned stage_ = 15;
  bool silent_ = false;  ///< another node goes first
  std::uint64_t wait_ = kFirstWait;
  std::uint64_t due_ = ~std::uint64_t{0};
  std::optional<NodeNumber> number_;
};

}  // namespace mlcca::relay
