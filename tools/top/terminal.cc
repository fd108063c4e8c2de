// SPDX-License-Identifier: BSD-2-Clause
#include "tools/top/terminal.hpp"

#include <poll.h>
#include <sys/ioctl.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>

namespace mlcca::tools::top {
namespace {

// Switch to the alternate screen, hide the cursor and disable line wrapping; and the reverse.
constexpr std::string_view kEnter = "\x1b[?1049h\x1b[?25l\x1b[?7l\x1b[2J";
constexpr std::string_view kLeave = "\x1b[?7h\x1b[?25h\x1b[?1049l";

constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGCONT, SIGWINCH};

sigset_t signals_of_interest() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : kSignals) sigaddset(&set, signal);
  return set;
}

bool write_all(std::string_view text) {
  while (!text.empty()) {
    const auto n = ::write(STDOUT_FILENO, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

/// Performs the default action of a blocked signal.
void suffer(int signal) {
  sigset_t one;
  sigemptyset(&one);
  sigaddset(&one, signal);
  ::signal(signal, SIG_DFL);  // NOLINT(cert-err33-c): a known signal
  ::raise(signal);            // NOLINT(cert-err33-c)
  ::pthread_sigmask(SIG_UNBLOCK, &one, nullptr);
  ::pthread_sigmask(SIG_BLOCK, &one, nullptr);
}

}  // namespace

bool has_screen() {
  const char* terminal = std::getenv("TERM");  // NOLINT(concurrency-mt-unsafe)
  return terminal != nullptr && *terminal != '\0' && std::string_view(terminal) != "dumb" &&
         ::isatty(STDIN_FILENO) != 0 && ::isatty(STDOUT_FILENO) != 0;
}

Result<Terminal> Terminal::take() {
  termios before{};
  if (::tcgetattr(STDIN_FILENO, &before) < 0)
    return fail(std::string("the terminal: ") + std::strerror(errno));  // NOLINT
  const sigset_t set = signals_of_interest();
  ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
  Fd signals(::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!signals) return fail(std::string("signalfd: ") + std::strerror(errno));  // NOLINT
  Terminal terminal(std::move(signals), before);
  terminal.enter();
  return terminal;
}

Terminal::Terminal(Fd signals, const termios& before)
    : signals_(std::move(signals)), before_(before) {}

Terminal::Terminal(Terminal&& other) noexcept
    : signals_(std::move(other.signals_)),
      before_(other.before_),
      entered_(std::exchange(other.entered_, false)) {}

Terminal::~Terminal() { leave(); }

void Terminal::enter() {
  termios raw = before_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_cc[VMIN] = 1;
  raw.c_cc[VTIME] = 0;
  ::tcsetattr(STDIN_FILENO, TCSADRAIN, &raw);
  write_all(kEnter);
  entered_ = true;
}

void Terminal::leave() {
  if (!std::exchange(entered_, false)) return;
  write_all(kLeave);
  ::tcsetattr(STDIN_FILENO, TCSADRAIN, &before_);
}

Size Terminal::size() {
  winsize window{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) < 0 || window.ws_col == 0 || window.ws_row == 0)
    return {};
  return {window.ws_col, window.ws_row};
}

bool Terminal::draw(const std::vector<std::string>& lines) {
  std::string text = "\x1b[H";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    text += lines[i];
    text += "\x1b[K";
    if (i + 1 < lines.size()) text += "\r\n";
  }
  return write_all(text);
}

Terminal::Happened Terminal::wait(std::chrono::milliseconds time) const {
  Happened happened;
  std::array<pollfd, 2> all{{{STDIN_FILENO, POLLIN, 0}, {signals_.get(), POLLIN, 0}}};
  if (::poll(all.data(), all.size(), static_cast<int>(time.count())) <= 0) return happened;
  if ((all[1].revents & POLLIN) != 0) {
    signalfd_siginfo info{};
    if (::read(signals_.get(), &info, sizeof info) == sizeof info)
      happened.signal = static_cast<int>(info.ssi_signo);
  }
  if (all[0].revents != 0) {
    std::array<char, 256> buffer{};
    const auto n = ::read(STDIN_FILENO, buffer.data(), buffer.size());
    if (n > 0)
      happened.keys.assign(buffer.data(), static_cast<std::size_t>(n));
    else
      happened.gone = n == 0 || (errno != EINTR && errno != EAGAIN);
  }
  return happened;
}

void Terminal::stop_and_go_on() {
  leave();
  suffer(SIGTSTP);
  enter();
}

void Terminal::end_by(int signal) {
  leave();
  suffer(signal);
  std::_Exit(128 + signal);  // in case the signal has not ended the process
}

}  // namespace mlcca::tools::top
