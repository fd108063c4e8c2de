// SPDX-License-Identifier: BSD-2-Clause
// The history of decisions and their reasons, for people, in an SQLite database. It never stops the
// gateway: what cannot be written is reported once and counted, and a damaged database is set aside
// and a new one begun.
#pragma once
#include <sqlite3.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "control/messages.hpp"

namespace mlcca::store {

/// A row of the history.
struct Decision {
  std::uint64_t unix_ns = 0;  ///< nanoseconds since 1970, UTC; at most 2^63-1
  std::string kind;           ///< granted, refused, withdrawn, degraded, released, …
  std::uint64_t subject = 0;  ///< 0: not about a subject
  std::string channel;
  std::string from;
  std::string to;
  std::string network;
  std::string message;                    ///< one line
  std::optional<control::Actor> by = {};  ///< who requested it; nullopt: the daemon itself
  bool operator==(const Decision&) const = default;
};

/// A query. Empty texts match everything, others match exactly.
struct HistoryFilter {
  std::string channel;
  std::string kind;
  std::uint64_t since_ns = 0;  ///< nanoseconds since 1970, inclusive
  std::uint64_t until_ns = std::numeric_limits<std::int64_t>::max();  ///< inclusive
  std::size_t limit = 100;
};

/// Older rows, and the oldest of more rows, are removed.
struct HistoryLimits {
  std::uint64_t rows = 1'000'000;
  std::uint64_t age_ns = 90ULL * 24 * 3600 * 1'000'000'000;
};

/// Collects decisions in memory, and writes them in small transactions. Owns the connection to the
/// database.
class History {
 public:
  /// Decisions that wait for flush(). Of more, the oldest are lost and counted.
  static constexpr std::size_t kMaxPending = 10'000;
  /// The most decisions that one flush_some() writes.
  static constexpr std::size_t kFlushStep = 64;
  /// One flush_some() removes at most as many rows as it adds and this many more, so that it stays
  /// short.
  static constexpr std::size_t kPruneStep = 64;
  /// ns after a failure before flush() tries again.
  static constexpr std::uint64_t kRetryNs = 5'000'000'000;

  /// Opens or creates `directory`/history.db. The object is always usable; see take_troubles().
  static History open(const std::string& directory, HistoryLimits limits = {});

  /// Collects a decision in memory only.
  void append(Decision decision);

  /// Writes the oldest waiting decisions in one transaction, and removes some rows that are too old
  /// at `now_unix_ns` or too many. True if there is more to write, and writing is possible.
  bool flush_some(std::uint64_t now_unix_ns);
  /// Writes everything that can be written.
  void flush(std::uint64_t now_unix_ns) {
    while (flush_some(now_unix_ns)) {
    }
  }

  /// The newest matching decisions by time, the newest first, including those that wait for
  /// flush(). Of equal times the later decision comes first. The error is that of the database.
  [[nodiscard]] Result<std::vector<Decision>> query(const HistoryFilter& filter);

  /// Keeps bytes of another part of the daemon under a name, at once, replacing what was kept under
  /// it.
  Result<void> keep_note(const std::string& name, const std::string& bytes);
  /// The kept bytes; empty if nothing was kept.
  [[nodiscard]] Result<std::string> note(const std::string& name);

  /// What the operator should know (a database that was set aside, a full disk, and when that has
  /// ended), each reported once.
  std::vector<std::string> take_troubles();

  /// The number of decisions that wait for flush().
  [[nodiscard]] std::size_t pending() const { return pending_.size(); }
  /// The number of decisions since open() that will never be written.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  using Database = std::unique_ptr<sqlite3, FreeWith<sqlite3_close_v2>>;
  using Statement = std::unique_ptr<sqlite3_stmt, FreeWith<sqlite3_finalize>>;

  History(std::string path, HistoryLimits limits) : path_(std::move(path)), limits_(limits) {}

  Result<void> connect();
  Result<void> add_actors();
  void disconnect();
  /// Runs `work` on the database, after connecting if necessary. If the database is damaged, runs
  /// it a second time on a new one.
  template <class Work>
  auto with_database(const Work& work) -> decltype(work());
  void set_aside(const std::string& why);
  Result<Statement> prepare(const char* text);
  Result<void> run(const char* text);
  Result<void> finish(sqlite3_stmt* statement);
  std::unexpected<Error> failed();

  Result<void> write(std::size_t count, std::uint64_t now_unix_ns);
  Result<void> prune(std::size_t added, std::uint64_t now_unix_ns);
  Result<std::vector<Decision>> select(const HistoryFilter& filter, std::size_t limit);

  std::string path_;
  HistoryLimits limits_;
  Database database_;
  Statement insert_;
  Statement prune_old_;
  Statement prune_many_;
  bool damaged_ = false;  ///< the last failed() was about damage
  std::deque<Decision> pending_;
  std::uint64_t lost_ = 0;
  bool failing_ = false;
  std::uint64_t failed_at_ = 0;  ///< unix time, ns
  std::vector<std::string> troubles_;
};

}  // namespace mlcca::store
