// SPDX-License-Identifier: BSD-2-Clause
// The leases of admissions: an application that stops renewing loses its reservation. Bookkeeping
// only: times are arguments, in ns of any steady clock.
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
  /// A lease that never ends; also the result of next_deadline() if there is no other lease.
  static constexpr std::uint64_t kUnbounded = ~std::uint64_t{0};

  /// Admission `id` lives until `now` + `length_ns` unless it is renewed. A former lease is
  /// replaced. A lease whose end would exceed 2^64-1 never ends.
  void set(std::uint64_t id, std::uint64_t length_ns, std::uint64_t now);
  /// Starts the lease again at `now` with its full length. No effect for an id without a lease.
  void renew(std::uint64_t id, std::uint64_t now);
  /// Lets the lease end `by_ns` after `now`. Its length for later renewals does not change.
  void postpone(std::uint64_t id, std::uint64_t by_ns, std::uint64_t now);
  void forget(std::uint64_t id);

  /// At most `most` leases that have ended (end <= now), the earliest first. They stay until they
  /// are forgotten or renewed.
  [[nodiscard]] std::vector<std::uint64_t> expired(std::uint64_t now,
                                                   std::size_t most = ~std::size_t{0}) const;
  /// When the first lease ends; kUnbounded if none does.
  [[nodiscard]] std::uint64_t next_deadline() const;
  /// Nanoseconds until the lease ends: 0 if it has ended, kUnbounded if it never does; nullopt for
  /// an id without a lease.
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
