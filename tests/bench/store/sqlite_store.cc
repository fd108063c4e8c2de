// SPDX-License-Identifier: BSD-2-Clause
#include "tests/bench/store/sqlite_store.hpp"

#include <ranges>
#include <string_view>
#include <utility>
#include <variant>

#include "daemon/store/format.hpp"

namespace mlcca::bench {
namespace {

using namespace store;  // NOLINT(google-build-using-namespace): what is stored

// One process has the database at a time, as it has the journal: there is no shared memory then.
constexpr const char* kPragmas = R"(
  PRAGMA locking_mode = EXCLUSIVE;
  PRAGMA journal_mode = WAL;
  PRAGMA synchronous = FULL;
  CREATE TABLE IF NOT EXISTS entry (kind INTEGER, key BLOB, value BLOB, PRIMARY KEY (kind, key))
    WITHOUT ROWID;
)";

std::string octets(std::uint64_t number) {
  std::string text;
  for (int shift = 56; shift >= 0; shift -= 8) text += static_cast<char>(number >> shift & 0xffU);
  return text;
}

/// Where an entry has its row, and whether it takes that away.
struct Row {
  int kind = 0;
  std::string key;
  bool gone = false;
};

struct RowOf {
  Row operator()(const Admitted& e) const { return {1, octets(e.request.id)}; }
  Row operator()(const Removed& e) const { return {1, octets(e.id), true}; }
  Row operator()(const Released& e) const { return {2, e.subject}; }
  Row operator()(const Reinstated& e) const { return {2, e.subject, true}; }
  Row operator()(const Granted& e) const { return {3, e.subject, e.state.empty()}; }
  Row operator()(const Gated& e) const { return {4, e.identity, e.ifindex == 0}; }
  Row operator()(const Enforced& e) const { return {5, octets(e.subject), e.slots.empty()}; }
  Row operator()(const Contradicted& e) const {
    return {6, octets(e.subject) + e.network, e.how.empty()};
  }
  Row operator()(const NextId&) const { return {7, {}}; }
};

void bind(sqlite3_stmt* to, int place, std::string_view bytes) {
  sqlite3_bind_blob64(to, place, bytes.empty() ? "" : bytes.data(), bytes.size(), SQLITE_STATIC);
}

}  // namespace

std::unexpected<Error> SqliteStore::failed() const { return fail(sqlite3_errmsg(database_.get())); }

Result<void> SqliteStore::run(const char* text) {
  if (sqlite3_exec(database_.get(), text, nullptr, nullptr, nullptr) != SQLITE_OK) return failed();
  return {};
}

Result<SqliteStore::Statement> SqliteStore::prepare(const char* text) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database_.get(), text, -1, &statement, nullptr) != SQLITE_OK)
    return failed();
  return Statement(statement);
}

Result<SqliteStore> SqliteStore::open(const std::string& directory, const char* vfs) {
  SqliteStore opened;
  if (auto done = opened.connect(directory + "/store.db", vfs); !done)
    return std::unexpected(done.error());
  if (auto done = opened.read(); !done) return std::unexpected(done.error());
  return opened;
}

Result<void> SqliteStore::connect(const std::string& path, const char* vfs) {
  sqlite3* database = nullptr;
  const int status =
      sqlite3_open_v2(path.c_str(), &database,
                      SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, vfs);
  database_.reset(database);
  if (status != SQLITE_OK) return failed();
  if (auto done = run(kPragmas); !done) return done;
  auto put = prepare("INSERT OR REPLACE INTO entry VALUES (?1, ?2, ?3)");
  if (!put) return std::unexpected(put.error());
  auto remove = prepare("DELETE FROM entry WHERE kind = ?1 AND key = ?2");
  if (!remove) return std::unexpected(remove.error());
  put_ = std::move(*put);
  remove_ = std::move(*remove);
  return {};
}

Result<void> SqliteStore::read() {
  const auto rows = prepare("SELECT value FROM entry");
  if (!rows) return std::unexpected(rows.error());
  int step = SQLITE_ROW;
  while ((step = sqlite3_step(rows->get())) == SQLITE_ROW) {
    const std::string_view value(static_cast<const char*>(sqlite3_column_blob(rows->get(), 0)),
                                 static_cast<std::size_t>(sqlite3_column_bytes(rows->get(), 0)));
    const auto entry = format::Reader({.count = 1}, value).next();
    if (!entry) return std::unexpected(entry.error());
    contents_.apply(**entry);
  }
  return step == SQLITE_DONE ? Result<void>() : failed();
}

Result<void> SqliteStore::append(const Entry& entry) {
  auto back = contents_.inverse(entry);
  if (!back) return {};
  if (batch_.empty()) former_next_ = contents_.next_id;
  contents_.apply(entry);
  batch_.push_back(entry);
  undo_.push_back(std::move(*back));
  return {};
}

Result<void> SqliteStore::write(const Entry& entry) {
  const Row row = std::visit(RowOf{}, entry);
  sqlite3_stmt* statement = (row.gone ? remove_ : put_).get();
  const std::string value = row.gone ? std::string() : format::encode(entry);
  sqlite3_bind_int(statement, 1, row.kind);
  bind(statement, 2, row.key);
  if (!row.gone) bind(statement, 3, value);
  const bool done = sqlite3_step(statement) == SQLITE_DONE;
  sqlite3_reset(statement);
  return done ? Result<void>() : failed();
}

Result<void> SqliteStore::commit() {
  if (batch_.empty()) return {};
  Result<void> done = run("BEGIN IMMEDIATE");
  for (const Entry& entry : batch_)
    if (done) done = write(entry);
  if (done && contents_.next_id != former_next_) done = write(NextId{contents_.next_id});
  if (done) done = run("COMMIT");
  if (!done) {
    if (sqlite3_get_autocommit(database_.get()) == 0)
      sqlite3_exec(database_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
    for (const Entry& back : std::views::reverse(undo_)) contents_.apply(back);
    contents_.next_id = former_next_;
  }
  batch_.clear();
  undo_.clear();
  return done;
}

}  // namespace mlcca::bench
