// SPDX-License-Identifier: BSD-2-Clause
// An interface for sending single frames on CAN interfaces: a CAN socket, or a fake.
#pragma once
#include <linux/can.h>

#include <cstdint>
#include <string>

namespace mlcca {

class CanSender {
 public:
  CanSender() = default;
  CanSender(const CanSender&) = delete;
  CanSender& operator=(const CanSender&) = delete;
  CanSender(CanSender&&) = delete;
  CanSender& operator=(CanSender&&) = delete;
  virtual ~CanSender() = default;

  /// Sends without waiting. False: not now, but it will be possible soon. A frame that cannot be
  /// sent is lost.
  virtual bool send(std::uint32_t ifindex, const can_frame& frame) = 0;
  /// Why frames cannot be sent; empty if the latest one was sent, or none has been tried.
  [[nodiscard]] virtual const std::string& problem() const = 0;
};

}  // namespace mlcca
