// SPDX-License-Identifier: BSD-2-Clause
// A process that writes is killed at any moment: what it has acknowledged is there.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <random>

#include "base/handle.hpp"
#include "tests/daemon/store/worlds.hpp"

namespace mlcca::store::test {
namespace {

/// In the child: one byte into the pipe for each batch that was committed.
[[noreturn]] void write_for_ever(const Story& story, const std::string& directory,
                                 std::size_t first, int pipe) {
  auto journal = Journal::open(directory);
  if (!journal) ::_exit(1);
  for (std::size_t i = first; i < story.batches.size(); ++i) {
    if (!write(*journal, story.batches[i])) ::_exit(2);
    if (::write(pipe, "+", 1) != 1) ::_exit(3);
    if (i % 5 == 4 && !journal->compact()) ::_exit(4);
  }
  for (;;) ::pause();
}

/// Bytes until the other end is closed, or `until` of them.
std::size_t acknowledged(int pipe, std::size_t until) {
  std::size_t count = 0;
  std::array<char, 1> byte{};
  while (count < until && ::read(pipe, byte.data(), byte.size()) == 1) ++count;
  return count;
}

TEST(AKilledProcess, LosesNothingThatItHasAcknowledged) {
  const Story story = random_story(41, 2000);
  const Folder folder;
  std::mt19937 random(std::random_device{}());
  std::size_t state = 0;
  for (int round = 0; round < 30; ++round) {
    std::array<int, 2> ends{};
    ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
    const Fd in(ends[0]);
    Fd out(ends[1]);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) write_for_ever(story, folder.path(), state, out.get());
    out.reset();
    // After some acknowledgements and then at any moment: the loop is no measure of time.
    std::size_t count = acknowledged(in.get(), random() % 12);
    for (auto spin = random() % 3'000'000; spin > 0; --spin) asm volatile("");
    ASSERT_EQ(::kill(child, SIGKILL), 0);
    count += acknowledged(in.get(), ~std::size_t{0});
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the child ended by itself: " << status;

    const auto journal = Journal::open(folder.path());
    ASSERT_TRUE(journal) << journal.error().text;
    state += count;
    if (journal->contents() != story.states[state]) ++state;  // committed, not yet acknowledged
    ASSERT_EQ(journal->contents(), story.states[state]) << text_of(journal->contents());
  }
  EXPECT_GT(state, 30U);
}

}  // namespace
}  // namespace mlcca::store::test
