// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/store/journal.hpp"

#include <fcntl.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ranges>
#include <utility>

#include "base/many.hpp"
#include "base/system_error.hpp"
#include "daemon/store/checksum.hpp"
#include "daemon/store/format.hpp"

namespace mlcca::store {
namespace {

Result<std::string> read_all(Disk& disk, int fd, const std::string& path) {
  const std::int64_t size = disk.size(fd);
  if (size < 0) return system_error(path);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  std::size_t have = 0;
  while (have < bytes.size()) {
    const ssize_t n = disk.pread(fd, bytes.data() + have, bytes.size() - have, have);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return system_error(path);
    if (n == 0) break;
    have += static_cast<std::size_t>(n);
  }
  bytes.resize(have);
  return bytes;
}

/// Writes the bytes and makes them durable.
Result<void> write_all(Disk& disk, int fd, std::string_view bytes, std::uint64_t offset,
                       const std::string& path) {
  while (!bytes.empty()) {
    const ssize_t n = disk.pwrite(fd, bytes.data(), bytes.size(), offset);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return system_error(path);
    if (n == 0) return fail(path + ": the disk takes nothing");
    bytes.remove_prefix(static_cast<std::size_t>(n));
    offset += static_cast<std::uint64_t>(n);
  }
  if (disk.fdatasync(fd) < 0) return system_error(path);
  return {};
}

Result<std::uint64_t> new_salt() {
  std::array<char, sizeof(std::uint64_t)> octets{};
  if (::getrandom(octets.data(), octets.size(), 0) != static_cast<ssize_t>(octets.size()))
    return system_error("getrandom");
  std::uint64_t salt = 0;
  std::memcpy(&salt, octets.data(), sizeof salt);
  return salt;
}

std::unexpected<Error> unusable(const std::string& path, const std::string& why) {
  return fail(path + ": " + why +
              ", nothing of it is used: put a copy back, or move it away to start without the "
              "run-time admissions");
}

/// Whether the latest call failed for want of room.
bool is_full() { return errno == ENOSPC || errno == EDQUOT; }

std::unexpected<Error> damaged(const std::string& path, std::uint64_t offset,
                               const std::string& how) {
  return unusable(path, "damaged at byte " + std::to_string(offset) + " (" + how + ")");
}

}  // namespace

// --- opening -------------------------------------------------------------------------------------

Result<Journal> Journal::open(const std::string& directory, Disk& disk) {
  Journal journal(disk);
  journal.directory_path_ = directory;
  journal.path_ = directory + "/journal";
  journal.directory_ = OpenFile(disk, disk.open(directory, O_RDONLY | O_DIRECTORY));
  if (!journal.directory_) return system_error(directory);
  // A lock file, not the directory: any process that may read the directory could hold its lock.
  journal.lock_ = OpenFile(disk, disk.open(directory + "/lock", O_RDWR | O_CREAT | O_NOFOLLOW));
  if (!journal.lock_) return system_error(directory + "/lock");
  if (disk.lock(journal.lock_.get()) < 0) {
    if (errno == EWOULDBLOCK) return fail(directory + ": in use by another process");
    return system_error(directory);
  }
  disk.unlink(journal.path_ + ".new");  // left by a crash during rewriting

  journal.file_ = OpenFile(disk, disk.open(journal.path_, O_RDWR));
  if (!journal.file_ && errno != ENOENT) return system_error(journal.path_);
  const auto ready = journal.file_ ? journal.read() : journal.compact();
  if (!ready) return std::unexpected(ready.error());
  return journal;
}

Result<void> Journal::read() {
  const auto text = read_all(*disk_, file_.get(), path_);
  if (!text) return std::unexpected(text.error());
  const std::string_view bytes = *text;
  const auto salt = format::read_file_head(bytes);
  if (!salt) return unusable(path_, salt.error().text);
  salt_ = *salt;
  end_ = format::kFileHead;
  std::uint64_t expected = 0;
  std::uint64_t last = end_;
  for (;; ++expected) {
    const auto used = read_batch(bytes.substr(end_), expected);
    if (!used) return std::unexpected(used.error());
    if (*used == 0) break;
    last = end_;
    end_ += *used;
  }
  // The first batch was synced before the file got its name, so no crash can have left it
  // incomplete.
  if (expected == 0) return damaged(path_, end_, "its first batch");
  sequence_ = expected - 1;
  if (sequence_ > 0) inherited_ = bytes.substr(last, end_ - last);
  return cut_tail(bytes);
}

/// Applies the batch at the front and returns its size; 0 if there is no complete one.
Result<std::uint64_t> Journal::read_batch(std::string_view bytes, std::uint64_t sequence) {
  const auto head = format::read_batch_head(bytes, salt_);
  if (!head) return 0;
  if (head->sequence != sequence)
    return damaged(path_, end_,
                   "batch " + std::to_string(head->sequence) + " in place of batch " +
                       std::to_string(sequence));
  if (head->length > bytes.size() - format::kBatchHead) return 0;
  const std::string_view body = bytes.substr(format::kBatchHead, head->length);
  if (crc64(body) != head->checksum) return 0;
  format::Reader reader(*head, body);
  for (;;) {
    const auto entry = reader.next();
    if (!entry)
      return fail(path_ + ": the batch at byte " + std::to_string(end_) + " " + entry.error().text +
                  ": was it written by a later version?");
    if (!*entry) break;
    if (const auto back = contents_.inverse(**entry)) change(**entry, *back, reader.bytes());
  }
  return format::kBatchHead + head->length;
}

/// Cuts off an incomplete batch. Only one batch is written at a time, so an incomplete one is the
/// last, torn by a crash. If another batch follows it, it is damage.
Result<void> Journal::cut_tail(std::string_view bytes) {
  const std::string_view tail = bytes.substr(end_);
  if (tail.size() > format::kAlign && format::holds_batch_head(tail.substr(format::kAlign), salt_))
    return damaged(path_, end_, "batch " + std::to_string(sequence_ + 1));
  if (!tail.empty()) {
    recovered_ = path_ + ": " + many(tail.size(), "byte at the end was", "bytes at the end were") +
                 " cut off: " + (tail.size() == 1 ? "it was" : "they were") +
                 " being written when the daemon or the "
                 "machine stopped, and no answer had been given";
    tail_unknown_ = true;
  }
  // A killed daemon may have written this without syncing. It is used from now on, so it must be
  // durable.
  directory_unsynced_ = true;
  if (auto ready = mend(); !ready && !is_full()) return ready;
  return {};
}

// --- changing ------------------------------------------------------------------------------------

/// Applies an entry. `back` is its inverse, `bytes` its size on disk.
void Journal::change(const Entry& entry, const Entry& back, std::uint64_t bytes) {
  if (format::is_alive(entry)) live_ += bytes;
  live_ -= format::live_bytes(back);
  contents_.apply(entry);
}

std::shared_ptr<const std::uint64_t> Journal::expect(std::uint64_t id) {
  expected_->insert(id);
  return {new std::uint64_t(id), [all = std::weak_ptr(expected_)](const std::uint64_t* known) {
            if (const auto there = all.lock()) there->erase(*known);
            delete known;  // NOLINT(cppcoreguidelines-owning-memory): of this very pointer
          }};
}

Result<void> Journal::append(const Entry& entry) {
  if (const auto* admitted = std::get_if<Admitted>(&entry)) {
    const std::uint64_t id = admitted->request.id;
    if (!std::holds_alternative<control::Admit>(admitted->request.body))
      return fail("an admission that is no Admit request cannot be stored");
    if (id == 0 || id == ~std::uint64_t{0})
      return fail("an admission cannot have the id " + std::to_string(id));
    if (id < contents_.next_id && contents_.admissions.find(id) == nullptr &&
        !expected_->contains(id))
      return fail("the id " + std::to_string(id) + " was used before");
  }
  auto back = contents_.inverse(entry);
  if (!back) return {};
  const std::string bytes = format::encode(entry);
  if (bytes.size() - format::kEntryHead > kMaxEntry)
    return fail("too large to be stored: " + std::to_string(bytes.size() - format::kEntryHead) +
                " bytes, at most " + std::to_string(kMaxEntry));
  if (batch_.size() + bytes.size() > kMaxBatch)
    return fail("more than " + std::to_string(kMaxBatch) + " bytes wait to be stored");
  if (batch_.empty()) former_next_ = contents_.next_id;
  change(entry, *back, bytes.size());
  batch_ += bytes;
  ++count_;
  undo_.push_back(std::move(*back));
  return {};
}

void Journal::roll_back() {
  if (!dirty()) return;
  for (const Entry& entry : std::views::reverse(undo_))
    if (const auto back = contents_.inverse(entry)) change(entry, *back, format::live_bytes(entry));
  contents_.next_id = former_next_;
  forget_batch();
}

/// Empties the batch. After a large one, such as that of a start, its memory is released.
void Journal::forget_batch() {
  constexpr std::size_t keep_bytes = std::size_t{1} << 16U;
  batch_.clear();
  if (batch_.capacity() > keep_bytes) batch_.shrink_to_fit();
  count_ = 0;
  undo_.clear();
  if (undo_.capacity() > keep_bytes / sizeof(Entry)) undo_.shrink_to_fit();
}

Result<void> Journal::commit() {
  if (!dirty()) return {};
  if (const auto ready = mend(); !ready) {
    roll_back();
    return ready;
  }
  if (is_gone()) {
    roll_back();
    const auto again = keep();
    return fail(path_ + ": another program removed or replaced it" +
                (again ? "; it has been written again, repeat the request"
                       : ", and it cannot be written again: " + again.error().text));
  }
  const std::string bytes = format::batch(salt_, sequence_ + 1, count_, batch_);
  if (const auto written = write_all(*disk_, file_.get(), bytes, end_, path_); !written) {
    tail_unknown_ = true;
    roll_back();
    if (const auto undone = mend(); !undone)
      return fail(written.error().text + "; and it could not be undone on disk (" +
                  undone.error().text + "): nothing can be stored until it is");
    return fail(written.error().text + "; it was undone");
  }
  end_ += bytes.size();
  ++sequence_;
  forget_batch();
  compact_if_large();
  return {};
}

Result<void> Journal::mend() {
  if (fresh_.file) {
    if (auto found = find_named(); !found) return found;
  }
  if (tail_unknown_) {
    if (disk_->truncate(file_.get(), end_) < 0 || disk_->fdatasync(file_.get()) < 0)
      return system_error(path_);
    tail_unknown_ = false;
  }
  if (!inherited_.empty()) {
    // After a sync that failed, the cache has what the disk lacks, and another sync does nothing.
    if (auto done = write_all(*disk_, file_.get(), inherited_, end_ - inherited_.size(), path_);
        !done)
      return done;
    inherited_ = {};
  }
  if (directory_unsynced_) {
    // Until then a crash brings the former file back, which does not have what this one will
    // contain.
    if (disk_->fsync(directory_.get()) < 0) return system_error(directory_path_);
    directory_unsynced_ = false;
  }
  return {};
}

// --- writing it again ----------------------------------------------------------------------------

Result<void> Journal::compact() {
  if (dirty()) return fail(path_ + ": something is not yet committed");
  if (auto ready = mend(); !ready) return ready;
  const auto salt = new_salt();
  if (!salt) return std::unexpected(salt.error());
  const std::string fresh = path_ + ".new";
  const std::string bytes = format::file_head(*salt) + format::snapshot(*salt, contents_);
  fresh_ = {OpenFile(*disk_, disk_->open(fresh, O_RDWR | O_CREAT | O_TRUNC)), *salt, bytes.size()};
  Result<void> done;
  if (!fresh_.file) done = system_error(fresh);
  if (done) done = write_all(*disk_, fresh_.file.get(), bytes, 0, fresh);
  if (!done) {
    fresh_ = {};
    disk_->unlink(fresh);
    return done;
  }
  if (disk_->rename(fresh, path_) == 0) {
    adopt_fresh();
    return mend();
  }
  done = system_error(fresh);
  static_cast<void>(mend());
  return done;
}

bool Journal::is_gone() const { return !disk_->names(path_, file_.get()); }

Result<bool> Journal::keep() {
  if (!is_gone()) return false;
  if (!disk_->names(directory_path_, directory_.get())) {
    OpenFile directory(*disk_, disk_->open(directory_path_, O_RDONLY | O_DIRECTORY));
    if (!directory) return system_error(directory_path_);
    if (disk_->lock(directory.get()) < 0) return system_error(directory_path_);
    directory_ = std::move(directory);
  }
  if (const auto done = compact(); !done) return std::unexpected(done.error());
  return true;
}

void Journal::adopt_fresh() {
  inherited_ = {};
  file_ = std::move(fresh_.file);
  salt_ = fresh_.salt;
  end_ = fresh_.bytes;
  sequence_ = 0;
  tail_unknown_ = false;
  directory_unsynced_ = true;
}

/// Finds out which file has the name after a failed rename, which may have succeeded nevertheless
/// (network file systems). What is written to a file without a name is lost.
Result<void> Journal::find_named() {
  const OpenFile named(*disk_, disk_->open(path_, O_RDONLY));
  if (!named) return system_error(path_);
  std::string head(format::kFileHead, '\0');
  if (disk_->pread(named.get(), head.data(), head.size(), 0) < 0) return system_error(path_);
  const auto salt = format::read_file_head(head);
  if (salt && *salt == fresh_.salt)
    adopt_fresh();
  else if (!salt || *salt != salt_)
    return fail(path_ + ": is not the file that was written");
  fresh_ = {};
  return {};
}

void Journal::compact_if_large() {
  if (end_ <= kCompactAtLeast || end_ / kCompactAbove <= live_ || end_ < retry_above_) return;
  if (const auto done = compact(); !done)
    trouble_ = "the journal could not be written again, it grows: " + done.error().text;
  else
    trouble_.reset();
  retry_above_ = trouble_ ? end_ + kCompactAtLeast : 0;
}

}  // namespace mlcca::store
