// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstdint>
#include <string>

namespace mlcca::enforce {

/// Before the pins of a device that is gone are removed: our programs go on with it where it is
/// now, and let everything pass there.
void retire_gate(const std::string& directory);

/// The kernel knows no interface of that index in this network namespace.
bool is_gone(std::uint32_t ifindex);

}  // namespace mlcca::enforce
