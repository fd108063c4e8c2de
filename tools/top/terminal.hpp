// SPDX-License-Identifier: BSD-2-Clause
// The terminal as a screen, restored in whatever way the process ends.
#pragma once
#include <termios.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "tools/top/layout.hpp"

namespace mlcca::tools::top {

/// Whether standard input and output are a terminal that can position its cursor (not TERM=dumb).
[[nodiscard]] bool has_screen();

/// While it exists, keys are read one by one without echo, the alternate screen is shown, and the
/// signals that end, stop or resize the process are received together with the keys.
class Terminal {
 public:
  static Result<Terminal> take();
  Terminal(Terminal&& other) noexcept;
  Terminal& operator=(Terminal&&) = delete;
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  ~Terminal();

  [[nodiscard]] static Size size();
  /// False if the terminal is gone.
  [[nodiscard]] static bool draw(const std::vector<std::string>& lines);

  /// What wait() has received.
  struct Happened {
    std::string keys;
    int signal = 0;     ///< one that ends, stops, continues or resizes; 0: none
    bool gone = false;  ///< the terminal is gone
  };
  /// Waits for keys, a signal or the time limit.
  [[nodiscard]] Happened wait(std::chrono::milliseconds time) const;

  /// Handles SIGTSTP: restores the terminal, stops, and takes the terminal again when continued.
  void stop_and_go_on();
  /// Restores the terminal and ends the process by that signal, so that the shell sees the cause.
  [[noreturn]] void end_by(int signal);

 private:
  explicit Terminal(Fd signals, const termios& before);
  void enter();
  void leave();

  Fd signals_;
  termios before_{};
  bool entered_ = false;
};

}  // namespace mlcca::tools::top
