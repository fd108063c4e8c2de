// SPDX-License-Identifier: BSD-2-Clause
#include "tools/readback/probes.hpp"

#include <fmt/format.h>
#include <linux/can.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "base/many.hpp"

namespace mlcca::readback {
namespace {

using gates::Direction;
using gates::GateReading;
using gates::SlotSpec;

/// The lengths from 8 bytes on that CAN FD has.
constexpr std::array<std::uint16_t, 8> kFdLengths = {8, 12, 16, 20, 24, 32, 48, 64};

std::uint16_t fd_length(std::uint16_t most) {
  const auto* const above = std::ranges::upper_bound(kFdLengths, most);
  return above == kFdLengths.begin() ? most : *std::prev(above);
}

bool same_key(const SlotSpec& slot, const Probe& probe, std::uint32_t profile) {
  std::uint32_t key = gate_key_mask(profile, probe.id);
  if ((probe.id & CAN_EFF_FLAG) == 0) key &= CAN_EFF_FLAG | CAN_SFF_MASK;
  return key != 0 && (slot.mask & key) == key && ((slot.id ^ probe.id) & key) == 0;
}

bool fits(const SlotSpec& slot, const Probe& probe) {
  return (probe.id & slot.mask) == slot.id && probe.len <= slot.max_len &&
         (slot.formats & (probe.fd ? GATE_FD : GATE_CLASSIC)) != 0;
}

bool is_whence(const SlotSpec& slot, const Probe& probe) {
  switch (probe.way) {
    case Probe::Way::in:
      return slot.direction == Direction::ingress;
    case Probe::Way::out:
      return slot.direction == Direction::egress && slot.source == 0 &&
             (slot.uid == GATE_ANY_UID || slot.uid == probe.uid);
    case Probe::Way::through:
      return slot.direction == Direction::egress && slot.source == probe.source;
  }
  return false;
}

/// The slots with the frame's key; if there are none, the slots with a matching mask.
std::vector<SlotSpec> candidates(const Probe& probe, const GateReading& gate) {
  const auto direction = probe.way == Probe::Way::in ? Direction::ingress : Direction::egress;
  std::vector<SlotSpec> named;
  std::vector<SlotSpec> masked;
  if (gate_key_mask(gate.profile, probe.id) == 0) return {};
  for (const SlotSpec& slot : gate.slots) {
    if (slot.direction != direction) continue;
    if (same_key(slot, probe, gate.profile))
      named.push_back(slot);
    else if ((probe.id & slot.mask) == slot.id)
      masked.push_back(slot);
  }
  return named.empty() ? masked : named;
}

/// The subject and origin in the slots that pass the frame: at the ingress what it is admitted as,
/// at the egress what it must have been admitted as.
using Origins = std::set<std::pair<std::uint64_t, std::uint32_t>>;
Origins origins(const Probe& probe, const GateReading& gate) {
  Origins passed;
  for (const SlotSpec& slot : candidates(probe, gate))
    if (slot.pass && is_whence(slot, probe) && fits(slot, probe))
      passed.emplace(slot.subject, slot.origin);
  return passed;
}

/// A frame with a key that has no slot, in the form that the profile uses for subjects.
Probe unknown_subject(const GateReading& gate, bool extended) {
  Probe probe{.id = extended ? CAN_EFF_FLAG | 0x0c0300c8U : 0x6a5U, .len = 1};
  for (int n = 0; n < GATE_SLOTS && !candidates(probe, gate).empty(); ++n) {
    const std::uint32_t key = gate_key_mask(gate.profile, probe.id);
    const std::uint32_t step = key & ~(key - 1);  // its lowest bit
    probe.id =
        (probe.id & CAN_EFF_FLAG) | ((probe.id + step) & (extended ? CAN_EFF_MASK : CAN_SFF_MASK));
  }
  return probe;
}

}  // namespace

Probes probes_for(const GateReading& gate) {
  std::set<Probe> frames;
  Probes out;
  for (const SlotSpec& slot : gate.slots) {
    const bool classic = (slot.formats & GATE_CLASSIC) != 0;
    if ((!classic && (slot.formats & GATE_FD) == 0) || slot.source == GATE_NO_SOURCE) {
      ++out.untried;
      continue;
    }
    Probe probe{.id = slot.id,
                .len = classic ? std::min<std::uint16_t>(slot.max_len, CAN_MAX_DLEN)
                               : fd_length(std::min<std::uint16_t>(slot.max_len, CANFD_MAX_DLEN)),
                .fd = !classic};
    if (slot.direction == Direction::egress) {
      probe.way = slot.source == 0 ? Probe::Way::out : Probe::Way::through;
      probe.source = slot.source;
      if (slot.source == 0 && slot.uid != GATE_ANY_UID) probe.uid = slot.uid;
    }
    frames.insert(probe);
    if (probe.len >= CAN_MAX_DLEN) continue;
    ++probe.len;
    frames.insert(probe);
  }
  for (const bool extended : {false, true}) frames.insert(unknown_subject(gate, extended));
  out.frames.assign(frames.begin(), frames.end());
  return out;
}

bool is_admitted(const Probe& probe, const GateReading& gate, std::span<const GateReading> all) {
  if (probe.way != Probe::Way::through) return !origins(probe, gate).empty();
  const auto source = std::ranges::find(all, probe.source, &GateReading::ifindex);
  if (source == all.end()) return false;
  Probe at_source = probe;
  at_source.way = Probe::Way::in;
  const auto entered = origins(at_source, *source);
  return std::ranges::any_of(origins(probe, gate), [&](auto o) { return entered.contains(o); });
}

bool enters_otherwise(const Probe& probe, const GateReading& gate,
                      std::span<const GateReading> all) {
  return probe.way == Probe::Way::through && !origins(probe, gate).empty() &&
         !is_admitted(probe, gate, all);
}

std::string to_text(const Probe& probe) {
  const auto id = (probe.id & CAN_EFF_FLAG) != 0 ? fmt::format("{:08X}", probe.id & CAN_EFF_MASK)
                                                 : fmt::format("{:03X}", probe.id & CAN_SFF_MASK);
  std::string text = fmt::format("{}{} of {}", (probe.id & CAN_RTR_FLAG) != 0 ? "remote " : "", id,
                                 many(probe.len, "byte"));
  if (probe.fd) text = "FD " + text;
  if (probe.way == Probe::Way::in) return text + " from the bus";
  if (probe.way == Probe::Way::out) return text + fmt::format(" sent by user {}", probe.uid);
  return text + fmt::format(" forwarded from interface {}", probe.source);
}

}  // namespace mlcca::readback
