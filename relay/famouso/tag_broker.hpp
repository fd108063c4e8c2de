// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's binding protocol on CAN: a node asks for the tag of a subject, and the broker answers
// with two frames of half of the subject each. A subject keeps its tag as long as there is a
// broker: assignments survive restarts, and a tag is never assigned twice.
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

/// Tags are assigned from the highest down, as every broker does.
inline constexpr TagNumber kHighestTag = 0x3fff;
inline constexpr TagNumber kLowestTag = 0x64;

/// Assigns the tags of one bus.
class TagBroker {
 public:
  using Dealt = std::pair<SubjectId, TagNumber>;
  using Answer = std::array<Frame, 2>;

  /// `before`: tags assigned earlier, or stated in the description. If a tag or a subject occurs
  /// twice, the first one counts.
  explicit TagBroker(std::span<const Dealt> before = {});

  /// Returns the frames to send in this order; nullopt if the frame is no request or no tag is
  /// left. Subject 0 gets no tag, because FAMOUSO's own brokers use it to mark a free place.
  std::optional<Answer> take(const Frame& frame);
  /// The tag of a channel of the broker itself, without frames.
  std::optional<TagNumber> tag_of_subject(SubjectId subject);

  /// The first subject that got no tag, because all are assigned; nullopt: there was none.
  [[nodiscard]] std::optional<SubjectId> without_tag() const { return without_tag_; }

  /// All assignments. They must be stored before an answer is sent.
  [[nodiscard]] std::span<const Dealt> dealt() const { return dealt_; }

 private:
  void deal(SubjectId subject, TagNumber tag);

  std::vector<Dealt> dealt_;
  std::unordered_map<SubjectId, TagNumber> tags_;
  std::vector<bool> taken_;
  TagNumber next_ = kHighestTag;
  std::optional<SubjectId> without_tag_;
};

}  // namespace mlcca::relay
