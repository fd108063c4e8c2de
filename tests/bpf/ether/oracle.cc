// SPDX-License-Identifier: BSD-2-Clause
// Compares every slot with every packet; no hash, no chains, no early way out.
#include "tests/bpf/ether/oracle.hpp"

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::SlotSpec;

/// Nothing beyond the end.
std::optional<std::uint64_t> number(const Bytes& bytes, std::size_t at, std::size_t octets) {
  if (at + octets > bytes.size()) return std::nullopt;
  std::uint64_t out = 0;
  for (std::size_t i = 0; i < octets; ++i) out = out << 8 | bytes[at + i];
  return out;
}

bool is_tag(std::uint64_t type) { return type == 0x8100 || type == 0x88a8; }

bool comes_from(const SlotSpec& s, const Sender& sender) {
  if (s.direction == Direction::ingress) return true;
  if (sender.local) return s.source == 0 && (s.uid == GATE_ANY_UID || s.uid == 0);
  return s.source != 0 && s.source == sender.ingress_ifindex;
}

/// The gate of that interface has passed it as what the slot is for.
bool is_vouched_for(const SlotSpec& s, const Sender& sender) {
  if (s.direction == Direction::ingress || sender.local) return true;
  return sender.mark == gate_ingress_token(kToken, s.source, gate_origin(s.subject, s.station));
}

/// Of what a slot has passed.
std::uint32_t mark_of(Direction direction, const SlotSpec& s) {
  return direction == Direction::ingress
             ? gate_ingress_token(kToken, kIfindex, gate_origin(s.subject, s.station))
             : 0;
}

gate_reason misfit(const SlotSpec& s, std::uint64_t length, bool fragmented, const Sender& sender) {
  if (!comes_from(s, sender) || !is_vouched_for(s, sender)) return GATE_R_SOURCE;
  if ((s.formats & (fragmented ? ETHER_FRAGMENT : ETHER_UNFRAGMENTED)) == 0) return GATE_R_FORMAT;
  if (length > s.max_len) return GATE_R_LENGTH;
  return s.pass ? GATE_R_PASSED : GATE_R_DENIED;
}

}  // namespace

EtherWorld::Seen EtherWorld::parse(const Bytes& bytes) {
  std::size_t at = 12;
  bool inside = false;
  for (int frame = 0; frame < 2; ++frame) {
    auto type = number(bytes, at, 2);
    for (int tags = 0; type && is_tag(*type); ++tags) {
      if (tags == ETHER_TAGS) return {.kind = Kind::opaque};
      at += 4;
      type = number(bytes, at, 2);
    }
    if (!type) return {.kind = Kind::malformed};
    at += 2;
    if (*type == 0x0800) return look_at_ip(bytes, at, inside);
    if (*type != 0x8334 && *type != 0x4305) return {};
    if (inside) return {.kind = Kind::opaque};
    if (*type == 0x4305) {
      const auto [kind, frame_at] = look_at_batman(bytes, at);
      if (frame_at == 0) return {.kind = kind};
      inside = true;
      at = frame_at + 12;
      continue;
    }
    const auto kind = number(bytes, at, 1);
    if (!kind) return {.kind = Kind::malformed};
    const bool flood = (*kind & 3) == 1;
    if ((*kind & 3) == 0) return {};
    if ((*kind & 3) == 3) return {.kind = Kind::opaque};
    const std::size_t what = at + (flood ? 16 : 22);
    if (number(bytes, what, 1) != 98) return look_at_awds(bytes, at, what, inside);
    inside = true;
    at = what + 1 + 12;
  }
  return {.kind = Kind::opaque};
}

/// Where the Ethernet frame in a packet of batman-adv begins; 0 if it has none, and what that is
/// then.
std::pair<EtherWorld::Kind, std::size_t> EtherWorld::look_at_batman(const Bytes& bytes,
                                                                    std::size_t at) {
  const auto head = number(bytes, at, 2);
  if (!head) return {Kind::malformed, 0};
  if ((*head & 0xff) != 15) return {Kind::opaque, 0};
  switch (*head >> 8) {
    case 0x01:
      return {Kind::foreign, at + 14};
    case 0x40:
      return {Kind::foreign, at + 10};
    case 0x42:
      return {Kind::foreign, at + 18};
    case 0x00:
    case 0x03:
    case 0x04:
    case 0x43:
    case 0x44:
      return {Kind::foreign, 0};
    default:
      return {Kind::opaque, 0};
  }
}

EtherWorld::Seen EtherWorld::look_at_awds(const Bytes& bytes, std::size_t packet, std::size_t at,
                                          bool inside) {
  const auto kind = number(bytes, at, 1);
  if (!kind) return {.kind = Kind::malformed};
  for (const std::uint64_t own : {0, 42, 43, 44, 96, 97, 100, 0x7d, 0x81, 0x82})
    if (*kind == own) return {};
  if (*kind != 0x7b && *kind != 0x7c) return {.kind = Kind::opaque};
  const auto size = number(bytes, at + 2, 2);
  const auto subject = number(bytes, at + 4, 8);
  if (!size || !subject || *size < 8 || at + 4 + *size > bytes.size())
    return {.kind = Kind::malformed};
  return {.kind = Kind::event,
          .subject = *subject,
          .station = *number(bytes, packet + 1, 6) | ETHER_MAC,
          .length = *size - 8,
          .fragmented = *kind == 0x7b,
          .inside = inside};
}

EtherWorld::Seen EtherWorld::look_at_ip(const Bytes& bytes, std::size_t at, bool inside) {
  if (at + 20 > bytes.size()) return {.kind = Kind::malformed};
  if (bytes[at + 9] != 17) return {};
  const std::size_t header = std::size_t{4} * (bytes[at] & 15U);
  const std::size_t total = *number(bytes, at + 2, 2);
  if (bytes[at] >> 4U != 4 || header < 20 || total <= header || at + total > bytes.size())
    return {.kind = Kind::malformed};
  const std::uint64_t fragment = *number(bytes, at + 6, 2);
  Seen seen{.more = (fragment & 0x2000) != 0,
            .offset = 8 * (fragment & 0x1fff),
            .here = total - header,
            .inside = inside,
            .addresses = *number(bytes, at + 12, 8),
            .id = static_cast<std::uint16_t>(*number(bytes, at + 4, 2))};
  seen.kind = Kind::malformed;
  if ((seen.more && seen.here % 8 != 0) || seen.offset + seen.here > 65535) return seen;
  if (seen.offset != 0) {
    seen.kind = Kind::later;
    return seen;
  }
  const std::size_t udp = at + header;
  if (seen.here < 8) return seen;
  const auto port = *number(bytes, udp + 2, 2);
  if (port != 9999 && port != 8888) {
    seen.kind = seen.more ? Kind::foreign_first : Kind::foreign;
    return seen;
  }
  seen.whole = *number(bytes, udp + 4, 2);
  if (seen.more ? seen.whole <= seen.here : seen.whole != seen.here) return seen;
  if (seen.here < 17 || bytes[udp + 16] > 1) return seen;
  seen.subject = *number(bytes, udp + 8, 8);
  seen.station = seen.addresses >> 32;
  seen.length = seen.whole - 17;
  seen.fragmented = bytes[udp + 16] == 1;
  seen.kind = Kind::event;
  return seen;
}

Judgement EtherWorld::refused(gate_reason reason, std::optional<std::size_t> slot,
                              std::optional<std::uint32_t> mark) const {
  return {.dropped = !audit, .mark = mark, .reason = reason, .slot = slot, .counts_in_slot = true};
}

/// Slots of a station are asked first, then the wildcard, which a station that has one never
/// reaches; the latest before others. A passing one wins, then the one that came furthest.
std::pair<gate_reason, std::optional<std::size_t>> EtherWorld::decide(Direction direction,
                                                                      const Seen& seen,
                                                                      const Sender& sender) const {
  gate_reason best = GATE_R_UNKNOWN;
  std::optional<std::size_t> slot;
  bool known = false;
  for (const bool is_wildcard : {false, true})
    for (std::size_t i = slots.size(); i-- > 0;) {
      const SlotSpec& s = slots[i];
      if (s.formats == 0 || s.direction != direction || s.subject != seen.subject) continue;
      if (is_wildcard != (s.station == 0) || (is_wildcard && known)) continue;
      auto reason = misfit(s, seen.length, seen.fragmented, sender);
      const bool of_another = !is_wildcard && s.station != seen.station;
      if (of_another) reason = GATE_R_SOURCE;
      known = known || (!is_wildcard && !of_another && comes_from(s, sender));
      if (reason == GATE_R_PASSED) return {reason, i};
      if (reason <= best) continue;
      best = reason;
      slot = i;
    }
  return {best, slot};
}

Judgement EtherWorld::judge_event(Direction direction, const Seen& seen, const Sender& sender) {
  const Name name{direction, seen.addresses, seen.id, seen.inside};
  const auto known = fragments_.find(name);
  const auto give_up = [&](gate_reason reason, std::optional<std::size_t> slot = {}) {
    if (seen.more && known != fragments_.end() && known->second.event && reason != GATE_R_FRAGMENT)
      fragments_.erase(known);
    return refused(reason, slot, 0);
  };
  if (!open || lapsed) return give_up(GATE_R_CLOSED);
  if (sender.segment != 0) return give_up(GATE_R_MALFORMED);
  if (seen.more && known != fragments_.end() && !known->second.event)
    return give_up(GATE_R_FRAGMENT);
  const auto [reason, slot] = decide(direction, seen, sender);
  if (reason != GATE_R_PASSED) return give_up(reason, slot);
  if (seen.more) fragments_[name] = {true, seen.here, seen.whole, *slot, seen.whole - seen.here};
  return {.mark = mark_of(direction, slots[*slot]),
          .reason = GATE_R_PASSED,
          .slot = slot,
          .bytes = seen.length,
          .counts_in_slot = true};
}

Judgement EtherWorld::judge_later(Direction direction, const Seen& seen, const Sender& sender) {
  const auto known = fragments_.find({direction, seen.addresses, seen.id, seen.inside});
  if (known == fragments_.end()) return refused(GATE_R_FRAGMENT, {}, {});
  Remembered& first = known->second;
  if (first.event && (!open || lapsed)) return refused(GATE_R_CLOSED, {}, {});
  const std::size_t end = seen.offset + seen.here;
  if (seen.offset < first.first) return refused(GATE_R_MALFORMED, {}, {});
  if (!first.event) return {};
  if (seen.more ? end >= first.whole : end != first.whole) return refused(GATE_R_MALFORMED, {}, {});
  const SlotSpec& slot = slots[first.slot];
  if (slot.formats == 0 || !slot.pass) return refused(GATE_R_DENIED, {}, {});
  if (!comes_from(slot, sender) || !is_vouched_for(slot, sender))
    return refused(GATE_R_SOURCE, {}, {});
  if (seen.here > first.left) return refused(GATE_R_EXCESS, first.slot, {});
  first.left -= seen.here;
  return {.mark = mark_of(direction, slot),
          .reason = GATE_R_PASSED,
          .slot = {},
          .bytes = 0,
          .counts_in_slot = false};
}

/// Of what carries an event, or may: in audit mode it is reported where it is refused first.
Judgement EtherWorld::reported_once(Direction direction, const Sender& sender,
                                    Judgement judged) const {
  if (!audit || judged.reason == GATE_R_PASSED) return judged;
  if (direction == Direction::ingress) {
    judged.mark = gate_refused_token(kToken);
    return judged;
  }
  if (sender.mark != gate_refused_token(kToken)) return judged;
  return {.mark = 0, .reason = GATE_R_ECHO, .slot = {}};
}

Judgement EtherWorld::judge(Direction direction, const Bytes& bytes, const Sender& sender) {
  const Seen seen = parse(bytes);
  switch (seen.kind) {
    case Kind::foreign:
      return {};
    case Kind::foreign_first: {
      auto& known = fragments_[{direction, seen.addresses, seen.id, seen.inside}];
      if (known.event) return refused(GATE_R_FRAGMENT, {}, {});
      known = {false, seen.here, 0, 0, 0};
      return {};
    }
    case Kind::later:
      return judge_later(direction, seen, sender);
    case Kind::malformed:
      return reported_once(direction, sender, refused(GATE_R_MALFORMED, {}, 0));
    case Kind::opaque:
      return reported_once(direction, sender, refused(GATE_R_OPAQUE, {}, 0));
    case Kind::event:
      break;
  }
  return reported_once(direction, sender, judge_event(direction, seen, sender));
}

std::optional<Judgement> EtherWorld::judge_early(const Bytes& bytes) const {
  const Seen seen = parse(bytes);
  if (audit) return std::nullopt;
  if (seen.kind == Kind::malformed) return refused(GATE_R_MALFORMED, {}, {});
  if (seen.kind == Kind::opaque) return refused(GATE_R_OPAQUE, {}, {});
  if (seen.kind != Kind::event || seen.more) return std::nullopt;
  if (!open || lapsed) return refused(GATE_R_CLOSED, {}, {});
  const auto [reason, slot] = decide(Direction::ingress, seen, {});
  if (reason == GATE_R_PASSED) return std::nullopt;
  return refused(reason, slot, {});
}

}  // namespace mlcca::test
