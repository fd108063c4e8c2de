// SPDX-License-Identifier: BSD-2-Clause
// The journal's append and commit against one bare write and fdatasync of the same bytes on the
// same disk, in turns; and decisions into the history against bare inserts of SQLite. usage:
// journal_bench DIRECTORY [ROUNDS]   (on a real disk: on a tmpfs a sync costs nothing)
#include <fcntl.h>
#include <fmt/core.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "daemon/store/history.hpp"
#include "daemon/store/journal.hpp"
#include "tests/bench/measure.hpp"

namespace {

using namespace mlcca;         // NOLINT(google-build-using-namespace): a bench
using namespace mlcca::bench;  // NOLINT(google-build-using-namespace): a bench

store::Admitted admitted(std::uint64_t id) {
  control::Admit admit;
  admit.channel = "camera-" + std::to_string(id);
  admit.from = "robot";
  admit.offered = {{"Bandwidth", 400'000, "byte s^-1", false}, {"Period", 40'000'000, "ns", false}};
  admit.node = 0x20;
  return {{id, admit}};
}

/// Appends to a file of its own and syncs.
class Bare {
 public:
  explicit Bare(const std::string& path)
      : file_(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600)) {
    require(static_cast<bool>(file_), path);
  }
  void write(const std::string& bytes) {
    const auto wanted = static_cast<ssize_t>(bytes.size());
    require(::pwrite(file_.get(), bytes.data(), bytes.size(), end_) == wanted, "pwrite");
    end_ += wanted;
    require(::fdatasync(file_.get()) == 0, "fdatasync");
  }

 private:
  Fd file_;
  off_t end_ = 0;
};

void bench_journal(const std::string& directory, std::uint64_t group, int rounds) {
  auto journal = store::Journal::open(directory);
  require(journal.has_value(), directory);
  Bare bare(directory + "/bare");
  std::uint64_t id = journal->contents().next_id;
  std::uint64_t oldest = id;
  std::vector<double> ours;
  std::vector<double> floor;
  std::vector<double> memory;
  std::uint64_t bytes = 0;
  for (int i = 0; i < rounds; ++i) {
    const std::uint64_t before = journal->file_bytes();
    ours.push_back(microseconds([&] {
      memory.push_back(microseconds([&] {
        for (std::uint64_t n = 0; n < group; ++n)
          require(journal->append(admitted(id++)).has_value(), "append");
      }));
      require(journal->commit().has_value(), "commit");
    }));
    // A round that wrote the file again is the slowest of them, and counts like any other.
    if (journal->file_bytes() > before) bytes = journal->file_bytes() - before;
    floor.push_back(microseconds([&] { bare.write(std::string(bytes, 'x')); }));
  }
  for (; oldest < id; ++oldest) require(journal->append(store::Removed{oldest}).has_value(), "");
  require(journal->commit().has_value() && journal->compact().has_value(), "commit");
  const double per = static_cast<double>(group);
  fmt::print(
      "journal, {:>2} admissions a commit, p50 {:>10.1f} us   bare fdatasync, {:>5} B {:>8.1f} us  "
      " "
      "ratio {:.2f}\n",
      group, quantile(ours, 0.5), bytes, quantile(floor, 0.5),
      quantile(ours, 0.5) / quantile(floor, 0.5));
  fmt::print(
      "journal, {:>2} admissions a commit, p99 {:>10.1f} us   the same            {:>8.1f} us   "
      "ratio {:.2f}\n",
      group, quantile(ours, 0.99), quantile(floor, 0.99),
      quantile(ours, 0.99) / quantile(floor, 0.99));
  fmt::print("  of it in memory {:.2f} us an admission; {:.0f} admissions a second\n",
             quantile(memory, 0.5) / per, per * 1e6 / quantile(ours, 0.5));
}

void bench_reopening(const std::string& directory, std::uint64_t live) {
  {
    auto journal = store::Journal::open(directory);
    require(journal.has_value(), directory);
    const std::uint64_t first = journal->contents().next_id;
    for (std::uint64_t id = first; id < first + live; ++id)
      require(journal->append(admitted(id)).has_value(), "append");
    require(journal->commit().has_value(), "commit");
    const double again = microseconds([&] { require(journal->compact().has_value(), "compact"); });
    fmt::print("journal of {} admissions ({:.1f} MB) written again in {:.0f} ms", live,
               static_cast<double>(journal->file_bytes()) / 1e6, again / 1e3);
  }
  const double read =
      microseconds([&] { require(store::Journal::open(directory).has_value(), "open"); });
  fmt::print(", read in {:.0f} ms\n", read / 1e3);
}

store::Decision decision(std::uint64_t n) {
  return {n,       "granted", n,      "camera-" + std::to_string(n % 1000),
          "robot", "base",    "mesh", "granted: Bandwidth 400000 byte/s of 812345 byte/s free"};
}

void bench_history(const std::string& directory, std::uint64_t group, std::uint64_t total) {
  store::History history = store::History::open(directory);
  const double ours = microseconds([&] {
    for (std::uint64_t n = 1; n <= total; ++n) {
      history.append(decision(n));
      if (n % group == 0) history.flush(n);
    }
  });
  require(history.pending() == 0 && history.lost() == 0, "history");

  sqlite3* opened = nullptr;
  require(sqlite3_open((directory + "/bare.db").c_str(), &opened) == SQLITE_OK, "sqlite3_open");
  const std::unique_ptr<sqlite3, FreeWith<sqlite3_close_v2>> database(opened);
  const auto run = [opened](const char* text) {
    require(sqlite3_exec(opened, text, nullptr, nullptr, nullptr) == SQLITE_OK, text);
  };
  run("PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL;"
      "CREATE TABLE IF NOT EXISTS d (a INTEGER, b TEXT, c INTEGER, d TEXT, e TEXT)");
  sqlite3_stmt* prepared = nullptr;
  require(sqlite3_prepare_v2(opened, "INSERT INTO d VALUES (?1, ?2, ?3, ?4, ?5)", -1, &prepared,
                             nullptr) == SQLITE_OK,
          "sqlite3_prepare");
  const std::unique_ptr<sqlite3_stmt, FreeWith<sqlite3_finalize>> insert(prepared);
  const double floor = microseconds([&] {
    for (std::uint64_t n = 1; n <= total; ++n) {
      if (n % group == 1) run("BEGIN");
      const store::Decision d = decision(n);
      sqlite3_bind_int64(prepared, 1, static_cast<std::int64_t>(n));
      sqlite3_bind_text(prepared, 2, d.kind.c_str(), -1, SQLITE_STATIC);
      sqlite3_bind_int64(prepared, 3, static_cast<std::int64_t>(d.subject));
      sqlite3_bind_text(prepared, 4, d.channel.c_str(), -1, SQLITE_STATIC);
      sqlite3_bind_text(prepared, 5, d.message.c_str(), -1, SQLITE_STATIC);
      require(sqlite3_step(prepared) == SQLITE_DONE, "insert");
      sqlite3_reset(prepared);
      if (n % group == 0) run("COMMIT");
    }
  });
  const double per = static_cast<double>(total);
  fmt::print(
      "history, {:>5} decisions a flush, each {:>8.2f} us   bare insert, no index  {:>8.2f} us   "
      "ratio {:.2f}\n",
      group, ours / per, floor / per, ours / floor);
  const double query = microseconds([&] {
    const auto found = history.query({.channel = "camera-7", .kind = "granted", .limit = 100});
    require(found && found->size() == 100, "query");
  });
  fmt::print("  {:.0f} decisions a second; the latest 100 of a channel in {:.0f} us\n",
             per * 1e6 / ours, query);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) {
    fmt::print(stderr, "usage: {} DIRECTORY [ROUNDS]\n", argv[0]);
    return 2;
  }
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 1000;
  std::string directory = std::string(argv[1]) + "/journal-bench-XXXXXX";
  require(::mkdtemp(directory.data()) != nullptr, directory);
  for (const std::uint64_t group : {1U, 8U, 64U}) bench_journal(directory, group, rounds);
  bench_reopening(directory, 100'000);
  for (const std::uint64_t group : {100U, 10'000U}) bench_history(directory, group, 100'000);
  std::filesystem::remove_all(directory);
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "journal_bench: {}\n", e.what());
  return 1;
}
