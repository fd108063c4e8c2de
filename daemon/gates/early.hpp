// SPDX-License-Identifier: BSD-2-Clause
// Our program in the driver of an interface (XDP), where the driver has a place for one. It goes
// with the device to another network namespace and comes back with it, when its pin is long gone.
// Who asks the kernel for a program by its id needs CAP_SYS_ADMIN: so those of ours are noted.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/attachment.hpp"

namespace mlcca::enforce {

/// Id of the program in the driver; 0: none.
std::uint32_t early_program(std::uint32_t ifindex);
/// Ids of the XDP programs beside `ours`, wherever they run: all see frames before tc does.
std::vector<std::uint32_t> other_early_programs(std::uint32_t ifindex, std::uint32_t ours);

/// Puts a program there, where there is none or, with `replace`, instead of what is there. False:
/// the driver has no place, or another program is there.
bool put_early(std::uint32_t ifindex, int program_fd, bool replace);

/// Takes a program out of the driver, if it is there.
void remove_early(std::uint32_t ifindex, int program_fd);

/// Before it is put anywhere. `root`: above the layouts, so that an upgrade knows them too.
Result<void> note_early(const std::string& root, std::uint32_t program);
bool is_noted_early(const std::string& root, std::uint32_t program);

/// Ours takes the place of ours, be it of a daemon before this one, or come back with its device;
/// elsewhere it is put where no program of another owner is. Gives whether it is there. Between
/// the check and the attachment another program can be attached.
Result<bool> put_early_in_place(const Place& place, int program_fd);

}  // namespace mlcca::enforce
