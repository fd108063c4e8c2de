// SPDX-License-Identifier: BSD-2-Clause
// Every call that the journal makes fails, once, for a while or from then on.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cerrno>
#include <csignal>
#include <random>
#include <string>

#include "tests/daemon/store/fake_disk.hpp"
#include "tests/daemon/store/worlds.hpp"

namespace mlcca::store::test {
namespace {

constexpr std::size_t kBatches = 10;

struct How {
  Trouble what;
  int error;
  std::size_t calls;
};

constexpr std::size_t kForEver = ~std::size_t{0} / 2;
constexpr How kHows[] = {
    {Trouble::fail, EIO, 1},          {Trouble::fail, EIO, 2},
    {Trouble::fail, EIO, kForEver},   {Trouble::fail_after, EIO, 1},
    {Trouble::fail_after, EIO, 3},    {Trouble::lose, EIO, 1},
    {Trouble::lose, EIO, 2},          {Trouble::write_part, ENOSPC, 1},
    {Trouble::write_part, ENOSPC, 3}, {Trouble::write_part, ENOSPC, kForEver},
};

/// What has been promised, and what may be found after a crash besides.
struct Promise {
  Contents answered;
  std::optional<Contents> needs_recheck;  ///< of a commit that failed and could not be undone
};

/// Writes the story on a disk that fails: a batch that was refused is tried again, in the end on a
/// disk that is whole. Every third batch is followed by a compaction.
class Writer {
 public:
  Writer(const Story& story, Disk& disk) : story_(story), disk_(disk) {}

  /// False: the journal could not be opened.
  bool open() {
    auto journal = Journal::open("/d", disk_);
    if (journal) journal_ = std::make_unique<Journal>(std::move(*journal));
    return journal_ != nullptr;
  }

  void write_story(Promise& promise) {
    for (std::size_t i = 0; i < story_.batches.size(); ++i) {
      for (int tries = 0; tries < 3; ++tries) {
        const auto done = write(*journal_, story_.batches[i]);
        ASSERT_FALSE(journal_->dirty());
        if (done) {
          promise = {story_.states[i + 1], std::nullopt};
          break;
        }
        ASSERT_EQ(journal_->contents(), story_.states[i]) << text_of(journal_->contents());
        if (done.error().text.find("could not be undone") != std::string::npos)
          promise.needs_recheck = story_.states[i + 1];
        else if (done.error().text.find("it was undone") != std::string::npos)
          promise.needs_recheck.reset();
      }
      if (promise.answered != story_.states[i + 1]) return;
      ASSERT_EQ(journal_->contents(), story_.states[i + 1]);
      if (i % 3 == 2) static_cast<void>(journal_->compact());
    }
  }

  Journal& journal() { return *journal_; }

 private:
  const Story& story_;
  Disk& disk_;
  std::unique_ptr<Journal> journal_;
};

TEST(AFailingCall, NeverCostsWhatWasAnswered) {
  const Story story = random_story(31, kBatches, 700);
  for (const How& how : kHows) {
    for (std::size_t at = 1;; ++at) {
      MemoryDisk memory;
      TroubledDisk disk(memory, &memory);
      disk.trouble(how.what, at, how.error, how.calls);
      Promise promise;
      Writer writer(story, disk);
      if (writer.open()) {
        ASSERT_NO_FATAL_FAILURE(writer.write_story(promise)) << at;
      }
      const bool came = disk.came();
      for (std::uint32_t seed = 0; seed < 10; ++seed) {
        std::mt19937 random(seed);
        const auto rest = memory.after_power_loss(random);
        const auto journal = Journal::open("/d", *rest);
        ASSERT_TRUE(journal) << at << ": " << journal.error().text;
        ASSERT_TRUE(journal->contents() == promise.answered ||
                    (promise.needs_recheck && journal->contents() == *promise.needs_recheck))
            << static_cast<int>(how.what) << " at " << at << " times " << how.calls << ", seed "
            << seed << "\nanswered: " << text_of(promise.answered)
            << "\nfound:    " << text_of(journal->contents());
      }
      if (!came) break;
      ASSERT_LT(at, 1000U);
    }
  }
}

TEST(AJournal, GoesOnWhenTheDiskIsWellAgain) {
  const Story story = random_story(32, kBatches);
  MemoryDisk memory;
  TroubledDisk disk(memory, &memory);
  auto journal = Journal::open("/d", disk);
  ASSERT_TRUE(journal);
  for (std::size_t i = 0; i < kBatches; ++i) {
    disk.trouble(Trouble::lose, 1, EIO, kForEver);
    const auto refused = write(*journal, story.batches[i]);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().text.find("Input/output error"), std::string::npos);
    ASSERT_FALSE(write(*journal, story.batches[i]));
    disk.trouble(Trouble::fail, kForEver, EIO);
    ASSERT_TRUE(write(*journal, story.batches[i]));
    ASSERT_EQ(journal->contents(), story.states[i + 1]);
  }
  std::mt19937 random(32);
  const auto rest = memory.after_power_loss(random);
  const auto again = Journal::open("/d", *rest);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->contents(), story.states.back());
}

/// A sync that failed leaves pages that count as written and are not. If the batch cannot be undone
/// either, the next daemon reads it in the cache, and goes on behind it.
TEST(ADaemonThatFollowsAFailedOne, TakesNothingForStoredThatOnlyTheCacheHas) {
  const Story story = random_story(35, 4, 900);
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    MemoryDisk memory;
    {
      TroubledDisk disk(memory, &memory);
      auto journal = Journal::open("/d", disk);
      ASSERT_TRUE(journal);
      ASSERT_TRUE(write(*journal, story.batches[0]));
      disk.trouble(Trouble::lose, 2, EIO, kForEver);  // the sync, and undoing it
      ASSERT_FALSE(write(*journal, story.batches[1]));
    }
    auto next = Journal::open("/d", memory);
    ASSERT_TRUE(next) << next.error().text;
    ASSERT_EQ(next->contents(), story.states[2]) << "it is in the cache";
    ASSERT_TRUE(write(*next, story.batches[2]));
    std::mt19937 random(seed);
    const auto rest = memory.after_power_loss(random);
    const auto again = Journal::open("/d", *rest);
    ASSERT_TRUE(again) << again.error().text;
    EXPECT_EQ(again->contents(), story.states[3]);
  }
}

/// What the cache has needs room for a second time on some file systems.
TEST(ADaemonThatFollowsAFailedOne, StartsOnAFullDiskAndStoresNothingUntilThereIsRoom) {
  const Story story = random_story(36, 3);
  MemoryDisk memory;
  {
    auto journal = Journal::open("/d", memory);
    ASSERT_TRUE(journal);
    ASSERT_TRUE(write(*journal, story.batches[0]));
  }
  TroubledDisk whole(memory);
  ASSERT_TRUE(Journal::open("/d", whole));
  int started = 0;
  for (std::size_t at = 1; at <= whole.calls(); ++at) {
    TroubledDisk full(memory);
    full.trouble(Trouble::fail, at, ENOSPC, 3);
    auto journal = Journal::open("/d", full);
    if (!journal) continue;
    ++started;
    EXPECT_EQ(journal->contents(), story.states[1]);
    const auto refused = write(*journal, story.batches[1]);
    ASSERT_FALSE(refused) << "at " << at;
    EXPECT_NE(refused.error().text.find("No space left"), std::string::npos);
    EXPECT_EQ(journal->contents(), story.states[1]);
  }
  EXPECT_GE(started, 1);
  auto journal = Journal::open("/d", memory);
  ASSERT_TRUE(journal && write(*journal, story.batches[1])) << "there is room again";
  EXPECT_EQ(journal->contents(), story.states[2]);
}

TEST(ARefusedBatchThatWasUndone, DoesNotComeBackAfterALossOfPower) {
  const Story story = random_story(34, 2, 900);
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    MemoryDisk memory;
    TroubledDisk disk(memory);
    auto journal = Journal::open("/d", disk);
    ASSERT_TRUE(journal);
    ASSERT_TRUE(write(*journal, story.batches[0]));
    disk.trouble(Trouble::fail_after, 2, EIO);  // the sync, which has done all it should
    const auto refused = write(*journal, story.batches[1]);
    ASSERT_FALSE(refused);
    ASSERT_NE(refused.error().text.find("it was undone"), std::string::npos);
    std::mt19937 random(seed);
    const auto rest = memory.after_power_loss(random);
    const auto again = Journal::open("/d", *rest);
    ASSERT_TRUE(again);
    ASSERT_EQ(again->contents(), story.states[1]) << seed;
  }
}

TEST(AnInterruptedCall, IsMadeAgain) {
  const Story story = random_story(33, 1);
  MemoryDisk memory;
  TroubledDisk disk(memory);
  auto journal = Journal::open("/d", disk);
  ASSERT_TRUE(journal);
  disk.trouble(Trouble::fail, 1, EINTR);
  EXPECT_TRUE(write(*journal, story.batches[0]));
}

TEST(ACompactionThatFails, IsReportedAndStopsNothing) {
  MemoryDisk memory;
  TroubledDisk disk(memory);
  auto journal = Journal::open("/d", disk);
  ASSERT_TRUE(journal);
  const std::string text(60'000, 'x');
  int i = 0;
  while (journal->file_bytes() <= kCompactAtLeast - 61'000)
    ASSERT_TRUE(write(*journal, {Granted{"0x1", text + std::to_string(i++)}}));
  // The next commit writes and syncs; the call after these begins the compaction.
  disk.trouble(Trouble::fail, 3, ENOSPC);
  while (!disk.came()) {
    const auto size = journal->file_bytes();
    if (size <= kCompactAtLeast - 60'100) disk.trouble(Trouble::fail, 3, ENOSPC);
    ASSERT_TRUE(write(*journal, {Granted{"0x1", text + std::to_string(i++)}}));
    ASSERT_GT(journal->file_bytes(), size);
  }
  ASSERT_TRUE(journal->trouble());
  EXPECT_NE(journal->trouble()->find("No space left on device"), std::string::npos);
  const auto grown = journal->file_bytes();
  while (journal->file_bytes() >= grown)
    ASSERT_TRUE(write(*journal, {Granted{"0x1", text + std::to_string(i++)}}));
  EXPECT_FALSE(journal->trouble()) << "tried again, and done";
  EXPECT_LT(journal->file_bytes(), kCompactAtLeast / 2);
}

TEST(AFileSizeLimit, RefusesTheBatchAndNothingElse) {
  const Folder folder;
  auto journal = Journal::open(folder.path());
  ASSERT_TRUE(journal);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit tight = before;
  tight.rlim_cur = 20'000;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &tight), 0);
  std::uint64_t id = 1;
  Contents answered;
  Result<void> done;
  while ((done = write(*journal, {admitted(id, std::string(700, 'x'))}))) {
    answered = journal->contents();
    ASSERT_LT(++id, 100U);
  }
  EXPECT_EQ(journal->contents(), answered);
  EXPECT_NE(done.error().text.find("File too large; it was undone"), std::string::npos)
      << done.error().text;
  EXPECT_TRUE(write(*journal, {Removed{1}})) << "a smaller one has room";
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_TRUE(write(*journal, {admitted(id)}));
  const Contents expected = journal->contents();
  journal = fail("closed");
  const auto again = Journal::open(folder.path());
  ASSERT_TRUE(again);
  EXPECT_EQ(again->contents(), expected);
  EXPECT_FALSE(again->recovered());
}

}  // namespace
}  // namespace mlcca::store::test
