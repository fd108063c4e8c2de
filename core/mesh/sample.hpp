// SPDX-License-Identifier: BSD-2-Clause
// What sources report: one sample for each direction of a link.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace mlcca::core::mesh {

/// A report about a link in the direction in which packets travel. Addresses are written as in
/// Node::address.
struct Sample {
  std::string from;
  std::string to;
  Value rate = 0;  ///< bit/s; 0: the source knows the link but not its rate
  RateKind kind = RateKind::phy;
  std::optional<Value> loss;             ///< share of packets lost in this direction, in 1e-9
  std::optional<std::uint32_t> channel;  ///< frequency in MHz or any number; links with equal
                                         ///< numbers share the medium
  std::optional<std::uint32_t> busy;     ///< 1e-6 of the medium's time taken around `from` by all
                                         ///< stations, our own traffic included
  std::optional<std::uint64_t> weight;   ///< cost that the routing protocol assigns to the link
  std::uint64_t taken = 0;               ///< CLOCK_MONOTONIC ns of the measurement
  std::optional<Value> valid;  ///< ns; the validity that the protocol states, if shorter than
                               ///< stale_after

  bool operator==(const Sample&) const = default;
};

/// The next hop that a routing protocol uses on a node.
struct NextHop {
  std::string from;
  std::string to;   ///< destination
  std::string via;  ///< neighbour of `from`
  bool operator==(const NextHop&) const = default;
};

/// Everything that a source knows at present. A link that is not in it is gone.
struct Snapshot {
  std::vector<Sample> links;
  std::vector<NextHop> next_hops;  ///< empty if the source knows no routes
  std::string problem;  ///< why the source knows nothing, as text; empty if there is no problem
  bool operator==(const Snapshot&) const = default;
};

/// Gives every link of the snapshot the same time.
inline void stamp(Snapshot& snapshot, std::uint64_t taken) {
  for (Sample& sample : snapshot.links) sample.taken = taken;
}

}  // namespace mlcca::core::mesh
