// SPDX-License-Identifier: BSD-2-Clause
// Decodes topology packets of AWDS and combines them into a graph. No sockets and no clock: the
// caller gives the time.
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

#include "core/mesh/bounds.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/sample.hpp"

namespace mlcca::net::awds {

inline constexpr std::uint16_t kEthertype = 0x8334;
inline constexpr std::size_t kShortest = 23;   ///< a topology packet without links and without name
inline constexpr std::size_t kLongest = 4096;  ///< size of AWDS's own packet buffer
inline constexpr std::size_t kMaxNodes = 1024;     ///< a limit, because any station on the air can
                                                   ///< invent nodes
inline constexpr std::size_t kMaxNeighbours = 40;  ///< in one packet
inline constexpr std::size_t kMaxName = 32;        ///< bytes

/// The MAC address of the mesh device.
using NodeId = std::array<std::uint8_t, 6>;

/// The form "02:00:00:00:00:01".
[[nodiscard]] std::string address_of(const NodeId& id);

/// A neighbour in a topology packet.
struct Neighbour {
  NodeId id{};
  std::uint16_t quality = 0;  ///< its meaning depends on the metric (core::mesh::AwdsMetric)
  bool operator==(const Neighbour&) const = default;
};

/// A topology packet.
struct Topology {
  NodeId source{};
  std::uint16_t sequence = 0;
  std::uint32_t validity = 0;  ///< ms
  std::vector<Neighbour> neighbours;
  std::string name;
  bool operator==(const Topology&) const = default;
};

/// Decodes a packet without its Ethernet header. Nullopt for another kind of packet or a truncated
/// one. Octets after the name are accepted (a signature).
[[nodiscard]] std::optional<Topology> parse(std::span<const std::uint8_t> packet);

/// What the quality that `reporter` gives `neighbour` says about one direction of the link. hops:
/// the link is there. etx: loss of neighbour -> reporter, 1 - n/32 where quality is 2047 (32 - n),
/// at least 1. packet_pair: rate of reporter -> neighbour, 800 octets in quality / 655350 s.
/// transmission_time: the same in quality / 65535 s. Rates include the overhead of each frame. The
/// largest quality of the last two means that nothing was measured: rate 0. Nullopt if the metric
/// cannot have produced this quality. `taken` and `valid` are not set.
[[nodiscard]] std::optional<core::mesh::Sample> sample_of(core::mesh::AwdsMetric metric,
                                                          const NodeId& reporter,
                                                          const Neighbour& neighbour);

/// The cost that AWDS's own route computation assigns to the link, from the qualities that both
/// ends give each other; 2^22 - 1 if `backward` is not known.
[[nodiscard]] std::uint64_t weight_of(core::mesh::AwdsMetric metric, std::uint16_t forward,
                                      std::optional<std::uint16_t> backward);

/// The mesh as described by the packets that are still valid.
class Graph {
 public:
  /// `described` are the addresses of nodes for which there is always room.
  explicit Graph(core::mesh::AwdsMetric metric, core::mesh::DescribedNodes described = {})
      : metric_(metric), described_(std::move(described)) {}

  /// Adds a packet received at `now` (ns). False: it is a copy of a known flood, older than that,
  /// or from one node too many. Beyond kMaxNodes the known nodes stay, but a described node
  /// replaces the undescribed one that came last.
  bool take(Topology topology, std::uint64_t now);
  /// The nodes and links that are valid at `now` (ns).
  [[nodiscard]] core::mesh::Snapshot snapshot(std::uint64_t now);

 private:
  struct Received {
    Topology topology;
    std::uint64_t at = 0;     ///< ns
    std::uint64_t since = 0;  ///< ns: when the node was first received
    bool described = false;
    [[nodiscard]] std::uint64_t valid() const;
  };
  [[nodiscard]] std::optional<std::uint16_t> quality(const NodeId& reporter,
                                                     const NodeId& neighbour) const;
  void forget_expired(std::uint64_t now);
  bool make_room(bool for_described);

  core::mesh::AwdsMetric metric_;
  core::mesh::DescribedNodes described_;
  std::map<NodeId, Received> nodes_;
  bool crowded_ = false;  ///< a node was left out since the last snapshot
};

}  // namespace mlcca::net::awds
