// SPDX-License-Identifier: BSD-2-Clause
// Our program in the driver of an interface (XDP), where the driver has a place for one.
#pragma once
#include <cstdint>

#include "core/result.hpp"

namespace mlcca::enforce {

/// Id of the program in the driver; 0: none.
std::uint32_t early_program(std::uint32_t ifindex);

/// Puts a program there, in the place of `ours_fd`, or where there is none (-1). False: the driver
/// has no place, or another program is there.
bool put_early(std::uint32_t ifindex, int program_fd, int ours_fd);

}  // namespace mlcca::enforce
