// SPDX-License-Identifier: BSD-2-Clause
// Everything the kernel says of one CAN controller, its driver and its queue: more than the daemon
// needs at each change, and changing by itself.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "base/result.hpp"

namespace mlcca::net {

struct ErrorCounters {
  std::uint16_t sending = 0;
  std::uint16_t receiving = 0;
  bool operator==(const ErrorCounters&) const = default;
};

struct Controller {
  int ifindex = 0;
  std::string driver;                   ///< empty: not said
  bool echoes = false;                  ///< IFF_ECHO: the driver gives back what was sent
  bool fd = false;                      ///< takes FD frames now
  std::uint32_t modes = 0;              ///< CAN_CTRLMODE_*
  std::uint32_t sample_point = 0;       ///< of 1000, 0: unknown
  std::uint32_t data_sample_point = 0;  ///< the same
  std::uint32_t clock = 0;              ///< Hz, 0: unknown
  std::uint32_t restart_ms = 0;         ///< 0: a bus-off stays
  std::optional<ErrorCounters> errors;  ///< nothing: the driver has none
  std::string queue;                    ///< kind of the discipline at the root; empty: none
  std::uint32_t queue_limit = 0;        ///< frames of one priority that it holds, 0: unknown
  std::uint32_t queue_length = 0;       ///< txqueuelen
};

/// Asks the kernel now.
[[nodiscard]] Result<Controller> read_controller(int ifindex);

}  // namespace mlcca::net
