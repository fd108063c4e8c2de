// SPDX-License-Identifier: BSD-2-Clause
// Programs of gates in this kernel that no pin names any more: of a daemon that died and whose pins
// were removed, of a gate that came back with its device.
#pragma once
#include <cstdint>
#include <map>

#include "base/result.hpp"

namespace mlcca::enforce {

/// All programs of ours by their ids, of any gateway on this machine; true: it lets pass what is
/// granted, false: it drops everything (`mlccad --close` puts those there). Takes some ms. Error:
/// the kernel has no type information (BTF), or no privilege.
Result<std::map<std::uint32_t, bool>> programs_of_gates();
/// False where that cannot be found out.
bool is_of_a_gate(std::uint32_t program);

}  // namespace mlcca::enforce
