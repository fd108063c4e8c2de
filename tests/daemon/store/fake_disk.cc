// SPDX-License-Identifier: BSD-2-Clause
#include "tests/daemon/store/fake_disk.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace mlcca::store::test {
namespace {

constexpr std::uint64_t kSector = 512;

bool coin(std::mt19937& random) { return random() % 2 == 0; }

std::string name_in(const std::string& path) { return path.substr(path.rfind('/') + 1); }

}  // namespace

// --- in memory -----------------------------------------------------------------------------------

std::size_t MemoryDisk::held() const {
  std::size_t out = 0;
  for (const auto& [name, file] : seen_) {
    out += file->seen.capacity() + file->synced.capacity();
    for (const Change& change : file->unsynced) out += change.bytes.capacity();
  }
  return out;
}

void MemoryDisk::apply(const Change& change, std::string& to) {
  if (change.truncates) {
    to.resize(change.offset, '\0');
    return;
  }
  to.resize(std::max<std::size_t>(to.size(), change.offset + change.bytes.size()), '\0');
  to.replace(change.offset, change.bytes.size(), change.bytes);
}

void MemoryDisk::name(Naming naming) {
  if (!naming.gone.empty()) seen_.erase(naming.gone);
  if (!naming.name.empty()) seen_[naming.name] = naming.file;
  unsynced_.push_back(std::move(naming));
}

int MemoryDisk::open(const std::string& path, int flags) {
  FilePtr file;
  if ((flags & O_DIRECTORY) == 0) {
    const std::string wanted = name_in(path);
    if (!seen_.contains(wanted)) {
      if ((flags & O_CREAT) == 0) return errno = ENOENT, -1;
      name({{}, wanted, std::make_shared<File>()});
    }
    file = seen_[wanted];
  }
  open_[next_fd_] = file;
  if ((flags & O_TRUNC) != 0 && !file->seen.empty()) truncate(next_fd_, 0);
  return next_fd_++;
}

std::int64_t MemoryDisk::size(int fd) {
  return static_cast<std::int64_t>(open_.at(fd)->seen.size());
}

ssize_t MemoryDisk::pread(int fd, char* to, std::size_t bytes, std::uint64_t offset) {
  const std::string& seen = open_.at(fd)->seen;
  if (offset >= seen.size()) return 0;
  return static_cast<ssize_t>(seen.copy(to, bytes, offset));
}

ssize_t MemoryDisk::pwrite(int fd, const char* from, std::size_t bytes, std::uint64_t offset) {
  File& file = *open_.at(fd);
  file.unsynced.push_back({false, offset, std::string(from, bytes)});
  apply(file.unsynced.back(), file.seen);
  return static_cast<ssize_t>(bytes);
}

int MemoryDisk::truncate(int fd, std::uint64_t bytes) {
  File& file = *open_.at(fd);
  file.unsynced.push_back({true, bytes, {}});
  apply(file.unsynced.back(), file.seen);
  return 0;
}

int MemoryDisk::fdatasync(int fd) {
  File& file = *open_.at(fd);
  for (const Change& change : file.unsynced) apply(change, file.synced);
  file.unsynced.clear();
  return 0;
}

int MemoryDisk::fsync(int fd) {
  if (open_.at(fd) != nullptr) return fdatasync(fd);
  synced_ = seen_;
  unsynced_.clear();
  return 0;
}

int MemoryDisk::rename(const std::string& from, const std::string& to) {
  const auto found = seen_.find(name_in(from));
  if (found == seen_.end()) return errno = ENOENT, -1;
  name({name_in(from), name_in(to), found->second});
  return 0;
}

int MemoryDisk::unlink(const std::string& path) {
  if (!seen_.contains(name_in(path))) return errno = ENOENT, -1;
  name({name_in(path), {}, nullptr});
  return 0;
}

bool MemoryDisk::names(const std::string& path, int fd) {
  const auto named = seen_.find(name_in(path));
  return !open_.at(fd) || (named != seen_.end() && named->second == open_.at(fd));
}

void MemoryDisk::forget_unsynced(int fd) {
  if (const FilePtr& file = open_.at(fd)) file->unsynced.clear();
}

/// Each sector of each write has arrived or not, in any order; the size is one of those on the way.
std::string MemoryDisk::some_of(const File& file, std::mt19937& random) {
  std::string disk = file.synced;
  std::vector<Change> parts;
  std::vector<std::uint64_t> sizes{disk.size(), file.seen.size()};
  for (const Change& change : file.unsynced) {
    if (change.truncates) {
      sizes.push_back(change.offset);
      if (coin(random)) parts.push_back(change);
      continue;
    }
    for (std::uint64_t at = change.offset, end = at + change.bytes.size(); at < end;) {
      const std::uint64_t next = std::min(end, (at / kSector + 1) * kSector);
      sizes.push_back(next);
      if (coin(random))
        parts.push_back({false, at, change.bytes.substr(at - change.offset, next - at)});
      at = next;
    }
  }
  if (coin(random)) std::ranges::shuffle(parts, random);
  for (const Change& part : parts) apply(part, disk);
  // A synced byte that nothing unsynced cuts off is never lost.
  const bool may_shrink =
      std::ranges::any_of(file.unsynced, [](const Change& c) { return c.truncates; });
  const std::uint64_t size = sizes[random() % sizes.size()];
  disk.resize(may_shrink ? size : std::max<std::uint64_t>(size, file.synced.size()), '\0');
  return disk;
}

std::unique_ptr<MemoryDisk> MemoryDisk::after_power_loss(std::mt19937& random) const {
  Names names = synced_;
  for (const Naming& naming : unsynced_) {
    if (coin(random)) continue;
    if (!naming.gone.empty()) names.erase(naming.gone);
    if (!naming.name.empty()) names[naming.name] = naming.file;
  }
  auto disk = std::make_unique<MemoryDisk>();
  for (const auto& [name, file] : names) {
    const std::string bytes = some_of(*file, random);
    disk->seen_[name] = std::make_shared<File>(File{bytes, bytes, {}});
  }
  disk->synced_ = disk->seen_;
  return disk;
}

// --- troubled ------------------------------------------------------------------------------------

void TroubledDisk::trouble(Trouble what, std::size_t at, int error, std::size_t calls) {
  what_ = what;
  part_written_ = false;
  first_ = calls_ + at;
  length_ = calls;
  error_ = error;
}

template <class Result>
Result TroubledDisk::call(const std::function<Result()>& made) {
  ++calls_;
  if (stopped_) throw PowerLoss{};
  if (!now()) return made();
  if (what_ == Trouble::stop || what_ == Trouble::stop_after) {
    if (what_ == Trouble::stop_after) made();
    stopped_ = true;
    throw PowerLoss{};
  }
  if (what_ == Trouble::fail_after) made();
  errno = error_;
  return -1;
}

int TroubledDisk::open(const std::string& path, int flags) {
  // A descriptor that is not returned would stay open.
  ++calls_;
  if (stopped_) throw PowerLoss{};
  if (!now()) return below_->open(path, flags);
  const bool stops = what_ == Trouble::stop || what_ == Trouble::stop_after;
  if (what_ == Trouble::stop_after || what_ == Trouble::fail_after)
    below_->close(below_->open(path, flags));
  if (stops) {
    stopped_ = true;
    throw PowerLoss{};
  }
  return errno = error_, -1;
}

int TroubledDisk::lock(int fd) {
  return call<int>([&] { return below_->lock(fd); });
}
std::int64_t TroubledDisk::size(int fd) {
  return call<std::int64_t>([&] { return below_->size(fd); });
}
ssize_t TroubledDisk::pread(int fd, char* to, std::size_t bytes, std::uint64_t offset) {
  return call<ssize_t>([&] { return below_->pread(fd, to, bytes, offset); });
}
ssize_t TroubledDisk::pwrite(int fd, const char* from, std::size_t bytes, std::uint64_t offset) {
  if (what_ == Trouble::write_part && calls_ + 1 == first_ && !part_written_) {
    part_written_ = true;
    ++calls_;
    ++first_;  // the next call fails
    return below_->pwrite(fd, from, bytes / 2, offset);
  }
  return call<ssize_t>([&] { return below_->pwrite(fd, from, bytes, offset); });
}
int TroubledDisk::truncate(int fd, std::uint64_t bytes) {
  return call<int>([&] { return below_->truncate(fd, bytes); });
}
int TroubledDisk::fdatasync(int fd) {
  const int done = call<int>([&] { return below_->fdatasync(fd); });
  if (done < 0 && what_ == Trouble::lose) memory_->forget_unsynced(fd);
  return done;
}
int TroubledDisk::fsync(int fd) {
  return call<int>([&] { return below_->fsync(fd); });
}
int TroubledDisk::rename(const std::string& from, const std::string& to) {
  return call<int>([&] { return below_->rename(from, to); });
}
int TroubledDisk::unlink(const std::string& path) {
  return call<int>([&] { return below_->unlink(path); });
}

}  // namespace mlcca::store::test
