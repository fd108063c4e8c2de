// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's binding protocol on CAN: a node asks for the tag of a subject, and the broker answers
// by two frames with half of the subject each. A subject has the same tag for as long as there is a
// broker: what was dealt is kept over restarts, and nothing is ever dealt again.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "relay/famouso/frame.hpp"

namespace mlcca::relay {

using SubjectId = std::uint64_t;
using TagNumber = std::uint16_t;

/// Dealt from the highest down, as every broker does.
inline constexpr TagNumber kHighestTag = 0x3fff;
inline constexpr TagNumber kLowestTag = 0x64;

class TagBroker {
 public:
  using Dealt = std::pair<SubjectId, TagNumber>;
  using Answer = std::array<Frame, 2>;

  /// `before`: what was dealt, or is stated in the description. A tag or a subject that is there
  /// twice counts once, the first time.
  explicit TagBroker(std::span<const Dealt> before = {});

  /// What is to be sent, in this order. Nothing: it is no request, or no tag is left. Subject 0
  /// has none: FAMOUSO's own brokers take it for a free place.
  std::optional<Answer> take(const Frame& frame);
  /// The same for a channel of the broker itself, without frames.
  std::optional<TagNumber> tag_of_subject(SubjectId subject);

  /// To be kept before an answer is sent.
  [[nodiscard]] std::span<const Dealt> dealt() const { return dealt_; }

 private:
  void deal(SubjectId subject, TagNumber tag);

  std::vector<Dealt> dealt_;
  std::unordered_map<SubjectId, TagNumber> tags_;
  std::vector<bool> taken_;
  TagNumber next_ = kHighestTag;
};

}  // namespace mlcca::relay
