// SPDX-License-Identifier: BSD-2-Clause
// mlccactl describe: channels with several attribute sets.
#include <gtest/gtest.h>

#include <string>

#include "description/read.hpp"
#include "tests/tools/design/describe/program.hpp"

namespace mlcca::test {
namespace {

TEST(DescribeSetsTest, PriorityIsForTheOptionsBehindIt) {
  const Folder folder;
  const auto file = folder.path("c.xml");
  ASSERT_EQ(run({"describe", file, "--subject", "0x1", "--priority", "10", "--set", "Omission=1",
                 "--priority", "-5", "--set", "Omission=4"})
                .status,
            0);
  const auto text = content_of(file);
  const auto high = text.find("<Attributes priority=\"10\">");
  const auto low = text.find("<Attributes priority=\"-5\">");
  EXPECT_LT(high, text.find("<Value>1</Value>"));
  EXPECT_LT(text.find("<Value>1</Value>"), low);
  EXPECT_LT(low, text.find("<Value>4</Value>"));

  const auto unclear = run({"describe", file, "--set", "Omission=2"});
  EXPECT_EQ(unclear.status, 2);
  EXPECT_TRUE(unclear.error.contains("of priority 10, -5: say which")) << unclear.error;
  ASSERT_EQ(run({"describe", file, "--remove-set", "10"}).status, 0);
  EXPECT_FALSE(content_of(file).contains("priority=\"10\""));
  EXPECT_TRUE(content_of(file).contains("<Value>4</Value>"));
}

TEST(DescribeSetsTest, ASecondSetGivesTheFirstItsPriority) {
  const Folder folder;
  const auto file = folder.path("c.xml");
  ASSERT_EQ(run({"describe", file, "--set", "Omission=1"}).status, 0);
  ASSERT_EQ(run({"describe", file, "--priority", "-1", "--set", "Omission=9"}).status, 0);
  EXPECT_TRUE(content_of(file).contains("<Attributes priority=\"0\">")) << content_of(file);
  EXPECT_TRUE(content_of(file).contains("<Attributes priority=\"-1\">"));
}

TEST(DescribeSetsTest, ANewSetStartsAsTheOneThatWasPreferred) {
  const Folder folder;
  const auto file = folder.path("c.xml");
  ASSERT_EQ(run({"describe", file, "--set", "Omission=1", "--set", "Period=50ms"}).status, 0);
  const auto ran =
      run({"describe", file, "--priority", "5", "--set", "Omission=0", "--set", "MaxPayload=8"});
  ASSERT_EQ(ran.status, 0) << ran.error;
  EXPECT_EQ(ran.out, file +
                         ": changed\n"
                         "  priority of the set that had none: 0\n"
                         "  Omission of the set of priority 5: 0\n"
                         "  Period of the set of priority 5: 50 ms\n"
                         "  MaxPayload of the set of priority 5: 8 bytes\n");
  // The preferred one is that of priority 5 now, though it stands behind the other.
  ASSERT_EQ(run({"describe", file, "--priority", "-1", "--set", "Omission=9", "--unset", "Period"})
                .status,
            0);
  const auto text = content_of(file);
  EXPECT_TRUE(description::check_part(file).empty()) << text;
  const auto first = text.substr(text.find("priority=\"0\""), text.find("priority=\"5\""));
  EXPECT_TRUE(first.contains("<Value>1</Value>")) << text;
  const auto last = text.substr(text.find("priority=\"-1\""));
  EXPECT_TRUE(last.contains("<Value>9</Value>")) << text;
  EXPECT_TRUE(last.contains("<Value>8</Value>")) << text;
  EXPECT_FALSE(last.contains("Period")) << text;
}

}  // namespace
}  // namespace mlcca::test
