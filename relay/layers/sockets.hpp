// SPDX-License-Identifier: BSD-2-Clause
// What the sockets of all layers have in common.
#pragma once
#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "base/system_error.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::relay {

/// What the kernel says beside the data of a message.
struct Beside {
  std::uint64_t unix_ns = 0;  ///< when it came; 0: not said
  std::uint32_t dropped = 0;  ///< messages that the socket has dropped so far
  bool says_dropped = false;
};
[[nodiscard]] Beside beside(msghdr& message);

/// A message that has come, or (size below 0) none; errno says why.
struct Received {
  ssize_t size = -1;
  int flags = 0;
  Beside beside;
};
/// Without waiting. `from`: gets the address of the sender, or nullptr.
[[nodiscard]] Received receive_into(const Fd& socket, void* data, std::size_t room,
                                    void* from = nullptr, socklen_t from_size = 0, int flags = 0);

/// Each message that comes has its time and the number of those that were dropped.
[[nodiscard]] Result<void> ask_for_times(const Fd& socket);
/// As much room as the kernel gives for what comes in a burst.
void widen(const Fd& socket);

/// What a failed send means for the event; errno is what it is.
[[nodiscard]] Sent failure_of_send();

}  // namespace mlcca::relay
