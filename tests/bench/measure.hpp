// SPDX-License-Identifier: BSD-2-Clause
// What benches measure by.
#pragma once
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace mlcca::bench {

inline void require(bool good, const std::string& what) {
  if (!good) throw std::runtime_error(what);
}

template <class Work>
double microseconds(const Work& work) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  work();
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

/// `part`: 0.5 is the median.
inline double quantile(std::vector<double> values, double part) {
  const auto at = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + at);
  return values[static_cast<std::size_t>(at)];
}

}  // namespace mlcca::bench
