// SPDX-License-Identifier: BSD-2-Clause
// A regular file in memory, read as it is needed.
#pragma once
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <utility>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::learn {

class MappedFile {
 public:
  /// Error: there is none, it cannot be read, or it is no regular file.
  static Result<MappedFile> open(const std::string& path) {
    const Fd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    struct stat status{};
    if (!fd || ::fstat(fd.get(), &status) != 0)
      return fail(path + ": " + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
    if (!S_ISREG(status.st_mode)) return fail(path + ": a recording is a regular file");
    if (status.st_size == 0) return fail(path + ": the file is empty");
    const auto size = static_cast<std::size_t>(status.st_size);
    void* const at = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd.get(), 0);
    if (at == MAP_FAILED)  // NOLINT(*-cstyle-cast,*-int-to-ptr): of the library
      return fail(path + ": " + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
    static_cast<void>(::madvise(at, size, MADV_SEQUENTIAL));
    return MappedFile(static_cast<const std::uint8_t*>(at), size);
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  MappedFile(MappedFile&& other) noexcept
      : at_(std::exchange(other.at_, nullptr)), size_(other.size_) {}
  MappedFile& operator=(MappedFile&&) = delete;
  ~MappedFile() {
    if (at_ != nullptr) ::munmap(const_cast<std::uint8_t*>(at_), size_);  // NOLINT(*-const-cast)
  }

  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return {at_, size_}; }

 private:
  MappedFile(const std::uint8_t* at, std::size_t size) : at_(at), size_(size) {}
  const std::uint8_t* at_;
  std::size_t size_;
};

}  // namespace mlcca::learn
