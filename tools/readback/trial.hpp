// SPDX-License-Identifier: BSD-2-Clause
// What frames through the copy of one gate have shown.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tools/readback/fate.hpp"

namespace mlcca::readback {

struct Trial {
  std::uint32_t ifindex = 0;
  std::size_t passed = 0;   ///< frames that had to pass and did
  std::size_t dropped = 0;  ///< frames that had to be dropped and were
  std::vector<std::string> problems;
  std::vector<std::string> untried;  ///< what could not be shown, and why

  /// `closed`: the gates were.
  void note(const std::string& frame, Fate fate, bool admitted, bool closed);
};

}  // namespace mlcca::readback
