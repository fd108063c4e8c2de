// SPDX-License-Identifier: BSD-2-Clause
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
inline std::uint64_t monotonic_ns() { return clock_ns(CLOCK_MONOTONIC); }
inline std::int64_t monotonic_s() {
  return static_cast<std::int64_t>(monotonic_ns() / 1'000'000'000);
}
/// Since 1970, UTC.
inline std::uint64_t unix_ns() { return clock_ns(CLOCK_REALTIME); }

}  // namespace mlcca
