// SPDX-License-Identifier: BSD-2-Clause
// How long a piece of work goes on without a report of progress, in units that do not depend on the
// machine.
#pragma once
#include <algorithm>
#include <cstddef>

#include "core/model/progress.hpp"

namespace mlcca::test {

/// Memory that this process has asked for, in pieces.
std::size_t allocations();

/// The work of this thread while it lives, cut at each report of core::Progress.
class Stretches {
 public:
  /// The longest one until now, in allocations.
  [[nodiscard]] std::size_t longest() {
    end();
    return longest_;
  }
  [[nodiscard]] std::size_t reports() const { return reports_; }

 private:
  void end() {
    const std::size_t now = allocations();
    longest_ = std::max(longest_, now - begun_);
    begun_ = now;
  }

  std::size_t longest_ = 0;
  std::size_t reports_ = 0;
  core::Progress progress_{[this] {
    end();
    ++reports_;
  }};
  std::size_t begun_ = allocations();
};

}  // namespace mlcca::test
