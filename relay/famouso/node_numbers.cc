// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/node_numbers.hpp"

#include <algorithm>

namespace mlcca::relay {
namespace {

constexpr unsigned kFirstStage = 15;
constexpr unsigned kStageShift = 18;
constexpr std::uint32_t kNibble = 0xf;

/// Stage 15 is the high half of the first octet, stage 0 the low half of the last one.
unsigned octet_of(unsigned stage) { return (kFirstStage - stage) / 2; }
unsigned shift_of(unsigned stage) { return stage % 2 == 1 ? 4 : 0; }

bool is_request(const Frame& frame) {
  return has_normal_priority(frame) && tag_of(frame) == kNodeRequest;
}

/// An answer of the broker. Its identifier has the highest bit of the stage where identifiers of
/// events have the fragment bit.
Frame answer(unsigned stage, std::uint32_t node, const Uid& data) {
  constexpr std::uint32_t fragment_bit = 1U << 21U;
  return {.id = kNormalPriority | ((stage & 8U) != 0 ? fragment_bit : 0U) | node << kNodeShift |
                kNodeAnswer,
          .length = 8,
          .data = data};
}

}  // namespace

NodeBroker::NodeBroker(const Uid& own, std::span<const Dealt> before)
    : dealt_(before.begin(), before.end()) {
  static_cast<void>(deal(own));
}

std::optional<NodeNumber> NodeBroker::number_of(const Uid& uid) const {
  const auto known = std::ranges::find(dealt_, uid, &Dealt::first);
  return known == dealt_.end() ? std::nullopt : std::optional(known->second);
}

/// Assigns the highest free number; nullopt if all are assigned.
std::optional<NodeNumber> NodeBroker::deal(const Uid& uid) {
  if (const auto known = number_of(uid)) return known;
  for (int number = kHighestNode; number >= 0; --number) {
    const auto candidate = static_cast<NodeNumber>(number);
    if (std::ranges::find(dealt_, candidate, &Dealt::second) != dealt_.end()) continue;
    dealt_.emplace_back(uid, candidate);
    return candidate;
  }
  return std::nullopt;
}

void NodeBroker::begin() {
  stage_ = kFirstStage;
  so_far_ = {};
}

std::optional<Frame> NodeBroker::take(const Frame& frame, std::uint64_t now) {
  if (!is_request(frame)) return std::nullopt;
  // Other stages are requests of nodes that lost the arbitration.
  if ((frame.id >> kStageShift & kNibble) != stage_) return std::nullopt;
  last_ = now;
  const auto nibble = static_cast<std::uint8_t>(frame.id >> kNodeShift & kNibble);
  std::uint8_t& octet = so_far_[octet_of(stage_)];
  octet = static_cast<std::uint8_t>((octet & ~(kNibble << shift_of(stage_))) |
                                    static_cast<unsigned>(nibble) << shift_of(stage_));
  if (stage_ != 0) {
    Uid shown = so_far_;
    if (stage_ > 1)
      shown[7] = static_cast<std::uint8_t>(stage_);
    else
      shown[7] = static_cast<std::uint8_t>((shown[7] & 0xf0U) | stage_);
    return answer(stage_--, kBrokerNode, shown);
  }
  const Uid uid = so_far_;
  begin();
  if (uid == Uid{}) return std::nullopt;
  const auto number = deal(uid);
  if (!number && !without_number_) without_number_ = uid;
  return number ? std::optional(answer(0, *number, uid)) : std::nullopt;
}

std::optional<std::uint64_t> NodeBroker::due() const {
  return stage_ == kFirstStage ? std::nullopt : std::optional(last_ + kPatience);
}

std::optional<Frame> NodeBroker::expire(std::uint64_t now) {
  const auto when = due();
  if (!when || now < *when) return std::nullopt;
  begin();
  return answer(0, kBrokerNode, Uid{});
}

}  // namespace mlcca::relay
