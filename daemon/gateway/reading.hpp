// SPDX-License-Identifier: BSD-2-Clause
// A description is read on a thread of its own: it may be long, its files and the users that it
// names may be slow to come. The loop goes on meanwhile (ADR 28).
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <memory>

#include "base/handle.hpp"

namespace mlcca {

/// One piece of work at a time.
class Reading {
 public:
  explicit Reading(sd_event* loop) : loop_(loop) {}

  /// Runs `work` on a thread, which must share nothing with anybody, then `done` in the loop; false
  /// when there is no thread to be had or the former one goes on.
  bool begin(std::function<void()> work, std::function<void()> done);
  /// What is under way is not waited for any more: its `done` is not called. It goes on, and
  /// nothing else can begin until it ends.
  void forget();

  [[nodiscard]] bool waits() const { return static_cast<bool>(done_); }
  /// When it began, CLOCK_MONOTONIC, ns.
  [[nodiscard]] std::uint64_t begun() const { return begun_; }
  /// A thread is under way, forgotten or not.
  [[nodiscard]] bool busy() const { return static_cast<bool>(source_); }

 private:
  static int on_end(sd_event_source*, int, std::uint32_t, void* self) noexcept;

  sd_event* loop_;
  std::shared_ptr<Fd> ended_;  ///< eventfd that the thread writes last
  std::unique_ptr<sd_event_source, FreeWith<sd_event_source_unref>> source_;
  std::function<void()> done_;
  std::uint64_t begun_ = 0;
};

}  // namespace mlcca
