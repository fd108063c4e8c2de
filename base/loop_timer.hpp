// SPDX-License-Identifier: BSD-2-Clause
// A timer of the event loop (sd-event), and the time of the loop.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <ctime>
#include <functional>
#include <memory>
#include <utility>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "base/system_error.hpp"

namespace mlcca {

/// An event source that ends with its owner, even within its own handler.
using EventSource = std::unique_ptr<sd_event_source, FreeWith<sd_event_source_disable_unref>>;

/// CLOCK_MONOTONIC, ns, at which this turn of the loop began.
[[nodiscard]] inline std::uint64_t loop_time(sd_event* loop) {
  std::uint64_t micros = 0;
  // NOLINTNEXTLINE(bugprone-unused-return-value): it fails for clocks that it does not know
  (void)sd_event_now(loop, CLOCK_MONOTONIC, &micros);
  return micros * 1000;
}

/// Calls a function from the loop, once for each call of set().
class LoopTimer {
 public:
  LoopTimer() = default;
  LoopTimer(const LoopTimer&) = delete;
  LoopTimer& operator=(const LoopTimer&) = delete;
  LoopTimer(LoopTimer&&) = delete;
  LoopTimer& operator=(LoopTimer&&) = delete;
  ~LoopTimer() = default;

  /// Starts the timer. It first fires in the next turn.
  [[nodiscard]] Result<void> start(sd_event* loop, std::function<void()> call) {
    constexpr std::uint64_t accuracy = 10'000;  // µs
    call_ = std::move(call);
    sd_event_source* raw = nullptr;
    const int e =
        sd_event_add_time_relative(loop, &raw, CLOCK_MONOTONIC, 0, accuracy, on_time, this);
    if (e < 0) return system_error("timer", -e);
    source_.reset(raw);
    return {};
  }

  /// Fires `micros` µs from now. Replaces an earlier setting.
  void set(std::uint64_t micros) {
    sd_event_source_set_time_relative(source_.get(), micros);
    sd_event_source_set_enabled(source_.get(), SD_EVENT_ONESHOT);
  }

 private:
  static int on_time(sd_event_source*, std::uint64_t, void* self) noexcept {
    static_cast<LoopTimer*>(self)->call_();
    return 0;
  }

  EventSource source_;
  std::function<void()> call_;
};

}  // namespace mlcca
