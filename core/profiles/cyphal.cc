// SPDX-License-Identifier: BSD-2-Clause
// Cyphal/CAN 1.0 identifiers: priority, service, anonymous, reserved, two bits that receivers
// ignore, subject-id, reserved, source.
#include <algorithm>

#include "core/model/medium.hpp"
#include "core/profiles/definition.hpp"
#include "core/profiles/layout.h"

namespace mlcca::core::profiles {
namespace {

// The last byte of each frame is the tail byte, and a transfer of several frames ends with a CRC.
constexpr unsigned kTail = 1;
constexpr unsigned kCrc = 2;
constexpr std::uint32_t kIgnoredBits = 3U << 21U;
constexpr std::uint32_t kNumberBits = GATE_CYPHAL_KEY;

// Cyphal Specification v1.0, 5.3: the heartbeat (7509) of every node once a second, and the
// allocation of node-ids (8165, 8166), which is requested anonymously. Services (such as GetInfo)
// are no messages.
constexpr std::uint32_t kAnyNode = kPriorityBits | kIgnoredBits | 0x7f;
constexpr std::uint32_t kAnonymous = 0x1000000;
constexpr std::array kHeartbeat = {extended(7509U << kNumberShift, kAnyNode)};
constexpr std::array kAllocation = {extended(8165U << kNumberShift, kAnyNode | kAnonymous, 64),
                                    extended(8166U << kNumberShift, kAnyNode | kAnonymous)};
constexpr std::array kControl = {
    ControlKind{.name = "heartbeat", .frames = kHeartbeat, .rate = 200, .burst = 128},
    ControlKind{.name = "allocation", .frames = kAllocation, .rate = 20, .burst = 10}};

std::vector<std::string> problems(const Binding& b) {
  if (b.id <= cyphal.last) return {};
  return {"SubjectID " + std::to_string(b.id) + " is too large: up to 8191"};
}

FrameIdentity identity(const Publisher& p, const Binding& b, bool /*fragmented*/) {
  FrameIdentity f = with_priority(p, b);
  f.mask &= ~kIgnoredBits;
  return f;
}

/// Identifiers of services and of anonymous nodes name no channel.
std::optional<IdentifierParts> parts(std::uint32_t bits) {
  constexpr std::uint32_t service = 1U << 25U;
  if ((bits & (service | kAnonymous)) != 0) return std::nullopt;
  return IdentifierParts{.number = bits >> kNumberShift & cyphal.last,
                         .node = bits & 0x7fU,
                         .priority = bits >> kPriorityShift};
}

unsigned frames(Value bytes, unsigned mtu) {
  const Value chunk = mtu - kTail;
  const Value most = kMaxFrames * chunk;
  return static_cast<unsigned>((std::min(bytes, most) + kCrc + chunk - 1) / chunk);
}

Value largest(unsigned mtu) { return Value{kMaxFrames} * (mtu - kTail) - kCrc; }

unsigned last_frame(Value bytes, unsigned count, unsigned mtu) {
  const Value chunk = mtu - kTail;
  return static_cast<unsigned>(bytes + kCrc - (count - 1) * chunk) + kTail;
}

constexpr Fragmentation kFragmentation{.reassembly = Reassembly::marked,
                                       .tail = kTail,
                                       .frames = frames,
                                       .largest = largest,
                                       .last_frame = last_frame,
                                       .room = "in 4096 frames"};

}  // namespace

constinit const ProfileTraits cyphal{.element = "a SubjectID",
                                     .last = 8191,
                                     .last_node = 127,
                                     .nodes = "0 to 127",
                                     .number_bits = kNumberBits,
                                     .has_number_priority = true,
                                     .problems = problems,
                                     .identity = identity,
                                     .overlap = overlap,
                                     .parts = parts,
                                     .number_text = {.decimal = true, .stem = "subject-"},
                                     .fragmentation = &kFragmentation,
                                     .control = kControl};

}  // namespace mlcca::core::profiles
