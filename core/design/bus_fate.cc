// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/bus_fate.hpp"

namespace mlcca::core {
namespace {

BusFate fate_of_refused(const BusDecision& decision) {
  return decision.in_vain ? BusFate::refused_for_others : BusFate::refused;
}

BusRow row_of_dropped(const BusDecision& decision, const can::Message& sent) {
  BusRow row{.fate = fate_of_refused(decision),
             .response = decision.refused_response,
             .jitter = decision.refused_response ? decision.refused_jitter : sent.jitter,
             .frames = decision.refused_frames};
  if (decision.refused_response)
    row.fate = *decision.refused_response == can::kNever ? BusFate::not_bounded : BusFate::late;
  else if (decision.refused_frames)
    row.fate = BusFate::queue_too_short;
  return row;
}

}  // namespace

BusDecision decision_of(const BusMessage& message) {
  return {.outcome = message.outcome,
          .held = message.held,
          .counted = message.is_counted(),
          .in_vain = message.in_vain,
          .refused_response = message.refused_response,
          .refused_jitter = message.refused_jitter,
          .refused_frames = message.refused_frames};
}

BusRow row_of(const BusDecision& decision, const can::Assumptions& assumptions,
              const can::Message& sent, const can::Response& response) {
  if (!decision.counted) return row_of_dropped(decision, sent);
  BusRow row{.fate = BusFate::met,
             .response = response.bounded ? response.response : can::kNever,
             .jitter = sent.jitter,
             .frames = std::nullopt};
  if (response.bounded) row.frames = response.queued_frames;
  if (decision.outcome == Outcome::run_time && !decision.held)
    row.fate = BusFate::run_time;
  else if (!response.bounded)
    row.fate = BusFate::not_bounded;
  else if (!response.meets(sent.deadline))
    row.fate = BusFate::late;
  else if (!can::fits(assumptions, sent, response))
    row.fate = BusFate::queue_too_short;
  else if (decision.outcome == Outcome::unfit || decision.in_vain)
    row.fate = fate_of_refused(decision);
  return row;
}

}  // namespace mlcca::core
