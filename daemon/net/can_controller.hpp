// SPDX-License-Identifier: BSD-2-Clause
// Everything that the kernel reports about one CAN controller, its driver and its queue. This is
// more than the daemon reads at each change, and some of it changes without notice.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "base/result.hpp"

namespace mlcca::net {

/// The transmit and receive error counters of a CAN controller (ISO 11898-1).
struct ErrorCounters {
  std::uint16_t sending = 0;
  std::uint16_t receiving = 0;
  bool operator==(const ErrorCounters&) const = default;
};

/// The state of one controller, when it was read.
struct CanController {
  int ifindex = 0;
  std::string driver;              ///< empty: not reported
  bool echoes = false;             ///< IFF_ECHO: the driver returns the frames that it has sent
  bool fd = false;                 ///< accepts FD frames at present
  std::uint32_t modes = 0;         ///< CAN_CTRLMODE_*
  std::uint32_t sample_point = 0;  ///< in 1/1000; 0: unknown
  std::uint32_t data_sample_point = 0;  ///< the same
  std::uint32_t clock = 0;              ///< Hz, 0: unknown
  std::uint32_t restart_ms = 0;         ///< 0: does not restart after bus-off
  std::optional<ErrorCounters> errors;  ///< nullopt: the driver reports none
  std::string queue;                    ///< kind of the root queueing discipline; empty: none
  std::uint32_t queue_limit = 0;        ///< frames of one priority that fit; 0: unknown
  std::uint32_t queue_length = 0;       ///< txqueuelen
};

/// Reads the state from the kernel.
[[nodiscard]] Result<CanController> read_controller(int ifindex);

}  // namespace mlcca::net
