// SPDX-License-Identifier: BSD-2-Clause
// TCX (Linux 6.6): programs of an interface in an order of their own, before clsact. Ours are
// attached without a link: nothing but the interface holds them, so that they stay when this
// process and all pins are gone. A link would go with its last reference, and with it the program.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::enforce {

inline constexpr std::uint32_t kLoopback = 1;  ///< the first interface of every network namespace

/// What runs in one direction, first to last.
struct TcxOrder {
  std::uint64_t revision = 0;  ///< another one when the order has changed
  std::vector<std::uint32_t> programs;
  [[nodiscard]] bool has(std::uint32_t program) const;
};

/// Nothing where the kernel has no TCX.
Result<std::optional<TcxOrder>> tcx_order(std::uint32_t ifindex, Direction direction);
bool kernel_has_tcx();

/// Puts a program before all others. It can be there once.
Result<void> tcx_attach_first(std::uint32_t ifindex, Direction direction, int program_fd);
/// In the place of another one: at every moment one of them runs.
Result<void> tcx_replace(std::uint32_t ifindex, Direction direction, int former_fd, int program_fd);

Result<void> tcx_detach(std::uint32_t ifindex, Direction direction, int program_fd);
/// The same of a program that only its id is known of, and that is not alone there: the kernel
/// finds it beside its neighbour. Error ESTALE: the order is another one by now.
Result<void> tcx_detach_beside(std::uint32_t ifindex, Direction direction, const TcxOrder& order,
                               std::uint32_t program);

}  // namespace mlcca::enforce
