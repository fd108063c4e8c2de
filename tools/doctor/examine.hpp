// SPDX-License-Identifier: BSD-2-Clause
// Runs all checks of one interface in order.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "tools/doctor/line.hpp"
#include "tools/doctor/probe.hpp"

namespace mlcca::doctor {

/// What the operator asks for.
struct Request {
  std::string interface;
  std::string bpf_root;  ///< bpffs folder in which mlccad pins its gates
  bool send = false;
  Identifier id;
  std::optional<unsigned> fifo_depth;  ///< depth of the controller's FIFO that the description
                                       ///< states
  unsigned bus_off_seconds = 0;  ///< how long to wait for a bus-off; 0: that check is left out
};

/// Why there is nothing to examine under that name; nullopt if there is, or if it is not known.
std::optional<std::string> why_no_controller(const std::string& interface);

/// Runs the checks. `say` prints what happens and what the operator must do. An error if the
/// interface cannot be read.
Result<std::vector<Line>> examine(const Request& request,
                                  const std::function<void(const std::string&)>& say);

}  // namespace mlcca::doctor
