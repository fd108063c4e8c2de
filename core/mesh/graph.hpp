// SPDX-License-Identifier: BSD-2-Clause
// A mesh as it is believed to be: what can be decided with, free of times, sources and addresses.
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

/// The channel of a link of which no source reports it: it shares the medium with every channel.
inline constexpr std::uint32_t kAnyChannel = std::numeric_limits<std::uint32_t>::max();

/// A link that carries, in the direction in which packets travel.
struct Link {
  std::uint32_t from = 0;  ///< node
  std::uint32_t to = 0;
  LinkQuality quality;
  std::uint32_t channel = kAnyChannel;  ///< equal ones share the medium
  Value busy = 0;                       ///< 1e-6 of the medium's time taken around `from`
  std::optional<std::uint64_t> weight;  ///< what the routing protocol reckons with

  bool operator==(const Link&) const = default;
};

/// Where a node sends what is for another.
struct NextHopIndex {
  std::uint32_t from = 0;
  std::uint32_t to = 0;   ///< destination
  std::uint32_t via = 0;  ///< neighbour of `from`

  auto operator<=>(const NextHopIndex&) const = default;
};

/// Why a link that is known carries nothing.
enum class Lack : std::uint8_t {
  gone,    ///< no source reports it any more, or the report is too old
  absent,  ///< who would know does not say that it is there
  rate,    ///< it is there, and its rate is unknown
  time,    ///< it was lost, and is back since less than Mesh::hold_up
};

/// A link that is known and carries nothing now. Its ends may still receive each other's signals,
/// and the routing protocol may still use it.
struct UnusableLink {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  std::optional<std::uint64_t> weight;
  Lack lack = Lack::gone;

  bool operator==(const UnusableLink&) const = default;
};

struct Graph {
  std::size_t nodes = 0;
  std::vector<Link> links;              ///< sorted by from, to; each pair once
  std::vector<UnusableLink> unusable;   ///< sorted by from, to; in no pair of `links`
  std::vector<NextHopIndex> next_hops;  ///< sorted; one for each from, to

  bool operator==(const Graph&) const = default;

  /// Of that direction; nullptr: there is none that carries. Its index is the distance from
  /// links.data().
  [[nodiscard]] const Link* find(std::uint32_t from, std::uint32_t to) const {
    const auto ends = [](const Link& link) { return std::pair(link.from, link.to); };
    const auto it = std::ranges::lower_bound(links, std::pair(from, to), {}, ends);
    return it != links.end() && ends(*it) == std::pair(from, to) ? &*it : nullptr;
  }
};

/// The described links alone, all of which carry what they state (of several for one direction the
/// first): for what is decided before anything runs.
[[nodiscard]] Graph described_graph(const Mesh& mesh);

}  // namespace mlcca::core::mesh
