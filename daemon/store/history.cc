// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/store/history.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <ranges>
#include <string_view>
#include <utility>

#include "base/many.hpp"

namespace mlcca::store {
namespace {

// WAL and NORMAL: a crash loses at most the latest decisions, never the database, and a flush waits
// for the disk only when the write-ahead log is copied back. 256 KiB of pages are cached, because
// rows are added at the end and rarely read.
constexpr const char* kPragmas = R"(
  PRAGMA journal_mode = WAL;
  PRAGMA synchronous = NORMAL;
  PRAGMA trusted_schema = OFF;
  PRAGMA cache_size = -256;
)";
constexpr const char* kSchema = R"(
  BEGIN IMMEDIATE;
  CREATE TABLE IF NOT EXISTS decision (
    id INTEGER PRIMARY KEY,
    unix_ns INTEGER NOT NULL,
    kind TEXT NOT NULL,
    subject INTEGER NOT NULL,
    channel TEXT NOT NULL,
    "from" TEXT NOT NULL,
    "to" TEXT NOT NULL,
    network TEXT NOT NULL,
    message TEXT NOT NULL,
    uid INTEGER,
    user TEXT,
    pid INTEGER
  );
  CREATE TABLE IF NOT EXISTS note (
    name TEXT PRIMARY KEY,
    bytes BLOB NOT NULL
  );
  CREATE INDEX IF NOT EXISTS decision_time ON decision (unix_ns);
  CREATE INDEX IF NOT EXISTS decision_channel ON decision (channel, unix_ns);
  CREATE INDEX IF NOT EXISTS decision_kind ON decision (kind, unix_ns);
  CREATE INDEX IF NOT EXISTS decision_channel_kind ON decision (channel, kind, unix_ns);
  COMMIT;
)";
constexpr const char* kInsert =
    R"(INSERT INTO decision (unix_ns, kind, subject, channel, "from", "to", network, message,
                             uid, user, pid)
       VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11))";
/// For a database of a version whose decisions had no actor.
constexpr const char* kAddActors = R"(
  BEGIN IMMEDIATE;
  ALTER TABLE decision ADD COLUMN uid INTEGER;
  ALTER TABLE decision ADD COLUMN user TEXT;
  ALTER TABLE decision ADD COLUMN pid INTEGER;
  COMMIT;
)";
constexpr const char* kPruneOld =
    R"(DELETE FROM decision WHERE id IN (
         SELECT id FROM decision WHERE unix_ns < ?1 ORDER BY unix_ns LIMIT ?2))";
// Ids increase and rows are removed in about that order. So the difference of ids counts the rows,
// and never too low.
constexpr const char* kPruneMany =
    R"(DELETE FROM decision WHERE id IN (
         SELECT id FROM decision WHERE id <= (SELECT MAX(id) FROM decision) - ?1
         ORDER BY id LIMIT ?2))";

/// A time or number, limited to what the column can hold.
std::int64_t bounded(std::uint64_t value) {
  return static_cast<std::int64_t>(
      std::min<std::uint64_t>(value, std::numeric_limits<std::int64_t>::max()));
}

void bind(sqlite3_stmt* to, int place, std::int64_t value) { sqlite3_bind_int64(to, place, value); }
void bind(sqlite3_stmt* to, int place, const std::string& text) {
  sqlite3_bind_text64(to, place, text.data(), text.size(), SQLITE_STATIC, SQLITE_UTF8);
}

std::string text_of(sqlite3_stmt* row, int column) {
  const void* bytes = sqlite3_column_blob(row, column);
  if (bytes == nullptr) return {};
  return {static_cast<const char*>(bytes),
          static_cast<std::size_t>(sqlite3_column_bytes(row, column))};
}

Decision decision_of(sqlite3_stmt* row) {
  const auto number = [row](int column) {
    return static_cast<std::uint64_t>(sqlite3_column_int64(row, column));
  };
  std::optional<control::Actor> by;
  if (sqlite3_column_type(row, 8) != SQLITE_NULL)
    by = control::Actor{static_cast<std::uint32_t>(number(8)), text_of(row, 9),
                        static_cast<std::uint32_t>(number(10))};
  return {number(0),       text_of(row, 1), number(2),       text_of(row, 3), text_of(row, 4),
          text_of(row, 5), text_of(row, 6), text_of(row, 7), std::move(by)};
}

bool matches(const Decision& d, const HistoryFilter& filter) {
  return (filter.channel.empty() || d.channel == filter.channel) &&
         (filter.kind.empty() || d.kind == filter.kind) && d.unix_ns >= filter.since_ns &&
         d.unix_ns <= filter.until_ns;
}

/// Contains only the requested conditions. Each of them has an index, and so do both together.
std::string query_text(const HistoryFilter& filter) {
  std::string text =
      R"(SELECT unix_ns, kind, subject, channel, "from", "to", network, message, uid, user, pid
         FROM decision
         WHERE unix_ns BETWEEN ?1 AND ?2)";
  if (!filter.channel.empty()) text += " AND channel = ?3";
  if (!filter.kind.empty()) text += " AND kind = ?4";
  return text + " ORDER BY unix_ns DESC, id DESC LIMIT ?5";
}

/// Codes that no further attempt can resolve: the file is not a usable database of ours. Errors of
/// the disk are not among them.
bool is_damage(int code) {
  return code == SQLITE_CORRUPT || code == SQLITE_NOTADB || code == SQLITE_ERROR ||
         code == SQLITE_FORMAT || code == SQLITE_MISMATCH;
}

/// SQLite's file system layer without its sleep. If SQLite cannot get a lock it sleeps up to 10 s
/// between attempts, and the daemon's heart-beat would have to wait. nullptr if there is none.
const char* layer_without_sleep() {
  static const bool registered = [] {
    const sqlite3_vfs* const usual = sqlite3_vfs_find(nullptr);
    if (usual == nullptr) return false;
    static sqlite3_vfs ours = *usual;
    ours.pNext = nullptr;
    ours.zName = "without-sleep";
    ours.xSleep = +[](sqlite3_vfs*, int /*microseconds*/) { return 0; };
    return sqlite3_vfs_register(&ours, 0) == SQLITE_OK;
  }();
  return registered ? "without-sleep" : nullptr;
}

/// A name beside `path` that is not in use.
std::string free_name(const std::string& path) {
  for (unsigned i = 1;; ++i) {
    std::string name = path + ".damaged-" + std::to_string(i);
    struct stat status{};
    if (::stat(name.c_str(), &status) < 0) return name;
  }
}

}  // namespace

// --- the database --------------------------------------------------------------------------------

std::unexpected<Error> History::failed() {
  damaged_ = is_damage(sqlite3_errcode(database_.get()));
  return fail(path_ + ": " + sqlite3_errmsg(database_.get()));
}

Result<History::Statement> History::prepare(const char* text) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database_.get(), text, -1, &statement, nullptr) != SQLITE_OK)
    return failed();
  return Statement(statement);
}

Result<void> History::run(const char* text) {
  if (sqlite3_exec(database_.get(), text, nullptr, nullptr, nullptr) != SQLITE_OK) return failed();
  return {};
}

/// Runs a statement that returns no rows, and resets it for the next time.
Result<void> History::finish(sqlite3_stmt* statement) {
  Result<void> done;
  if (sqlite3_step(statement) != SQLITE_DONE) done = failed();
  sqlite3_reset(statement);
  sqlite3_clear_bindings(statement);
  return done;
}

void History::disconnect() {
  insert_.reset();
  prune_old_.reset();
  prune_many_.reset();
  database_.reset();
}

Result<void> History::connect() {
  sqlite3* database = nullptr;
  const int opened = sqlite3_open_v2(
      path_.c_str(), &database, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX,
      layer_without_sleep());
  database_.reset(database);
  Result<void> done;
  if (opened != SQLITE_OK) done = failed();
  if (done) done = run(kPragmas);
  if (done) done = run(kSchema);
  if (done) done = add_actors();
  for (const auto& [statement, text] :
       {std::pair(&insert_, kInsert), std::pair(&prune_old_, kPruneOld),
        std::pair(&prune_many_, kPruneMany)}) {
    if (!done) break;
    auto prepared = prepare(text);
    if (prepared)
      *statement = std::move(*prepared);
    else
      done = std::unexpected(prepared.error());
  }
  if (!done) disconnect();
  return done;
}

Result<void> History::add_actors() {
  const int known = sqlite3_table_column_metadata(database_.get(), nullptr, "decision", "uid",
                                                  nullptr, nullptr, nullptr, nullptr, nullptr);
  return known == SQLITE_OK ? Result<void>() : run(kAddActors);
}

void History::set_aside(const std::string& why) {
  disconnect();
  const std::string name = free_name(path_);
  if (std::rename(path_.c_str(), name.c_str()) != 0) {
    troubles_.push_back(why + "; and it could not be set aside: " +
                        std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
    return;
  }
  for (const char* companion : {"-wal", "-shm"})
    static_cast<void>(std::rename((path_ + companion).c_str(), (name + companion).c_str()));
  troubles_.push_back(why + ": a new history is begun, the damaged one is kept as " + name);
}

template <class Work>
auto History::with_database(const Work& work) -> decltype(work()) {
  for (bool again = false;; again = true) {
    damaged_ = false;
    auto connected = database_ ? Result<void>() : connect();
    auto done = connected ? work() : std::unexpected(connected.error());
    if (done || !damaged_ || again) return done;
    set_aside(done.error().text);
  }
}

History History::open(const std::string& directory, HistoryLimits limits) {
  History history(directory + "/history.db", limits);
  if (const auto done = history.with_database([] { return Result<void>(); }); !done) {
    history.failing_ = true;
    history.troubles_.push_back("the history is not written: " + done.error().text);
  }
  return history;
}

// --- writing -------------------------------------------------------------------------------------

void History::append(Decision decision) {
  if (pending_.size() == kMaxPending) {
    pending_.pop_front();
    ++lost_;
  }
  pending_.push_back(std::move(decision));
}

bool History::flush_some(std::uint64_t now_unix_ns) {
  if (pending_.empty()) return false;
  const bool soon = now_unix_ns >= failed_at_ && now_unix_ns - failed_at_ < kRetryNs;
  if (failing_ && soon) return false;
  const std::size_t count = std::min(pending_.size(), kFlushStep);
  const auto done = with_database([&] { return write(count, now_unix_ns); });
  if (!done) {
    if (!std::exchange(failing_, true))
      troubles_.push_back("the history is not written: " + done.error().text);
    failed_at_ = now_unix_ns;
    return false;
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(count));
  if (std::exchange(failing_, false))
    troubles_.push_back("the history is written again, " +
                        many(lost_, "decision was", "decisions were") + " lost so far");
  return !pending_.empty();
}

Result<void> History::write(std::size_t count, std::uint64_t now_unix_ns) {
  auto done = run("BEGIN IMMEDIATE");
  if (!done) return done;
  for (const Decision& d : pending_ | std::views::take(count)) {
    sqlite3_stmt* to = insert_.get();
    bind(to, 1, bounded(d.unix_ns));
    bind(to, 2, d.kind);
    bind(to, 3, static_cast<std::int64_t>(d.subject));
    bind(to, 4, d.channel);
    bind(to, 5, d.from);
    bind(to, 6, d.to);
    bind(to, 7, d.network);
    bind(to, 8, d.message);
    if (d.by) {
      bind(to, 9, std::int64_t{d.by->uid});
      bind(to, 10, d.by->user);
      bind(to, 11, std::int64_t{d.by->pid});
    }
    done = finish(to);
    if (!done) break;
  }
  if (done) done = prune(count, now_unix_ns);
  if (done) done = run("COMMIT");
  // Some failures have already rolled back; then there is no transaction any more.
  if (!done && sqlite3_get_autocommit(database_.get()) == 0)
    sqlite3_exec(database_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
  return done;
}

Result<void> History::prune(std::size_t added, std::uint64_t now_unix_ns) {
  const auto step = static_cast<std::int64_t>(kPruneStep + added);
  const std::uint64_t oldest = now_unix_ns > limits_.age_ns ? now_unix_ns - limits_.age_ns : 0;
  bind(prune_old_.get(), 1, bounded(oldest));
  bind(prune_old_.get(), 2, step);
  if (auto done = finish(prune_old_.get()); !done) return done;
  bind(prune_many_.get(), 1, bounded(limits_.rows));
  bind(prune_many_.get(), 2, step);
  return finish(prune_many_.get());
}

// --- reading -------------------------------------------------------------------------------------

Result<std::vector<Decision>> History::query(const HistoryFilter& filter) {
  const auto newer = [](const Decision& a, const Decision& b) { return a.unix_ns > b.unix_ns; };
  std::vector<Decision> waiting;
  for (const Decision& d : std::views::reverse(pending_))
    if (matches(d, filter)) waiting.push_back(d);
  std::ranges::stable_sort(waiting, newer);  // the clock may have been set back
  auto written = with_database([&] { return select(filter, filter.limit); });
  if (!written) return written;
  std::vector<Decision> found;
  found.reserve(waiting.size() + written->size());
  std::ranges::merge(std::make_move_iterator(waiting.begin()),
                     std::make_move_iterator(waiting.end()),
                     std::make_move_iterator(written->begin()),
                     std::make_move_iterator(written->end()), std::back_inserter(found), newer);
  if (found.size() > filter.limit) found.resize(filter.limit);
  return found;
}

Result<std::vector<Decision>> History::select(const HistoryFilter& filter, std::size_t limit) {
  const auto statement = prepare(query_text(filter).c_str());
  if (!statement) return std::unexpected(statement.error());
  sqlite3_stmt* rows = statement->get();
  bind(rows, 1, bounded(filter.since_ns));
  bind(rows, 2, bounded(filter.until_ns));
  if (!filter.channel.empty()) bind(rows, 3, filter.channel);
  if (!filter.kind.empty()) bind(rows, 4, filter.kind);
  bind(rows, 5, bounded(limit));
  std::vector<Decision> found;
  for (;;) {
    const int stepped = sqlite3_step(rows);
    if (stepped == SQLITE_DONE) return found;
    if (stepped != SQLITE_ROW) return failed();
    found.push_back(decision_of(rows));
  }
}

// --- notes ---------------------------------------------------------------------------------------

Result<void> History::keep_note(const std::string& name, const std::string& bytes) {
  return with_database([&]() -> Result<void> {
    const auto statement = prepare("INSERT OR REPLACE INTO note (name, bytes) VALUES (?1, ?2)");
    if (!statement) return std::unexpected(statement.error());
    bind(statement->get(), 1, name);
    sqlite3_bind_blob64(statement->get(), 2, bytes.data(), bytes.size(), SQLITE_STATIC);
    return finish(statement->get());
  });
}

Result<std::string> History::note(const std::string& name) {
  return with_database([&]() -> Result<std::string> {
    const auto statement = prepare("SELECT bytes FROM note WHERE name = ?1");
    if (!statement) return std::unexpected(statement.error());
    bind(statement->get(), 1, name);
    const int stepped = sqlite3_step(statement->get());
    if (stepped == SQLITE_DONE) return std::string();
    if (stepped != SQLITE_ROW) return failed();
    return text_of(statement->get(), 0);
  });
}

std::vector<std::string> History::take_troubles() { return std::exchange(troubles_, {}); }

}  // namespace mlcca::store
