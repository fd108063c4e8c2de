// SPDX-License-Identifier: BSD-2-Clause
// dot reads a file in memory and writes to a pipe: only one end can block, and it is awaited with a
// limit, so neither program can hold the other.
#include "tools/design/check/graphviz.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): of POSIX
#include <spawn.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "base/handle.hpp"

namespace mlcca::tools::design {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kTooLong = "needs too long for this graph";
constexpr std::size_t kMaxDrawing = std::size_t{16} << 20U;  // bytes

std::unexpected<Error> failed(const char* program, std::string_view what) {
  return fail(fmt::format("{}: {}", program, what));
}

/// A file in memory that holds `text` and is read from its start.
Fd memory_file(std::string_view text) {
  Fd file(::memfd_create("graph", MFD_CLOEXEC));
  while (file && !text.empty()) {
    const auto n = ::write(file.get(), text.data(), text.size());
    if (n < 0) return {};
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  if (file) ::lseek(file.get(), 0, SEEK_SET);
  return file;
}

/// As poll wants it; 0 when it has passed.
int milliseconds_to(Clock::time_point deadline) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
  return static_cast<int>(std::max<std::int64_t>(left, 0));
}

/// A running program; killed and reaped unless it was waited for.
class Child {
 public:
  Child() = default;
  ~Child() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    wait();
  }
  Child(const Child&) = delete;
  Child(Child&&) = delete;
  Child& operator=(const Child&) = delete;
  Child& operator=(Child&&) = delete;

  /// 0, or an error number. Standard error goes nowhere; no signal is blocked.
  int start(const char* program, int in, int out) {
    posix_spawn_file_actions_t files;
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawn_file_actions_adddup2(&files, in, STDIN_FILENO);
    ::posix_spawn_file_actions_adddup2(&files, out, STDOUT_FILENO);
    ::posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawnattr_t attributes;
    ::posix_spawnattr_init(&attributes);
    sigset_t none;
    ::sigemptyset(&none);
    ::posix_spawnattr_setsigmask(&attributes, &none);
    ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
    std::string name = program;
    std::string format = "-Tsvg";
    const std::array<char*, 3> arguments{name.data(), format.data(), nullptr};
    const int error =
        ::posix_spawnp(&pid_, program, &files, &attributes, arguments.data(), environ);
    if (error != 0) pid_ = 0;
    ::posix_spawnattr_destroy(&attributes);
    ::posix_spawn_file_actions_destroy(&files);
    return error;
  }

  /// Whether it has ended by then.
  [[nodiscard]] bool ends_until(Clock::time_point deadline) const {
    // Through syscall(): the C library's declaration has C++ linkage in Debian 12.
    const Fd process(static_cast<int>(::syscall(SYS_pidfd_open, pid_, 0)));
    pollfd ended{.fd = process.get(), .events = POLLIN, .revents = 0};
    int polled = -1;
    do {
      polled = ::poll(&ended, 1, milliseconds_to(deadline));
    } while (polled < 0 && errno == EINTR);
    return polled > 0;
  }

  /// As waitpid says it.
  int wait() {
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = 0;
    return status;
  }

 private:
  pid_t pid_ = 0;
};

/// Everything up to the end of `fd`.
Result<std::string> read_until(int fd, Clock::time_point deadline, const char* program) {
  std::string text;
  std::array<char, 65536> piece{};
  for (;;) {
    pollfd ready{.fd = fd, .events = POLLIN, .revents = 0};
    const int polled = ::poll(&ready, 1, milliseconds_to(deadline));
    if (polled < 0 && errno == EINTR) continue;
    if (polled < 0) return failed(program, std::strerror(errno));
    if (polled == 0) return failed(program, kTooLong);
    const auto n = ::read(fd, piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return failed(program, std::strerror(errno));
    if (n == 0) return text;
    text.append(piece.data(), static_cast<std::size_t>(n));
    if (text.size() > kMaxDrawing) return failed(program, "draws more than can be shown");
  }
}

}  // namespace

Result<std::string> draw_svg(const std::string& source, const char* program,
                             std::chrono::milliseconds patience) {
  const auto deadline = Clock::now() + patience;
  const Fd graph = memory_file(source);
  std::array<int, 2> ends{};
  if (!graph || ::pipe2(ends.data(), O_CLOEXEC) != 0) return failed(program, std::strerror(errno));
  const Fd out(ends[0]);
  Fd in(ends[1]);
  Child child;
  if (const int error = child.start(program, graph.get(), in.get()); error != 0)
    return failed(program, error == ENOENT ? "is not installed" : std::strerror(error));
  in.reset();
  const auto drawing = read_until(out.get(), deadline, program);
  if (!drawing) return drawing;
  if (!child.ends_until(deadline)) return failed(program, kTooLong);
  if (const int status = child.wait(); status != 0) return failed(program, "has failed");
  const auto start = drawing->find("<svg");
  if (start == std::string::npos) return failed(program, "has drawn nothing");
  return drawing->substr(start);
}

}  // namespace mlcca::tools::design
