// SPDX-License-Identifier: BSD-2-Clause
// A copy of the gateway in a network namespace of its own: virtual interfaces with the names and
// indices of the real ones, our programs with copies of the tables in force. Frames that are sent
// there touch no bus, no counter of the gateway and no publisher's share.
#pragma once
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/readback.hpp"
#include "tools/readback/trial.hpp"

namespace mlcca::readback {

/// Sends frames through copies of all gates of the reading: as they are now, and closed. This
/// thread enters the namespaces and stays there. `root`: the bpffs of the reading. Errors: no
/// privilege, a kernel without virtual interfaces.
Result<std::vector<Trial>> try_gates(const enforce::Reading& reading, const std::string& root);

}  // namespace mlcca::readback
