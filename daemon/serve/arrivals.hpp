// SPDX-License-Identifier: BSD-2-Clause
// How often a user may connect. No I/O: time comes in as argument, in nanoseconds of any steady
// clock.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/result.hpp"
#include "daemon/serve/turns.hpp"

namespace mlcca::serve {

class Arrivals {
 public:
  Arrivals(Rate members, Rate others) : users_(members, others) {}
  /// Why one more connection of this user is closed at once; otherwise it is counted.
  Result<void> let_in(Turns::User user, std::uint64_t now);
  [[nodiscard]] std::size_t users() const { return users_.size(); }

 private:
  void tidy(std::uint64_t now);
  Buckets users_;
  std::uint64_t tidied_ = 0;
};

}  // namespace mlcca::serve
