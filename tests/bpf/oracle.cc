// SPDX-License-Identifier: BSD-2-Clause
// Compares every slot with every frame: no buckets, no chains, no early way out.
#include "tests/bpf/oracle.hpp"

#include <cstring>

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::SlotSpec;

struct Parsed {
  std::uint32_t can_id = 0;
  unsigned len = 0;
  std::uint8_t format = GATE_CLASSIC;
};

/// At ingress up to 32 bytes, a multiple of 8, may stand in front of the frame.
bool is_frame(std::size_t size, std::size_t mtu, Direction direction) {
  if (size == mtu) return true;
  return direction == Direction::ingress && size > mtu && size <= mtu + 32 && (size - mtu) % 8 == 0;
}

std::optional<Parsed> parse(const Bytes& bytes, Direction direction) {
  Parsed f;
  const bool fd = is_frame(bytes.size(), CANFD_MTU, direction);
  if (!fd && !is_frame(bytes.size(), CAN_MTU, direction)) return std::nullopt;
  const auto* const start = bytes.data() + bytes.size() - (fd ? CANFD_MTU : CAN_MTU);
  std::memcpy(&f.can_id, start, 4);
  f.len = start[4];
  f.format = fd ? GATE_FD : GATE_CLASSIC;
  if (f.len > (fd ? 64U : 8U)) return std::nullopt;
  return f;
}

/// A header of 12 bytes that fits what is there, at its start or behind 16 bytes, not both.
std::optional<Parsed> parse_xl(const Bytes& bytes, Direction direction) {
  std::optional<Parsed> found;
  for (const std::size_t lead : {0U, 16U}) {
    if ((lead != 0 && direction == Direction::egress) || bytes.size() < lead + 8) continue;
    Parsed f{.format = GATE_XL};
    std::uint16_t len = 0;
    std::memcpy(&f.can_id, &bytes[lead], 4);
    std::memcpy(&len, &bytes[lead + 6], 2);
    f.len = len;
    if ((bytes[lead + 4] & 0x80U) == 0 || len < 1 || len > 2048) continue;
    if (bytes.size() != lead + 12 + len) continue;
    if (found) return std::nullopt;
    found = f;
  }
  // The priority has 11 bits, and the network's number stands in bits 16 to 23.
  if (found && (found->can_id & ~0x00ff07ffU) != 0) return std::nullopt;
  return found;
}

std::uint32_t bits(std::uint32_t id, unsigned first, unsigned last) {
  return (id >> first) & ((1U << (last - first + 1)) - 1);
}

/// What the profile's document calls the name of a message; nothing where it knows none.
std::optional<std::uint32_t> key(std::uint32_t profile, std::uint32_t id) {
  const bool extended = (id & CAN_EFF_FLAG) != 0;
  switch (profile) {
    case GATE_PROFILE_RAW:
      return extended ? id & (CAN_EFF_FLAG | CAN_EFF_MASK) : bits(id, 0, 10);
    case GATE_PROFILE_CANOPEN:
      if (extended) return std::nullopt;
      return bits(id, 0, 10);
    case GATE_PROFILE_FAMOUSO:
      if (!extended) return std::nullopt;
      return bits(id, 0, 13);
    case GATE_PROFILE_J1939: {
      if (!extended) return std::nullopt;
      const bool has_destination = bits(id, 16, 23) < 240;
      return bits(id, 16, 25) << 8 | (has_destination ? 0 : bits(id, 8, 15));
    }
    case GATE_PROFILE_CYPHAL:
      if (!extended || bits(id, 25, 25) != 0 || bits(id, 23, 23) != 0 || bits(id, 7, 7) != 0)
        return std::nullopt;
      return bits(id, 8, 20);
    default:
      return std::nullopt;
  }
}

constexpr std::int64_t kNobody = GATE_NO_SOURCE;

std::int64_t source(const Sender& sender) {
  if (sender.local) return 0;
  return sender.ingress_ifindex != 0 ? sender.ingress_ifindex : kNobody;
}

/// The mark says that the interface of the slot has passed the frame as what the slot demands.
bool vouched(const SlotSpec& s, std::uint32_t mark) {
  return s.source == GATE_NO_SOURCE || mark == gate_ingress_token(kToken, s.source, s.origin);
}

/// The destination of a J1939 frame is part of what a slot is for, if the slot states one.
bool is_elsewhere(std::uint32_t profile, const SlotSpec& s, const Parsed& f) {
  return profile == GATE_PROFILE_J1939 && bits((s.id ^ f.can_id) & s.mask, 8, 15) != 0;
}

gate_reason misfit(const SlotSpec& s, const Parsed& f, std::int64_t from, std::uint32_t mark) {
  if ((f.can_id & s.mask) != s.id) return GATE_R_IDENTIFIER;
  if (s.direction == Direction::egress) {
    if (from != std::int64_t{s.source}) return GATE_R_SOURCE;
    if (from != 0 && !vouched(s, mark)) return GATE_R_SOURCE;
    if (from == 0 && s.uid != GATE_ANY_UID && s.uid != 0) return GATE_R_SOURCE;
  }
  if ((s.formats & f.format) == 0) return GATE_R_FORMAT;
  if (f.len > s.max_len) return GATE_R_LENGTH;
  return s.pass ? GATE_R_PASSED : GATE_R_DENIED;
}

/// Identifiers as they are: the key is all of them.
bool is_plain(std::uint32_t profile) {
  return profile == GATE_PROFILE_RAW || profile == GATE_PROFILE_CANOPEN;
}

/// The slot leaves part of the key open.
bool is_masked(std::uint32_t profile, const SlotSpec& s) {
  if (!is_plain(profile)) return false;
  const std::uint32_t whole = (s.id & CAN_EFF_FLAG) != 0 ? CAN_EFF_MASK : CAN_SFF_MASK;
  return (s.mask & whole) != whole;
}

/// The frame has what the mask covers of the slot's key.
bool fits_mask(const SlotSpec& s, std::uint32_t can_id) {
  return ((s.id ^ can_id) & s.mask & (CAN_EFF_FLAG | CAN_EFF_MASK)) == 0;
}

/// The latest slot is asked first; a passing one wins, then the one that came furthest. Slots with
/// a mask are asked when no slot has the frame's key.
void decide_by_key(const World& world, Direction direction, const Parsed& f, std::int64_t from,
                   std::uint32_t mark, Judgement& j) {
  j.reason = GATE_R_UNKNOWN;
  const auto name = key(world.profile, f.can_id);
  if (!name) return;
  for (const bool masked : {false, true}) {
    for (std::size_t i = world.slots.size(); i-- > 0;) {
      const auto& s = world.slots[i];
      if (s.direction != direction || is_masked(world.profile, s) != masked) continue;
      if (!masked && key(world.profile, s.id) != name) continue;
      if (is_plain(world.profile) && !fits_mask(s, f.can_id)) continue;
      if (is_elsewhere(world.profile, s, f)) continue;
      const auto reason = misfit(s, f, from, mark);
      if (reason == GATE_R_PASSED || reason > j.reason) {
        j.reason = reason;
        j.slot = i;
      }
      if (reason == GATE_R_PASSED) return;
    }
    if (j.reason != GATE_R_UNKNOWN) return;
  }
}

/// Random frames announce no message (their payload is 0): a packet is of none.
void decide(const World& world, Direction direction, const Parsed& f, std::int64_t from,
            std::uint32_t mark, Judgement& j) {
  constexpr std::uint32_t packet = 0xeb;
  decide_by_key(world, direction, f, from, mark, j);
  if (world.profile == GATE_PROFILE_J1939 && (f.can_id & CAN_EFF_FLAG) != 0 &&
      bits(f.can_id, 16, 25) == packet && j.reason != GATE_R_PASSED)
    j.reason = GATE_R_FRAGMENT;
}

Judgement refused(const World& world, gate_reason reason, std::uint32_t mark) {
  return {.outcome = {!world.audit, mark}, .reason = reason, .slot = {}, .bytes = 0};
}

/// At ingress: what audit mode passes has a mark of its own.
Judgement refused_in(const World& world, gate_reason reason) {
  return refused(world, reason, world.audit ? kReportedBefore : 0);
}

Judgement judge_ingress(const World& world, const Bytes& bytes, const Sender& sender) {
  const Judgement echo{.outcome = {false, 0}, .reason = GATE_R_ECHO, .slot = {}, .bytes = 0};
  if (sender.local || (world.echo_by_mark && sender.mark == ~kToken)) return echo;
  const auto f = sender.xl ? parse_xl(bytes, Direction::ingress) : parse(bytes, Direction::ingress);
  if (!f) return refused_in(world, GATE_R_MALFORMED);
  if ((f->can_id & CAN_ERR_FLAG) != 0)
    return {.outcome = {false, 0}, .reason = GATE_R_ERROR_IN, .slot = {}, .bytes = 0};
  if (!world.open || world.lapsed) return refused_in(world, GATE_R_CLOSED);
  Judgement j;
  decide(world, Direction::ingress, *f, kNobody, sender.mark, j);
  const bool pass = j.reason == GATE_R_PASSED;
  j.outcome =
      pass ? Outcome{false, gate_ingress_token(kToken, kIfindex, world.slots[*j.slot].origin)}
           : refused_in(world, j.reason).outcome;
  if (pass && (f->can_id & CAN_RTR_FLAG) == 0) j.bytes = f->len;
  return j;
}

Judgement judge_egress(const World& world, const Bytes& bytes, const Sender& sender) {
  const std::uint32_t mark = world.echo_by_mark ? ~kToken : 0;
  const auto f = sender.xl ? parse_xl(bytes, Direction::egress) : parse(bytes, Direction::egress);
  if (!f) return refused(world, GATE_R_MALFORMED, mark);
  if ((f->can_id & CAN_ERR_FLAG) != 0) return refused(world, GATE_R_ERROR_FRAME, mark);
  if (!world.open || world.lapsed) return refused(world, GATE_R_CLOSED, mark);
  Judgement j;
  decide(world, Direction::egress, *f, source(sender), sender.mark, j);
  j.outcome = {j.reason != GATE_R_PASSED && !world.audit, mark};
  if (j.reason == GATE_R_PASSED && (f->can_id & CAN_RTR_FLAG) == 0) j.bytes = f->len;
  return j;
}

}  // namespace

Judgement judge(const World& world, Direction direction, const Bytes& bytes, const Sender& sender) {
  if (direction == Direction::ingress) return judge_ingress(world, bytes, sender);
  const Judgement j = judge_egress(world, bytes, sender);
  const bool reported = world.audit && sender.mark == kReportedBefore && j.reason != GATE_R_PASSED;
  return reported ? Judgement{.outcome = j.outcome, .reason = GATE_R_ECHO, .slot = {}, .bytes = 0}
                  : j;
}

}  // namespace mlcca::test
