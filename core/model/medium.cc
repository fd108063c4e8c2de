// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/medium.hpp"

#include "core/can/frame.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca::core {
namespace {

/// Payload bytes of the event in a frame that carries it unfragmented.
unsigned room(const Network& network, const Binding& binding) {
  const Fragmentation* const several = fragmentation_of(network, binding);
  return frame_bytes(binding) - (several == nullptr ? 0 : several->tail);
}

}  // namespace

const Fragmentation* fragmentation_of(const Network& network, const Binding& binding) {
  const Fragmentation* const several = traits_of(network.profile).fragmentation;
  if (several == nullptr || several->obstacle == nullptr) return several;
  return several->obstacle(binding).empty() ? several : nullptr;
}

const Fragmentation* transport_of(const Network& network, const Binding* binding, Value bytes) {
  if (network.carries_subjects() || !is_fragmented(network, binding, bytes)) return nullptr;
  const Fragmentation* const several = fragmentation_of(network, *binding);
  return several->carriers == nullptr ? nullptr : several;
}

Value pauses_of(const Network& network, const Binding* binding, Value bytes) {
  const Fragmentation* const transport = transport_of(network, binding, bytes);
  if (transport == nullptr) return 0;
  return (frames_per_event(network, binding, bytes) - 1) * transport->longest_pause;
}

unsigned frame_bytes(const Binding& binding) {
  if (binding.format == FrameFormat::xl) return kXlBytes;
  return binding.format == FrameFormat::classic ? kClassicBytes : kFdBytes;
}

unsigned frame_bytes(const Network& network, const Binding& binding, Value bytes) {
  const unsigned most = frame_bytes(binding);
  if (bytes >= most || is_fragmented(network, &binding, bytes)) return most;
  const auto used = static_cast<unsigned>(bytes) + most - room(network, binding);
  const bool fd = binding.format == FrameFormat::fd || binding.format == FrameFormat::any;
  return fd ? can::fd_size(used) : used;
}

Value event_bytes(const Network& network, const Binding& binding) {
  const Fragmentation* const several = fragmentation_of(network, binding);
  const unsigned most = frame_bytes(binding);
  return several == nullptr ? most : several->largest(most);
}

Value event_bytes(const Network& network) {
  return network.kind == NetworkKind::ieee802154 ? kWpanBytes : kDatagramMaxEvent;
}

unsigned datagram_bytes(const Network& network) {
  return network.kind == NetworkKind::ieee802154 ? kWpanBytes : kDatagramBytes;
}

bool is_fragmented(const Network& network, const Binding* binding, Value bytes) {
  if (network.carries_subjects())
    return bytes > datagram_bytes(network) && event_bytes(network) > datagram_bytes(network);
  return binding != nullptr && fragmentation_of(network, *binding) != nullptr &&
         bytes > room(network, *binding);
}

unsigned frames_per_event(const Network& network, const Binding* binding, Value bytes) {
  if (!is_fragmented(network, binding, bytes)) return 1;
  const ProfileTraits& traits = traits_of(network.profile);
  return network.carries_subjects() ? traits.datagrams(bytes)
                                    : traits.fragmentation->frames(bytes, frame_bytes(*binding));
}

}  // namespace mlcca::core
