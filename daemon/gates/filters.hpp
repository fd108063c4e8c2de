// SPDX-License-Identifier: BSD-2-Clause
// Our two filters in the clsact hooks of an interface. They have a fixed priority and handle; no
// other filters are touched.
#pragma once
#include <cstdint>

#include "base/result.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::gates {

/// The id of the program in our place; 0 if there is none, or no clsact.
Result<std::uint32_t> program_in_place(std::uint32_t ifindex, Direction direction);

/// Makes the clsact queueing discipline. No effect if there is one.
Result<void> make_hooks(std::uint32_t ifindex);

/// Puts a program in our place, replacing what is there.
Result<void> put_filter(std::uint32_t ifindex, Direction direction, int program_fd);
/// Puts a program in our place if that is empty; false if it is not.
Result<bool> put_filter_if_empty(std::uint32_t ifindex, Direction direction, int program_fd);
/// Puts a program before other filters of our priority. For a moment there are two filters of ours.
Result<void> put_filter_first(std::uint32_t ifindex, Direction direction, int program_fd);
/// Removes our filter, if it is there.
void remove_filter(std::uint32_t ifindex, Direction direction);

}  // namespace mlcca::gates
