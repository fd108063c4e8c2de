// SPDX-License-Identifier: BSD-2-Clause
// One piece of work that goes on beside the loop, as an interface: a thread (Reading), or a fake.
#pragma once
#include <cstdint>
#include <functional>

namespace mlcca {

class Background {
 public:
  Background() = default;
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;
  Background(Background&&) = delete;
  Background& operator=(Background&&) = delete;
  virtual ~Background() = default;

  /// Runs `work` beside the loop, which must share nothing with anyone, then `done` in the loop;
  /// false when it cannot be had or the former piece goes on.
  virtual bool begin(std::function<void()> work, std::function<void()> done) = 0;
  /// What is under way is not waited for any more: its `done` is not called. It goes on, and
  /// nothing else can begin until it ends.
  virtual void forget() = 0;
  /// `done` is still to be called.
  [[nodiscard]] virtual bool waits() const = 0;
  /// When it began, CLOCK_MONOTONIC, ns.
  [[nodiscard]] virtual std::uint64_t begun() const = 0;
  /// Work is under way, forgotten or not.
  [[nodiscard]] virtual bool busy() const = 0;
};

}  // namespace mlcca
