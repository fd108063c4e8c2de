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
  EXPECT_TRUE(
      text.contains("  <Attributes priority=\"10\" omission=\"1\"/>\n"
                    "  <Attributes priority=\"-5\" omission=\"4\"/>\n"))
      << text;

  const auto unclear = run({"describe", file, "--set", "Omission=2"});
  EXPECT_EQ(unclear.status, 2);
  EXPECT_TRUE(unclear.error.contains("of priority 10, -5: say which")) << unclear.error;
  ASSERT_EQ(run({"describe", file, "--remove-set", "10"}).status, 0);
  EXPECT_FALSE(content_of(file).contains("priority=\"10\""));
  EXPECT_TRUE(content_of(file).contains("omission=\"4\""));
}

TEST(DescribeSetsTest, ASecondSetGivesTheFirstItsPriority) {
  const Folder folder;
  const auto file = folder.path("c.xml");
  ASSERT_EQ(run({"describe", file, "--set", "Omission=1"}).status, 0);
  ASSERT_EQ(run({"describe", file, "--priority", "-1", "--set", "Omission=9"}).status, 0);
  EXPECT_TRUE(content_of(file).contains("<Attributes omission=\"1\" priority=\"0\"/>"))
      << content_of(file);
  EXPECT_TRUE(content_of(file).contains("<Attributes priority=\"-1\" omission=\"9\"/>"));
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
  EXPECT_TRUE(text.contains(
      "  <Attributes omission=\"1\" period=\"50ms\" priority=\"0\"/>\n"
      "  <Attributes priority=\"5\" omission=\"0\" period=\"50ms\" maxPayload=\"8\"/>\n"
      "  <Attributes priority=\"-1\" omission=\"9\" maxPayload=\"8\"/>\n"))
      << text;
}

}  // namespace
}  // namespace mlcca::test
