// SPDX-License-Identifier: BSD-2-Clause
#include "core/can/of_system.hpp"

#include <algorithm>

#include "core/model/medium.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca::core::can {
namespace {

/// The shortest and longest time (ns) of a frame with these payload bytes, in any format that the
/// binding allows.
struct Range {
  Time shortest = 0;
  Time longest = 0;
};
Range times_of(const Timing& timing, const Binding& binding, unsigned bytes) {
  if (binding.format == FrameFormat::xl) {
    const Time time = xl_frame_time(timing, bytes);
    return {time, time};
  }
  const Time classic = frame_time(timing, {.extended = binding.extended, .fd = false}, bytes);
  const Time fd = frame_time(timing, {.extended = binding.extended, .fd = true}, bytes);
  if (binding.format == FrameFormat::classic) return {classic, classic};
  if (binding.format == FrameFormat::fd) return {fd, fd};
  return {std::min(classic, fd), std::max(classic, fd)};
}

/// The first and last identifier that the frames may have.
Identifier range_of(const FrameIdentity& identity, const Binding& binding) {
  const std::uint32_t whole = binding.extended ? kExtendedBits : kStandardBits;
  const std::uint32_t first = identity.id & whole;
  return {.id = first, .last = first | (whole & ~identity.mask), .extended = binding.extended};
}

/// Extends the message to a transport protocol: events that fit one frame have the event's
/// identifier, others those of the protocol's frames.
void transport_in(const Fragmentation& transport, const Publisher& publisher,
                  const Network& network, const Binding& binding, Message& m) {
  const auto event = identity_of(publisher, network, binding, true);
  for (const FrameIdentity& carrier : transport.carriers(*event)) {
    const Identifier range = range_of(carrier, binding);
    m.lowest_priority =
        std::max({m.lowest_priority, m.priority, arbitration(range.last, range.extended)});
    m.priority = std::min(m.priority, arbitration(range.id, range.extended));
  }
  m.least_pause = transport.least_pause;
  m.sender = *publisher.node;
}

}  // namespace

std::optional<Identifier> identifier_of(const Publisher& publisher, const Network& network,
                                        const Binding& binding, bool fragmented) {
  const auto identity = identity_of(publisher, network, binding, fragmented);
  if (!identity) return std::nullopt;
  return range_of(*identity, binding);
}

std::optional<Message> message_of(const System& system, const Publisher& publisher, std::size_t set,
                                  std::size_t network, const Timing& timing) {
  const Network& medium = system.networks[network];
  const Binding* binding = medium.binding_of(publisher.channel);
  const AttributeSet& offered = attributes_in(publisher, set);
  if (medium.kind != NetworkKind::can || binding == nullptr || timing.bitrate == 0 ||
      !offered.has(Attribute::period) ||
      (binding->format != FrameFormat::classic && timing.data_bitrate == 0))
    return std::nullopt;
  const unsigned most = frame_bytes(*binding);
  const Value bytes = offered.has(Attribute::max_payload) ? offered[Attribute::max_payload] : most;
  Message m;
  m.frames = frames_per_event(medium, binding, bytes);
  const auto identifier = identifier_of(publisher, medium, *binding, m.frames > 1);
  if (!identifier) return std::nullopt;
  m.priority = arbitration(identifier->id, identifier->extended);
  if (identifier->last != identifier->id)
    m.lowest_priority = arbitration(identifier->last, identifier->extended);
  if (const auto* transport = transport_of(medium, binding, bytes))
    transport_in(*transport, publisher, medium, *binding, m);
  m.pauses = pauses_of(medium, binding, bytes);
  m.longest_frame = times_of(timing, *binding, frame_bytes(medium, *binding, bytes)).longest;
  m.last_frame = m.longest_frame;
  m.transmission = m.longest_frame * m.frames;
  if (m.frames > 1) {
    const Fragmentation& several = *fragmentation_of(medium, *binding);
    const unsigned rest = several.last_frame(bytes, m.frames, most);
    const Range last = times_of(timing, *binding, std::max(rest, 1U));
    m.last_frame = last.shortest;
    if (rest != 0) m.transmission -= m.longest_frame - last.longest;
  }
  m.period = offered[Attribute::period];
  m.deadline = m.period;
  m.jitter = offered.has(Attribute::jitter) ? offered[Attribute::jitter] : 0;
  return m;
}

Timing timing_of(const Network& network) {
  return {.bitrate = network.bus.bitrate, .data_bitrate = network.bus.data_bitrate};
}

Assumptions assumptions_of(const System& system, std::size_t network, const Timing& timing) {
  const CanBus& bus = system.networks[network].bus;
  Assumptions assumptions;
  assumptions.timing = timing;
  assumptions.fd_frames = timing.data_bitrate > 0;
  for (const Binding& binding : system.networks[network].bindings) {
    if (binding.format != FrameFormat::classic) assumptions.fd_frames = true;
    if (binding.format == FrameFormat::xl) assumptions.xl_frames = true;
  }
  assumptions.unknown_senders = bus.unknown_senders;
  assumptions.background = bus.background;
  assumptions.faults = bus.faults;
  for (const Gateway& gateway : system.gateways)
    if (const Port* port = gateway.port_on(network))
      assumptions.queues.push_back({.queueing = port->queueing,
                                    .fifo_depth = port->fifo_depth,
                                    .length = port->queue_length,
                                    .bands = kPrioBands});
  return assumptions;
}

}  // namespace mlcca::core::can
