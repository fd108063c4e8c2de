// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/entry_slot.hpp"

#include "bpf/ether.h"

namespace mlcca::gates {
namespace {

std::uint8_t formats_of(const core::GateEntry& e, core::NetworkKind kind) {
  if (kind != core::NetworkKind::can)
    return ETHER_UNFRAGMENTED | (e.fragmented ? ETHER_FRAGMENT : 0);
  return static_cast<std::uint8_t>((e.classic ? GATE_CLASSIC : 0) | (e.fd ? GATE_FD : 0) |
                                   (e.xl ? GATE_XL : 0) | (e.transport ? GATE_TRANSPORT : 0));
}

/// The origin of a CAN slot. An Ethernet gate derives it from the slot's subject and station, so it
/// is 0 there.
std::uint32_t origin_of(const core::GateEntry& e, core::NetworkKind kind) {
  if (kind != core::NetworkKind::can) return 0;
  if (e.direction == Direction::ingress)
    return gate_origin(e.subject, gate_publisher(e.id, e.mask));
  if (!e.source_port) return 0;
  return gate_origin(e.subject, gate_publisher(e.entered_as.id, e.entered_as.mask));
}

}  // namespace

SlotSpec slot_of(const core::GateEntry& e, core::NetworkKind kind, std::uint32_t source) {
  SlotSpec slot;
  slot.direction = e.direction;
  slot.max_len = e.max_length;
  slot.formats = formats_of(e, kind);
  slot.id = e.id;
  slot.mask = e.mask;
  slot.subject = e.subject;
  slot.station = e.station.bits;
  slot.origin = origin_of(e, kind);
  if (e.direction == Direction::ingress) return slot;
  if (e.source_port)
    slot.source = source;
  else if (e.from_kernel)
    slot.source = GATE_NO_SOURCE;
  else
    slot.uid = e.uid;
  return slot;
}

SlotSpec slot_of(const core::GateRule& rule, core::NetworkKind kind, std::uint32_t source) {
  SlotSpec slot = slot_of(rule.entry, kind, source);
  slot.pass = rule.pass;
  slot.per_frame = rule.policing.per_frame;
  slot.per_byte = rule.policing.per_byte;
  slot.tolerance = rule.policing.tolerance;
  slot.excess_passes = rule.policing.counts_only;
  if (gate_gap_scale(rule.watching.period) != 0) {
    slot.period = rule.watching.period;
    slot.silence = rule.watching.silence;
    slot.together = rule.watching.together;
  }
  return slot;
}

}  // namespace mlcca::gates
