// SPDX-License-Identifier: BSD-2-Clause
// What is read of a CAN interface without sending anything, and what to think of it.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/can/frame.hpp"
#include "daemon/net/controller.hpp"
#include "daemon/net/links.hpp"
#include "tools/doctor/line.hpp"

namespace mlcca::doctor {

enum class Gate : std::uint8_t {
  none,
  audit,      ///< drops nothing
  enforcing,  ///< drops what was not admitted, the frames of doctor too
  unknown,
};

struct Device {
  net::Link link;
  net::Controller controller;
  Gate gate = Gate::none;
  std::string gate_error;  ///< why it is unknown
};

/// vcan or vxcan: no controller, and no time on a bus.
[[nodiscard]] bool is_virtual(const Device& device);
[[nodiscard]] core::can::Timing timing_of(const Device& device);

/// Lines about all that was read.
[[nodiscard]] std::vector<Line> judge(const Device& device);

/// Why no probe frame can be sent, and how it could be; nothing: it can.
[[nodiscard]] std::optional<std::string> why_not_send(const Device& device, bool may_send);

}  // namespace mlcca::doctor
