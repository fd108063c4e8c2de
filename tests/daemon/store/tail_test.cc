// SPDX-License-Identifier: BSD-2-Clause
// Files that end too early or hold other bits than were written, and files written by hand as
// docs/reference/journal.md says.
#include <fcntl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "control/codec.hpp"
#include "tests/daemon/store/fake_disk.hpp"
#include "tests/daemon/store/worlds.hpp"

namespace mlcca::store::test {
namespace {

std::unique_ptr<MemoryDisk> disk_with(std::string_view journal) {
  auto disk = std::make_unique<MemoryDisk>();
  const OpenFile file(*disk, disk->open("/d/journal", O_RDWR | O_CREAT));
  disk->pwrite(file.get(), journal.data(), journal.size(), 0);
  return disk;
}

std::string bytes_of(Disk& disk) {
  const OpenFile file(disk, disk.open("/d/journal", O_RDONLY));
  std::string bytes(static_cast<std::size_t>(disk.size(file.get())), '\0');
  disk.pread(file.get(), bytes.data(), bytes.size(), 0);
  return bytes;
}

/// A journal as it was written, and where its batches end: ends[0] is that of the snapshot.
struct Recording {
  Story story;
  std::string bytes;
  std::vector<std::size_t> ends;
};

/// `compacted`: batches that are in the snapshot.
Recording recorded(std::uint32_t seed, std::size_t batches, std::size_t compacted) {
  Recording r{random_story(seed, compacted + batches, 60), {}, {}};
  MemoryDisk disk;
  auto journal = Journal::open("/d", disk);
  EXPECT_TRUE(journal);
  for (std::size_t i = 0; i < compacted; ++i) EXPECT_TRUE(write(*journal, r.story.batches[i]));
  EXPECT_TRUE(journal->compact());
  r.ends.push_back(journal->file_bytes());
  for (std::size_t i = compacted; i < r.story.batches.size(); ++i) {
    EXPECT_TRUE(write(*journal, r.story.batches[i]));
    r.ends.push_back(journal->file_bytes());
  }
  r.story.states.erase(r.story.states.begin(),
                       r.story.states.begin() + static_cast<std::ptrdiff_t>(compacted));
  r.bytes = bytes_of(disk);
  EXPECT_EQ(r.bytes.size(), r.ends.back());
  return r;
}

TEST(ATornFile, IsTheStateAfterItsLastWholeBatch) {
  for (const std::size_t compacted : {std::size_t{0}, std::size_t{10}}) {
    const Recording r = recorded(11, 25, compacted);
    for (std::size_t size = 0; size <= r.bytes.size(); ++size) {
      const auto disk = disk_with(r.bytes.substr(0, size));
      auto journal = Journal::open("/d", *disk);
      const auto whole = std::ranges::upper_bound(r.ends, size) - r.ends.begin();
      if (whole == 0) {
        ASSERT_FALSE(journal) << size << ": the snapshot cannot be torn by a crash";
        ASSERT_NE(journal.error().text.find("/d/journal: damaged at byte "), std::string::npos);
        continue;
      }
      const std::size_t state = static_cast<std::size_t>(whole) - 1;
      ASSERT_TRUE(journal) << size << ": " << journal.error().text;
      ASSERT_EQ(journal->contents(), r.story.states[state]) << size;
      ASSERT_EQ(journal->recovered().has_value(), size != r.ends[state]) << size;
      ASSERT_EQ(bytes_of(*disk), r.bytes.substr(0, r.ends[state])) << size;
    }
  }
}

TEST(ATornFile, IsWrittenOn) {
  const Recording r = recorded(12, 10, 0);
  for (std::size_t size = r.ends[8]; size < r.bytes.size(); ++size) {
    const auto disk = disk_with(r.bytes.substr(0, size));
    const std::size_t state = size >= r.ends[9] ? 9 : 8;
    {
      auto journal = Journal::open("/d", *disk);
      ASSERT_TRUE(journal);
      for (std::size_t i = state; i < 10; ++i) ASSERT_TRUE(write(*journal, r.story.batches[i]));
    }
    const auto journal = Journal::open("/d", *disk);
    ASSERT_TRUE(journal);
    ASSERT_EQ(journal->contents(), r.story.states[10]);
    ASSERT_FALSE(journal->recovered());
  }
}

TEST(ATornFile, MayEndInAnything) {
  const Recording r = recorded(13, 3, 0);
  std::mt19937 random(13);
  for (int i = 0; i < 300; ++i) {
    std::string tail(1 + random() % 3000, '\0');
    if (i % 2 == 0)
      for (char& c : tail) c = static_cast<char>(random());
    const auto disk = disk_with(r.bytes + tail);
    const auto journal = Journal::open("/d", *disk);
    ASSERT_TRUE(journal) << journal.error().text;
    ASSERT_EQ(journal->contents(), r.story.states.back());
    ASSERT_TRUE(journal->recovered());
  }
}

TEST(AFlippedBit, IsNoticedWhereverItIs) {
  const Recording r = recorded(14, 12, 5);
  const std::size_t last = r.ends[r.ends.size() - 2];
  for (std::size_t bit = 0; bit < 8 * r.bytes.size(); bit += bit / 8 < 200 ? 1 : 3) {
    std::string bytes = r.bytes;
    const std::size_t at = bit / 8;
    bytes[at] = static_cast<char>(bytes[at] ^ (1U << (bit % 8)));
    const auto disk = disk_with(bytes);
    const auto journal = Journal::open("/d", *disk);
    if (at >= last) {
      // Nothing follows: this could as well be what a crash has left.
      ASSERT_TRUE(journal) << bit;
      ASSERT_EQ(journal->contents(), r.story.states[r.story.states.size() - 2]);
      ASSERT_TRUE(journal->recovered());
      continue;
    }
    ASSERT_FALSE(journal) << bit;
    // The batch is named in which the bit is; of the head and the snapshot, the beginning.
    const auto batch = std::ranges::upper_bound(r.ends, at);
    const std::size_t from = at < 24 ? 0 : batch == r.ends.begin() ? 24 : *(batch - 1);
    ASSERT_NE(journal.error().text.find("damaged at byte " + std::to_string(from) + " "),
              std::string::npos)
        << bit << ": " << journal.error().text;
    ASSERT_EQ(bytes_of(*disk), bytes) << "a damaged file must be left alone";
  }
}

TEST(ManyFlippedBits, NeverGiveAStateThatNeverWas) {
  const Recording r = recorded(15, 12, 5);
  std::mt19937 random(15);
  std::size_t refused = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string bytes = r.bytes;
    for (std::size_t flips = 1 + random() % 20; flips > 0; --flips) {
      char& byte = bytes[random() % bytes.size()];
      byte = static_cast<char>(byte ^ (1U << (random() % 8)));
    }
    const auto disk = disk_with(bytes);
    const auto journal = Journal::open("/d", *disk);
    refused += journal ? 0 : 1;
    if (!journal) continue;
    ASSERT_NE(std::ranges::find(r.story.states, journal->contents()), r.story.states.end());
  }
  EXPECT_GT(refused, 10'000U);
}

TEST(BatchesThatAreMissingOrTwice, AreDamage) {
  const Recording r = recorded(16, 4, 0);
  const std::string missing = r.bytes.substr(0, r.ends[1]) + r.bytes.substr(r.ends[2]);
  const std::string twice = r.bytes.substr(0, r.ends[2]) + r.bytes.substr(r.ends[1]);
  const std::string only_a_head = r.bytes.substr(0, r.ends[1]) + r.bytes.substr(r.ends[2], 40);
  for (const std::string& bytes : {missing, twice, only_a_head}) {
    const auto disk = disk_with(bytes);
    const auto journal = Journal::open("/d", *disk);
    ASSERT_FALSE(journal);
    EXPECT_NE(journal.error().text.find("in place of batch"), std::string::npos);
  }
}

TEST(BytesOfAnotherJournal, AreNeverTakenForOurs) {
  const Recording ours = recorded(17, 3, 0);
  const Recording theirs = recorded(18, 5, 0);
  const auto disk = disk_with(ours.bytes + theirs.bytes.substr(theirs.ends[3]));
  const auto journal = Journal::open("/d", *disk);
  ASSERT_TRUE(journal) << journal.error().text;
  EXPECT_EQ(journal->contents(), ours.story.states.back());
  EXPECT_TRUE(journal->recovered());
}

// --- by hand -------------------------------------------------------------------------------------

std::string number(std::uint64_t value, std::size_t bytes) {
  std::string out;
  for (; bytes > 0; --bytes, value >>= 8U) out += static_cast<char>(value & 0xffU);
  return out;
}

/// CRC-64/XZ, bit by bit.
std::string checksum(std::string_view bytes) {
  std::uint64_t crc = ~std::uint64_t{0};
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) * 0xc96c5795d7870f42U);
  }
  return number(~crc, 8);
}

const std::string kSalt = "saltsalt";

std::string head_of(const std::string& layout) { return layout + kSalt + checksum(layout + kSalt); }
std::string head() { return head_of("MLCCAJ02"); }

/// A field of protobuf: a number, or anything of less than 128 bytes.
std::string field(int number, std::uint64_t value) {
  return std::string{static_cast<char>(8 * number), static_cast<char>(value)};
}
std::string field(int number, const std::string& bytes) {
  return std::string{static_cast<char>(8 * number + 2), static_cast<char>(bytes.size())} + bytes;
}

std::string entry(const std::string& message) { return number(message.size(), 4) + message; }

/// Without the length that the control socket has in front.
std::string request_of(std::uint64_t id) { return control::encode(admitted(id).request).substr(1); }

std::string batch(std::uint64_t sequence, std::uint32_t count, std::string entries) {
  while (entries.size() % 8 != 0) entries += '\0';
  const std::string front = "BTCH" + number(count, 4) + number(sequence, 8) +
                            number(entries.size(), 8) + checksum(entries);
  return front + checksum(kSalt + front) + entries;
}

TEST(AFileWrittenByHand, IsRead) {
  const std::string delivery = field(1, "camera") + field(2, 7) + field(3, "control");
  const std::string grants = field(1, 2) + field(2, delivery);
  const std::string slots = field(1, field(1, 3) + field(2, 1));
  const std::string snapshot = batch(0, 3,
                                     entry(field(6, field(1, 50))) +
                                         entry(field(1, field(1, request_of(7)) + field(2, 100))) +
                                         entry(field(3, field(1, "0x9"))));
  const std::string change = batch(
      1, 7,
      entry(field(1, field(1, request_of(50)))) + entry(field(2, field(1, 7))) +
          entry(field(4, field(1, "0x9"))) + entry(field(5, field(1, "0x8") + field(2, grants))) +
          entry(
              field(7, field(1, "name can0") + field(2, "bus") + field(3, "can0") + field(4, 3))) +
          entry(field(8, field(1, 8) + field(2, slots))) +
          entry(field(9, field(1, "bus") + field(2, 8) + field(3, 5) + field(4, "dealt"))));
  const auto disk = disk_with(head() + snapshot + change);
  const auto journal = Journal::open("/d", *disk);
  ASSERT_TRUE(journal) << journal.error().text;
  Contents expected;
  expected.admissions = {admitted(50).request};
  expected.granted = {{"0x8", grants}};
  expected.gated = {{"name can0", {"name can0", "bus", "can0", 3}}};
  expected.enforced = {{8, slots}};
  expected.contradicted = {{{"bus", 8}, {"bus", 8, 5, "dealt"}}};
  expected.next_id = 51;
  EXPECT_EQ(journal->contents(), expected) << text_of(journal->contents());
}

TEST(AFileOfALaterVersion, IsLeftAlone) {
  const std::string good = head() + batch(0, 1, entry(field(6, field(1, 1))));
  const std::string inside = request_of(1);
  for (const std::string& unknown :
       {entry(field(12, "")), entry(""), entry(field(3, field(2, "news"))),
        entry(field(3, field(1, "0x1")) + field(15, 1)), entry(field(2, field(1, "text"))),
        entry(field(3, field(1, "\xff"))), entry(field(1, field(1, inside + field(15, 1)))),
        entry(field(1, field(1, inside.substr(1)))), entry(field(1, "")),
        entry(field(1, field(1, field(1, 1) + field(2, "")))), entry(field(3, 1)),
        number(30, 4) + field(3, field(1, "0x1"))}) {
    const std::string bytes =
        good + batch(1, 1, unknown) + batch(2, 1, entry(field(3, field(1, "0x1"))));
    const auto disk = disk_with(bytes);
    const auto journal = Journal::open("/d", *disk);
    ASSERT_FALSE(journal) << ::testing::PrintToString(unknown);
    ASSERT_NE(journal.error().text.find("/d/journal: the batch at byte "), std::string::npos)
        << journal.error().text;
    ASSERT_EQ(bytes_of(*disk), bytes);
  }
  const auto disk = disk_with(good + batch(1, 2, entry(field(3, field(1, "0x1")))));
  EXPECT_FALSE(Journal::open("/d", *disk)) << "fewer entries than it says";
}

TEST(AFileOfAnotherLayout, IsNamedAndLeftAlone) {
  for (const std::string layout : {"MLCCAJ01", "MLCCAJ03"}) {
    const std::string bytes = head_of(layout) + batch(0, 1, entry(field(6, field(1, 1))));
    const auto disk = disk_with(bytes);
    const auto journal = Journal::open("/d", *disk);
    ASSERT_FALSE(journal);
    EXPECT_EQ(journal.error().text,
              "/d/journal: a journal of layout " + layout +
                  ", and this version reads only MLCCAJ02, nothing of it is used: put a copy back, "
                  "or move it away to start without the run-time admissions");
    EXPECT_EQ(bytes_of(*disk), bytes);
  }
}

}  // namespace
}  // namespace mlcca::store::test
