// SPDX-License-Identifier: BSD-2-Clause
// Access to the clocks of the kernel, and an interface for them that tests can replace.
#pragma once
#include <cstdint>
#include <ctime>

namespace mlcca {

inline std::uint64_t clock_ns(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000 +
         static_cast<std::uint64_t>(now.tv_nsec);
}
/// A time that never goes back (CLOCK_MONOTONIC).
inline std::uint64_t monotonic_ns() { return clock_ns(CLOCK_MONOTONIC); }
inline std::int64_t monotonic_s() {
  return static_cast<std::int64_t>(monotonic_ns() / 1'000'000'000);
}
/// Nanoseconds since 1970, UTC (CLOCK_REALTIME). An administrator or a time service may set it.
inline std::uint64_t unix_ns() { return clock_ns(CLOCK_REALTIME); }

/// The clocks of the machine behind an interface, so that a test can set the time.
class Clock {
 public:
  Clock() = default;
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;
  Clock(Clock&&) = delete;
  Clock& operator=(Clock&&) = delete;
  virtual ~Clock() = default;

  /// Nanoseconds of CLOCK_MONOTONIC, which never go back.
  [[nodiscard]] virtual std::uint64_t monotonic_ns() const = 0;
  /// Nanoseconds since 1970, UTC; an administrator or a time service may set this clock.
  [[nodiscard]] virtual std::uint64_t unix_ns() const = 0;
  [[nodiscard]] std::int64_t monotonic_s() const {
    return static_cast<std::int64_t>(monotonic_ns() / 1'000'000'000);
  }
};

/// The clocks of the kernel.
class SystemClock final : public Clock {
 public:
  [[nodiscard]] std::uint64_t monotonic_ns() const override { return mlcca::monotonic_ns(); }
  [[nodiscard]] std::uint64_t unix_ns() const override { return mlcca::unix_ns(); }
};

}  // namespace mlcca
