// SPDX-License-Identifier: BSD-2-Clause
// A CAN socket of one interface: sends probe frames, and sees all frames with their times.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "core/can/wire.hpp"

namespace mlcca::doctor {

struct Identifier {
  std::uint32_t value = 0;
  bool extended = false;
};

/// "0x1FFFFFFF": hexadecimal with or without 0x; up to 7FF it has 11 bits, above that 29.
[[nodiscard]] Result<Identifier> read_identifier(const std::string& text);

struct Seen {
  std::uint64_t ns = 0;      ///< CLOCK_REALTIME, by the kernel
  bool own = false;          ///< a frame of ours that came back
  std::uint32_t number = 0;  ///< of ours
  std::uint32_t error = 0;   ///< CAN_ERR_* classes of an error frame, 0: it is none
  core::can::WireFrame frame;
};

class Probe {
 public:
  static Result<Probe> open(int ifindex, Identifier id, bool fd);

  [[nodiscard]] int fd() const { return socket_.get(); }
  /// Frame number N as it is on the wire.
  [[nodiscard]] core::can::WireFrame frame(std::uint32_t number, bool fd) const;
  /// False: there is no room.
  [[nodiscard]] Result<bool> send(std::uint32_t number, bool fd) const;
  /// Nothing within this time.
  [[nodiscard]] Result<std::optional<Seen>> next(unsigned patience_ms) const;

 private:
  Probe(Fd socket, Identifier id) : socket_(std::move(socket)), id_(id) {}
  Fd socket_;
  Identifier id_;
};

}  // namespace mlcca::doctor
