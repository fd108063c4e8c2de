// SPDX-License-Identifier: BSD-2-Clause
// How often programs poll, and how often at most they report what has changed.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>

#include "base/loop_timer.hpp"
#include "base/result.hpp"

namespace mlcca {

inline constexpr std::uint64_t kPollInterval =
    1'000'000;                                         ///< µs after which a source is polled again
inline constexpr std::uint64_t kLeastPause = 100'000;  ///< µs between two reports

/// Calls a function when asked to, but not more often than every kLeastPause. Earlier requests are
/// served together when that time has passed.
class Throttle {
 public:
  [[nodiscard]] Result<void> start(sd_event* loop, std::function<void()> call);
  void ask();

 private:
  void go();

  sd_event* loop_ = nullptr;
  std::function<void()> call_;
  std::uint64_t next_ = 0;  ///< ns
  bool asked_ = false;
  LoopTimer timer_;
};

}  // namespace mlcca
