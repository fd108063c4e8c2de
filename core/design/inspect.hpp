// SPDX-License-Identifier: BSD-2-Clause
// The design-time check of a complete description, with findings as its result.
#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/can/analysis.hpp"
#include "core/can/message.hpp"
#include "core/design/bus_messages.hpp"
#include "core/design/findings.hpp"
#include "core/design/load.hpp"
#include "core/model/system.hpp"
#include "mlcca/satisfies.hpp"

namespace mlcca::core {

/// The result of one channel.
struct ChannelResult {
  std::size_t deliveries = 0;      ///< one per publisher and place with subscribers
  Outcome outcome = Outcome::fit;  ///< the worst of them; also unfit if a publisher is missing
  std::size_t set = 0;             ///< the attribute set used if all best cases hold
  bool open_set = false;           ///< the set depends on which best cases hold
};

/// A message on a bus and its response time if all messages there are sent.
struct SentMessage {
  const BusMessage* message = nullptr;
  can::Response response;
  bool by_admission = false;  ///< see bus_responses.hpp
};
/// The messages of one network that are described sufficiently; empty if the bus is not analysed.
[[nodiscard]] std::vector<SentMessage> all_sent(const InspectedBuses& buses, std::size_t network);

/// The result of inspect().
struct Inspection {
  std::vector<Finding> findings;  ///< in the order of the description: file, line, number
  std::vector<ChannelResult> channels;
  std::vector<NetworkLoad> networks;
};

/// Called about every thousand channels.
using InspectProgress = std::function<void(std::size_t channels_done)>;

/// Called for each channel after all have been decided: first with the attribute set in use, then
/// with each other set as it would be if all other channels stay as they are. Verdicts keep their
/// hops, with the response times of the final schedules. `errors`: why not everything is granted.
using EachDecided = std::function<void(std::size_t channel, const Decision& decision,
                                       std::span<const Finding> errors)>;

/// Decides every channel as a gateway would, except that best cases pass and become notes. `system`
/// must have sorted bindings. What the rules of description/ find (two channels with one subject,
/// duplicate identifiers, …) is not repeated. `buses`: if not null, receives what is on the
/// analysed buses.
[[nodiscard]] Inspection inspect(const System& system, const InspectProgress& progress = {},
                                 const EachDecided& each = {}, InspectedBuses* buses = nullptr);

}  // namespace mlcca::core
