// SPDX-License-Identifier: BSD-2-Clause
// What must hold for every input. A target ends at the first thing that does not.
#pragma once
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace mlcca::fuzz {

/// Where it is said; a target whose code writes a log to stderr has another one.
inline int demand_fd = STDERR_FILENO;

inline void demand(bool holds, const std::string& what) {
  if (holds) return;
  ::dprintf(demand_fd, "does not hold: %s\n", what.c_str());  // NOLINT(*-vararg)
  std::abort();
}

}  // namespace mlcca::fuzz
