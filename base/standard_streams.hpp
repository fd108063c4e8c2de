// SPDX-License-Identifier: BSD-2-Clause
// Standard output and standard error of all programs. What cannot be written to standard error is
// lost, and changes neither what a program does nor its exit status. What cannot be written to
// standard output is an error.
#pragma once
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <string>
#include <string_view>

namespace mlcca {

/// Opens /dev/null for each standard stream that is closed, so that no file which is opened later
/// becomes that stream and gets the messages. Reading standard input and writing the others still
/// fails. For the beginning of main().
inline void keep_standard_streams() {
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(fd, F_GETFD) < 0)  // open() takes the lowest free number, which is this one
      static_cast<void>(::open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY));
}

/// Writes everything, and waits while the reader is slow. Returns 0 or the errno value.
[[nodiscard]] inline int write_whole(int fd, std::string_view text) {
  while (!text.empty()) {
    const auto written = ::write(fd, text.data(), text.size());
    if (written > 0) {
      text.remove_prefix(static_cast<std::size_t>(written));
    } else if (written == 0) {
      return ENOSPC;
    } else if (errno == EAGAIN) {
      pollfd ready{.fd = fd, .events = POLLOUT, .revents = 0};
      static_cast<void>(::poll(&ready, 1, -1));
    } else if (errno != EINTR) {
      return errno;
    }
  }
  return 0;
}

/// Writes to standard error. A full disk, a closed stream and a reader that has gone are ignored.
inline void to_stderr(std::string_view text) {
  sigset_t pipe;
  sigset_t before;
  sigset_t pending;
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  sigpending(&pending);
  ::pthread_sigmask(SIG_BLOCK, &pipe, &before);
  if (write_whole(STDERR_FILENO, text) == EPIPE && sigismember(&pending, SIGPIPE) == 0) {
    const timespec at_once{};
    static_cast<void>(sigtimedwait(&pipe, nullptr, &at_once));  // discards the signal
  }
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

/// Reports that standard output cannot be written. `error` is an errno value.
inline void complain_of_stdout(std::string_view program, int error) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): one thread
  to_stderr(std::string(program) + ": standard output: " + std::strerror(error) + '\n');
}

/// Writes to standard output. False, after a message, if that fails; the program must then end with
/// the exit status for errors of the outside world.
[[nodiscard]] inline bool printed(std::string_view program, std::string_view text) {
  const int error = write_whole(STDOUT_FILENO, text);
  if (error != 0) complain_of_stdout(program, error);
  return error == 0;
}

/// Closes standard output, for the end of main(): some file systems report only then that a disk is
/// full. Returns `status`, or `unwritten` after a message if that fails.
[[nodiscard]] inline int end_program(std::string_view program, int status, int unwritten) {
  if (::close(STDOUT_FILENO) == 0 || status == unwritten) return status;
  complain_of_stdout(program, errno);
  return unwritten;
}

}  // namespace mlcca
