// SPDX-License-Identifier: BSD-2-Clause
// Parts of a network of so many bytes a second, as all of these tests have them.
#pragma once
#include <cstddef>
#include <numeric>
#include <vector>

#include "core/reserve/parts.hpp"

namespace mlcca::core::cluster::test {

inline Part part_of(std::size_t network, Value bytes) {
  Part part;
  part.network = network;
  if (bytes != 0) part.rates.push_back({.bytes_per_second = bytes, .source = {.admission = 1}});
  return part;
}

inline Value bytes_of(const std::vector<RatePart>& rates) {
  return std::accumulate(rates.begin(), rates.end(), Value{0},
                         [](Value sum, const RatePart& one) { return sum + one.bytes_per_second; });
}

}  // namespace mlcca::core::cluster::test
