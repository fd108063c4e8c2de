// SPDX-License-Identifier: BSD-2-Clause
// Sets timerfds.
#pragma once
#include <sys/timerfd.h>

#include <chrono>

#include "base/handle.hpp"

namespace mlcca {

/// Sets a timerfd: it becomes readable once, after `time`. This replaces an earlier setting; 0
/// switches the timer off.
inline void start_timer(const Fd& timer, std::chrono::milliseconds time) {
  constexpr long in_a_second = 1000;
  constexpr long in_a_milli = 1'000'000;
  itimerspec at{};
  at.it_value.tv_sec = time.count() / in_a_second;
  at.it_value.tv_nsec = time.count() % in_a_second * in_a_milli;
  ::timerfd_settime(timer.get(), 0, &at, nullptr);
}

}  // namespace mlcca
