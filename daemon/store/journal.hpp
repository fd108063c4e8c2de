// SPDX-License-Identifier: BSD-2-Clause
// The journal of run-time grants: every change is on disk, in order and with a checksum, before the
// answer is given. docs/reference/journal.md describes the file and its guarantees.
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

/// The most bytes of one entry on disk, without its head; append() refuses more. The largest
/// request that the control socket takes fits, with its user.
inline constexpr std::size_t kMaxEntry = control::Request::kMaxBytes + 64;
/// The most bytes of all entries between two commits; append() refuses more.
inline constexpr std::size_t kMaxBatch = 64UL * 1024 * 1024;
/// The file is rewritten if it is larger than this many times its live content …
inline constexpr std::uint64_t kCompactAbove = 4;
/// … and larger than this many bytes, because rewriting less is not worth the time.
inline constexpr std::uint64_t kCompactAtLeast = 1024UL * 1024;

/// Entries are collected in memory until commit() writes them as one batch. After a crash at any
/// byte, either all entries of a batch are there or none. Only one Journal may be open for a
/// directory at a time.
///
///     journal.append(Admitted{request});
///     if (auto done = journal.commit(); !done) return refuse(done.error());
///     answer();
class Journal {
 public:
  /// Reads the existing journal. An incomplete batch at the end, left by a crash, is cut off; see
  /// recovered(). Damage elsewhere, or another layout, is an error that names the file and says
  /// what to do; then nothing of it is used. `directory` must exist; `disk` must outlive the
  /// journal.
  static Result<Journal> open(const std::string& directory, Disk& disk = real_disk());

  /// The contents, including what is appended and not yet committed.
  [[nodiscard]] const Contents& contents() const { return contents_; }

  /// Collects an entry in memory. Refuses entries or batches that are too large, an Admitted that
  /// is no Admit request, and ids that are not new. An entry that changes nothing is not written.
  Result<void> append(const Entry& entry);

  /// Reserves an id: an admission with it may be appended after those with later ids, as long as
  /// the result is kept.
  [[nodiscard]] std::shared_ptr<const std::uint64_t> expect(std::uint64_t id);
  [[nodiscard]] bool expects(std::uint64_t id) const { return expected_->contains(id); }

  /// Writes everything since the last commit with one write and one fdatasync. On failure all of it
  /// is undone, in memory and on disk, and the error says so. The journal stays usable, unless the
  /// disk refuses even the undoing: then every commit tries that first, and fails as long as that
  /// fails. Rewrites the file if too little of it is live; trouble() reports a failure of that.
  Result<void> commit();

  /// Undoes on disk what could not be undone when its commit failed; until then a loss of power may
  /// bring it back. Each commit does this first. No effect if everything was undone.
  Result<void> mend();

  /// Rewrites the file if another program has removed or replaced it or its directory, because what
  /// is written to a file without a name is lost with the process. True if it was rewritten.
  /// commit() does the same, and refuses what was to be committed. Nothing may be uncommitted.
  Result<bool> keep();

  /// Whether something is appended and not committed.
  [[nodiscard]] bool dirty() const { return count_ > 0; }
  /// Drops what is not committed.
  void roll_back();

  /// Rewrites the file with its live content only. On failure the old file stays. Nothing may be
  /// uncommitted.
  Result<void> compact();

  /// What was cut off when the journal was opened, in words; nullopt if it was complete.
  [[nodiscard]] const std::optional<std::string>& recovered() const { return recovered_; }
  /// Why the latest rewriting of a too large file failed; nullopt if it succeeded.
  [[nodiscard]] const std::optional<std::string>& trouble() const { return trouble_; }

  /// The bytes of the file, by which tests and benchmarks observe when it is rewritten, and those
  /// of its live content.
  [[nodiscard]] std::uint64_t file_bytes() const { return end_; }
  [[nodiscard]] std::uint64_t live_bytes() const { return live_; }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  explicit Journal(Disk& disk) : disk_(&disk) {}

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
  std::uint64_t end_ = 0;       ///< offset of its end, bytes
  std::uint64_t live_ = 0;      ///< bytes of the contents as entries

  struct Fresh {
    OpenFile file;
    std::uint64_t salt = 0;
    std::uint64_t bytes = 0;
  };
  Fresh fresh_;  ///< rewritten and perhaps renamed; without a file: there is none

  std::string batch_;              ///< entries in the format of the disk
  std::uint32_t count_ = 0;        ///< the number of these entries
  std::vector<Entry> undo_;        ///< the inverse of each, oldest first
  std::uint64_t former_next_ = 1;  ///< next_id before these entries

  /// The ids that expect() has reserved.
  std::shared_ptr<std::set<std::uint64_t>> expected_ = std::make_shared<std::set<std::uint64_t>>();

  bool tail_unknown_ = false;        ///< bytes of a failed commit may follow end_
  bool directory_unsynced_ = false;  ///< a crash could bring the former file back
  /// The last batch that a former process wrote, until it has been written again; empty: it has.
  std::string inherited_;
  std::uint64_t retry_above_ = 0;  ///< file size above which a failed rewriting is retried
  std::optional<std::string> recovered_;
  std::optional<std::string> trouble_;
};

}  // namespace mlcca::store
