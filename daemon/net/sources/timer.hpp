// SPDX-License-Identifier: BSD-2-Clause
// Helpers of sources for the event loop: handles, time, and polling at intervals.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <memory>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "core/mesh/sample.hpp"

namespace mlcca::net {

/// An event source that ends with its owner, even within its own handler.
using EventSource = std::unique_ptr<sd_event_source, FreeWith<sd_event_source_disable_unref>>;

inline constexpr std::uint64_t kPollInterval = 1'000'000;  ///< µs after which sources poll again
inline constexpr std::uint64_t kLeastPause = 100'000;      ///< µs between two snapshots of a source

/// CLOCK_MONOTONIC, ns, at which this turn of the loop began.
[[nodiscard]] std::uint64_t time_of(sd_event* loop);

/// Gives every link of the snapshot the same time.
void stamp(core::mesh::Snapshot& snapshot, std::uint64_t taken);

/// The text "WHAT: words of the error".
[[nodiscard]] std::string error_words(const std::string& what, int error);

/// Calls a function from the loop, once for each call of set().
class Timer {
 public:
  Timer() = default;
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;
  Timer(Timer&&) = delete;
  Timer& operator=(Timer&&) = delete;
  ~Timer() = default;

  /// Starts the timer. It first fires in the next turn.
  [[nodiscard]] Result<void> start(sd_event* loop, std::function<void()> call);
  /// Fires `micros` µs from now. Replaces an earlier setting.
  void set(std::uint64_t micros);

 private:
  static int on_time(sd_event_source*, std::uint64_t, void* self) noexcept;

  EventSource source_;
  std::function<void()> call_;
};

/// Calls a function when asked to, but not more often than every kLeastPause. Earlier requests are
/// served together when that time has passed.
class Pace {
 public:
  [[nodiscard]] Result<void> start(sd_event* loop, std::function<void()> call);
  void ask();

 private:
  void go();

  sd_event* loop_ = nullptr;
  std::function<void()> call_;
  std::uint64_t next_ = 0;  ///< ns
  bool asked_ = false;
  Timer timer_;
};

}  // namespace mlcca::net
