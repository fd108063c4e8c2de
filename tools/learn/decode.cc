// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/decode.hpp"

#include <algorithm>
#include <cstddef>

#include "base/big_endian.hpp"
#include "core/gates/control_traffic.hpp"
#include "core/profiles/profile.hpp"
#include "tools/elements.hpp"

namespace mlcca::learn {

bool Decoder::is_control(const Frame& frame) const {
  return tools::is_control(profile_, frame.id & (kExtended | kIdentifierBits));
}

/// CANopen heart-beat (CiA 301): identifier 0x700 plus the node number, one byte with the state.
bool Decoder::is_heart_beat(const Frame& frame) {
  const std::uint32_t id = frame.id & (kExtended | kIdentifierBits);
  return id > 0x700 && id <= 0x77f && frame.data.size() == 1 && (frame.id & kRemote) == 0;
}

void Decoder::take(const Frame& frame, const OnEvent& on_event) {
  const core::ProfileTraits& traits = core::traits_of(profile_);
  const auto reassembly = core::reassembly_of(profile_);
  Event event;
  if ((frame.id & kRemote) != 0 && !traits.remote_frames) {
    ++others_;
    return;
  }
  event.ns = frame.ns;
  event.bytes = event.frame_bytes = static_cast<std::uint32_t>(frame.data.size());
  event.fd = frame.fd;
  event.remote = (frame.id & kRemote) != 0;
  event.local = frame.local;
  event.number = frame.id & (kExtended | kIdentifierBits);
  event.head = frame.data;
  const auto parts = tools::parts_of(profile_, frame.id);
  if (parts) {
    event.number = parts->number;
    event.node = parts->node;
    event.priority = parts->priority;
  }
  if (reassembly == core::Reassembly::announced && parts) {
    take_j1939(frame, event, on_event);
    return;
  }
  if (traits.deals_tags) take_binding(frame);
  const bool subscribes = traits.deals_tags && parts && parts->number == subscribe_tag_;
  if (is_control(frame) || subscribes) {
    event.control = traits.has_heart_beats && is_heart_beat(frame);
    if (event.control)
      on_event(event);
    else
      ++lost_control_;
    return;
  }
  if (!parts) {
    ++others_;
    return;
  }
  if (reassembly == core::Reassembly::marked)
    take_cyphal(frame, event, on_event);
  else if (reassembly == core::Reassembly::counted && parts->is_fragment)
    take_fragment(frame, event, on_event);
  else
    on_event(event);
}

/// An answer of the FAMOUSO broker has two frames, each with node, half, tag, and four bytes of the
/// subject.
void Decoder::take_binding(const Frame& frame) {
  constexpr std::uint32_t answer = 0x1f5fc004;
  const auto& data = frame.data;
  if ((frame.id & kIdentifierBits) != answer || data.size() != 8) return;
  const std::uint32_t tag = (data[2] & 0x3fU) << 8U | data[3];
  const auto half = static_cast<std::uint32_t>(from_big_endian(data.subspan(4)));
  const bool is_second = data[1] != 0;
  if (!is_second)
    half_dealt_ = half == core::kSubscribeSubject >> 32U ? tag : 0;
  else if (half_dealt_ == tag && half == (core::kSubscribeSubject & UINT32_MAX))
    subscribe_tag_ = tag;
}

/// Transport protocol (SAE J1939-21): a message of more than 8 bytes is announced with its length
/// and PGN, and the following packets carry its data.
void Decoder::take_j1939(const Frame& frame, Event event, const OnEvent& on_event) {
  constexpr std::uint32_t connection = 0xec00;
  constexpr std::uint8_t broadcast = 32;
  constexpr std::uint8_t request_to_send = 16;
  const auto& data = frame.data;
  if (event.number == connection && data.size() == 8 &&
      (data[0] == broadcast || data[0] == request_to_send)) {
    event.number = data[5] | std::uint32_t{data[6]} << 8U | std::uint32_t{data[7]} << 16U;
    event.bytes = data[1] | std::uint32_t{data[2]} << 8U;
    event.frame_bytes = 8;
    event.head = {};
    on_event(event);
    return;
  }
  if (is_control(frame)) {
    ++lost_control_;
    return;
  }
  on_event(event);
}

/// Cyphal/CAN: the last byte of a frame says whether it is the first or last one of a transfer. A
/// transfer of several frames ends with a CRC of two bytes.
void Decoder::take_cyphal(const Frame& frame, Event event, const OnEvent& on_event) {
  if (frame.data.empty()) {
    ++others_;
    return;
  }
  --event.bytes;
  event.head = frame.data.first(frame.data.size() - 1);
  const std::uint8_t tail = frame.data.back();
  const bool first = (tail & 0x80U) != 0;
  const bool last = (tail & 0x40U) != 0;
  if (first && last)
    on_event(event);
  else
    go_on(frame.id & kIdentifierBits, event, first, last, 2, on_event);
}

/// FAMOUSO: a fragment begins with the number of fragments that follow.
void Decoder::take_fragment(const Frame& frame, Event event, const OnEvent& on_event) {
  if (frame.data.empty()) return;
  const std::uint8_t head = frame.data.front();
  const bool is_short = (head & 0x80U) == 0;
  if (!is_short && frame.data.size() < 2) return;
  const bool first = (head & (is_short ? 0x20U : 0x10U)) != 0;
  const std::uint32_t follow = is_short ? head & 0x1fU : (head & 0x0fU) << 8U | frame.data[1];
  event.bytes -= is_short ? 1 : 2;
  event.head = frame.data.subspan(is_short ? 1 : 2);
  go_on(frame.id & kIdentifierBits, event, first, follow == 0, 0, on_event);
}

void Decoder::Begun::add_head(std::span<const std::uint8_t> data) {
  const auto more = data.first(std::min(data.size(), kHead - head_bytes));
  std::ranges::copy(more, head.begin() + static_cast<std::ptrdiff_t>(head_bytes));
  head_bytes += more.size();
}

void Decoder::go_on(std::uint32_t id, const Event& event, bool is_first, bool is_last,
                    std::uint32_t less, const OnEvent& on_event) {
  const auto known = begun_.find(id);
  if (is_first) {
    if (known == begun_.end() && begun_.size() >= kMostBegun)
      begun_.erase(
          std::ranges::min_element(begun_, {}, [](const auto& one) { return one.second.latest; }));
    Begun& first = begun_[id] = {event, event.ns};
    first.add_head(event.head);
    return;
  }
  if (known == begun_.end()) return;  // its first frame was not seen
  Begun& begun = known->second;
  begun.latest = event.ns;
  begun.event.bytes = std::min(begun.event.bytes + event.bytes, 65'535U);
  begun.event.frame_bytes = std::max(begun.event.frame_bytes, event.frame_bytes);
  begun.add_head(event.head);
  if (!is_last) return;
  const Begun done = begun;
  begun_.erase(known);
  Event whole = done.event;
  whole.bytes -= std::min(whole.bytes, less);
  whole.head = std::span(done.head).first(std::min<std::size_t>(done.head_bytes, whole.bytes));
  on_event(whole);
}

}  // namespace mlcca::learn
