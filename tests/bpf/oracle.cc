// SPDX-License-Identifier: BSD-2-Clause
// Looks at every slot for every frame: no buckets, no chains, no early way out.
#include "bpf/oracle.hpp"

#include <cstring>

namespace mlcca::test {
namespace {

using enforce::Direction;
using enforce::SlotSpec;

struct Parsed {
  std::uint32_t can_id = 0;
  unsigned len = 0;
  bool fd = false;
};

/// At ingress up to 32 bytes, a multiple of 8, may stand in front of the frame.
bool is_frame(std::size_t size, std::size_t mtu, Direction direction) {
  if (size == mtu) return true;
  return direction == Direction::ingress && size > mtu && size <= mtu + 32 && (size - mtu) % 8 == 0;
}

std::optional<Parsed> parse(const Bytes& bytes, Direction direction) {
  Parsed f;
  f.fd = is_frame(bytes.size(), CANFD_MTU, direction);
  if (!f.fd && !is_frame(bytes.size(), CAN_MTU, direction)) return std::nullopt;
  const auto* const start = bytes.data() + bytes.size() - (f.fd ? CANFD_MTU : CAN_MTU);
  std::memcpy(&f.can_id, start, 4);
  f.len = start[4];
  if (f.len > (f.fd ? 64U : 8U)) return std::nullopt;
  return f;
}

bool same_key(std::uint32_t profile, std::uint32_t a, std::uint32_t b) {
  const bool extended = (a & CAN_EFF_FLAG) != 0;
  if (extended != ((b & CAN_EFF_FLAG) != 0)) return false;
  if (profile == GATE_PROFILE_FAMOUSO) return extended && (a & 0x3fff) == (b & 0x3fff);
  return profile == GATE_PROFILE_RAW && (a & CAN_EFF_MASK) == (b & CAN_EFF_MASK);
}

constexpr std::int64_t kNobody = -1;

std::int64_t source(const Sender& sender) {
  if (sender.local) return 0;
  return sender.ingress_ifindex != 0 ? sender.ingress_ifindex : kNobody;
}

/// The mark says that the interface of the slot has passed the frame as the slot's subject.
bool vouched(const SlotSpec& s, std::uint32_t mark) {
  return s.source != 0 && mark == gate_ingress_token(kToken, s.source, s.subject);
}

gate_reason misfit(const SlotSpec& s, const Parsed& f, std::int64_t from, std::uint32_t mark) {
  if ((f.can_id & s.mask) != s.id) return GATE_R_IDENTIFIER;
  if (s.direction == Direction::egress) {
    if (from != std::int64_t{s.source}) return GATE_R_SOURCE;
    if (from != 0 && !vouched(s, mark)) return GATE_R_SOURCE;
    if (from == 0 && s.uid != GATE_ANY_UID && s.uid != 0) return GATE_R_SOURCE;
  }
  if ((s.formats & (f.fd ? GATE_FD : GATE_CLASSIC)) == 0) return GATE_R_FORMAT;
  if (f.len > s.max_len) return GATE_R_LENGTH;
  return s.pass ? GATE_R_PASSED : GATE_R_DENIED;
}

/// The latest slot is asked first; a passing one wins, then the one that came furthest.
void decide(const World& world, Direction direction, const Parsed& f, std::int64_t from,
            std::uint32_t mark, Judgement& j) {
  j.reason = GATE_R_UNKNOWN;
  for (std::size_t i = world.slots.size(); i-- > 0;) {
    const auto& s = world.slots[i];
    if (s.direction != direction || !same_key(world.profile, s.id, f.can_id)) continue;
    const auto reason = misfit(s, f, from, mark);
    if (reason == GATE_R_PASSED || reason > j.reason) {
      j.reason = reason;
      j.slot = i;
    }
    if (reason == GATE_R_PASSED) return;
  }
}

Judgement refused(const World& world, gate_reason reason, std::uint32_t mark) {
  return {.outcome = {!world.audit, mark}, .reason = reason, .slot = {}, .bytes = 0};
}

Judgement judge_ingress(const World& world, const Bytes& bytes, const Sender& sender) {
  const Judgement echo{.outcome = {false, 0}, .reason = GATE_R_ECHO, .slot = {}, .bytes = 0};
  if (sender.local || (world.echo_by_mark && sender.mark == ~kToken)) return echo;
  const auto f = parse(bytes, Direction::ingress);
  if (!f) return refused(world, GATE_R_MALFORMED, 0);
  if ((f->can_id & CAN_ERR_FLAG) != 0)
    return {.outcome = {false, 0}, .reason = GATE_R_ERROR_IN, .slot = {}, .bytes = 0};
  if (!world.open || world.lapsed) return refused(world, GATE_R_CLOSED, 0);
  Judgement j;
  decide(world, Direction::ingress, *f, kNobody, sender.mark, j);
  const bool pass = j.reason == GATE_R_PASSED;
  j.outcome = {!pass && !world.audit,
               pass ? gate_ingress_token(kToken, kIfindex, world.slots[*j.slot].subject) : 0};
  if (pass && (f->can_id & CAN_RTR_FLAG) == 0) j.bytes = f->len;
  return j;
}

Judgement judge_egress(const World& world, const Bytes& bytes, const Sender& sender) {
  const std::uint32_t mark = world.echo_by_mark ? ~kToken : 0;
  const auto f = parse(bytes, Direction::egress);
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
  return direction == Direction::ingress ? judge_ingress(world, bytes, sender)
                                         : judge_egress(world, bytes, sender);
}

}  // namespace mlcca::test
