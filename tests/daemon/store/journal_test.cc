// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/store/journal.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include "base/handle.hpp"
#include "control/codec.hpp"
#include "daemon/store/format.hpp"
#include "tests/daemon/store/fake_disk.hpp"
#include "tests/daemon/store/worlds.hpp"

namespace mlcca::store::test {
namespace {

Journal opened(const Folder& folder) {
  auto journal = Journal::open(folder.path());
  if (!journal) throw std::runtime_error(journal.error().text);
  return std::move(*journal);
}

void must_write(Journal& journal, const Batch& batch) {
  const auto done = write(journal, batch);
  ASSERT_TRUE(done) << done.error().text;
}

TEST(Journal, BeginsEmptyAndReadableForItsUserOnly) {
  const Folder folder;
  const Journal journal = opened(folder);
  EXPECT_EQ(journal.contents(), Contents{});
  EXPECT_FALSE(journal.recovered());
  struct stat status{};
  ASSERT_EQ(::stat(journal.path().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
}

TEST(Journal, RemembersWhatWasCommitted) {
  const Folder folder;
  const Story story = random_story(4, 40);
  for (std::size_t i = 0; i < story.batches.size(); ++i) {
    Journal journal = opened(folder);
    ASSERT_EQ(journal.contents(), story.states[i]) << text_of(journal.contents());
    ASSERT_FALSE(journal.recovered());
    must_write(journal, story.batches[i]);
    ASSERT_EQ(journal.contents(), story.states[i + 1]);
  }
}

TEST(Journal, ForgetsWhatWasNotCommitted) {
  const Folder folder;
  const Story story = random_story(5, 2);
  {
    Journal journal = opened(folder);
    must_write(journal, story.batches[0]);
    for (const Entry& entry : story.batches[1]) ASSERT_TRUE(journal.append(entry));
    EXPECT_TRUE(journal.dirty());
    EXPECT_EQ(journal.contents(), story.states[2]);
  }
  EXPECT_EQ(opened(folder).contents(), story.states[1]);
}

TEST(Journal, RollsBackExactly) {
  const Folder folder;
  const Story story = random_story(6, 100);
  Journal journal = opened(folder);
  for (std::size_t i = 0; i < story.batches.size(); ++i) {
    for (int round = 0; round < 2; ++round) {
      const std::uint64_t live = journal.live_bytes();
      for (const Entry& entry : story.batches[i]) ASSERT_TRUE(journal.append(entry));
      journal.roll_back();
      ASSERT_FALSE(journal.dirty());
      ASSERT_EQ(journal.contents(), story.states[i]) << text_of(journal.contents());
      ASSERT_EQ(journal.live_bytes(), live);
    }
    must_write(journal, story.batches[i]);
  }
}

TEST(Journal, CountsWhatLivesAsItIsOnDisk) {
  for (const Entry& entry :
       {Entry(Granted{"0x1", "set=1"}), Entry(Enforced{1, "slots"}), Entry(admitted(1)),
        Entry(Released{"0x1"}), Entry(Contradicted{"bus", 1, 0x3ffe, "dealt otherwise"})})
    EXPECT_EQ(format::live_bytes(entry), format::encode(entry).size());
  for (const Entry& entry : {Entry(Granted{"0x1", ""}), Entry(Enforced{1, ""}), Entry(Removed{1}),
                             Entry(Contradicted{"bus", 1, 0x3ffe, ""})})
    EXPECT_EQ(format::live_bytes(entry), 0U);
}

TEST(Journal, WritesNothingForWhatChangesNothing) {
  const Folder folder;
  Journal journal = opened(folder);
  must_write(journal, {admitted(1), Released{"0x1"}, Granted{"0x1", "set=1"}});
  const std::uint64_t size = journal.file_bytes();
  must_write(journal, {admitted(1), Released{"0x1"}, Granted{"0x1", "set=1"}, Removed{2},
                       Reinstated{"0x2"}, Granted{"0x2", ""}});
  EXPECT_FALSE(journal.dirty());
  EXPECT_EQ(journal.file_bytes(), size);
}

TEST(Journal, NeverGivesAnIdTwice) {
  const Folder folder;
  {
    Journal journal = opened(folder);
    must_write(journal, {admitted(5)});
    must_write(journal, {Removed{5}});
    EXPECT_FALSE(journal.append(admitted(5)));
    EXPECT_FALSE(journal.append(admitted(4)));
    EXPECT_EQ(journal.contents().next_id, 6U);
  }
  EXPECT_EQ(opened(folder).contents().next_id, 6U);
  ASSERT_TRUE(opened(folder).compact());
  Journal journal = opened(folder);
  EXPECT_EQ(journal.contents().next_id, 6U);
  EXPECT_TRUE(journal.contents().admissions.empty());
  EXPECT_FALSE(journal.append(admitted(5)));
  EXPECT_TRUE(journal.append(admitted(6)));
}

TEST(Journal, TakesAnIdThatWasSetAsideWhileSomebodyKeepsIt) {
  const Folder folder;
  Journal journal = opened(folder);
  auto kept = journal.expect(1);
  auto dropped = journal.expect(2);
  ASSERT_TRUE(journal.append(NextId{10}));
  dropped.reset();
  EXPECT_TRUE(journal.append(Admitted{{1, control::Admit{}}, 0}));
  EXPECT_FALSE(journal.append(Admitted{{2, control::Admit{}}, 0}));
  // Whoever keeps it longer than the journal is there does no harm.
  Journal other = std::move(journal);
  auto later = other.expect(3);
  other = opened(Folder());
  later.reset();
}

TEST(Journal, RefusesWhatIsNoAdmission) {
  const Folder folder;
  Journal journal = opened(folder);
  EXPECT_FALSE(journal.append(Admitted{{1, control::Query{}}}));
  EXPECT_FALSE(journal.append(admitted(0)));
  EXPECT_FALSE(journal.append(admitted(~std::uint64_t{0})));
  EXPECT_FALSE(journal.dirty());
  EXPECT_EQ(journal.contents(), Contents{});
}

TEST(Journal, TakesEntriesUpToItsLimit) {
  const Folder folder;
  const auto room_in = [](const Entry& with_60000) {
    return kMaxEntry - (format::encode(with_60000).size() - format::kEntryHead - 60'000);
  };
  const Granted granted{"0x1", std::string(60'000, 'x')};
  const Granted largest{"0x1", std::string(room_in(granted), 'x')};
  const Granted larger{"0x1", std::string(room_in(granted) + 1, 'x')};
  const std::size_t room = room_in(admitted(1, std::string(60'000, 'c')));
  const Admitted longest = admitted(1, std::string(room, 'c'));
  {
    Journal journal = opened(folder);
    EXPECT_FALSE(journal.append(larger));
    EXPECT_FALSE(journal.append(admitted(1, std::string(room + 1, 'c'))));
    EXPECT_FALSE(journal.dirty());
    must_write(journal, {largest, longest});
  }
  const Journal journal = opened(folder);
  EXPECT_EQ(journal.contents().granted.at("0x1"), largest.state);
  EXPECT_EQ(*journal.contents().admissions.find(1), longest.request);
}

TEST(Journal, TakesTheLargestRequestOfAnyUser) {
  MemoryDisk disk;
  Journal journal = std::move(*Journal::open("/d", disk));
  // The daemon gives the request its id, which the client did not send.
  constexpr std::uint64_t id = ~std::uint64_t{1};
  Admitted largest = admitted(0, "");
  largest.by = ~std::uint32_t{0};
  auto& channel = std::get<control::Admit>(largest.request.body).channel;
  channel.assign(60'000, 'c');
  const std::size_t prefix = 3;
  channel.append(control::Request::kMaxBytes - (control::encode(largest.request).size() - prefix),
                 'c');
  ASSERT_EQ(control::encode(largest.request).size() - prefix, control::Request::kMaxBytes);
  largest.request.id = id;
  const auto done = write(journal, {largest});
  EXPECT_TRUE(done) << done.error().text;
}

TEST(Journal, TakesBatchesUpToItsLimit) {
  MemoryDisk disk;
  Journal journal = std::move(*Journal::open("/d", disk));
  std::size_t taken = 0;
  for (;; ++taken)
    if (!journal.append(Released{std::to_string(taken) + std::string(60'000, 'x')})) break;
  EXPECT_GE(taken, kMaxBatch / 60'020);
  EXPECT_LE(taken, kMaxBatch / 60'000);
  ASSERT_TRUE(journal.commit());
  ASSERT_TRUE(journal.append(Released{"more"}));
}

TEST(Journal, IsRewrittenWhenAnotherProgramRemovesIt) {
  const Folder folder;
  Contents all;
  {
    Journal journal = opened(folder);
    ASSERT_TRUE(journal.append(Released{"before"}));
    ASSERT_TRUE(journal.commit());
    EXPECT_FALSE(*journal.keep());
    std::filesystem::remove(journal.path());
    const auto again = journal.keep();
    ASSERT_TRUE(again) << again.error().text;
    EXPECT_TRUE(*again);
    EXPECT_FALSE(*journal.keep());
    ASSERT_TRUE(journal.append(Released{"after"}));
    ASSERT_TRUE(journal.commit());
    all = journal.contents();
  }
  EXPECT_EQ(opened(folder).contents(), all);
}

TEST(Journal, RefusesWhatIsCommittedToAFileThatWasReplaced) {
  const Folder folder;
  Journal journal = opened(folder);
  const auto before = journal.contents();
  std::filesystem::rename(journal.path(), journal.path() + ".old");
  std::ofstream(journal.path()) << "something else";
  ASSERT_TRUE(journal.append(Released{"lost"}));
  const auto done = journal.commit();
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().text.find(
                "removed or replaced it; it has been written again, repeat the request"),
            std::string::npos)
      << done.error().text;
  EXPECT_EQ(journal.contents(), before);
  ASSERT_TRUE(journal.append(Released{"kept"}));
  EXPECT_TRUE(journal.commit());
}

TEST(Journal, IsRewrittenInADirectoryThatWasReplaced) {
  const Folder folder;
  Journal journal = opened(folder);
  std::filesystem::rename(folder.path(), folder.path() + ".old");
  EXPECT_FALSE(journal.keep());
  std::filesystem::create_directory(folder.path());
  ASSERT_TRUE(journal.append(Released{"lost"}));
  EXPECT_FALSE(journal.commit());
  ASSERT_TRUE(journal.append(Released{"kept"}));
  EXPECT_TRUE(journal.commit());
  std::filesystem::remove_all(folder.path() + ".old");
}

TEST(Journal, BelongsToOneProcessAtATime) {
  const Folder folder;
  const Journal journal = opened(folder);
  const auto second = Journal::open(folder.path());
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().text.find("in use by another process"), std::string::npos);
}

TEST(Journal, IsOpenedWhileAnotherProcessHoldsTheLockOfItsDirectory) {
  const Folder folder;
  const Fd directory(::open(folder.path().c_str(), O_RDONLY | O_DIRECTORY));
  ASSERT_EQ(::flock(directory.get(), LOCK_EX | LOCK_NB), 0);
  const auto journal = Journal::open(folder.path());
  ASSERT_TRUE(journal) << journal.error().text;
  struct stat lock{};
  ASSERT_EQ(::stat((folder.path() + "/lock").c_str(), &lock), 0);
  EXPECT_EQ(lock.st_mode & 07777U, 0600U);
}

TEST(Journal, NamesADirectoryThatIsNotThere) {
  const auto journal = Journal::open("/nonexistent/mlcca");
  ASSERT_FALSE(journal);
  EXPECT_EQ(journal.error().text, "/nonexistent/mlcca: No such file or directory");
}

// --- written again -------------------------------------------------------------------------------

TEST(Compaction, KeepsTheFileWithinAMultipleOfWhatIsAlive) {
  MemoryDisk disk;
  Journal journal = std::move(*Journal::open("/d", disk));
  must_write(journal, {admitted(1), Released{"0x1"}});
  const std::string text(1000, 'x');
  std::uint64_t largest = 0;
  for (int i = 0; i < 5000; ++i) {
    must_write(journal, {Granted{"0x2", text + std::to_string(i)}});
    largest = std::max(largest, journal.file_bytes());
    ASSERT_LE(journal.file_bytes(), kCompactAtLeast + 2000);
  }
  EXPECT_GT(largest, kCompactAtLeast - 2000) << "rewritten earlier than stated";
  EXPECT_FALSE(journal.trouble());
}

TEST(Compaction, LeavesAFileOfLivingEntriesAlone) {
  MemoryDisk disk;
  Journal journal = std::move(*Journal::open("/d", disk));
  std::uint64_t size = 0;
  for (std::uint64_t id = 1; id <= 300; ++id) {
    must_write(journal, {admitted(id, std::string(10'000, 'x'))});
    ASSERT_GT(journal.file_bytes(), size);
    size = journal.file_bytes();
  }
  EXPECT_GT(size, 2 * kCompactAtLeast);
  for (std::uint64_t id = 1; id <= 300; ++id) must_write(journal, {Removed{id}});
  EXPECT_LE(journal.file_bytes(), kCompactAtLeast + kCompactAbove * journal.live_bytes());
  EXPECT_EQ(journal.live_bytes(), 0U);
}

TEST(Compaction, ChangesNothingThatCounts) {
  const Folder folder;
  const Story story = random_story(7, 60);
  for (std::size_t i = 0; i < story.batches.size(); ++i) {
    Journal journal = opened(folder);
    ASSERT_EQ(journal.contents(), story.states[i]);
    const std::uint64_t live = journal.live_bytes();
    ASSERT_TRUE(journal.compact());
    ASSERT_EQ(journal.contents(), story.states[i]);
    ASSERT_EQ(journal.live_bytes(), live);
    must_write(journal, story.batches[i]);
  }
  EXPECT_FALSE(std::filesystem::exists(folder.file("journal.new")));
}

TEST(Compaction, WaitsForACommit) {
  const Folder folder;
  Journal journal = opened(folder);
  ASSERT_TRUE(journal.append(admitted(1)));
  EXPECT_FALSE(journal.compact());
  EXPECT_TRUE(journal.dirty());
}

}  // namespace
}  // namespace mlcca::store::test
