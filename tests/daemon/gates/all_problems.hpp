// SPDX-License-Identifier: BSD-2-Clause
// What is wrong with a gate that was read back, as one text.
#pragma once
#include <string>

#include "daemon/gates/readback.hpp"

namespace mlcca::gates {

/// A line for each problem; empty: there is none.
inline std::string all_problems(const GateReading& gate) {
  std::string all;
  for (const auto& problem : gate.problems) all += problem + "\n";
  return all;
}

}  // namespace mlcca::gates
