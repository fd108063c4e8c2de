// SPDX-License-Identifier: BSD-2-Clause
// TCX (Linux 6.6): a list of programs of an interface that runs before clsact. Ours are attached
// without a BPF link, so only the interface holds them, and they stay when this process and all
// pins are gone. A link would end with its last reference, and the program with it.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::gates {

inline constexpr std::uint32_t kLoopback = 1;  ///< the first interface of every network namespace

/// The programs of one direction, in their order.
struct TcxOrder {
  std::uint64_t revision = 0;  ///< changes with every change of the order
  std::vector<std::uint32_t> programs;
  [[nodiscard]] bool has(std::uint32_t program) const;
};

/// nullopt if the kernel has no TCX.
Result<std::optional<TcxOrder>> tcx_order(std::uint32_t ifindex, Direction direction);
bool kernel_has_tcx();

/// Puts a program before all others. A program can be in the list only once.
Result<void> tcx_attach_first(std::uint32_t ifindex, Direction direction, int program_fd);
/// Replaces a program by another one: at every moment one of them runs.
Result<void> tcx_replace(std::uint32_t ifindex, Direction direction, int former_fd, int program_fd);

Result<void> tcx_detach(std::uint32_t ifindex, Direction direction, int program_fd);
/// Detaches a program of which only the id is known, and which is not alone there: the kernel finds
/// it by its neighbour. Error ESTALE: the order has changed meanwhile.
Result<void> tcx_detach_beside(std::uint32_t ifindex, Direction direction, const TcxOrder& order,
                               std::uint32_t program);

}  // namespace mlcca::gates
