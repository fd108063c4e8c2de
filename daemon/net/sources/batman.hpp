// SPDX-License-Identifier: BSD-2-Clause
// Neighbours and originators of batman-adv, read from its generic netlink family.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/net/sources/genl.hpp"
#include "daemon/net/sources/source.hpp"

namespace mlcca::net {
namespace batman {

// Each reader returns nullopt for a message of another command, or one that does not identify its
// subject.

/// BATADV_CMD_GET_HARDIF: an interface below the mesh interface.
struct HardInterface {
  std::uint32_t index = 0;
  std::string mac;
};
[[nodiscard]] std::optional<HardInterface> read_hard_interface(genl::Octets message);

/// BATADV_CMD_GET_NEIGHBORS: a direct neighbour.
struct Neighbour {
  std::string mac;
  std::uint32_t interface = 0;      ///< index of the hard interface on which it is received
  std::optional<Value> throughput;  ///< bit/s (BATMAN_V)
  std::uint32_t last_seen = 0;      ///< ms ago
};
[[nodiscard]] std::optional<Neighbour> read_neighbour(genl::Octets message);

/// BATADV_CMD_GET_ORIGINATORS: a path to a node. There is one for each neighbour that offers one.
struct Originator {
  std::string mac;
  std::string next_hop;
  std::uint32_t interface = 0;          ///< index of the hard interface towards the next hop
  bool best = false;                    ///< the path that is used
  std::optional<std::uint8_t> quality;  ///< TQ of BATMAN_IV, 255 is the best
  std::uint32_t last_seen = 0;          ///< ms ago
};
[[nodiscard]] std::optional<Originator> read_originator(genl::Octets message);

/// The answers of one poll of a mesh interface.
struct Seen {
  std::vector<HardInterface> interfaces;
  std::vector<Neighbour> neighbours;
  std::vector<Originator> originators;
};
/// The links and next hops that follow from one poll. `now`: CLOCK_MONOTONIC ns of the poll.
[[nodiscard]] core::mesh::Snapshot view(const Seen& seen, std::uint64_t now);

}  // namespace batman

/// Polls the mesh interface `source.interface` (bat0) each second. The interface may appear later.
/// Needs CAP_NET_ADMIN.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_batman(const core::mesh::Source& source,
                                                              sd_event* loop,
                                                              LinkSource::Report report);

}  // namespace mlcca::net
