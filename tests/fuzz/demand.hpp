// SPDX-License-Identifier: BSD-2-Clause
// What must hold for every input. A target ends at the first thing that does not.
#pragma once
#include <cstdio>
#include <cstdlib>
#include <string>

namespace mlcca::fuzz {

inline void demand(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what.c_str());
  std::abort();
}

}  // namespace mlcca::fuzz
