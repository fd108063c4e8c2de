// SPDX-License-Identifier: BSD-2-Clause
// A new system: what is asked of its networks, gateway and channels, and the description of it.
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

struct PlannedNetwork {
  std::string name;
  core::NetworkKind kind{};
  std::string interface;
  std::uint32_t bitrate = 0;       ///< bit/s, of a CAN bus
  std::uint32_t queue_length = 0;  ///< frames, of the gateway's port on it; 0: as by default
};

struct PlannedChannel {
  std::string name;
  Value period = 0;  ///< ns
  Value bytes = 0;
  std::size_t from = 0;         ///< index of a network
  std::vector<std::size_t> to;  ///< the same
};

struct Plan {
  std::string name;
  std::string gateway;
  std::vector<PlannedNetwork> networks;
  std::vector<PlannedChannel> channels;
};

inline constexpr std::size_t kMostPlannedNetworks = 16;
inline constexpr std::size_t kMostPlannedChannels = 1000;

/// What is wrong with a name; empty: nothing.
std::string problem_of_planned_name(std::string_view name);

/// "NAME:KIND:INTERFACE", of a CAN bus with ":BITRATE" behind it (500k where that is missing):
/// added to the plan.
Result<void> add_network(Plan& plan, std::string_view text);
/// "NAME:PERIOD:BYTES:FROM:TO", with commas between several networks that it goes to: the same.
Result<void> add_channel(Plan& plan, std::string_view text);

/// The XML. `random`: gives the subject of a channel, never 0.
std::string description_of(const Plan& plan, std::uint64_t (*random)());
/// The same, and the queues of the gateway hold what may wait there.
std::string description_that_holds(Plan& plan, std::uint64_t (*random)());

}  // namespace mlcca::tools::design
