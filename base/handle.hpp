// SPDX-License-Identifier: BSD-2-Clause
// Owners of handles that C libraries return. Declare one on the line that obtains the handle.
#pragma once
#include <unistd.h>

#include <memory>
#include <utility>

namespace mlcca {

/// A deleter for std::unique_ptr that calls the C function `Free`, as in `using Loop =
/// std::unique_ptr<sd_event, FreeWith<sd_event_unref>>`.
template <auto Free>
struct FreeWith {
  template <class T>
  void operator()(T* p) const noexcept {
    Free(p);
  }
};

/// Owns a file descriptor and closes it; -1 means that there is none.
class Fd {
 public:
  Fd() = default;
  explicit Fd(int fd) : fd_(fd) {}
  Fd(Fd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Fd& operator=(Fd&& other) noexcept {
    if (this != &other) reset(std::exchange(other.fd_, -1));
    return *this;
  }
  Fd(const Fd&) = delete;
  Fd& operator=(const Fd&) = delete;
  ~Fd() { reset(); }

  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] explicit operator bool() const { return fd_ >= 0; }
  void reset(int fd = -1) {
    if (fd_ >= 0) ::close(fd_);
    fd_ = fd;
  }

 private:
  int fd_ = -1;
};

}  // namespace mlcca
