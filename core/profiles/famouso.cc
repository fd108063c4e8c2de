// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO on CAN: priority, fragment bit, node, and the etag that a broker assigns. On
// Ethernet-like networks datagrams carry the subject itself.
#include <algorithm>

#include "base/number.hpp"
#include "core/model/medium.hpp"
#include "core/profiles/definition.hpp"
#include "core/profiles/layout.h"

namespace mlcca::core::profiles {
namespace {

constexpr unsigned kNodeShift = 14;
constexpr std::uint32_t kTagBits = GATE_ETAG_MASK;
constexpr std::uint32_t kFragmentBit = 1U << 21U;
constexpr unsigned kTopShift = 22;  // of the priority

// All have priority 0x7d. The request of a stage has stage and nibble in the place of the node and
// the fragment bit; its answer keeps the top bit of the stage. Tags are assigned by node 0x7f.
constexpr std::uint32_t kNode = 0x1fc000;
constexpr std::uint32_t kStage = 0x3fc000;
constexpr std::array kConfiguration = {extended(0x1f400000, kStage),
                                       extended(0x1f400001, kStage, 0)};
constexpr ControlFrames asking_for_tag(ControlFrames frames) {
  frames.asks_for_tag = true;
  return frames;
}
constexpr std::array kBinding = {asking_for_tag(extended(0x1f400002, kNode)),
                                 extended(0x1f5fc004, 0)};
constexpr ControlFrames of_subscriptions(ControlFrames frames) {
  frames.of_subscriptions = true;
  return frames;
}
// What a plain FAMOUSO node sends fits one frame; a message with attributes is fragmented.
constexpr std::array kSubscribe = {
    extended(0x1f400000, kNode | kTagBits),
    of_subscriptions(extended(0x1f400000 | kFragmentBit, kNode | kTagBits))};
// A node subscribes all its channels at once when it starts.
constexpr ControlKind kSubscribing{
    .name = "subscribe", .frames = kSubscribe, .rate = 100, .burst = 100, .is_tagged = true};
constexpr std::array kControl = {
    ControlKind{.name = "configuration", .frames = kConfiguration, .rate = 200, .burst = 32},
    ControlKind{.name = "binding", .frames = kBinding, .rate = 200, .burst = 32}, kSubscribing};
// If frames carry the subject itself, nothing is configured or bound.
constexpr std::array kDatagramControl = {kSubscribing};

std::vector<std::string> problems(const Binding& b) {
  if (b.id >= famouso.first && b.id <= famouso.last) return {};
  return {"ETag " + hexadecimal(b.id) +
          " is not right: 0x64 to 0x3fff (the smaller ones are the protocol's own)"};
}

/// While the etag is unknown, its bits are open.
FrameIdentity identity(const Publisher& p, const Binding& b, bool fragmented) {
  const std::uint32_t known = b.waits_for_tag() ? kExtendedBits & ~kTagBits : kExtendedBits;
  return {
      .id = static_cast<std::uint32_t>(p.priority) << kTopShift |
            static_cast<std::uint32_t>(*p.node) << kNodeShift | b.id,
      // Events up to the published size may be fragmented or not: both forms of the frame occur.
      .mask = fragmented ? known & ~kFragmentBit : known};
}

/// Tags below the first one are for management.
std::optional<IdentifierParts> parts(std::uint32_t bits) {
  const std::uint32_t tag = bits & kTagBits;
  if (tag < famouso.first) return std::nullopt;
  return IdentifierParts{.number = tag,
                         .node = bits >> kNodeShift & 0x7fU,
                         .priority = bits >> kTopShift & 0x7fU,
                         .is_fragment = (bits & kFragmentBit) != 0};
}

// Fragments have a header of one byte while the count of followers fits 5 bits, otherwise of two.
// All but the last are full; beyond those 32, the analysis does not rely on which one is short.
constexpr unsigned kShortHeaders = 32;

unsigned frames(Value bytes, unsigned mtu) {
  const Value in_short = Value{kShortHeaders} * (mtu - 1);
  if (bytes <= in_short) return static_cast<unsigned>((bytes + mtu - 2) / (mtu - 1));
  const Value rest = std::min(bytes, kFamousoMaxEvent * 8) - in_short;
  return static_cast<unsigned>(kShortHeaders + (rest + mtu - 3) / (mtu - 2));
}

Value largest(unsigned /*mtu*/) { return kFamousoMaxEvent; }

unsigned last_frame(Value bytes, unsigned count, unsigned mtu) {
  if (count > kShortHeaders) return 0;
  return static_cast<unsigned>(bytes - Value{count - 1} * (mtu - 1)) + 1;
}

constexpr Fragmentation kFragmentation{.reassembly = Reassembly::counted,
                                       .frames = frames,
                                       .largest = largest,
                                       .last_frame = last_frame,
                                       .room = "in 4096 fragments"};

unsigned datagrams(Value bytes) {
  constexpr Value headers = 6;
  constexpr Value chunk = kDatagramBytes - headers;
  return static_cast<unsigned>((std::min(bytes, kDatagramMaxEvent) + chunk - 1) / chunk);
}

}  // namespace

constinit const ProfileTraits famouso{.element = "an ETag",
                                      .first = 0x64,
                                      .last = kTagBits,
                                      .last_node = 126,
                                      .nodes = "0 to 126 (127 is the broker's)",
                                      .deals_tags = true,
                                      .has_sender_priority = true,
                                      .problems = problems,
                                      .identity = identity,
                                      .overlap = overlap,
                                      .parts = parts,
                                      .number_text = {.digits = 3, .stem = "etag-"},
                                      .fragmentation = &kFragmentation,
                                      .control = kControl,
                                      .datagrams = datagrams,
                                      .datagram_control = kDatagramControl};

}  // namespace mlcca::core::profiles
