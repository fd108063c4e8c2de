// SPDX-License-Identifier: BSD-2-Clause
// The terminal as a screen, and as it was again whatever ends us.
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

/// Both ends are a terminal that can place its cursor: not with TERM=dumb or without TERM.
[[nodiscard]] bool has_screen();

/// While it lives: keys come one by one and unseen, the screen is another one than the shell's, and
/// the signals that end, stop or resize us are waited for with the keys.
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

  struct Happened {
    std::string keys;
    int signal = 0;     ///< that ends us, or stopped us and we go on
    bool gone = false;  ///< the terminal is gone
  };
  /// Waits for keys, a signal or the end of the time.
  [[nodiscard]] Happened wait(std::chrono::milliseconds time) const;

  /// SIGTSTP: gives the terminal back, stops, and takes it again when it goes on.
  void stop_and_go_on();
  /// Gives the terminal back and ends the process by that signal, so that the shell knows.
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
