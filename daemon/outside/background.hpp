// SPDX-License-Identifier: BSD-2-Clause
// An interface for one piece of work that runs beside the loop: a thread (Reading), or a fake.
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

  /// Runs `work`, which must share no data with others, beside the loop, and then `done` in the
  /// loop. False if that is not possible, or a former piece of work still runs.
  virtual bool begin(std::function<void()> work, std::function<void()> done) = 0;
  /// Gives up waiting for the work: its `done` is not called. The work continues, and nothing else
  /// can begin until it ends.
  virtual void forget() = 0;
  /// Whether `done` is still to be called.
  [[nodiscard]] virtual bool waits() const = 0;
  /// When the work began: CLOCK_MONOTONIC, ns.
  [[nodiscard]] virtual std::uint64_t begun() const = 0;
  /// Whether work is running, forgotten or not.
  [[nodiscard]] virtual bool busy() const = 0;
};

}  // namespace mlcca
