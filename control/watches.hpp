// SPDX-License-Identifier: BSD-2-Clause
// Conclusions from the supervision of a publisher's events.
#pragma once
#include "control/messages.hpp"

namespace mlcca::control {

/// Events were missing and are arriving again, but not yet long enough to count as restored.
inline bool is_coming_again(const Watch& watch) {
  return watch.missing_now && watch.events != 0 && watch.since_last_ns < watch.timeout_ns;
}

}  // namespace mlcca::control
