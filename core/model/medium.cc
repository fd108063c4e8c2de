// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/medium.hpp"

#include "core/can/frame.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca::core {
namespace {

/// Payload bytes of a frame that are the event's, when it is in one frame.
unsigned room(const Network& network, const Binding& binding) {
  const Fragmentation* const several = traits_of(network.profile).fragmentation;
  return frame_bytes(binding) - (several == nullptr ? 0 : several->tail);
}

}  // namespace

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
  const Fragmentation* const several = traits_of(network.profile).fragmentation;
  const unsigned most = frame_bytes(binding);
  return several == nullptr ? most : several->largest(most);
}

bool is_fragmented(const Network& network, const Binding* binding, Value bytes) {
  if (network.carries_subjects()) return bytes > kDatagramBytes;
  return traits_of(network.profile).fragmentation != nullptr && binding != nullptr &&
         bytes > room(network, *binding);
}

unsigned frames_per_event(const Network& network, const Binding* binding, Value bytes) {
  if (!is_fragmented(network, binding, bytes)) return 1;
  const ProfileTraits& traits = traits_of(network.profile);
  return network.carries_subjects() ? traits.datagrams(bytes)
                                    : traits.fragmentation->frames(bytes, frame_bytes(*binding));
}

}  // namespace mlcca::core
