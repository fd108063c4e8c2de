// SPDX-License-Identifier: BSD-2-Clause
// Medium time: the time of the medium that a packet, an event and a flow take on a link. Times are
// rounded up and rates down, so that a link never seems to carry more than it does.
#pragma once
#include <span>

#include "core/mesh/mesh.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::core::mesh {

/// The ps of medium time in one second.
inline constexpr Value kFullTime = 1'000'000'000'000;

/// What a link carries in one direction.
struct LinkQuality {
  Value rate = 0;  ///< bit/s; 0: not known
  RateKind kind = RateKind::phy;
  Value loss = 0;           ///< share of packets lost, in 1e-9; each is sent again until it arrives
  bool loss_known = false;  ///< if false, `loss` is 0 because it was not measured

  bool operator==(const LinkQuality&) const = default;
};

/// The ps that a packet with so much payload takes: (o + 8 (L + h) / R) / (1 - loss), the airtime
/// of IEEE 802.11s with the packet's own size. Overhead time o (Mesh::packet_time) and header h
/// count for PHY rates only. kUnbounded for a link without a rate or with a loss of 100 %.
[[nodiscard]] Value packet_time(const LinkQuality& link, const Mesh& mesh, Value payload_bytes);

/// The ps for one event, sent in packets of at most Mesh::packet_bytes. An event of 0 bytes is one
/// packet without payload.
[[nodiscard]] Value event_time(const LinkQuality& link, const Mesh& mesh, Value event_bytes);

/// The event size that is used in computations: a size of 0 (not known) counts as one full packet.
[[nodiscard]] constexpr Value reckoned_event(const Mesh& mesh, Value event_bytes) {
  if (event_bytes != 0) return event_bytes;
  return mesh.packet_bytes != 0 ? mesh.packet_bytes : 1;
}

/// The ps per second for a flow of `bytes_per_second` of payload in events of `event_bytes` (0: not
/// known, full packets). More than kFullTime: it does not fit even alone.
[[nodiscard]] Value medium_time(const LinkQuality& link, const Mesh& mesh, Value bytes_per_second,
                                Value event_bytes);

/// The bit/s of a path whose links take turns, 1/R = sum of 1/R_i, rounded down: equation 1 of the
/// paper (Schulze, Lukas, ETFA 2009). Exact for up to 16 rates; with more, groups of 16 are rounded
/// down first, which costs less than 2 bit/s. 0 if there are no rates or one is 0.
[[nodiscard]] Value paper_rate(std::span<const Value> rates_bit_s);

}  // namespace mlcca::core::mesh
