// SPDX-License-Identifier: BSD-2-Clause
// Leases of admissions: an application that stops renewing loses what it reserved. Bookkeeping
// only: time comes in as argument, in nanoseconds of any steady clock.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace mlcca {

class Leases {
 public:
  /// What never ends; next_deadline() when there is no lease that does.
  static constexpr std::uint64_t kUnbounded = ~std::uint64_t{0};

  /// Admission `id` lives until `now` + `length_ns`, unless renewed. A lease that it had before is
  /// replaced. A lease whose end would exceed 2^64-1 never ends.
  void set(std::uint64_t id, std::uint64_t length_ns, std::uint64_t now);
  /// From `now` on as long as it was set for; nothing for an id without a lease.
  void renew(std::uint64_t id, std::uint64_t now);
  /// Ends `by_ns` from `now` on, and is as long as before when it is renewed.
  void postpone(std::uint64_t id, std::uint64_t by_ns, std::uint64_t now);
  void forget(std::uint64_t id);

  /// Those whose end has come (end <= now), the one that ended first in front, and not more of them
  /// than `most`. They stay until they are forgotten or renewed.
  [[nodiscard]] std::vector<std::uint64_t> expired(std::uint64_t now,
                                                   std::size_t most = ~std::size_t{0}) const;
  /// When the first one ends.
  [[nodiscard]] std::uint64_t next_deadline() const;
  /// Nanoseconds until it ends: 0 when it has ended, kUnbounded when it never does; nothing for an
  /// id without a lease.
  [[nodiscard]] std::optional<std::uint64_t> remaining(std::uint64_t id, std::uint64_t now) const;

 private:
  struct Lease {
    std::uint64_t length_ns = 0;
    std::uint64_t end = 0;
  };
  void end_after(std::uint64_t id, Lease& lease, std::uint64_t ns, std::uint64_t now);

  std::map<std::uint64_t, Lease> by_id_;
  std::set<std::pair<std::uint64_t, std::uint64_t>> by_end_;  ///< end, id
};

}  // namespace mlcca
