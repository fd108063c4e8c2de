// SPDX-License-Identifier: BSD-2-Clause
// The journal of reservations: every change is on disk, in order and checksummed, before the answer
// is given. docs/reference/journal.md describes the file byte by byte and what is guaranteed.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "control/messages.hpp"
#include "daemon/store/contents.hpp"
#include "daemon/store/disk.hpp"

namespace mlcca::store {

/// Bytes of one entry on disk, without its head; append() refuses more.
/// The largest request that the control socket takes has room, with its user.
inline constexpr std::size_t kMaxEntry = control::Request::kMaxBytes + 64;
/// Bytes of all entries between two commits; append() refuses more.
inline constexpr std::size_t kMaxBatch = 64UL * 1024 * 1024;
/// The file is written again when it is larger than this many times what lives in it …
inline constexpr std::uint64_t kCompactAbove = 4;
/// … and than this many bytes: rewriting less is not worth the wait.
inline constexpr std::uint64_t kCompactAtLeast = 1024UL * 1024;

/// Entries are collected in memory until commit() writes them as one batch: after a crash, at
/// whatever byte, all of a batch are there or none. One journal a directory at a time.
///
///     journal.append(Admitted{request});
///     if (auto done = journal.commit(); !done) return refuse(done.error());
///     answer();
class Journal {
 public:
  /// Reads what is there. An unfinished batch at the end (a crash) is cut off, see recovered().
  /// Damage anywhere else, and a file of another layout, is an error that names the file and says
  /// what to do: nothing of it is used. `directory` must exist; `disk` must outlive the journal.
  static Result<Journal> open(const std::string& directory, Disk& disk = real_disk());

  /// With what is appended and not yet committed.
  [[nodiscard]] const Contents& contents() const { return contents_; }

  /// Into memory only. Refuses an entry or batch that is too large, an Admitted that is no Admit
  /// request, and an id of the past. An entry that changes nothing is not written.
  Result<void> append(const Entry& entry);

  /// An admission of that id may be appended after those of later ones, as long as what is given is
  /// kept.
  [[nodiscard]] std::shared_ptr<const std::uint64_t> expect(std::uint64_t id);

  /// One write and one fdatasync for everything since the last commit. On failure all of it is
  /// undone, in memory and on disk, and the error says so; the journal can be used again, unless
  /// the disk refuses even the undoing: then every commit tries that first, and fails while it
  /// fails. Writes the file again when too little in it is alive; a failure of that is reported by
  /// trouble().
  Result<void> commit();

  /// Undoes on disk what could not be undone when its commit failed: until then a loss of power may
  /// bring it back. Each commit does it first. Does nothing where all was undone.
  Result<void> mend();

  /// Writes the file again if another program has removed or replaced it, or its directory: what
  /// goes into a file without a name is lost with the process. True if so. commit() does the same,
  /// and refuses what was to be committed. There must be nothing uncommitted.
  Result<bool> keep();

  /// Something is appended and not committed.
  [[nodiscard]] bool dirty() const { return count_ > 0; }
  /// Drops what is not committed.
  void roll_back();

  /// Writes the file again, with nothing in it but what is alive. On failure the old one stays.
  /// There must be nothing uncommitted.
  Result<void> compact();

  /// What was cut off when the journal was opened, in words; nothing if it was whole.
  [[nodiscard]] const std::optional<std::string>& recovered() const { return recovered_; }
  /// Why the file could not be written again the last time it was too large; nothing if it could.
  [[nodiscard]] const std::optional<std::string>& trouble() const { return trouble_; }

  /// Bytes of the file, and those of what is alive in it.
  [[nodiscard]] std::uint64_t file_bytes() const { return end_; }
  [[nodiscard]] std::uint64_t live_bytes() const { return live_; }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  explicit Journal(Disk& disk) : disk_(&disk) {}

  Result<void> begin();
  Result<void> read();
  Result<std::uint64_t> read_batch(std::string_view bytes, std::uint64_t sequence);
  Result<void> cut_tail(std::string_view bytes);
  [[nodiscard]] bool is_gone() const;
  void forget_batch();
  void change(const Entry& entry, const Entry& back, std::uint64_t bytes);
  void compact_if_large();
  void adopt_fresh();
  Result<void> find_named();

  Disk* disk_;
  std::string directory_path_;
  std::string path_;
  OpenFile directory_;
  OpenFile lock_;  ///< held while the journal is open
  OpenFile file_;
  Contents contents_{};
  std::uint64_t salt_ = 0;
  std::uint64_t sequence_ = 0;  ///< of the last batch on disk
  std::uint64_t end_ = 0;       ///< of the last batch on disk, bytes
  std::uint64_t live_ = 0;      ///< bytes that the contents take as entries

  struct Fresh {
    OpenFile file;
    std::uint64_t salt = 0;
    std::uint64_t bytes = 0;
  };
  Fresh fresh_;  ///< written again and perhaps renamed; no file: there is none

  std::string batch_;              ///< entries as they will be on disk
  std::uint32_t count_ = 0;        ///< of them
  std::vector<Entry> undo_;        ///< of the same, oldest first
  std::uint64_t former_next_ = 1;  ///< next_id before them

  /// Ids that were set aside.
  std::shared_ptr<std::set<std::uint64_t>> expected_ = std::make_shared<std::set<std::uint64_t>>();

  bool tail_unknown_ = false;        ///< bytes of a failed commit may stand behind end_
  bool directory_unsynced_ = false;  ///< a crash could bring the former file back
  std::uint64_t retry_above_ = 0;    ///< file size from which a failed compaction is tried again
  std::optional<std::string> recovered_;
  std::optional<std::string> trouble_;
};

}  // namespace mlcca::store
