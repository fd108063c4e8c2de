// SPDX-License-Identifier: BSD-2-Clause
// A copy of the gateway in a network namespace of its own: virtual interfaces with the names and
// indices of the real ones, our programs with copies of the tables in force. Frames that are sent
// there touch no bus, no counter and nobody's share.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "daemon/enforce/readback.hpp"

namespace mlcca::readback {

/// What the frames of one gate have shown.
struct Trial {
  std::uint32_t ifindex = 0;
  std::size_t passed = 0;   ///< frames that had to pass and did
  std::size_t dropped = 0;  ///< frames that had to be dropped and were
  std::vector<std::string> problems;
  std::vector<std::string> untried;  ///< what could not be shown, and why
};

/// Sends frames through copies of all CAN gates of the reading: as they are now, and closed. This
/// thread enters the namespaces and stays there. `root`: the bpffs of the reading. Errors: no
/// privilege, a kernel without virtual CAN.
Result<std::vector<Trial>> try_gates(const enforce::Reading& reading, const std::string& root);

}  // namespace mlcca::readback
