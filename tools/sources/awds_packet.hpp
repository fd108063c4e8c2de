// SPDX-License-Identifier: BSD-2-Clause
// Topology packets of AWDS as bytes, and the graph that they add up to. No sockets and no clock:
// whoever calls gives the time.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/mesh.hpp"
#include "core/mesh/sample.hpp"
#include "daemon/net/sources/bounds.hpp"

namespace mlcca::net::awds {

inline constexpr std::uint16_t kEthertype = 0x8334;
inline constexpr std::size_t kShortest = 23;   ///< a topology packet without links and without name
inline constexpr std::size_t kLongest = 4096;  ///< AWDS's own packet buffer
inline constexpr std::size_t kMaxNodes = 1024;     ///< anyone on the air can invent nodes
inline constexpr std::size_t kMaxNeighbours = 40;  ///< in one packet
inline constexpr std::size_t kMaxName = 32;        ///< bytes

/// Six octets, those of the mesh device.
using NodeId = std::array<std::uint8_t, 6>;

/// "02:00:00:00:00:01"
[[nodiscard]] std::string address_of(const NodeId& id);

struct Neighbour {
  NodeId id{};
  std::uint16_t quality = 0;  ///< what it means depends on the metric (core::mesh::AwdsMetric)
  bool operator==(const Neighbour&) const = default;
};

struct Topology {
  NodeId source{};
  std::uint16_t sequence = 0;
  std::uint32_t validity = 0;  ///< ms
  std::vector<Neighbour> neighbours;
  std::string name;
  bool operator==(const Topology&) const = default;
};

/// A packet as it follows the Ethernet header. Nothing: another kind of packet, or one that is cut
/// off. Octets after the name are legal (a signature).
[[nodiscard]] std::optional<Topology> parse(std::span<const std::uint8_t> packet);

/// What the quality that `reporter` gives `neighbour` says of one direction of the link:
/// hops: the link is there; etx: loss of neighbour -> reporter, 1 - n/32 where quality is
/// 2047 (32 - n), at least 1; packet_pair: rate of reporter -> neighbour, 800 octets in
/// quality / 655350 s; transmission_time: the same in quality / 65535 s. Rates include the overhead
/// of each frame. The largest quality of the last two says that nothing was measured: rate 0.
/// Nothing where the metric cannot have produced this quality. `taken` and `valid` are left alone.
[[nodiscard]] std::optional<core::mesh::Sample> sample_of(core::mesh::AwdsMetric metric,
                                                          const NodeId& reporter,
                                                          const Neighbour& neighbour);

/// What AWDS's own route computation charges for the link, from the quality that each end gives the
/// other; 2^22 - 1 where `backward` is not known.
[[nodiscard]] std::uint64_t weight_of(core::mesh::AwdsMetric metric, std::uint16_t forward,
                                      std::optional<std::uint16_t> backward);

/// The mesh as the packets of the last time describe it.
class Graph {
 public:
  /// `described`: addresses of nodes that always have room.
  explicit Graph(core::mesh::AwdsMetric metric, Described described = {})
      : metric_(metric), described_(std::move(described)) {}

  /// False: a copy of a flood that is known, an older one, or one node too many. Of more than
  /// kMaxNodes those stay that are known; a described one takes the room of the undescribed one
  /// that came last. `now`: ns.
  bool take(Topology topology, std::uint64_t now);
  /// What is still valid at `now`.
  [[nodiscard]] core::mesh::Snapshot snapshot(std::uint64_t now);

 private:
  struct Received {
    Topology topology;
    std::uint64_t at = 0;     ///< ns
    std::uint64_t since = 0;  ///< ns: when it was received first
    bool described = false;
    [[nodiscard]] std::uint64_t valid() const;
  };
  [[nodiscard]] std::optional<std::uint16_t> quality(const NodeId& reporter,
                                                     const NodeId& neighbour) const;
  void forget_expired(std::uint64_t now);
  bool make_room(bool for_described);

  core::mesh::AwdsMetric metric_;
  Described described_;
  std::map<NodeId, Received> nodes_;
  bool crowded_ = false;  ///< a node was left out since the last snapshot
};

}  // namespace mlcca::net::awds
