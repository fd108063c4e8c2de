// SPDX-License-Identifier: BSD-2-Clause
// What goes through very many channels, rules or slots says now and then that it goes on.
#pragma once
#include <functional>
#include <utility>

namespace mlcca::core {

/// While it lives, `on_step` is called on this thread as made() and step() say. It must not touch
/// what is being worked on.
class Progress {
 public:
  explicit Progress(std::function<void()> on_step)
      : on_step_(std::move(on_step)), before_(std::exchange(current_, this)) {}
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  Progress(Progress&&) = delete;
  Progress& operator=(Progress&&) = delete;
  ~Progress() { current_ = before_; }

  /// After what takes as long as the decision of a channel.
  static void made() {
    if (current_ != nullptr) current_->on_step_();
  }
  /// After what takes a microsecond or less: so many of these are reported as one.
  static void step() {
    if (current_ != nullptr && ++current_->steps_ % kSteps == 0) current_->on_step_();
  }
  /// A projection for algorithms that compare: each read of an element is a step.
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
