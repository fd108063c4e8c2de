// SPDX-License-Identifier: BSD-2-Clause
// The system calls of the journal, one method for each, so that tests can fail each call, stop
// after each call, and simulate a loss of power.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

namespace mlcca::store {

/// Results and errno are those of the calls of the same name.
class Disk {
 public:
  Disk() = default;
  Disk(const Disk&) = delete;
  Disk& operator=(const Disk&) = delete;
  Disk(Disk&&) = delete;
  Disk& operator=(Disk&&) = delete;
  virtual ~Disk() = default;

  /// `flags` as for open(2); O_CLOEXEC is added. A new file has mode 0600.
  virtual int open(const std::string& path, int flags) = 0;
  virtual void close(int fd) = 0;
  /// An exclusive flock(2) that does not wait.
  virtual int lock(int fd) = 0;
  virtual std::int64_t size(int fd) = 0;
  virtual ssize_t pread(int fd, char* to, std::size_t bytes, std::uint64_t offset) = 0;
  virtual ssize_t pwrite(int fd, const char* from, std::size_t bytes, std::uint64_t offset) = 0;
  virtual int truncate(int fd, std::uint64_t bytes) = 0;
  /// Makes the contents and the size of a file durable.
  virtual int fdatasync(int fd) = 0;
  /// Makes the names in a directory durable.
  virtual int fsync(int fd) = 0;
  virtual int rename(const std::string& from, const std::string& to) = 0;
  virtual int unlink(const std::string& path) = 0;
  /// False only if `path` certainly names another file than `fd`, or nothing.
  virtual bool names(const std::string& path, int fd) = 0;
};

/// The disk of the kernel.
Disk& real_disk();

/// Owns a descriptor of a Disk.
class OpenFile {
 public:
  OpenFile() = default;
  OpenFile(Disk& disk, int fd) : disk_(&disk), fd_(fd) {}
  OpenFile(OpenFile&& other) noexcept : disk_(other.disk_), fd_(std::exchange(other.fd_, -1)) {}
  OpenFile& operator=(OpenFile&& other) noexcept {
    if (this != &other) {
      reset();
      disk_ = other.disk_;
      fd_ = std::exchange(other.fd_, -1);
    }
    return *this;
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() { reset(); }

  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] explicit operator bool() const { return fd_ >= 0; }
  void reset() {
    if (fd_ >= 0) disk_->close(fd_);
    fd_ = -1;
  }

 private:
  Disk* disk_ = nullptr;
  int fd_ = -1;
};

}  // namespace mlcca::store
