// SPDX-License-Identifier: BSD-2-Clause
// Our XDP program in the driver of an interface, if the driver supports XDP. It stays with a device
// that moves to another network namespace and back, when its pin may be gone. Opening a program by
// its id needs CAP_SYS_ADMIN, so the ids of our programs are noted in a map.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/attachment.hpp"

namespace mlcca::gates {

/// The id of the XDP program in the driver; 0 if there is none.
std::uint32_t early_program(std::uint32_t ifindex);
/// The ids of XDP programs other than `ours`, in the driver or elsewhere. All see frames before tc
/// does.
std::vector<std::uint32_t> other_early_programs(std::uint32_t ifindex, std::uint32_t ours);

/// Puts a program into the driver if there is none, or with `replace` in place of the present one.
/// False: the driver has no support, or another program is there.
bool put_early(std::uint32_t ifindex, int program_fd, bool replace);

/// Removes a program from the driver, if it is there.
void remove_early(std::uint32_t ifindex, int program_fd);

/// Notes the id of a program of ours, before it is attached. `root` is the directory above those of
/// the layouts, so that a later version knows the notes as well.
Result<void> note_early(const std::string& root, std::uint32_t program);
bool is_noted_early(const std::string& root, std::uint32_t program);

/// Puts our program in the driver: in place of one of ours (of an earlier daemon, or that came back
/// with its device), or where there is none. Returns whether it is there. Another program can be
/// attached between the check and the attachment.
Result<bool> put_early_in_place(const GateLocation& place, int program_fd);

}  // namespace mlcca::gates
