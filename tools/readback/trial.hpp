// SPDX-License-Identifier: BSD-2-Clause
// The results of sending frames through the copy of a gate.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tools/readback/fate.hpp"

namespace mlcca::readback {

/// The results for one gate.
struct Trial {
  std::uint32_t ifindex = 0;
  std::size_t passed = 0;   ///< frames that had to pass and did
  std::size_t dropped = 0;  ///< frames that had to be dropped and were
  std::vector<std::string> problems;
  std::vector<std::string> untried;  ///< what could not be tried, and why

  /// Records the fate of a frame; `closed` states that the gates were closed.
  void note(const std::string& frame, Fate fate, bool admitted, bool closed);
};

}  // namespace mlcca::readback
