// SPDX-License-Identifier: BSD-2-Clause
// mlccactl top: a screen that follows the gateway, or batches of output.
#pragma once
#include <cstdint>
#include <string>

#include "tools/exit.hpp"

namespace mlcca::tools {

struct Options;

/// The arguments as typed.
struct TopArguments {
  double delay = 1;  ///< seconds
  bool batch = false;
  std::uint32_t count = 0;  ///< batches or screens; 0: without end
  std::string by = "subject";
  std::string sort = "rate";
  bool reverse = false;
  std::string filter;
};

/// Runs the verb until the user quits, `count` is reached or an error occurs.
Exit follow(const Options& options, const TopArguments& arguments);

}  // namespace mlcca::tools
