// SPDX-License-Identifier: BSD-2-Clause
#include "tests/relay/famouso/node_client.hpp"

#include <algorithm>

namespace mlcca::relay {
namespace {

constexpr unsigned kFirstOfNode = 15;
constexpr unsigned kStageOfNode = 18;
constexpr std::uint64_t kNotDue = ~std::uint64_t{0};

/// Stage 15 is the high half of the first octet, stage 0 the low half of the last one.
std::uint8_t nibble_of(const Uid& uid, unsigned stage) {
  return uid[(kFirstOfNode - stage) / 2] >> (stage % 2 == 1 ? 4 : 0) & 0xf;
}

}  // namespace

Frame NodeClient::request() const {
  return {.id = kNormalPriority | stage_ << kStageOfNode |
                static_cast<std::uint32_t>(nibble_of(uid_, stage_)) << kNodeShift | kNodeRequest,
          .length = 0,
          .data = {}};
}

Frame NodeClient::start(std::uint64_t now) {
  wait_ = kFirstWait;
  return restart(now);
}

Frame NodeClient::restart(std::uint64_t now) {
  stage_ = kFirstOfNode;
  silent_ = false;
  due_ = now + wait_;
  return request();
}

/// Whether the UID in the answer agrees with ours as far as it was sent.
bool NodeClient::agrees(const Frame& answer) const {
  if ((answer.data[7] & 0xfU) != stage_) return false;
  for (unsigned s = kFirstOfNode; s >= stage_ && s <= kFirstOfNode; --s)
    if (s != 0 && nibble_of(answer.data, s) != nibble_of(uid_, s)) return false;
  return true;
}

std::optional<Frame> NodeClient::take(const Frame& frame, std::uint64_t now) {
  if (number_ || due_ == kNotDue || !has_normal_priority(frame) || tag_of(frame) != kNodeAnswer ||
      frame.length != 8)
    return std::nullopt;
  if (node_of(frame) != kBrokerNode) {
    if (frame.data == uid_) {
      number_ = static_cast<NodeNumber>(node_of(frame));
      due_ = kNotDue;
      return std::nullopt;
    }
    return restart(now);
  }
  if (frame.data == Uid{}) return restart(now);
  due_ = now + wait_;
  if (silent_ || !agrees(frame) || stage_ == 0) {
    silent_ = true;
    return std::nullopt;
  }
  --stage_;
  return request();
}

std::optional<Frame> NodeClient::expire(std::uint64_t now) {
  if (number_ || now < due_) return std::nullopt;
  wait_ = std::min(wait_ * 2, kLongestWait);
  return restart(now);
}

}  // namespace mlcca::relay
