// SPDX-License-Identifier: BSD-2-Clause
// What sends single frames on CAN interfaces: a socket of CAN, or a fake.
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

  /// Does not wait. False: it will be able to send soon. A frame that cannot be sent is lost.
  virtual bool send(std::uint32_t ifindex, const can_frame& frame) = 0;
  /// Why frames cannot be sent; empty: the latest one could, or none has been sent.
  [[nodiscard]] virtual const std::string& problem() const = 0;
};

}  // namespace mlcca
