// SPDX-License-Identifier: BSD-2-Clause
#include "core/medium.hpp"

#include <algorithm>

namespace mlcca::core {

unsigned frame_bytes(const Binding& binding) {
  return binding.format == FrameFormat::classic ? kClassicBytes : kFdBytes;
}

bool is_fragmented(const Network& network, const Binding* binding, Value bytes) {
  return network.profile == Profile::famouso && binding != nullptr && bytes > frame_bytes(*binding);
}

unsigned frames_per_event(const Network& network, const Binding* binding, Value bytes) {
  if (!is_fragmented(network, binding, bytes)) return 1;
  constexpr Value short_headers = 32;  // fragments whose count of followers fits in 5 bits
  const Value mtu = frame_bytes(*binding);
  const Value in_short = short_headers * (mtu - 1);
  if (bytes <= in_short) return static_cast<unsigned>((bytes + mtu - 2) / (mtu - 1));
  const Value rest = std::min(bytes, kFamousoMaxEvent * 8) - in_short;
  return static_cast<unsigned>(short_headers + (rest + mtu - 3) / (mtu - 2));
}

}  // namespace mlcca::core
