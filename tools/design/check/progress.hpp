// SPDX-License-Identifier: BSD-2-Clause
// Shows the progress of long work on one line of a terminal.
#pragma once
#include <chrono>
#include <functional>
#include <string_view>

namespace mlcca::tools::design {

/// Writes "reading 45 %" over the former text: nothing in the first second, then at most ten times
/// a second. The text is erased at the end.
class ProgressLine {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Now = std::function<Time()>;
  using Write = std::function<void(std::string_view)>;

  /// Starts the first second.
  ProgressLine(Now now, Write write)
      : now_(std::move(now)), write_(std::move(write)), next_(now_() + kSilence) {}
  ~ProgressLine() { erase(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine(ProgressLine&&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ProgressLine& operator=(ProgressLine&&) = delete;

  /// Shows the progress `done`, from 0 to 1.
  void show(std::string_view what, double done);
  /// Erases the text; show() may be called again.
  void erase();

  static constexpr std::chrono::milliseconds kSilence{1000};
  static constexpr std::chrono::milliseconds kPause{100};

 private:
  Now now_;
  Write write_;
  Time next_;
  bool shown_ = false;
};

}  // namespace mlcca::tools::design
