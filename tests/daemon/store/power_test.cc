// SPDX-License-Identifier: BSD-2-Clause
// The power goes, or the process ends, during every call that the journal makes.
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>

#include "tests/daemon/store/fake_disk.hpp"
#include "tests/daemon/store/worlds.hpp"

namespace mlcca::store::test {
namespace {

constexpr std::size_t kBatches = 12;

/// Written on `disk` until it stops: how many batches had been answered then, and whether the next
/// one was begun. Every fourth batch is followed by a compaction.
struct Progress {
  std::size_t answered = 0;
  bool begun = false;
  bool finished = false;
};

Progress write_story(const Story& story, const std::string& directory, Disk& disk) {
  Progress progress;
  try {
    auto journal = Journal::open(directory, disk);
    EXPECT_TRUE(journal) << journal.error().text;
    for (const Batch& batch : story.batches) {
      progress.begun = true;
      const auto done = write(*journal, batch);
      EXPECT_TRUE(done) << done.error().text;
      ++progress.answered;
      progress.begun = false;
      if (progress.answered % 4 != 0) continue;
      EXPECT_TRUE(journal->compact());
    }
    progress.finished = true;
  } catch (const PowerLoss&) {
  }
  return progress;
}

void expect_before_or_after(const Contents& found, const Story& story, const Progress& progress) {
  const bool before = found == story.states[progress.answered];
  const bool after = progress.begun && found == story.states[progress.answered + 1];
  ASSERT_TRUE(before || after) << "after " << progress.answered
                               << " answers, expected: " << text_of(story.states[progress.answered])
                               << "\nfound: " << text_of(found);
}

TEST(ALossOfPower, LeavesTheStateBeforeOrAfterTheBatch) {
  const Story story = random_story(21, kBatches, 900);
  for (const Trouble how : {Trouble::stop, Trouble::stop_after}) {
    std::size_t stops = 1;
    for (;; ++stops) {
      MemoryDisk memory;
      TroubledDisk disk(memory);
      disk.trouble(how, stops, 0);
      const Progress progress = write_story(story, "/d", disk);
      if (progress.finished) break;
      for (std::uint32_t seed = 0; seed < 60; ++seed) {
        std::mt19937 random(seed);
        const auto rest = memory.after_power_loss(random);
        const auto journal = Journal::open("/d", *rest);
        ASSERT_TRUE(journal) << stops << ", " << seed << ": " << journal.error().text;
        ASSERT_NO_FATAL_FAILURE(expect_before_or_after(journal->contents(), story, progress))
            << stops << ", " << seed;
      }
    }
    EXPECT_GT(stops, 3 * kBatches) << "it makes more calls than that";
  }
}

TEST(ALossOfPowerDuringRecovery, LeavesTheSame) {
  const Story story = random_story(22, kBatches, 900);
  std::mt19937 random(22);
  for (std::size_t stops = 1;; ++stops) {
    MemoryDisk memory;
    TroubledDisk disk(memory);
    disk.trouble(Trouble::stop, stops, 0);
    const Progress progress = write_story(story, "/d", disk);
    if (progress.finished) break;
    for (int round = 0; round < 3; ++round) {
      auto rest = memory.after_power_loss(random);
      Contents used;
      bool was_used = false;
      for (std::size_t again = 1; again < 20; ++again) {
        TroubledDisk troubled(*rest);
        troubled.trouble(Trouble::stop, again, 0);
        try {
          const auto journal = Journal::open("/d", troubled);
          ASSERT_TRUE(journal) << journal.error().text;
          // What a start has seen may have been acted on: no later one sees less.
          if (was_used) {
            ASSERT_EQ(journal->contents(), used);
          }
          used = journal->contents();
          was_used = true;
          ASSERT_NO_FATAL_FAILURE(expect_before_or_after(used, story, progress));
        } catch (const PowerLoss&) {
        }
        rest = rest->after_power_loss(random);
      }
      ASSERT_TRUE(was_used);
    }
  }
}

TEST(WhatAStartHasSeenAfterAKill, IsNotLostWithThePower) {
  const Story story = random_story(24, kBatches, 900);
  for (std::size_t stops = 1;; ++stops) {
    for (std::uint32_t seed = 0; seed < 10; ++seed) {
      MemoryDisk memory;
      TroubledDisk disk(memory);
      disk.trouble(Trouble::stop, stops, 0);
      const Progress progress = write_story(story, "/d", disk);
      if (progress.finished) return;
      Contents used;
      {
        const auto journal = Journal::open("/d", memory);
        ASSERT_TRUE(journal) << journal.error().text;
        used = journal->contents();
        ASSERT_NO_FATAL_FAILURE(expect_before_or_after(used, story, progress)) << stops;
      }
      std::mt19937 random(seed);
      const auto rest = memory.after_power_loss(random);
      const auto journal = Journal::open("/d", *rest);
      ASSERT_TRUE(journal) << journal.error().text;
      ASSERT_EQ(journal->contents(), used) << stops << ", " << seed;
    }
  }
}

TEST(AnEndedProcess, LeavesRealFilesInTheStateBeforeOrAfter) {
  const Story story = random_story(23, 6);
  for (const Trouble how : {Trouble::stop, Trouble::stop_after}) {
    for (std::size_t stops = 1;; ++stops) {
      const Folder folder;
      TroubledDisk disk(real_disk());
      disk.trouble(how, stops, 0);
      const Progress progress = write_story(story, folder.path(), disk);
      if (progress.finished) break;
      const auto journal = Journal::open(folder.path());
      ASSERT_TRUE(journal) << journal.error().text;
      ASSERT_NO_FATAL_FAILURE(expect_before_or_after(journal->contents(), story, progress))
          << stops;
    }
  }
}

}  // namespace
}  // namespace mlcca::store::test
