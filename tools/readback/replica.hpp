// SPDX-License-Identifier: BSD-2-Clause
// A replica of the gateway in a network namespace: virtual interfaces with the names and indices of
// the real ones, and our gate programs with copies of the tables in force. Frames sent there touch
// no bus, no counter of the gateway and no publisher's policing.
#pragma once
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/readback.hpp"
#include "tools/readback/trial.hpp"

namespace mlcca::readback {

/// Sends frames through copies of all gates of the reading, first as the gates are now, then
/// closed. The calling thread enters the namespaces for good. `root` is the bpffs of the reading.
/// An error without privileges or without virtual interfaces in the kernel.
Result<std::vector<Trial>> try_gates(const gates::Reading& reading, const std::string& root);

}  // namespace mlcca::readback
