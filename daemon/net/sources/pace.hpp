// SPDX-License-Identifier: BSD-2-Clause
// How often link sources look, and the time that their snapshots carry.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>

#include "base/loop_timer.hpp"
#include "base/result.hpp"
#include "core/mesh/sample.hpp"

namespace mlcca::net {

inline constexpr std::uint64_t kPollInterval = 1'000'000;  ///< µs after which sources poll again
inline constexpr std::uint64_t kLeastPause = 100'000;      ///< µs between two snapshots of a source

/// Gives every link of the snapshot the same time.
void stamp(core::mesh::Snapshot& snapshot, std::uint64_t taken);

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

}  // namespace mlcca::net
