// SPDX-License-Identifier: BSD-2-Clause
// Slots and events for the tables of packets.
#pragma once
#include <vector>

#include "tests/bpf/ether/loaded_ether.hpp"

namespace mlcca::test {

using gates::Direction;
using gates::SlotSpec;

inline constexpr auto kIn = Direction::ingress;
inline constexpr auto kOut = Direction::egress;
inline constexpr std::uint64_t kSubject = 0x44697374616e6365;  // "Distance"
/// Of an event of a station, or of a sender without a slot of its own.
inline std::uint32_t mark_from(std::uint32_t ifindex, std::uint64_t station = 0) {
  return gate_ingress_token(kToken, ifindex, gate_origin(kSubject, station));
}
inline const std::uint32_t kAdmitted = mark_from(kIfindex);
inline const std::uint32_t kFromOther = mark_from(kOther);

inline SlotSpec slot(Direction direction) {
  SlotSpec s;
  s.direction = direction;
  s.pass = true;
  s.subject = kSubject;
  s.max_len = 100;
  s.formats = ETHER_UNFRAGMENTED;
  return s;
}
inline SlotSpec with(SlotSpec s, auto change) {
  change(s);
  return s;
}
inline SlotSpec in() { return slot(kIn); }
inline SlotSpec of_user(std::uint32_t uid) {
  return with(slot(kOut), [=](SlotSpec& s) { s.uid = uid; });
}
inline SlotSpec from(std::uint32_t ifindex) {
  return with(slot(kOut), [=](SlotSpec& s) { s.source = ifindex; });
}
inline SlotSpec denied(const SlotSpec& spec) {
  return with(spec, [](SlotSpec& s) { s.pass = false; });
}
inline SlotSpec fragmented(const SlotSpec& spec) {
  return with(spec, [](SlotSpec& s) { s.formats = ETHER_UNFRAGMENTED | ETHER_FRAGMENT; });
}
inline SlotSpec sized(const SlotSpec& spec, std::uint16_t bytes) {
  return with(spec, [=](SlotSpec& s) { s.max_len = bytes; });
}

inline Datagram event(auto change) {
  Datagram d;
  d.subject = kSubject;
  change(d);
  return d;
}
inline Datagram event() {
  return event([](Datagram&) {});
}
inline Bytes packet(auto change) { return frame(event(change).whole()); }
inline Bytes packet() { return frame(event().whole()); }
inline Bytes cut(Bytes bytes, std::size_t size) {
  bytes.resize(size);
  return bytes;
}

inline constexpr Sender kWire{};
inline constexpr Sender kLocal{.local = true};
inline const Sender kForwarded{.mark = kFromOther, .ingress_ifindex = kOther};

}  // namespace mlcca::test
