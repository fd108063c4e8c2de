// SPDX-License-Identifier: BSD-2-Clause
// Disks for tests: one in memory that can lose its power, and one that fails or stops at a call.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "daemon/store/disk.hpp"

namespace mlcca::store::test {

/// The power is gone: thrown out of the call during which it happens.
struct PowerLoss {};

/// Files as a kernel keeps them: what was written is seen at once, what is on the disk is what was
/// synced, and whatever part of the rest the disk has felt like writing. One directory.
class MemoryDisk final : public Disk {
 public:
  int open(const std::string& path, int flags) override;
  void close(int fd) override { open_.erase(fd); }
  int lock(int) override { return 0; }
  std::int64_t size(int fd) override;
  ssize_t pread(int fd, char* to, std::size_t bytes, std::uint64_t offset) override;
  ssize_t pwrite(int fd, const char* from, std::size_t bytes, std::uint64_t offset) override;
  int truncate(int fd, std::uint64_t bytes) override;
  int fdatasync(int fd) override;
  int fsync(int fd) override;
  int rename(const std::string& from, const std::string& to) override;
  int unlink(const std::string& path) override;
  bool names(const std::string& path, int fd) override;

  /// What a failed fdatasync leaves on Linux: the pages count as written, and are not.
  void forget_unsynced(int fd);

  /// The disk after a loss of power at this moment: of what was not synced any sectors of 512 bytes
  /// of any write, any sizes and any names, as `random` chooses.
  [[nodiscard]] std::unique_ptr<MemoryDisk> after_power_loss(std::mt19937& random) const;

  /// Bytes of memory that the contents of its files take, about.
  [[nodiscard]] std::size_t held() const;

 private:
  struct Change {
    bool truncates = false;
    std::uint64_t offset = 0;  ///< or the size
    std::string bytes;
  };
  struct File {
    std::string seen;
    std::string synced;
    std::vector<Change> unsynced;
  };
  using FilePtr = std::shared_ptr<File>;
  using Names = std::map<std::string, FilePtr>;
  struct Naming {
    std::string gone;  ///< empty: none
    std::string name;  ///< empty: none
    FilePtr file;
  };

  static void apply(const Change& change, std::string& to);
  static std::string some_of(const File& file, std::mt19937& random);
  void name(Naming naming);

  Names seen_;
  Names synced_;
  std::vector<Naming> unsynced_;
  std::map<int, FilePtr> open_;  ///< null: the directory
  int next_fd_ = 3;
};

enum class Trouble : std::uint8_t {
  stop,        ///< the process ends before the call
  stop_after,  ///< the process ends when the call has been made
  fail,        ///< the call fails
  fail_after,  ///< the call is made and says that it failed
  lose,        ///< as fail; a failing fdatasync also loses what it should have written
  write_part,  ///< a write writes half, and the next call fails; others as fail
};

/// Counts the calls (but close) and makes trouble at one of them, or from one of them on.
class TroubledDisk final : public Disk {
 public:
  /// `memory`: the same disk, for Trouble::lose.
  explicit TroubledDisk(Disk& below, MemoryDisk* memory = nullptr)
      : below_(&below), memory_(memory) {}

  /// The `at`-th call from now, from 1; `calls` of them in a row.
  void trouble(Trouble what, std::size_t at, int error, std::size_t calls = 1);
  [[nodiscard]] std::size_t calls() const { return calls_; }
  /// The trouble has come.
  [[nodiscard]] bool came() const { return calls_ >= first_; }

  int open(const std::string& path, int flags) override;
  void close(int fd) override { below_->close(fd); }
  int lock(int fd) override;
  std::int64_t size(int fd) override;
  ssize_t pread(int fd, char* to, std::size_t bytes, std::uint64_t offset) override;
  ssize_t pwrite(int fd, const char* from, std::size_t bytes, std::uint64_t offset) override;
  int truncate(int fd, std::uint64_t bytes) override;
  int fdatasync(int fd) override;
  int fsync(int fd) override;
  int rename(const std::string& from, const std::string& to) override;
  int unlink(const std::string& path) override;
  bool names(const std::string& path, int fd) override { return below_->names(path, fd); }

 private:
  template <class Result>
  Result call(const std::function<Result()>& made);
  [[nodiscard]] bool now() const { return calls_ >= first_ && calls_ - first_ < length_; }

  Disk* below_;
  MemoryDisk* memory_;
  Trouble what_ = Trouble::fail;
  std::size_t first_ = ~std::size_t{0};
  std::size_t length_ = 0;
  int error_ = 0;
  std::size_t calls_ = 0;
  bool part_written_ = false;
  bool stopped_ = false;
};

}  // namespace mlcca::store::test
