// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/store/disk.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

namespace mlcca::store {
namespace {

class RealDisk final : public Disk {
 public:
  int open(const std::string& path, int flags) override {
    return ::open(path.c_str(), flags | O_CLOEXEC, 0600);
  }
  void close(int fd) override { ::close(fd); }
  int lock(int fd) override { return ::flock(fd, LOCK_EX | LOCK_NB); }
  std::int64_t size(int fd) override {
    struct stat status{};
    return ::fstat(fd, &status) < 0 ? -1 : status.st_size;
  }
  ssize_t pread(int fd, char* to, std::size_t bytes, std::uint64_t offset) override {
    return ::pread(fd, to, bytes, static_cast<off_t>(offset));
  }
  ssize_t pwrite(int fd, const char* from, std::size_t bytes, std::uint64_t offset) override {
    return ::pwrite(fd, from, bytes, static_cast<off_t>(offset));
  }
  int truncate(int fd, std::uint64_t bytes) override {
    return ::ftruncate(fd, static_cast<off_t>(bytes));
  }
  int fdatasync(int fd) override { return ::fdatasync(fd); }
  int fsync(int fd) override { return ::fsync(fd); }
  int rename(const std::string& from, const std::string& to) override {
    return ::rename(from.c_str(), to.c_str());
  }
  int unlink(const std::string& path) override { return ::unlink(path.c_str()); }
  bool names(const std::string& path, int fd) override {
    struct stat named{};
    struct stat opened{};
    if (::fstat(fd, &opened) < 0) return true;
    if (::stat(path.c_str(), &named) < 0) return errno != ENOENT;
    return named.st_dev == opened.st_dev && named.st_ino == opened.st_ino;
  }
};

}  // namespace

Disk& real_disk() {
  static RealDisk disk;
  return disk;
}

}  // namespace mlcca::store
