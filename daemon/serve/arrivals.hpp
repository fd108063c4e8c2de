// SPDX-License-Identifier: BSD-2-Clause
// Limits how often a user may connect. No I/O: times are arguments, in ns of any steady clock.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/result.hpp"
#include "daemon/serve/turns.hpp"

namespace mlcca::serve {

/// A token bucket of connections for each user.
class Arrivals {
 public:
  Arrivals(Rate members, Rate others) : users_(members, others) {}
  /// Counts one more connection of this user. The error says why it is to be closed at once
  /// instead.
  Result<void> let_in(Turns::User user, std::uint64_t now);
  [[nodiscard]] std::size_t users() const { return users_.size(); }

 private:
  void tidy(std::uint64_t now);
  Buckets users_;
  std::uint64_t tidied_ = 0;
};

}  // namespace mlcca::serve
