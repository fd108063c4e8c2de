// SPDX-License-Identifier: BSD-2-Clause
// The exit status of mlccactl, whichever program carries a verb out.
#pragma once
#include <cstdint>

namespace mlcca::tools {

/// What scripts can rely on.
enum class Exit : std::uint8_t {
  fine = 0,     ///< granted, clean, or nothing to decide
  refused = 1,  ///< a delivery that was asked for is not granted; a check has findings
  usage = 2,    ///< the command line or a description cannot be used
  world = 3,    ///< no daemon, no permission, or the kernel or the disk refused
};

}  // namespace mlcca::tools
