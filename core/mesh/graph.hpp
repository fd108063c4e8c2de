// SPDX-License-Identifier: BSD-2-Clause
// The believed state of a mesh, without times, sources and addresses. Decisions are made from it.
#pragma once
#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/mesh/medium_time.hpp"

namespace mlcca::core::mesh {

/// The channel of a link for which no source reports one. Such a link shares the medium with every
/// channel.
inline constexpr std::uint32_t kAnyChannel = std::numeric_limits<std::uint32_t>::max();

/// A link that carries packets, in the direction in which they travel.
struct Link {
  std::uint32_t from = 0;  ///< index of a node
  std::uint32_t to = 0;
  LinkQuality quality;
  std::uint32_t channel = kAnyChannel;  ///< links with equal channels share the medium
  Value busy = 0;                       ///< 1e-6 of the medium's time taken around `from`
  std::optional<std::uint64_t> weight;  ///< cost that the routing protocol assigns to it

  bool operator==(const Link&) const = default;
};

/// The node to which a node sends packets for another.
struct NextHopIndex {
  std::uint32_t from = 0;
  std::uint32_t to = 0;   ///< destination
  std::uint32_t via = 0;  ///< neighbour of `from`

  auto operator<=>(const NextHopIndex&) const = default;
};

/// Why a known link carries nothing.
enum class Lack : std::uint8_t {
  gone,    ///< no source reports it any more, or the report is too old
  absent,  ///< the sources that would know do not report it as present
  rate,    ///< it is present, and its rate is unknown
  time,    ///< it was lost, and is back for less than Mesh::hold_up
};

/// A known link that carries nothing now. Its ends may still receive each other's signals, and the
/// routing protocol may still use it.
struct UnusableLink {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  std::optional<std::uint64_t> weight;
  Lack lack = Lack::gone;

  bool operator==(const UnusableLink&) const = default;
};

/// The nodes (numbers below `nodes`), links and next hops of a mesh.
struct Graph {
  std::size_t nodes = 0;
  std::vector<Link> links;              ///< sorted by (from, to), each pair once
  std::vector<UnusableLink> unusable;   ///< sorted by (from, to), no pair of `links`
  std::vector<NextHopIndex> next_hops;  ///< sorted, one for each (from, to)

  bool operator==(const Graph&) const = default;

  /// The link of that direction that carries packets, or null. Its index is the distance from
  /// links.data().
  [[nodiscard]] const Link* find(std::uint32_t from, std::uint32_t to) const {
    const auto ends = [](const Link& link) { return std::pair(link.from, link.to); };
    const auto it = std::ranges::lower_bound(links, std::pair(from, to), {}, ends);
    return it != links.end() && ends(*it) == std::pair(from, to) ? &*it : nullptr;
  }
};

}  // namespace mlcca::core::mesh
