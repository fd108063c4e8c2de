// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/medium.hpp"

#include <algorithm>

#include "core/can/frame.hpp"

namespace mlcca::core {
namespace {

/// Payload bytes of a frame that are the event's, when it is in one frame.
unsigned room(const Network& network, const Binding& binding) {
  return frame_bytes(binding) - (network.profile == Profile::cyphal ? kCyphalTail : 0);
}

unsigned famouso_frames(Value bytes, Value mtu) {
  constexpr Value short_headers = 32;  // fragments whose count of followers fits in 5 bits
  const Value in_short = short_headers * (mtu - 1);
  if (bytes <= in_short) return static_cast<unsigned>((bytes + mtu - 2) / (mtu - 1));
  const Value rest = std::min(bytes, kFamousoMaxEvent * 8) - in_short;
  return static_cast<unsigned>(short_headers + (rest + mtu - 3) / (mtu - 2));
}

unsigned datagrams(Value bytes) {
  constexpr Value headers = 6;
  constexpr Value chunk = kDatagramBytes - headers;
  return static_cast<unsigned>((std::min(bytes, kDatagramMaxEvent) + chunk - 1) / chunk);
}

unsigned cyphal_frames(Value bytes, Value mtu) {
  const Value chunk = mtu - kCyphalTail;
  const Value most = kMaxFrames * chunk;
  return static_cast<unsigned>((std::min(bytes, most) + kCyphalCrc + chunk - 1) / chunk);
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
  if (network.profile == Profile::famouso) return kFamousoMaxEvent;
  if (network.profile == Profile::cyphal)
    return Value{kMaxFrames} * (frame_bytes(binding) - kCyphalTail) - kCyphalCrc;
  return frame_bytes(binding);
}

bool is_fragmented(const Network& network, const Binding* binding, Value bytes) {
  if (network.carries_subjects()) return bytes > kDatagramBytes;
  const bool fragments = network.profile == Profile::famouso || network.profile == Profile::cyphal;
  return fragments && binding != nullptr && bytes > room(network, *binding);
}

unsigned frames_per_event(const Network& network, const Binding* binding, Value bytes) {
  if (!is_fragmented(network, binding, bytes)) return 1;
  if (network.carries_subjects()) return datagrams(bytes);
  const Value mtu = frame_bytes(*binding);
  return network.profile == Profile::cyphal ? cyphal_frames(bytes, mtu)
                                            : famouso_frames(bytes, mtu);
}

}  // namespace mlcca::core
