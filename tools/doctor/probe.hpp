// SPDX-License-Identifier: BSD-2-Clause
// A CAN socket on one interface that sends probe frames and receives all frames with time stamps.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "core/can/wire.hpp"

namespace mlcca::doctor {

/// The identifier of probe frames.
struct Identifier {
  std::uint32_t value = 0;
  bool extended = false;
};

/// Parses "0x1FFFFFFF" (hexadecimal, 0x is optional). Up to 7FF the identifier has 11 bits, else
/// 29.
[[nodiscard]] Result<Identifier> read_identifier(const std::string& text);

/// A received frame.
struct Seen {
  std::uint64_t ns = 0;      ///< time stamp of the kernel (CLOCK_REALTIME)
  bool own = false;          ///< the echo of a frame of ours
  std::uint32_t number = 0;  ///< number of that frame
  std::uint32_t error = 0;   ///< CAN_ERR_* classes of an error frame; 0: it is none
  core::can::WireFrame frame;
};

/// The socket; frames of ours are numbered, so that their echoes are recognised.
class Probe {
 public:
  static Result<Probe> open(int ifindex, Identifier id, bool fd);

  [[nodiscard]] int fd() const { return socket_.get(); }
  /// Probe frame `number` as it is on the wire.
  [[nodiscard]] core::can::WireFrame frame(std::uint32_t number, bool fd) const;
  /// Sends probe frame `number`. False: the queue has no room.
  [[nodiscard]] Result<bool> send(std::uint32_t number, bool fd) const;
  /// The next frame; nullopt if none arrives in time.
  [[nodiscard]] Result<std::optional<Seen>> next(unsigned patience_ms) const;

 private:
  Probe(Fd socket, Identifier id) : socket_(std::move(socket)), id_(id) {}
  Fd socket_;
  Identifier id_;
};

}  // namespace mlcca::doctor
