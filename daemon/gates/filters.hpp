// SPDX-License-Identifier: BSD-2-Clause
// Our two places in the clsact hooks of an interface: fixed priority and handle, nothing else.
#pragma once
#include <cstdint>

#include "base/result.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::enforce {

/// Id of the program in our place; 0: none, or no clsact there.
Result<std::uint32_t> program_in_place(std::uint32_t ifindex, Direction direction);

/// Makes the clsact queueing discipline; harmless when there is one.
Result<void> make_hooks(std::uint32_t ifindex);

/// Puts a program in our place, instead of what is there.
Result<void> put_filter(std::uint32_t ifindex, Direction direction, int program_fd);
/// Only where our place is empty: false when it is not.
Result<bool> put_filter_if_empty(std::uint32_t ifindex, Direction direction, int program_fd);
/// Before other filters of our priority. For a moment there are two of ours.
Result<void> put_filter_first(std::uint32_t ifindex, Direction direction, int program_fd);
/// Ours, if it is there.
void remove_filter(std::uint32_t ifindex, Direction direction);

}  // namespace mlcca::enforce
