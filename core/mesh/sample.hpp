// SPDX-License-Identifier: BSD-2-Clause
// What sources report of links: one sample for each direction.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace mlcca::core::mesh {

/// A link in the direction in which packets travel. Addresses as in Node::address.
struct Sample {
  std::string from;
  std::string to;
  Value rate = 0;  ///< bit/s; 0: the source knows the link but not its rate
  RateKind kind = RateKind::phy;
  std::optional<Value> loss;             ///< 1e-9 of the packets in this direction
  std::optional<std::uint32_t> channel;  ///< frequency in MHz or any number; equal ones share
  std::optional<std::uint32_t> busy;     ///< 1e-6 of the medium's time that is taken around `from`
                                         ///< by all stations, our own traffic included
  std::optional<std::uint64_t> weight;   ///< cost that the routing protocol gives it
  std::uint64_t taken = 0;               ///< CLOCK_MONOTONIC ns of the measurement
  std::optional<Value> valid;  ///< ns; the protocol's own validity, shorter than stale_after

  bool operator==(const Sample&) const = default;
};

/// The next hop that a routing protocol on a node uses.
struct NextHop {
  std::string from;
  std::string to;   ///< destination
  std::string via;  ///< neighbour of `from`
  bool operator==(const NextHop&) const = default;
};

/// All that one source knows now: what is not in it is gone.
struct Snapshot {
  std::vector<Sample> links;
  std::vector<NextHop> next_hops;  ///< empty: the source knows no routes
  std::string problem;             ///< why it knows nothing, in words; empty: none
  bool operator==(const Snapshot&) const = default;
};

}  // namespace mlcca::core::mesh
