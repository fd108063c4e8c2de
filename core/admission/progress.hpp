// SPDX-License-Identifier: BSD-2-Clause
// What decides about very many channels says now and then that it goes on.
#pragma once
#include <functional>

namespace mlcca::core {

/// While it lives, `told` is called on this thread after each channel that was decided. It must not
/// touch what is being decided.
class Progress {
 public:
  explicit Progress(std::function<void()> told);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  Progress(Progress&&) = delete;
  Progress& operator=(Progress&&) = delete;
  ~Progress();

  /// To be called by whoever goes on.
  static void made();

 private:
  std::function<void()> told_;
  Progress* before_;
};

}  // namespace mlcca::core
