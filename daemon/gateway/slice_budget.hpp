// SPDX-License-Identifier: BSD-2-Clause
// Decides when a slice of a reply is long enough.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/clock.hpp"
#include "daemon/serve/server.hpp"

namespace mlcca {

/// A budget of rows and time for one slice.
class SliceBudget {
 public:
  /// `row_bytes` is the size of a usual row in the encoded reply.
  explicit SliceBudget(std::size_t row_bytes) : left_(serve::Server::kSliceBytes / row_bytes) {}

  /// Counts rows that were made; false if the next one belongs to another slice.
  bool made(std::size_t rows = 1) {
    left_ -= rows < left_ ? rows : left_;
    return left_ != 0 && monotonic_ns() < end_;
  }

 private:
  std::size_t left_;
  std::uint64_t end_ = monotonic_ns() + serve::Server::kSlice;
};

}  // namespace mlcca
