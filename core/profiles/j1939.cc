// SPDX-License-Identifier: BSD-2-Clause
// SAE J1939-21 identifiers: priority, PGN with the destination of PDU1 in its low byte, source.
#include <algorithm>

#include "base/number.hpp"
#include "core/model/medium.hpp"
#include "core/profiles/definition.hpp"
#include "core/profiles/layout.h"

namespace mlcca::core::profiles {
namespace {

constexpr std::uint32_t kDestinationBits = 0xffU << kNumberShift;
constexpr std::uint32_t kNumberBits = GATE_J1939_PDU1_KEY;

// SAE J1939-81 (address claim), J1939-21 (request, acknowledgement, transport), ISO 11783-3
// (extended transport). Priorities and destinations, if any, are open. An address is claimed
// towards all nodes, also from the null address.
constexpr std::uint32_t kSource = 0xff;
constexpr std::uint32_t kAnyTwo = kPriorityBits | kDestinationBits | kSource;
constexpr std::array kAddressClaim = {extended(0x00eeff00, kPriorityBits | kSource)};
constexpr std::array kRequest = {extended(0x00ea0000, kAnyTwo)};
constexpr std::array kAcknowledgement = {extended(0x00e80000, kAnyTwo)};
constexpr std::array kTransport = {extended(0x00ec0000, kAnyTwo), extended(0x00eb0000, kAnyTwo)};
constexpr std::array kExtendedTransport = {extended(0x00c80000, kAnyTwo),
                                           extended(0x00c70000, kAnyTwo)};
constexpr std::array kControl = {
    ControlKind{.name = "address-claim", .frames = kAddressClaim, .rate = 50, .burst = 256},
    ControlKind{.name = "request", .frames = kRequest, .rate = 100, .burst = 20},
    ControlKind{.name = "acknowledgement", .frames = kAcknowledgement, .rate = 100, .burst = 20},
    ControlKind{
        .name = "transport", .frames = kTransport, .rate = 500, .burst = 300, .is_carrier = true},
    ControlKind{.name = "extended-transport",
                .frames = kExtendedTransport,
                .rate = 500,
                .burst = 300,
                .is_carrier = true}};

/// Whether the PGN has a destination: PDU format below 240 (PDU1). Its low byte is 0.
constexpr bool has_destination(std::uint32_t pgn) {
  constexpr std::uint32_t pdu2 = 240;
  return (pgn >> 8 & 0xff) < pdu2;
}

bool contains_destination(const Binding& b) { return has_destination(b.id) && (b.id & 0xff) != 0; }

std::string problem(const Binding& b) {
  if (b.id > j1939.last) return "is too large: up to 262143 (0x3ffff)";
  if (contains_destination(b))
    return "is sent to an address, which is no part of it: write " + hexadecimal(b.id & ~0xffU) +
           ", with destination=\"" + hexadecimal(b.id & 0xff) + "\" where it is for that one alone";
  if (b.destination && !has_destination(b.id))
    return "is broadcast: remove attribute destination, which is for PGNs below 0xf000 of a data "
           "page";
  return {};
}

std::vector<std::string> problems(const Binding& b) {
  const auto text = problem(b);
  if (text.empty()) return {};
  return {"PGN " + std::to_string(b.id) + " (" + hexadecimal(b.id) + ") " + text};
}

std::string unlisted_problem(const Binding& b) {
  if (!contains_destination(b)) return {};
  return "PGN " + hexadecimal(b.id) +
         " is sent to an address, which is no part of it: " + hexadecimal(b.id & ~0xffU);
}

FrameIdentity identity(const Publisher& p, const Binding& b, bool /*fragmented*/) {
  FrameIdentity f = with_priority(p, b);
  if (b.destination)
    f.id |= static_cast<std::uint32_t>(*b.destination) << kNumberShift;
  else if (has_destination(b.id))
    f.mask &= ~kDestinationBits;
  return f;
}

std::optional<IdentifierParts> parts(std::uint32_t bits) {
  const std::uint32_t number = bits >> kNumberShift & j1939.last;
  IdentifierParts out{.number = number, .node = bits & kSource, .priority = bits >> kPriorityShift};
  if (has_destination(number)) {
    out.destination = number & 0xffU;
    out.number &= ~0xffU;
  }
  return out;
}

// The transport protocol (J1939-21, 5.10 and annex C): a broadcast announce message (TP.CM_BAM) and
// packets of 7 bytes (TP.DT), each 50 to 200 ms after the one before, all towards all nodes. A
// message to one address is requested by its receiver, whose frames no channel admits.
constexpr std::uint32_t kNumberAndDestination = 0x03ffff00;
constexpr std::uint32_t kConnectionManagement = 0x00ecff00;
constexpr std::uint32_t kDataTransfer = 0x00ebff00;
constexpr std::uint8_t kGlobalAddress = 0xff;
constexpr Value kPacket = 7;
constexpr Value kMessage = 1785;
constexpr Value kMillisecond = 1'000'000;

unsigned frames(Value bytes, unsigned /*mtu*/) {
  return static_cast<unsigned>(1 + (std::min(bytes, kMessage) + kPacket - 1) / kPacket);
}

Value largest(unsigned /*mtu*/) { return kMessage; }

/// The last packet is padded to full length.
unsigned last_frame(Value /*bytes*/, unsigned /*frames*/, unsigned mtu) { return mtu; }

std::string_view obstacle(const Binding& b) {
  if (b.format != FrameFormat::classic) return "the transport protocol is for classic frames";
  if (b.destination && *b.destination != kGlobalAddress)
    return "what is longer goes to an address by RTS and CTS, which no gate can judge: leave "
           "attribute destination out, or let it be 0xff";
  return {};
}

std::array<FrameIdentity, 2> carriers(const FrameIdentity& event) {
  const auto with = [&](std::uint32_t number) {
    return FrameIdentity{.id = (event.id & ~kNumberAndDestination) | number,
                         .mask = event.mask | kNumberAndDestination};
  };
  return {with(kConnectionManagement), with(kDataTransfer)};
}

constexpr Fragmentation kFragmentation{.reassembly = Reassembly::announced,
                                       .frames = frames,
                                       .largest = largest,
                                       .last_frame = last_frame,
                                       .room = "by the transport protocol",
                                       .obstacle = obstacle,
                                       .carriers = carriers,
                                       .least_pause = 50 * kMillisecond,
                                       .longest_pause = 200 * kMillisecond};

bool same(const Binding& a, const Binding& b) {
  return a.id == b.id && (!a.destination || !b.destination || a.destination == b.destination);
}

}  // namespace

constinit const ProfileTraits j1939{.element = "a PGN",
                                    .last = 0x3ffff,
                                    .last_node = 253,
                                    .nodes = "0 to 253 (254 and 255 are nobody's address)",
                                    .number_bits = kNumberBits,
                                    .destination_bits = kDestinationBits,
                                    .has_number_priority = true,
                                    .problems = problems,
                                    .unlisted_problem = unlisted_problem,
                                    .identity = identity,
                                    .overlap = same,
                                    .parts = parts,
                                    .number_text = {.stem = "pgn-"},
                                    .dbc_protocol = "J1939",
                                    .fragmentation = &kFragmentation,
                                    .control = kControl};

}  // namespace mlcca::core::profiles
