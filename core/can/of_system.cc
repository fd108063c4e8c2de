// SPDX-License-Identifier: BSD-2-Clause
#include "core/can/of_system.hpp"

#include <algorithm>

#include "core/medium.hpp"

namespace mlcca::core::can {
namespace {

// FAMOUSO's 29-bit identifier: priority, fragment bit, node, etag.
constexpr unsigned kNodeShift = 14;
constexpr std::uint32_t kFragmentBit = 1U << 21U;
constexpr unsigned kPriorityShift = 22;
constexpr unsigned kShortHeaders = 32;  // fragments of an event whose headers are all of one byte

/// Longest frame with these payload bytes in any format that the binding allows.
Time longest_of(const Timing& timing, const Binding& binding, bool extended, unsigned bytes) {
  Time longest = 0;
  if (binding.format != FrameFormat::fd)
    longest = frame_time(timing, {.extended = extended, .fd = false}, bytes);
  if (binding.format != FrameFormat::classic)
    longest = std::max(longest, frame_time(timing, {.extended = extended, .fd = true}, bytes));
  return longest;
}

/// Shortest frame with these payload bytes in any format that the binding allows.
Time shortest_of(const Timing& timing, const Binding& binding, bool extended, unsigned bytes) {
  Time shortest = kNever;
  if (binding.format != FrameFormat::fd)
    shortest = frame_time(timing, {.extended = extended, .fd = false}, bytes);
  if (binding.format != FrameFormat::classic)
    shortest = std::min(shortest, frame_time(timing, {.extended = extended, .fd = true}, bytes));
  return shortest;
}

}  // namespace

Identifier identifier_of(const Publisher& publisher, const Network& network,
                         const Binding& binding) {
  if (network.profile != Profile::famouso) return {.id = binding.id, .extended = binding.extended};
  return {.id = static_cast<std::uint32_t>(publisher.priority) << kPriorityShift |
                static_cast<std::uint32_t>(publisher.node.value_or(0)) << kNodeShift | binding.id,
          .extended = true};
}

std::optional<Message> message_of(const System& system, const Publisher& publisher, std::size_t set,
                                  std::size_t network, const Timing& timing) {
  const Network& medium = system.networks[network];
  const Binding* binding = medium.binding_of(publisher.channel);
  const AttributeSet& offered = attributes_in(publisher, set);
  if (medium.kind != NetworkKind::can || binding == nullptr || timing.bitrate == 0 ||
      !offered.has(Attribute::period))
    return std::nullopt;
  const bool famouso = medium.profile == Profile::famouso;
  if (medium.profile == Profile::none || (famouso && !publisher.node)) return std::nullopt;
  const unsigned most = frame_bytes(*binding);
  const Value bytes = offered.has(Attribute::max_payload) ? offered[Attribute::max_payload] : most;

  Message m;
  m.frames = frames_per_event(medium, binding, bytes);
  const auto [id, extended] = identifier_of(publisher, medium, *binding);
  m.priority = arbitration(id, extended);
  // An event that fits one frame is not split, so both identifiers occur.
  if (m.frames > 1) m.lowest_priority = arbitration(id | kFragmentBit, extended);
  const auto in_frame = static_cast<unsigned>(std::min<Value>(bytes, most));
  m.longest_frame = longest_of(timing, *binding, extended, in_frame);
  m.last_frame = m.longest_frame;
  m.transmission = m.longest_frame * m.frames;
  if (m.frames > 1) {
    // All fragments but the last are full; which one is short beyond 32 of them is not relied on.
    const unsigned chunk = most - 1;
    const auto rest = m.frames <= kShortHeaders
                          ? static_cast<unsigned>(bytes - (m.frames - 1) * Value{chunk})
                          : 0;
    m.last_frame = shortest_of(timing, *binding, extended, rest + 1);
    if (m.frames <= kShortHeaders)
      m.transmission -= m.longest_frame - longest_of(timing, *binding, extended, rest + 1);
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
  for (const Binding& binding : system.networks[network].bindings)
    if (binding.format != FrameFormat::classic) assumptions.fd_frames = true;
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
