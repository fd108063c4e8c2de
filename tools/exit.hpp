// SPDX-License-Identifier: BSD-2-Clause
// The exit status of mlccactl, which all programs that carry out its verbs share.
#pragma once
#include <cstdint>

namespace mlcca::tools {

/// The exit statuses; scripts rely on their values.
enum class Exit : std::uint8_t {
  fine = 0,     ///< granted, without findings, or there was nothing to decide
  refused = 1,  ///< a requested delivery is not granted, or a check has findings
  usage = 2,    ///< the command line or a description cannot be used
  world = 3,    ///< no daemon, no permission, or an error of the kernel or the disk
};

}  // namespace mlcca::tools
