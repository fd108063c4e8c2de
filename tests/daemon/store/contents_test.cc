// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/store/contents.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "daemon/store/checksum.hpp"
#include "tests/daemon/store/worlds.hpp"

namespace mlcca::store::test {
namespace {

TEST(Contents, FollowTheEntriesOfARandomStory) {
  const Story story = random_story(1, 500);
  Contents contents;
  for (std::size_t i = 0; i < story.batches.size(); ++i) {
    for (const Entry& entry : story.batches[i]) contents.apply(entry);
    ASSERT_EQ(contents, story.states[i + 1]) << text_of(contents);
  }
}

TEST(Contents, AreAsBeforeWhenTheInverseIsApplied) {
  const Story story = random_story(2, 300);
  Contents contents;
  for (const Batch& batch : story.batches) {
    for (const Entry& entry : batch) {
      Contents before = contents;
      const auto back = contents.inverse(entry);
      ASSERT_TRUE(back);
      contents.apply(entry);
      ASSERT_NE(contents, before);
      Contents undone = contents;
      undone.apply(*back);
      before.next_id = undone.next_id;
      ASSERT_EQ(undone, before) << text_of(undone);
    }
  }
}

TEST(Contents, HaveNoInverseForWhatChangesNothing) {
  Contents contents;
  EXPECT_FALSE(contents.inverse(Removed{7}));
  EXPECT_FALSE(contents.inverse(Reinstated{"0x1"}));
  EXPECT_FALSE(contents.inverse(Granted{"0x1", ""}));
  contents.apply(admitted(1));
  contents.apply(Released{"0x1"});
  contents.apply(Granted{"0x1", "set=1"});
  EXPECT_FALSE(contents.inverse(admitted(1)));
  EXPECT_FALSE(contents.inverse(Released{"0x1"}));
  EXPECT_FALSE(contents.inverse(Granted{"0x1", "set=1"}));
}

TEST(Contents, NeverGoBackToAFormerNextId) {
  Contents contents;
  EXPECT_FALSE(contents.inverse(NextId{1}));
  EXPECT_EQ(contents.inverse(NextId{7}), Entry(NextId{1}));
  contents.apply(NextId{7});
  EXPECT_EQ(contents.next_id, 7U);
  contents.apply(NextId{1});
  EXPECT_EQ(contents.next_id, 7U);
}

TEST(Contents, KeepWhichInterfaceAPortHas) {
  Contents contents;
  const Gated can0{"name can0", "robot-can", "can0", 3};
  Gated again = can0;
  again.ifindex = 7;
  EXPECT_EQ(contents.inverse(can0), Entry(Gated{"name can0", "", "", 0}));
  contents.apply(can0);
  EXPECT_FALSE(contents.inverse(can0));
  EXPECT_EQ(contents.inverse(again), Entry(can0));
  contents.apply(again);
  EXPECT_EQ(contents.gated, (std::map<std::string, Gated>{{"name can0", again}}));
  contents.apply(Gated{"name can0", "", "", 0});
  EXPECT_TRUE(contents.gated.empty());
  EXPECT_FALSE(contents.inverse(Gated{"name can0", "", "", 0}));
}

TEST(Contents, KeepTheLatestSlotsOfASubject) {
  Contents contents;
  const std::string octets("\0\1", 2);
  EXPECT_FALSE(contents.inverse(Enforced{0, {}}));
  EXPECT_EQ(contents.inverse(Enforced{0, octets}), Entry(Enforced{0, {}}));
  contents.apply(Enforced{0, octets});
  EXPECT_FALSE(contents.inverse(Enforced{0, octets}));
  EXPECT_EQ(contents.inverse(Enforced{0, "other"}), Entry(Enforced{0, octets}));
  EXPECT_EQ(contents.enforced, (std::map<std::uint64_t, std::string>{{0, octets}}));
  contents.apply(Enforced{0, {}});
  EXPECT_TRUE(contents.enforced.empty());
}

TEST(Contents, KeepWhatTheBrokerHasDealtOtherwiseUntilItIsOver) {
  Contents contents;
  const Contradicted switched{"robot-can", 7, 0x3ffe, "dealt to Distance"};
  const Contradicted over{"robot-can", 7, 0x3ffe, ""};
  const Contradicted elsewhere{"second-can", 7, 0x3ffe, "dealt to Velocity"};
  EXPECT_FALSE(contents.inverse(over));
  EXPECT_EQ(contents.inverse(switched), Entry(Contradicted{"robot-can", 7, 0, ""}));
  contents.apply(switched);
  contents.apply(elsewhere);
  EXPECT_FALSE(contents.inverse(switched));
  EXPECT_EQ(contents.inverse(over), Entry(switched));
  contents.apply(over);
  EXPECT_EQ(contents.contradicted.size(), 1U);
  EXPECT_EQ(contents.contradicted.at({"second-can", 7}), elsewhere);
}

TEST(Contents, KeepThatTheGatewayIsIntroduced) {
  Contents contents;
  EXPECT_FALSE(contents.inverse(Introduced{false}));
  EXPECT_EQ(contents.inverse(Introduced{true}), Entry(Introduced{false}));
  contents.apply(Introduced{true});
  EXPECT_TRUE(contents.introduced);
  EXPECT_FALSE(contents.inverse(Introduced{true}));
}

TEST(Contents, KeepTheLatestGrantOfASubject) {
  Contents contents;
  contents.apply(Granted{"0x1", "set=1"});
  contents.apply(Granted{"0x1", "set=2"});
  EXPECT_EQ(contents.granted, (std::map<std::string, std::string>{{"0x1", "set=2"}}));
  EXPECT_EQ(contents.inverse(Granted{"0x1", "set=3"}), Entry(Granted{"0x1", "set=2"}));
}

TEST(Contents, ListAdmissionsOldestFirst) {
  Contents contents;
  for (const std::uint64_t id : {3U, 1U, 2U}) contents.apply(admitted(id));
  std::string ids;
  for (const control::Request& r : contents.admissions) ids += std::to_string(r.id);
  EXPECT_EQ(ids, "123");
  EXPECT_EQ(contents.next_id, 4U);
}

/// CRC-64 by its definition, bit by bit, with the published polynomial (not reflected).
std::uint64_t crc64_by_definition(std::string_view bytes) {
  std::uint64_t rest = ~std::uint64_t{0};
  for (const char c : bytes) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      const std::uint64_t in = (static_cast<unsigned char>(c) >> bit) & 1U;
      const std::uint64_t out = (rest >> 63U) ^ in;
      rest = (rest << 1U) ^ (out != 0 ? 0x42f0e1eba9ea3693U : 0U);
    }
  }
  std::uint64_t reflected = 0;
  for (unsigned bit = 0; bit < 64; ++bit) reflected |= ((rest >> bit) & 1U) << (63U - bit);
  return ~reflected;
}

TEST(Checksum, IsWhatItsDefinitionSays) {
  std::mt19937 random(3);
  EXPECT_EQ(crc64_by_definition("123456789"), 0x995dc9bbdf1939faU);
  for (int i = 0; i < 200; ++i) {
    std::string bytes(random() % 100, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    const std::size_t cut = bytes.empty() ? 0 : random() % bytes.size();
    ASSERT_EQ(crc64(bytes), crc64_by_definition(bytes));
    ASSERT_EQ(crc64(std::string_view(bytes).substr(cut), crc64(bytes.substr(0, cut))),
              crc64(bytes));
  }
}

}  // namespace
}  // namespace mlcca::store::test
