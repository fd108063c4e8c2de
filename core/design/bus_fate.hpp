// SPDX-License-Identifier: BSD-2-Clause
// The result for one message of a bus, in the same words everywhere: a fate and a time.
#pragma once
#include <cstdint>
#include <optional>

#include "core/can/analysis.hpp"
#include "core/can/message.hpp"
#include "core/design/bus_messages.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::core {

/// The result for a message of a bus.
enum class BusFate : std::uint8_t {
  met,
  late,
  not_bounded,
  queue_too_short,
  refused_for_others,  ///< because others would be late or lost on this bus
  refused,             ///< for a reason other than this bus
  run_time,            ///< the run time decides whether it takes the place of others
};

/// What a check decides about a message of a bus; the fields are those of BusMessage.
struct BusDecision {
  Outcome outcome = Outcome::fit;
  bool held = true;     ///< see BusMessage
  bool counted = true;  ///< it can be on the bus
  bool in_vain = false;
  std::optional<Value> refused_response = {};
  Value refused_jitter = 0;
  std::optional<std::uint32_t> refused_frames = {};
};

/// What the check has decided about that message.
[[nodiscard]] BusDecision decision_of(const BusMessage& message);

/// A message that can be on the bus has the times that it has together with everything that can be
/// there. One that a gate drops before has those for which the check refuses it, if it does so for
/// any.
struct BusRow {
  BusFate fate = BusFate::met;
  std::optional<Value> response;        ///< kNever: not bounded; nullopt: it has none on this bus
  Value jitter = 0;                     ///< that the response contains
  std::optional<std::uint32_t> frames;  ///< that wait in its queue; nullopt: unknown
};

/// `sent` and `response` are those beside the messages that count.
[[nodiscard]] BusRow row_of(const BusDecision& decision, const can::Assumptions& assumptions,
                            const can::Message& sent, const can::Response& response);

}  // namespace mlcca::core
