// SPDX-License-Identifier: BSD-2-Clause
// Finds the programs of gates in this kernel, also those that no pin names: of a daemon that died
// and whose pins were removed, or of a gate that came back with its device.
#pragma once
#include <cstdint>
#include <map>

#include "base/result.hpp"

namespace mlcca::gates {

/// All our programs by id, of any gateway on this machine. True: the program passes what is
/// granted; false: it drops everything (those of `mlccad --close`). Takes some ms. The error: the
/// kernel has no type information (BTF), or no privilege.
Result<std::map<std::uint32_t, bool>> programs_of_gates();
/// False also if that cannot be found out.
bool is_of_a_gate(std::uint32_t program);

}  // namespace mlcca::gates
