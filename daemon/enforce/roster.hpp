// SPDX-License-Identifier: BSD-2-Clause
// Programs of gates in this kernel that no pin names any more: of a daemon that died and whose pins
// somebody removed, of a gate that came back with its device.
#pragma once
#include <cstdint>
#include <set>

#include "core/result.hpp"

namespace mlcca::enforce {

/// Ids of all programs of ours, of any gateway on this machine. Takes some ms. Error: the kernel
/// has no type information (BTF), or no privilege.
Result<std::set<std::uint32_t>> programs_of_gates();
/// Of those, the ones that let pass what they are told; `mlccad --close` puts others there.
Result<std::set<std::uint32_t>> programs_that_may_pass();
/// False where that cannot be found out.
bool is_of_a_gate(std::uint32_t program);

}  // namespace mlcca::enforce
