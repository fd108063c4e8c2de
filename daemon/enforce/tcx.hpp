// SPDX-License-Identifier: BSD-2-Clause
// TCX (Linux 6.6): programs of an interface in an order of their own, before clsact. A program is
// held there by a link, and goes with the last reference to it.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "core/handle.hpp"
#include "core/result.hpp"
#include "daemon/enforce/slots.hpp"

namespace mlcca::enforce {

/// What runs in one direction, first to last.
struct TcxOrder {
  std::uint64_t revision = 0;  ///< another one when the order has changed
  std::vector<std::uint32_t> programs;
};

/// Nothing where the kernel has no TCX.
Result<std::optional<TcxOrder>> tcx_order(std::uint32_t ifindex, Direction direction);
bool kernel_has_tcx();

/// Puts a program before all others.
Result<Fd> tcx_attach_first(std::uint32_t ifindex, Direction direction, int program_fd);
/// In the place of the program that the link holds.
Result<void> tcx_update(int link_fd, int program_fd);

/// At once, whoever else holds the link; it is dead then.
void tcx_detach(int link_fd);

/// Of the program that a TCX link holds on this interface; 0: the link is of another kind or
/// interface, or its interface is gone.
std::uint32_t tcx_program(int link_fd, std::uint32_t ifindex);

}  // namespace mlcca::enforce
