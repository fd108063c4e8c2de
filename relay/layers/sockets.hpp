// SPDX-License-Identifier: BSD-2-Clause
// What the sockets of all layers have in common.
#pragma once
#include <sys/socket.h>

#include <cstdint>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::relay {

/// What the kernel says beside the data of a message.
struct Beside {
  std::uint64_t unix_ns = 0;  ///< when it came; 0: not said
  std::uint32_t dropped = 0;  ///< messages that the socket has dropped so far
  bool says_dropped = false;
};
[[nodiscard]] Beside beside(msghdr& message);

/// Each message that comes has its time and the number of those that were dropped.
[[nodiscard]] Result<void> ask_for_times(const Fd& socket);
/// As much room as the kernel gives for what comes in a burst.
void widen(const Fd& socket);

/// What a failed send means for the event; errno is what it is.
[[nodiscard]] Sent failure_of_send();
[[nodiscard]] std::unexpected<Error> system_error(const std::string& call);

}  // namespace mlcca::relay
