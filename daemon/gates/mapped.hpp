// SPDX-License-Identifier: BSD-2-Clause
// The values of a BPF array map as plain memory.
#pragma once
#include <sys/mman.h>

#include <cstddef>
#include <span>
#include <utility>

namespace mlcca::gates {

/// Maps the values. Empty if the kernel refuses; errno has the reason.
template <class T>
class Mapped {
 public:
  static_assert(sizeof(T) % 8 == 0, "array values are padded to 8 bytes");

  Mapped() = default;
  Mapped(int map, std::size_t count) {
    void* memory = ::mmap(nullptr, count * sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED, map, 0);
    if (memory != MAP_FAILED) values_ = {static_cast<T*>(memory), count};
  }
  Mapped(Mapped&& other) noexcept : values_(std::exchange(other.values_, {})) {}
  Mapped& operator=(Mapped&& other) noexcept {
    std::swap(values_, other.values_);
    return *this;
  }
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;
  ~Mapped() {
    if (!values_.empty()) ::munmap(values_.data(), values_.size_bytes());
  }

  [[nodiscard]] explicit operator bool() const { return !values_.empty(); }
  [[nodiscard]] std::span<T> span() const { return values_; }
  T& operator[](std::size_t i) const { return values_[i]; }

 private:
  std::span<T> values_;
};

}  // namespace mlcca::gates
