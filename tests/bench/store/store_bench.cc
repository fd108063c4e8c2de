// SPDX-License-Identifier: BSD-2-Clause
// The journal against SQLite (WAL, synchronous=FULL, one transaction a turn) with the same entries,
// in turns and on the same file system, and the same crashes of both: docs/adr/0037. usage:
// store_bench DIRECTORY [ROUNDS]   (on a real disk: on a tmpfs a sync costs nothing)
#include <fcntl.h>
#include <fmt/core.h>
#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "core/model/text.hpp"
#include "daemon/store/journal.hpp"
#include "daemon/store/records.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/store/crashes.hpp"
#include "tests/bench/store/sqlite_store.hpp"

namespace {

using namespace mlcca;         // NOLINT(google-build-using-namespace): a bench
using namespace mlcca::bench;  // NOLINT(google-build-using-namespace): a bench
using Entries = std::vector<store::Entry>;

/// A number of a file of /proc, in the line that begins with `key`.
std::uint64_t number_in(const char* file, const std::string& key) {
  std::ifstream in(file);
  std::string word;
  std::uint64_t number = 0;
  while (in >> word)
    if (word == key && in >> number) return number;
  return 0;
}
std::uint64_t written() { return number_in("/proc/self/io", "wchar:"); }
std::uint64_t dirtied() { return number_in("/proc/self/io", "write_bytes:"); }

/// What the daemon commits in the turn of an admission: the request, the grant, and a slot at
/// either end.
Entries admission(std::uint64_t id) {
  control::Admit admit;
  admit.channel = "camera-" + std::to_string(id);
  admit.from = "robot";
  admit.offered = {{"Bandwidth", 400'000, "byte s^-1", false}, {"Period", 40'000'000, "ns", false}};
  admit.node = 0x20;
  const std::uint64_t subject = 0x6d6c636361000000 + id;
  gates::PlacedSlot slot{.ifindex = 3, .slot = {}};
  slot.slot.pass = true;
  slot.slot.id = 0x80000000 | static_cast<std::uint32_t>(id);
  slot.slot.mask = 0xdfffffff;
  slot.slot.per_frame = 320'000;
  slot.slot.per_byte = 2'000;
  slot.slot.tolerance = 1'000'000;
  std::array<gates::PlacedSlot, 2> slots{slot, slot};
  slots[1].ifindex = 4;
  slots[1].slot.direction = gates::Direction::egress;
  slots[1].slot.source = 3;
  return {store::Admitted{{id, admit}, 1000},
          store::Granted{core::format_subject(subject),
                         store::record_of(core::Grants{0, {{"robot", id, "base"}}})},
          store::Enforced{subject, store::record_of(slots)}};
}

template <class Store>
void commit(Store& to, const Entries& entries) {
  for (const store::Entry& entry : entries) require(to.append(entry).has_value(), "append");
  const auto done = to.commit();
  require(done.has_value(), done ? "" : done.error().text);
}

struct Measured {
  std::vector<double> microseconds;
  std::uint64_t written = 0;
  std::uint64_t dirtied = 0;
};

template <class Work>
void measure(Measured& to, const Work& work) {
  const std::uint64_t bytes = written();
  const std::uint64_t pages = dirtied();
  to.microseconds.push_back(microseconds(work));
  to.written += written() - bytes;
  to.dirtied += dirtied() - pages;
}

void print(const char* name, const Measured& m, const Measured& floor, double changes) {
  const auto rounds = static_cast<double>(m.microseconds.size());
  const double p50 = quantile(m.microseconds, 0.5);
  fmt::print(
      "{:<18} p50 {:>8.0f} us ({:.2f})  p99 {:>8.0f} us ({:.2f})  {:>7.0f} entries/s  written "
      "{:>6.0f} B, dirtied {:>6.0f} B an entry\n",
      name, p50, p50 / quantile(floor.microseconds, 0.5), quantile(m.microseconds, 0.99),
      quantile(m.microseconds, 0.99) / quantile(floor.microseconds, 0.99), changes * 1e6 / p50,
      static_cast<double>(m.written) / rounds / changes,
      static_cast<double>(m.dirtied) / rounds / changes);
}

/// `group` admissions a commit, in turns, and a bare write and sync of as many bytes as the journal
/// has written.
void bench_commits(const std::string& directory, std::uint64_t group, int rounds) {
  const std::string folder = directory + "/commits-" + std::to_string(group);
  std::filesystem::create_directory(folder);
  auto journal = store::Journal::open(folder);
  auto sqlite = bench::SqliteStore::open(folder);
  require(journal && sqlite, folder);
  const Fd bare(::open((folder + "/bare").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
  Measured ours;
  Measured theirs;
  Measured floor;
  off_t end = 0;
  std::uint64_t id = 1;
  for (int round = 0; round < rounds; ++round) {
    Entries entries;
    for (std::uint64_t n = 0; n < group; ++n)
      for (store::Entry& entry : admission(id++)) entries.push_back(std::move(entry));
    const std::uint64_t before = journal->file_bytes();
    measure(ours, [&] { commit(*journal, entries); });
    measure(theirs, [&] { commit(*sqlite, entries); });
    const std::string bytes(journal->file_bytes() - before, 'x');
    measure(floor, [&] {
      require(::pwrite(bare.get(), bytes.data(), bytes.size(), end) ==
                      static_cast<ssize_t>(bytes.size()) &&
                  ::fdatasync(bare.get()) == 0,
              "bare");
    });
    end += static_cast<off_t>(bytes.size());
  }
  require(journal->contents() == sqlite->contents(), "they hold different things");
  fmt::print("{} admission{} of 3 entries a commit, {} commits (ratio to bare write and sync)\n",
             group, group == 1 ? "" : "s", rounds);
  const auto changes = static_cast<double>(3 * group);
  print("  journal", ours, floor, changes);
  print("  SQLite", theirs, floor, changes);
  print("  bare", floor, floor, changes);
}

/// In a process of its own: how long it takes to open, and what that takes of memory.
template <class Open>
void bench_open(const char* name, const std::string& folder, const Open& open) {
  constexpr int kTimes = 5;
  constexpr std::size_t kFigures = 4;
  std::array<std::array<double, kFigures>, kTimes> seen{};
  for (auto& each : seen) {
    std::array<int, 2> ends{};
    require(::pipe2(ends.data(), O_CLOEXEC) == 0, "pipe2");
    const pid_t child = ::fork();
    if (child == 0) {
      const auto heap = [] {
        const auto now = ::mallinfo2();
        return static_cast<double>(now.uordblks + now.hblkhd);
      };
      ::malloc_trim(0);
      std::ofstream("/proc/self/clear_refs") << 5;  // the peak is reset
      const double heap_before = heap();
      const auto before = static_cast<double>(number_in("/proc/self/status", "VmRSS:"));
      std::array<double, kFigures> out{};
      const std::clock_t processor = std::clock();
      const auto start = std::chrono::steady_clock::now();
      const auto opened = open(folder);
      out[0] = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                   .count();
      out[1] = 1e3 * static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC;
      out[2] = (heap() - heap_before) / 1e6;
      out[3] = (static_cast<double>(number_in("/proc/self/status", "VmHWM:")) - before) / 1e3;
      const auto wanted = static_cast<ssize_t>(sizeof out);
      ::_exit(opened && ::write(ends[1], out.data(), sizeof out) == wanted ? 0 : 1);
    }
    ::close(ends[1]);
    const Fd in(ends[0]);
    const auto wanted = static_cast<ssize_t>(sizeof each);
    require(::read(in.get(), each.data(), sizeof each) == wanted, name);
    require(::waitpid(child, nullptr, 0) == child, name);
  }
  std::ranges::sort(seen);
  const auto& median = seen[kTimes / 2];
  fmt::print(
      "  {:<10} opened in {:>8.1f} ms, {:>8.1f} ms of processor; memory {:>6.1f} MB, at most "
      "{:>6.1f} MB\n",
      name, median[0], median[1], median[2], median[3]);
}

void bench_replay(const std::string& directory, std::uint64_t grants) {
  const std::string folder = directory + "/replay-" + std::to_string(grants);
  std::filesystem::create_directory(folder);
  // In a process of its own: what this one has freed would hide what opening takes.
  const pid_t child = ::fork();
  if (child == 0) {
    auto journal = store::Journal::open(folder);
    auto sqlite = bench::SqliteStore::open(folder);
    require(journal && sqlite, folder);
    constexpr std::uint64_t kAtOnce = 1000;
    for (std::uint64_t id = 1; id <= grants;) {
      Entries entries;
      for (const std::uint64_t last = id + kAtOnce; id < last; ++id)
        for (store::Entry& entry : admission(id)) entries.push_back(std::move(entry));
      commit(*journal, entries);
      commit(*sqlite, entries);
    }
    sqlite = fail("closed");
    ::_exit(0);
  }
  int status = 0;
  require(::waitpid(child, &status, 0) == child && status == 0, "cannot be filled");
  fmt::print("{} grants: journal {:.1f} MB, SQLite {:.1f} MB\n", grants,
             static_cast<double>(std::filesystem::file_size(folder + "/journal")) / 1e6,
             static_cast<double>(std::filesystem::file_size(folder + "/store.db")) / 1e6);
  bench_open("journal", folder, [](const auto& at) { return store::Journal::open(at); });
  bench_open("SQLite", folder, [](const auto& at) { return bench::SqliteStore::open(at); });
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) {
    fmt::print(stderr, "usage: {} DIRECTORY [ROUNDS]\n", argv[0]);
    return 2;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 2000;
  std::string directory = std::string(argv[1]) + "/store-bench-XXXXXX";
  require(::mkdtemp(directory.data()) != nullptr, directory);
  bench_commits(directory, 1, rounds);
  bench_commits(directory, 300, std::max(rounds / 40, 10));
  bench_replay(directory, 1'000);
  bench_replay(directory, 100'000);
  bench::crash_both(directory);
  std::filesystem::remove_all(directory);
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "store_bench: {}\n", e.what());
  return 1;
}
