// SPDX-License-Identifier: BSD-2-Clause
// What every source does with the event loop: keeps handles, asks the time, polls again after a
// while.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <memory>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "core/mesh/sample.hpp"

namespace mlcca::net {

/// Of an event source: it is over with its owner, even in the middle of its own handler.
using EventSource = std::unique_ptr<sd_event_source, FreeWith<sd_event_source_disable_unref>>;

inline constexpr std::uint64_t kPollInterval = 1'000'000;  ///< µs after which sources poll again
inline constexpr std::uint64_t kLeastPause = 100'000;      ///< µs between two snapshots of a source

/// ns, CLOCK_MONOTONIC, when this turn of the loop began.
[[nodiscard]] std::uint64_t time_of(sd_event* loop);

/// Gives every link of the snapshot the same age.
void stamp(core::mesh::Snapshot& snapshot, std::uint64_t taken);

/// "WHAT: words of the error".
[[nodiscard]] std::string error_words(const std::string& what, int error);

/// Calls a function from the loop, once for each time that it is set.
class Timer {
 public:
  Timer() = default;
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;
  Timer(Timer&&) = delete;
  Timer& operator=(Timer&&) = delete;
  ~Timer() = default;

  /// Fires at the first turn.
  [[nodiscard]] Result<void> start(sd_event* loop, std::function<void()> call);
  /// `micros` from now; replaces an earlier setting.
  void set(std::uint64_t micros);

 private:
  static int on_time(sd_event_source*, std::uint64_t, void* self) noexcept;

  EventSource source_;
  std::function<void()> call_;
};

/// Calls a function when asked to, but not more often than every kLeastPause: who asks earlier is
/// served then, once.
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
