// SPDX-License-Identifier: BSD-2-Clause
// Functions that the sockets of all layers share.
#pragma once
#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "base/system_error.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::relay {

/// Ancillary data of a received message.
struct Beside {
  std::uint64_t unix_ns = 0;  ///< when the kernel received it; 0: unknown
  std::uint32_t dropped = 0;  ///< messages that the socket has dropped so far
  /// `dropped` is stated.
  bool says_dropped = false;
};
[[nodiscard]] Beside beside(msghdr& message);

/// A received message; a negative size: none was received, and errno says why.
struct Received {
  ssize_t size = -1;
  int flags = 0;
  Beside beside;
};
/// Receives without waiting. `from`: where the sender's address is stored, or null.
[[nodiscard]] Received receive_into(const Fd& socket, void* data, std::size_t room,
                                    void* from = nullptr, socklen_t from_size = 0, int flags = 0);

/// Room for the ancillary data of a message.
struct BesideRoom {
  alignas(cmsghdr) std::array<char, 128> bytes;
};

/// Receives several messages with one system call.
class Batch {
 public:
  /// `data` and `from` are valid until the next call.
  struct Message {
    Received received;
    const std::uint8_t* data = nullptr;
    const sockaddr_storage* from = nullptr;
  };

  /// `room`: octets of the longest message; longer ones are cut.
  explicit Batch(std::size_t room);
  /// The next message, without waiting. If the kernel had fewer messages than a batch takes, the
  /// call after the last of them gives none (EAGAIN) without asking the kernel again.
  [[nodiscard]] Message next(const Fd& socket);
  /// Whether there are messages that a poll of the socket does not report.
  [[nodiscard]] bool pending() const { return at_ < count_; }

 private:
  static constexpr std::size_t kMost = 8;

  std::vector<std::uint8_t> data_;
  std::array<sockaddr_storage, kMost> from_{};
  std::array<BesideRoom, kMost> control_{};
  std::array<iovec, kMost> parts_{};
  std::array<mmsghdr, kMost> messages_{};
  std::size_t at_ = 0;
  std::size_t count_ = 0;
  bool drained_ = false;  ///< the kernel had no more than these
};

/// Makes the kernel state the time of each message and the number of dropped ones.
[[nodiscard]] Result<void> ask_for_times(const Fd& socket);
/// Sets the receive buffer to the largest size that the kernel allows, for bursts.
void widen(const Fd& socket);

/// What a failed send means for the event, according to errno.
[[nodiscard]] Sent failure_of_send();

}  // namespace mlcca::relay
