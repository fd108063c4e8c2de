// SPDX-License-Identifier: BSD-2-Clause
#include "tests/bench/store/crashes.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <random>
#include <stdexcept>

#include "daemon/store/journal.hpp"
#include "tests/bench/store/disk_vfs.hpp"
#include "tests/bench/store/sqlite_store.hpp"
#include "tests/daemon/store/fake_disk.hpp"
#include "tests/daemon/store/worlds.hpp"

namespace mlcca::bench {
namespace {

using store::Journal;
using store::test::Batch;
using store::test::MemoryDisk;
using store::test::random_story;
using store::test::Story;
using store::test::Trouble;
using store::test::TroubledDisk;

struct OurJournal {
  static constexpr const char* kName = "journal";
  static constexpr const char* kFile = "/d/journal";
  static Result<Journal> open(store::Disk& disk) { return Journal::open("/d", disk); }
  static Result<Journal> open(const std::string& directory) { return Journal::open(directory); }
};
struct Sqlite {
  static constexpr const char* kName = "SQLite";
  static constexpr const char* kFile = "/d/store.db";
  static Result<SqliteStore> open(store::Disk& disk) {
    use_disk(disk);
    auto opened = SqliteStore::open("/d", kDiskVfs);
    check();
    return opened;
  }
  static Result<SqliteStore> open(const std::string& directory) {
    return SqliteStore::open(directory);
  }
  /// An exception cannot come through SQLite: it is thrown here.
  static void check() {
    if (power_is_gone()) throw store::test::PowerLoss{};
  }
};

template <class Store>
Result<void> write(Store& to, const Batch& batch) {
  Result<void> done;
  for (const store::Entry& entry : batch)
    if (done) done = to.append(entry);
  if (done) done = to.commit();
  if constexpr (std::is_same_v<Store, SqliteStore>) Sqlite::check();
  return done;
}

struct Count {
  std::size_t crashes = 0;
  std::size_t lost = 0;     ///< answered, and not there
  std::size_t came = 0;     ///< refused, and there
  std::size_t refused = 0;  ///< not opened
  std::size_t wrong = 0;    ///< opened, in a state that never was
};

void print(const char* test, const char* name, const Count& c) {
  fmt::print("{:<48} {:<8} {:>6} {:>7} {:>7} {:>7} {:>7}\n", test, name, c.crashes, c.lost, c.came,
             c.refused, c.wrong);
}

/// The power goes at each call, with any sectors of what was not synced.
template <class Kind>
void lose_power() {
  const Story story = random_story(21, 12, 900);
  Count count;
  for (const Trouble how : {Trouble::stop, Trouble::stop_after}) {
    for (std::size_t at = 1;; ++at) {
      MemoryDisk memory;
      TroubledDisk disk(memory);
      disk.trouble(how, at, 0);
      std::size_t answered = 0;
      bool finished = false;
      try {
        auto to = Kind::open(disk);
        if (!to) throw std::runtime_error(to.error().text);
        for (const Batch& batch : story.batches)
          if (write(*to, batch)) ++answered;
        finished = true;
      } catch (const store::test::PowerLoss&) {
      }
      if (finished) break;
      for (std::uint32_t seed = 0; seed < 60; ++seed) {
        std::mt19937 random(seed);
        const auto rest = memory.after_power_loss(random);
        const auto found = Kind::open(*rest);
        ++count.crashes;
        if (!found) {
          ++count.refused;
          continue;
        }
        const auto state = std::ranges::find(story.states, found->contents());
        const auto place = static_cast<std::size_t>(state - story.states.begin());
        if (place == story.states.size() || place > answered + 1) ++count.wrong;
        if (place < answered) ++count.lost;
      }
    }
  }
  print("loss of power at each call", Kind::kName, count);
}

/// A call of a commit fails, the batch is refused, and then the power goes.
template <class Kind>
void fail_and_lose_power(const char* test, Trouble how) {
  const Story story = random_story(34, 3, 900);
  Count count;
  for (std::size_t at = 1;; ++at) {
    bool came = false;
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
      MemoryDisk memory;
      TroubledDisk disk(memory, &memory);
      auto to = Kind::open(disk);
      if (!to || !write(*to, story.batches[0])) throw std::runtime_error("no store to fail");
      disk.trouble(how, at, EIO);
      const bool refused = !write(*to, story.batches[1]);
      came = disk.came();
      if (!came) break;
      std::mt19937 random(seed);
      const auto rest = memory.after_power_loss(random);
      to = fail("closed: the rest does not see that");
      const auto found = Kind::open(*rest);
      ++count.crashes;
      if (!found)
        ++count.refused;
      else if (found->contents() != story.states[1] && found->contents() != story.states[2])
        ++count.wrong;
      else if (refused && found->contents() == story.states[2])
        ++count.came;
      else if (!refused && found->contents() == story.states[1])
        ++count.lost;
    }
    if (!came) break;
  }
  print(test, Kind::kName, count);
}

/// A bit of a file that was closed is another one: every third, in turn.
template <class Kind>
void flip_bits() {
  const Story story = random_story(14, 30, 60);
  MemoryDisk memory;
  {
    auto to = Kind::open(memory);
    if (!to) throw std::runtime_error(to.error().text);
    for (const Batch& batch : story.batches)
      if (!write(*to, batch)) throw std::runtime_error("no store to alter");
  }
  const store::OpenFile file(memory, memory.open(Kind::kFile, O_RDWR));
  std::string bytes(static_cast<std::size_t>(memory.size(file.get())), '\0');
  memory.pread(file.get(), bytes.data(), bytes.size(), 0);
  Count count;
  for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += 3) {
    MemoryDisk altered;
    const store::OpenFile to(altered, altered.open(Kind::kFile, O_RDWR | O_CREAT));
    std::string with = bytes;
    with[bit / 8] = static_cast<char>(with[bit / 8] ^ (1U << (bit % 8)));
    altered.pwrite(to.get(), with.data(), with.size(), 0);
    const auto found = Kind::open(altered);
    ++count.crashes;
    if (!found)
      ++count.refused;
    else if (found->contents() == story.states[story.states.size() - 2])
      ++count.lost;
    else if (found->contents() != story.states.back())
      ++count.wrong;
  }
  print("a bit of the file is another one", Kind::kName, count);
}

/// In the child: one byte into the pipe for each batch that was committed.
template <class Kind>
[[noreturn]] void write_for_ever(const Story& story, const std::string& directory,
                                 std::size_t first, int pipe) {
  auto to = Kind::open(directory);
  if (!to) ::_exit(1);
  for (std::size_t i = first; i < story.batches.size(); ++i)
    if (!write(*to, story.batches[i]) || ::write(pipe, "+", 1) != 1) ::_exit(2);
  for (;;) ::pause();
}

std::size_t acknowledged(int pipe, std::size_t until) {
  std::size_t count = 0;
  std::array<char, 1> byte{};
  while (count < until && ::read(pipe, byte.data(), byte.size()) == 1) ++count;
  return count;
}

template <class Kind>
void kill_processes(const std::string& parent) {
  const Story story = random_story(41, 2000);
  const std::string directory = parent + "/killed-" + Kind::kName;
  std::filesystem::create_directory(directory);
  std::mt19937 random(41);
  Count count;
  std::size_t state = 0;
  // A machine that is busy lets the child go on for long.
  for (; count.crashes < 100 && state + 1 < story.states.size(); ++count.crashes) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("pipe2");
    const Fd in(ends[0]);
    Fd out(ends[1]);
    const pid_t child = ::fork();
    if (child == 0) write_for_ever<Kind>(story, directory, state, out.get());
    out.reset();
    std::size_t done = acknowledged(in.get(), random() % 12);
    for (auto spin = random() % 3'000'000; spin > 0; --spin) asm volatile("");
    ::kill(child, SIGKILL);
    done += acknowledged(in.get(), ~std::size_t{0});
    int status = 0;
    ::waitpid(child, &status, 0);
    if (!WIFSIGNALED(status)) throw std::runtime_error("a child ended by itself");
    const auto found = Kind::open(directory);
    if (!found) throw std::runtime_error(found.error().text);
    state += done;
    if (state + 1 < story.states.size() && found->contents() == story.states[state + 1])
      ++state;  // committed, not acknowledged
    if (found->contents() == story.states[state]) continue;
    ++count.lost;
    break;
  }
  print("SIGKILL at random moments, real files", Kind::kName, count);
}

template <class Kind>
void crash(const std::string& directory) {
  flip_bits<Kind>();
  lose_power<Kind>();
  fail_and_lose_power<Kind>("a call fails that was made; then loss of power", Trouble::fail_after);
  fail_and_lose_power<Kind>("a call fails, a sync loses its pages; then power", Trouble::lose);
  kill_processes<Kind>(directory);
}

}  // namespace

void crash_both(const std::string& directory) {
  fmt::print(
      "Crashes: all; an answer is lost; a refused batch came back; not opened; a state that never "
      "was\n");
  crash<OurJournal>(directory);
  crash<Sqlite>(directory);
}

}  // namespace mlcca::bench
