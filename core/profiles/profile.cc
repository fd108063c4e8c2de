// SPDX-License-Identifier: BSD-2-Clause
#include "core/profiles/profile.hpp"

#include <array>

namespace mlcca::core {
namespace {

// FAMOUSO's 29-bit identifier: priority, fragment bit, node, etag.
constexpr unsigned kFamousoNodeShift = 14;
constexpr std::uint32_t kTagBits = 0x3fff;
constexpr std::uint32_t kFragmentBit = 1U << 21U;
constexpr unsigned kFamousoPriorityShift = 22;

// J1939-21: priority, PGN with the destination of PDU1 in its low byte, source.
// Cyphal/CAN 1.0: priority, service, anonymous, reserved, two bits that receivers ignore,
// subject-id, reserved, source.
constexpr unsigned kPriorityShift = 26;
constexpr std::uint32_t kPriorityBits = 7U << kPriorityShift;
constexpr unsigned kNumberShift = 8;
constexpr std::uint32_t kDestinationBits = 0xffU << kNumberShift;
constexpr std::uint32_t kIgnoredBits = 3U << 21U;

constexpr std::array<ProfileTraits, 6> kTraits{{
    {.element = "nothing"},
    {.element = "an Identifier", .last = kExtendedBits, .remote_frames = true, .xl = true},
    {.element = "an ETag", .first = 0x64, .last = 0x3fff, .last_node = 126},
    {.element = "a PGN", .last = 0x3ffff, .last_node = 253},
    {.element = "a SubjectID", .last = 8191, .last_node = 127},
    {.element = "a COBID", .last = kStandardBits, .remote_frames = true},
}};

/// As long as the etag is not known, it may be any.
FrameIdentity famouso(const Publisher& p, const Binding& b, bool fragmented) {
  const std::uint32_t known = b.waits_for_tag() ? kExtendedBits & ~kTagBits : kExtendedBits;
  return {
      .id = static_cast<std::uint32_t>(p.priority) << kFamousoPriorityShift |
            static_cast<std::uint32_t>(*p.node) << kFamousoNodeShift | b.id,
      // Events up to the published size may be fragmented or not: both forms of the frame occur.
      .mask = fragmented ? known & ~kFragmentBit : known};
}

FrameIdentity with_priority(const Publisher& p, const Binding& b) {
  FrameIdentity f{.id = b.id << kNumberShift | *p.node, .mask = kExtendedBits};
  if (b.priority)
    f.id |= static_cast<std::uint32_t>(*b.priority) << kPriorityShift;
  else
    f.mask &= ~kPriorityBits;
  return f;
}

FrameIdentity j1939(const Publisher& p, const Binding& b) {
  FrameIdentity f = with_priority(p, b);
  if (b.destination)
    f.id |= static_cast<std::uint32_t>(*b.destination) << kNumberShift;
  else if (has_destination(b.id))
    f.mask &= ~kDestinationBits;
  return f;
}

FrameIdentity cyphal(const Publisher& p, const Binding& b) {
  FrameIdentity f = with_priority(p, b);
  f.mask &= ~kIgnoredBits;
  return f;
}

/// Of an 11-bit identifier all 29 bits count: those that a standard frame does not have must be 0.
FrameIdentity plain(const Binding& b) {
  return {.id = b.id,
          .mask = b.extended ? b.mask & kExtendedBits : b.mask | (kExtendedBits & ~kStandardBits)};
}

}  // namespace

const ProfileTraits& traits_of(Profile profile) {
  return kTraits.at(static_cast<std::size_t>(profile));
}

bool can_send(const Publisher& publisher, const Network& network) {
  if (!has_nodes(network.profile)) return true;
  return publisher.node && *publisher.node <= traits_of(network.profile).last_node;
}

std::optional<Sender> sender_of(const System& system, const Publisher& publisher) {
  const Sender local{.channel = publisher.channel,
                     .place = publisher.place,
                     .node = publisher.node,
                     .uid = publisher.uid};
  if (publisher.place.kind == Place::Kind::gateway)
    return publisher.uid ? std::optional(local) : std::nullopt;
  const Network& network = system.networks[publisher.place.index];
  if (network.profile == Profile::none) return std::nullopt;
  if (has_nodes(network.profile)) return publisher.node ? std::optional(local) : std::nullopt;
  // No frame there names a node: one that is stated is for networks further on.
  Sender anonymous = local;
  anonymous.node = std::nullopt;
  return anonymous;
}

std::string_view way_to_differ(const Publisher& publisher) {
  if (publisher.place.kind == Place::Kind::gateway) return "another user or node is needed";
  return publisher.node ? "every publisher has a node of its own"
                        : "an identifier has one sender on a bus";
}

std::optional<FrameIdentity> identity_of(const Publisher& publisher, const Network& network,
                                         const Binding& binding, bool fragmented) {
  if (network.profile == Profile::none || !can_send(publisher, network)) return std::nullopt;
  FrameIdentity f;
  switch (network.profile) {
    case Profile::famouso:
      f = famouso(publisher, binding, fragmented);
      break;
    case Profile::j1939:
      f = j1939(publisher, binding);
      break;
    case Profile::cyphal:
      f = cyphal(publisher, binding);
      break;
    default:
      f = plain(binding);
      break;
  }
  if (binding.extended) f.id |= kExtendedFlag;
  f.mask |= kExtendedFlag;
  return f;
}

bool clash(Profile profile, const Binding& a, const Binding& b) {
  if (a.extended != b.extended) return false;
  if (profile == Profile::j1939)
    return a.id == b.id && (!a.destination || !b.destination || a.destination == b.destination);
  return ((a.id ^ b.id) & a.mask & b.mask) == 0;
}

}  // namespace mlcca::core
