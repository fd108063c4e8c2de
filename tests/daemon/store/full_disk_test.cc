// SPDX-License-Identifier: BSD-2-Clause
// A file system that is really full: a tmpfs of a few pages. Root, in a mount namespace of its own.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "daemon/store/history.hpp"
#include "daemon/store/journal.hpp"
#include "tests/daemon/store/worlds.hpp"

namespace mlcca::store::test {
namespace {

class AFullDisk : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    ASSERT_EQ(::unshare(CLONE_NEWNS), 0);
    ASSERT_EQ(::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr), 0);
  }
  void SetUp() override {
    ASSERT_EQ(::mount("tiny", folder_.path().c_str(), "tmpfs", 0, "size=256k"), 0);
  }
  void TearDown() override { ::umount2(folder_.path().c_str(), MNT_DETACH); }

  [[nodiscard]] std::uint64_t room() const {
    return std::filesystem::space(folder_.path()).available;
  }
  /// Another program's file that leaves `pages` of 4096 bytes.
  void fill_but(std::uint64_t pages) const {
    write_file(folder_.file("ballast"), std::string(room() - 4096 * pages, 'b'));
    ASSERT_EQ(room(), 4096 * pages);
  }
  void make_room() const { std::filesystem::remove(folder_.file("ballast")); }

  Folder folder_;
};

TEST_F(AFullDisk, RefusesTheBatchAndKeepsEveryOther) {
  auto journal = Journal::open(folder_.path());
  ASSERT_TRUE(journal) << journal.error().text;
  ASSERT_NO_FATAL_FAILURE(fill_but(3));
  Contents answered;
  std::uint64_t id = 1;
  Result<void> done;
  while ((done = write(*journal, {admitted(id, std::string(700, 'x'))}))) {
    answered = journal->contents();
    ASSERT_LT(++id, 1000U);
  }
  EXPECT_GT(id, 10U);
  EXPECT_NE(done.error().text.find("No space left on device; it was undone"), std::string::npos)
      << done.error().text;
  EXPECT_EQ(journal->contents(), answered);
  EXPECT_FALSE(journal->compact()) << "there is no room for a second file";
  EXPECT_FALSE(std::filesystem::exists(folder_.file("journal.new")));
  make_room();
  EXPECT_TRUE(write(*journal, {admitted(id)}));
  EXPECT_TRUE(journal->compact());
  answered = journal->contents();
  journal = fail("closed");
  const auto again = Journal::open(folder_.path());
  ASSERT_TRUE(again);
  EXPECT_EQ(again->contents(), answered);
}

TEST_F(AFullDisk, DoesNotLetAJournalBeginByHalves) {
  ASSERT_NO_FATAL_FAILURE(fill_but(0));
  const auto refused = Journal::open(folder_.path());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text.find("No space left on device"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_.file("journal")));
  make_room();
  EXPECT_TRUE(Journal::open(folder_.path()));
}

TEST_F(AFullDisk, StopsTheHistoryUntilThereIsRoomAndIsSaidOnce) {
  History history = History::open(folder_.path());
  ASSERT_TRUE(history.take_troubles().empty());
  ASSERT_NO_FATAL_FAILURE(fill_but(8));
  const auto decide = [&history](std::uint64_t n) {
    history.append({n, "granted", n, "video", "robot", "base", "mesh", std::string(500, 'm')});
    history.flush(n * History::kRetryNs);
  };
  std::uint64_t n = 1;
  for (; history.pending() == 0; ++n) {
    decide(n);
    ASSERT_LT(n, 10'000U);
  }
  const auto said = history.take_troubles();
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said[0].find("full"), std::string::npos) << said[0];
  for (const std::uint64_t end = n + 20; n < end; ++n) decide(n);
  EXPECT_TRUE(history.take_troubles().empty());
  EXPECT_EQ(history.pending(), 21U);
  make_room();
  decide(n);
  EXPECT_EQ(history.pending(), 0U);
  ASSERT_EQ(history.take_troubles().size(), 1U);
  EXPECT_EQ(history.lost(), 0U);
  HistoryFilter all;
  all.limit = 10'000;
  const auto rows = history.query(all);
  ASSERT_TRUE(rows);
  EXPECT_EQ(rows->size(), n) << "none is missing, none is there twice";
}

}  // namespace
}  // namespace mlcca::store::test
