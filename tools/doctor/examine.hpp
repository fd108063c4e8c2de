// SPDX-License-Identifier: BSD-2-Clause
// All checks of one interface, one after the other.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "tools/doctor/line.hpp"
#include "tools/doctor/probe.hpp"

namespace mlcca::doctor {

struct Request {
  std::string interface;
  std::string bpf_root;  ///< where mlccad pins its gates
  bool send = false;
  Identifier id;
  std::optional<unsigned> fifo_depth;  ///< that the description says
  unsigned bus_off_seconds = 0;        ///< 0: is not waited for
};

/// `say` prints for the operator what happens, and what to do. Errors: the interface cannot be
/// read.
Result<std::vector<Line>> examine(const Request& request,
                                  const std::function<void(const std::string&)>& say);

}  // namespace mlcca::doctor
