// SPDX-License-Identifier: BSD-2-Clause
// The check of a whole description at design time: completeness and correctness, as findings.
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

/// What became of one channel.
struct ChannelResult {
  std::size_t deliveries = 0;      ///< from each publisher to each place with subscribers
  Outcome outcome = Outcome::fit;  ///< the worst of them; unfit too where a publisher is missing
  std::size_t set = 0;             ///< the attribute set that is used, if all best cases hold
  bool open_set = false;           ///< which one is used depends on which best cases hold
};

/// A message on a bus and its response time, if all messages there are sent.
struct SentMessage {
  const BusMessage* message = nullptr;
  can::Response response;
  bool by_admission = false;  ///< see bus_responses.hpp
};
/// Of one network, those of which the description says enough; none where it is not analysed.
[[nodiscard]] std::vector<SentMessage> all_sent(const InspectedBuses& buses, std::size_t network);

struct Inspection {
  std::vector<Finding> findings;  ///< in the order of the description: file, line, number
  std::vector<ChannelResult> channels;
  std::vector<NetworkLoad> networks;
};

/// Called about every thousand channels.
using InspectProgress = std::function<void(std::size_t channels_done)>;

/// Called for each channel when all are decided, first with the attribute set that is used, then
/// with each of the others as it would be if everybody else stayed as they are. Verdicts have their
/// hops, with the response times of the final schedules. `errors`: why not everything is granted.
using EachDecided = std::function<void(std::size_t channel, const Decision& decision,
                                       std::span<const Finding> errors)>;

/// Decides every channel of `system` as a gateway would, but lets best cases pass, which are then
/// notes: the run time decides. `system` has sorted bindings, and what the description's own rules
/// find (two channels with one subject, an identifier given twice, …) is not repeated here.
/// `buses`, if there are any: gets what is on them.
[[nodiscard]] Inspection inspect(const System& system, const InspectProgress& progress = {},
                                 const EachDecided& each = {}, InspectedBuses* buses = nullptr);

}  // namespace mlcca::core
