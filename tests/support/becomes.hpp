// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <poll.h>

#include <chrono>

namespace mlcca::test {

/// Checks every millisecond until it holds; false after a time that is generous for a busy machine.
bool becomes(auto holds) {
  constexpr std::chrono::seconds kPatience{60};
  const auto start = std::chrono::steady_clock::now();
  while (!holds()) {
    if (std::chrono::steady_clock::now() - start > kPatience) return false;
    poll(nullptr, 0, 1);
  }
  return true;
}

}  // namespace mlcca::test
