// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/tag_broker.hpp"

#include <algorithm>
#include <cstddef>

#include "base/big_endian.hpp"

namespace mlcca::relay {
namespace {

constexpr std::size_t kHalf = 4;  // octets of a subject in one answer

Frame half(const Frame& request, std::uint8_t which, TagNumber tag) {
  Frame out{
      .id = kNormalPriority | kBrokerNode << kNodeShift | kTagAnswer, .length = 8, .data = {}};
  out.data[0] = static_cast<std::uint8_t>(node_of(request));
  out.data[1] = which;
  out.data[2] = static_cast<std::uint8_t>(tag >> 8U);
  out.data[3] = static_cast<std::uint8_t>(tag & 0xffU);
  std::copy_n(request.data.begin() + static_cast<std::ptrdiff_t>(which * kHalf), kHalf,
              out.data.begin() + kHalf);
  return out;
}

}  // namespace

TagBroker::TagBroker(std::span<const Dealt> before) : taken_(kHighestTag + 1U) {
  for (const auto& [subject, tag] : before)
    if (subject != 0 && tag <= kHighestTag && !taken_[tag]) deal(subject, tag);
}

/// Assigns a tag unless the subject has one.
void TagBroker::deal(SubjectId subject, TagNumber tag) {
  if (!tags_.emplace(subject, tag).second) return;
  taken_[tag] = true;
  dealt_.emplace_back(subject, tag);
}

std::optional<TagNumber> TagBroker::tag_of_subject(SubjectId subject) {
  if (subject == 0) return std::nullopt;
  if (const auto known = tags_.find(subject); known != tags_.end()) return known->second;
  while (next_ >= kLowestTag && taken_[next_]) --next_;
  if (next_ < kLowestTag) {
    without_tag_ = without_tag_.value_or(subject);
    return std::nullopt;
  }
  deal(subject, next_);
  return next_;
}

std::optional<TagBroker::Answer> TagBroker::take(const Frame& frame) {
  constexpr std::uint32_t fragment_bit = 1U << 21U;
  if (!has_normal_priority(frame) || tag_of(frame) != kTagRequest || frame.length != 8 ||
      (frame.id & fragment_bit) != 0)
    return std::nullopt;
  const auto tag = tag_of_subject(from_big_endian(frame.data));
  if (!tag) return std::nullopt;
  return Answer{half(frame, 0, *tag), half(frame, 1, *tag)};
}

}  // namespace mlcca::relay
