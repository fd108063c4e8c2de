// SPDX-License-Identifier: BSD-2-Clause
// What the journal does, by SQLite: a prototype to measure and to crash (docs/adr/0037).
#pragma once
#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/store/contents.hpp"

namespace mlcca::bench {

/// One table of what is alive, in the encoding of the journal: WAL, synchronous=FULL, one
/// transaction a commit.
class SqliteStore {
 public:
  /// `vfs`: name of a file system layer; null: the usual one.
  static Result<SqliteStore> open(const std::string& directory, const char* vfs = nullptr);

  [[nodiscard]] const store::Contents& contents() const { return contents_; }
  Result<void> append(const store::Entry& entry);
  Result<void> commit();

 private:
  using Statement = std::unique_ptr<sqlite3_stmt, FreeWith<sqlite3_finalize>>;

  Result<void> connect(const std::string& path, const char* vfs);
  Result<void> read();
  Result<void> write(const store::Entry& entry);
  Result<void> run(const char* text);
  Result<Statement> prepare(const char* text);
  [[nodiscard]] std::unexpected<Error> failed() const;

  std::unique_ptr<sqlite3, FreeWith<sqlite3_close_v2>> database_;
  Statement put_;
  Statement remove_;
  store::Contents contents_;
  std::vector<store::Entry> batch_;
  std::vector<store::Entry> undo_;
  std::uint64_t former_next_ = 1;
};

}  // namespace mlcca::bench
