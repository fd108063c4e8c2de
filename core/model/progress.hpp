// SPDX-License-Identifier: BSD-2-Clause
// Progress reports from long computations, so that the heart-beat goes on while they run.
#pragma once
#include <functional>
#include <utility>

namespace mlcca::core {

/// While an object of this class lives, made() and step() on the same thread call `on_step`. It
/// must not touch the data of the computation. Objects nest; the innermost one is called.
class Progress {
 public:
  explicit Progress(std::function<void()> on_step)
      : on_step_(std::move(on_step)), before_(std::exchange(current_, this)) {}
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  Progress(Progress&&) = delete;
  Progress& operator=(Progress&&) = delete;
  ~Progress() { current_ = before_; }

  /// Reports a unit of work that takes as long as the decision of a channel.
  static void made() {
    if (current_ != nullptr) current_->on_step_();
  }
  /// Reports a unit of work that takes a microsecond or less. Only every kSteps-th is passed on.
  static void step() {
    if (current_ != nullptr && ++current_->steps_ % kSteps == 0) current_->on_step_();
  }
  /// A projection for algorithms that compare elements: each read of an element counts as a step.
  template <auto Member>
  struct At {
    const auto& operator()(const auto& element) const {
      step();
      return element.*Member;
    }
  };

 private:
  static constexpr unsigned kSteps = 32;
  static inline constinit thread_local Progress* current_ = nullptr;

  std::function<void()> on_step_;
  Progress* before_;
  unsigned steps_ = 0;
};

}  // namespace mlcca::core
