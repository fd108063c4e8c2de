// SPDX-License-Identifier: BSD-2-Clause
// The passive checks of a CAN interface: what can be read without sending, and its assessment.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/can/frame.hpp"
#include "daemon/net/can_controller.hpp"
#include "daemon/net/links.hpp"
#include "tools/doctor/line.hpp"

namespace mlcca::doctor {

/// What mlccad's gate does on the interface.
enum class Gate : std::uint8_t {
  none,
  audit,      ///< it drops nothing
  enforcing,  ///< it drops everything that is not admitted, also the frames of doctor
  unknown,
};

/// What was read about an interface.
struct Device {
  net::Link link;
  net::CanController controller;
  Gate gate = Gate::none;
  std::string gate_error;  ///< why `gate` is unknown
};

/// A vcan or vxcan interface: it has no controller, and frames take no time on a bus.
[[nodiscard]] bool is_virtual(const Device& device);
[[nodiscard]] core::can::Timing timing_of(const Device& device);

/// The result lines of all passive checks.
[[nodiscard]] std::vector<Line> judge(const Device& device);

/// Why no probe frame can be sent and how to change that; nullopt if one can.
[[nodiscard]] std::optional<std::string> why_not_send(const Device& device, bool may_send);

}  // namespace mlcca::doctor
