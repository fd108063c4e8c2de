// SPDX-License-Identifier: BSD-2-Clause
// Interfaces as they are read, to be spoilt one thing at a time.
#pragma once
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "tools/doctor/device.hpp"

namespace mlcca::doctor::test {

inline Device controller() {
  Device device;
  device.link.name = "can0";
  device.link.kind = "can";
  device.link.is_can = true;
  device.link.up = device.link.running = true;
  device.link.can_state = "error-active";
  device.link.bitrate = 500'000;
  device.controller.driver = "kvaser_pci";
  device.controller.echoes = true;
  device.controller.sample_point = 875;
  device.controller.clock = 8'000'000;
  device.controller.errors = net::ErrorCounters{};
  device.controller.queue = "pfifo_fast";
  device.controller.queue_limit = 10;
  device.controller.queue_length = 10;
  return device;
}

inline Device fd_controller() {
  auto device = controller();
  device.controller.fd = true;
  device.link.data_bitrate = 2'000'000;
  return device;
}

inline Device virtual_bus() {
  Device device;
  device.link.name = "v0";
  device.link.kind = "vxcan";
  device.link.is_can = true;
  device.link.up = device.link.running = true;
  device.controller.queue = "noqueue";
  return device;
}

inline const Line& line(std::span<const Line> lines, const std::string& check) {
  return *std::ranges::find(lines, check, &Line::check);
}

}  // namespace mlcca::doctor::test
