// SPDX-License-Identifier: BSD-2-Clause
// mlccactl top: a screen that follows the gateway, or one batch after the other.
#pragma once
#include <cstdint>
#include <string>

#include "tools/exit.hpp"

namespace mlcca::tools {

struct Options;

/// As typed.
struct TopArguments {
  double delay = 1;  ///< s
  bool batch = false;
  std::uint32_t count = 0;  ///< of batches or screens, 0: no end
  std::string by = "subject";
  std::string sort = "rate";
  bool reverse = false;
  std::string filter;
};

Exit follow(const Options& options, const TopArguments& arguments);

}  // namespace mlcca::tools
