// SPDX-License-Identifier: BSD-2-Clause
// What is said of a message on a bus, wherever it is: one verdict and one time.
#pragma once
#include <cstdint>
#include <optional>

#include "core/can/analysis.hpp"
#include "core/can/message.hpp"
#include "core/design/bus_messages.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::core {

enum class BusFate : std::uint8_t {
  met,
  late,
  not_bounded,
  queue_too_short,
  refused_for_others,  ///< others would be late or lost on this bus
  refused,             ///< for something else than this bus
  run_time,            ///< left to the run time whether it takes the place of others
};

/// What a check decides about a message of a bus.
struct BusDecision {
  Outcome outcome = Outcome::fit;
  bool held = true;     ///< as of BusMessage, and the others too
  bool counted = true;  ///< it can be on the bus
  bool in_vain = false;
  std::optional<Value> refused_response = {};
  Value refused_jitter = 0;
  std::optional<std::uint32_t> refused_frames = {};
};

[[nodiscard]] BusDecision decision_of(const BusMessage& message);

/// What is on the bus has the times that it has beside all that can be there. What is not, because
/// a gate drops it before, has those for which the check refuses it, if it does for any.
struct BusRow {
  BusFate fate = BusFate::met;
  std::optional<Value> response;        ///< kNever: not bounded; nothing: it has none here
  Value jitter = 0;                     ///< that is in the response
  std::optional<std::uint32_t> frames;  ///< that wait in its queue
};

/// `sent` with `response`: beside what counts.
[[nodiscard]] BusRow row_of(const BusDecision& decision, const can::Assumptions& assumptions,
                            const can::Message& sent, const can::Response& response);

}  // namespace mlcca::core
