// SPDX-License-Identifier: BSD-2-Clause
// A new system as `mlccactl new` plans it from its arguments or questions, and the description made
// from that.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::tools::design {

/// A network of the new system.
struct PlannedNetwork {
  std::string name;
  core::NetworkKind kind{};
  std::string interface;
  std::uint32_t bitrate = 0;       ///< bit/s of a CAN bus
  std::uint32_t queue_length = 0;  ///< frames of the queue of the gateway's port; 0: the default
};

/// A channel of the new system.
struct PlannedChannel {
  std::string name;
  Value period = 0;  ///< ns
  Value bytes = 0;
  std::size_t from = 0;         ///< index of the network
  std::vector<std::size_t> to;  ///< indices of networks
};

/// The new system, with a gateway on all networks; without one if its name is empty.
struct Plan {
  std::string name;
  std::string gateway;
  std::vector<PlannedNetwork> networks;
  std::vector<PlannedChannel> channels;
};

inline constexpr std::size_t kMostPlannedNetworks = 16;
inline constexpr std::size_t kMostPlannedChannels = 1000;

/// What is wrong with a name; empty: nothing is.
std::string problem_of_planned_name(std::string_view name);

/// Adds a network, "NAME:KIND:INTERFACE" with ":BITRATE" behind it for a CAN bus (default 500k).
Result<void> add_network(Plan& plan, std::string_view text);
/// Adds a channel, "NAME:PERIOD:BYTES:FROM:TO" with commas between several destination networks.
Result<void> add_channel(Plan& plan, std::string_view text);

/// The XML of the description. `random` generates the subject of a channel, never 0.
std::string description_of(const Plan& plan, std::uint64_t (*random)());
/// As description_of(), with queues of the gateway that are long enough for what may wait there.
std::string description_that_holds(Plan& plan, std::uint64_t (*random)());

}  // namespace mlcca::tools::design
