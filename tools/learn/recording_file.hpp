// SPDX-License-Identifier: BSD-2-Clause
// Opens a recording.
#pragma once
#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::learn {

/// An open recording: a regular file, mapped into memory and read when it is needed, or a pipe.
class RecordingFile {
 public:
  /// The path "-" is standard input. The result is an error if the file cannot be read, is empty,
  /// or is neither a regular file nor a pipe.
  static Result<RecordingFile> open(const std::string& path) {
    // For a named pipe this waits for a writer, as in every program.
    Fd fd(path == "-" ? ::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0)
                      : ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY));
    struct stat status{};
    if (!fd || ::fstat(fd.get(), &status) != 0) return fail(reason());
    if (S_ISFIFO(status.st_mode) || S_ISSOCK(status.st_mode))
      return RecordingFile(nullptr, 0, std::move(fd));
    if (!S_ISREG(status.st_mode)) return fail("a recording is a regular file or a pipe");
    if (status.st_size == 0) return fail("the file is empty");
    const auto size = static_cast<std::size_t>(status.st_size);
    void* const at = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd.get(), 0);
    if (at == MAP_FAILED)  // NOLINT(*-cstyle-cast,*-int-to-ptr): of the library
      return fail(reason());
    static_cast<void>(::madvise(at, size, MADV_SEQUENTIAL));
    return RecordingFile(static_cast<const std::uint8_t*>(at), size, Fd());
  }
  RecordingFile(const RecordingFile&) = delete;
  RecordingFile& operator=(const RecordingFile&) = delete;
  RecordingFile(RecordingFile&& other) noexcept
      : at_(std::exchange(other.at_, nullptr)), size_(other.size_), fd_(std::move(other.fd_)) {}
  RecordingFile& operator=(RecordingFile&&) = delete;
  ~RecordingFile() {
    if (at_ != nullptr) ::munmap(const_cast<std::uint8_t*>(at_), size_);  // NOLINT(*-const-cast)
  }

  /// The bytes of a regular file; nullopt for a pipe, which is read by read().
  [[nodiscard]] std::optional<std::span<const std::uint8_t>> bytes() const {
    if (at_ == nullptr) return std::nullopt;
    return std::span(at_, size_);
  }
  /// Reads from a pipe; 0 at its end, and when `stop` returns true, which is called ten times a
  /// second.
  [[nodiscard]] Result<std::size_t> read(std::span<std::uint8_t> to,
                                         const std::function<bool()>& stop) const {
    constexpr int tenth_of_a_second = 100;  // ms
    for (;;) {
      if (stop) {
        if (stop()) return std::size_t{0};
        pollfd readable{.fd = fd_.get(), .events = POLLIN, .revents = 0};
        if (::poll(&readable, 1, tenth_of_a_second) <= 0) continue;
      }
      const ssize_t got = ::read(fd_.get(), to.data(), to.size());
      if (got >= 0) return static_cast<std::size_t>(got);
      if (errno != EINTR) return fail(reason());
    }
  }

 private:
  static std::string reason() { return std::strerror(errno); }  // NOLINT(concurrency-mt-unsafe)
  RecordingFile(const std::uint8_t* at, std::size_t size, Fd fd)
      : at_(at), size_(size), fd_(std::move(fd)) {}
  const std::uint8_t* at_;
  std::size_t size_;
  Fd fd_;
};

}  // namespace mlcca::learn
