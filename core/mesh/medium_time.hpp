// SPDX-License-Identifier: BSD-2-Clause
// Medium time: what a packet, an event and a flow take of the time of the medium that a link uses.
// Times are rounded up and rates down, so that a link never seems to carry more than it does.
#pragma once
#include <span>

#include "core/mesh/mesh.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::core::mesh {

/// ps of medium time in a second: all of it.
inline constexpr Value kFullTime = 1'000'000'000'000;

/// What a link carries in one direction.
struct LinkQuality {
  Value rate = 0;  ///< bit/s, 0: not known
  RateKind kind = RateKind::phy;
  Value loss = 0;           ///< 1e-9 of the packets, each sent again until it arrives
  bool loss_known = false;  ///< false: `loss` is 0 because it was not measured

  bool operator==(const LinkQuality&) const = default;
};

/// ps until a packet of so many payload bytes is through: (o + 8 (L + h) / R) / (1 - loss), the
/// airtime of 802.11s with the frame's own size. Overhead time o (Mesh::packet_time) and header h
/// count for PHY rates only. kUnbounded for a link without a rate or with certain loss.
[[nodiscard]] Value packet_time(const LinkQuality& link, const Mesh& mesh, Value payload_bytes);

/// ps for one event of so many bytes, in packets of at most Mesh::packet_bytes. An event of 0 bytes
/// is one packet without payload.
[[nodiscard]] Value event_time(const LinkQuality& link, const Mesh& mesh, Value event_bytes);

/// The size of the events that a flow is reckoned with: 0, not known, means packets that are full.
[[nodiscard]] constexpr Value reckoned_event(const Mesh& mesh, Value event_bytes) {
  if (event_bytes != 0) return event_bytes;
  return mesh.packet_bytes != 0 ? mesh.packet_bytes : 1;
}

/// ps in each second for `bytes_per_second` of payload in events of `event_bytes` (0: not known,
/// full packets). More than kFullTime: not even alone.
[[nodiscard]] Value medium_time(const LinkQuality& link, const Mesh& mesh, Value bytes_per_second,
                                Value event_bytes);

/// bit/s of links that take turns, 1/R = sum of 1/R_i: equation 1 of the paper (Schulze, Lukas,
/// ETFA 2009), rounded down. Exact for up to 16 rates; of more, each 16 are rounded down first,
/// which costs less than 2 bit/s. No rates, or one that is 0, give 0.
[[nodiscard]] Value paper_rate(std::span<const Value> rates_bit_s);

}  // namespace mlcca::core::mesh
