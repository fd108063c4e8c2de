// SPDX-License-Identifier: BSD-2-Clause
// Files that are made to harm: a clear answer, in bounded memory.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/tools/design/check/program.hpp"

namespace mlcca {
namespace {

class HostileTest : public test::CheckTest {
 protected:
  static constexpr long kMostMemory = 64L * 1024;  // KiB

  /// The answer to a file that is refused.
  static std::string refused(const std::string& name) {
    const auto outcome = test::run({"check", name});
    EXPECT_EQ(outcome.status, 2) << outcome.error;
    EXPECT_LT(outcome.max_rss_kib, kMostMemory);
    EXPECT_LT(outcome.out.size(), 4096U);
    return outcome.out;
  }
};

TEST_F(HostileTest, BillionLaughs) {
  std::string text = "<!DOCTYPE System [\n<!ENTITY a0 \"ha\">\n";
  for (int i = 1; i < 30; ++i)
    text += fmt::format("<!ENTITY a{0} \"&a{1};&a{1};&a{1};&a{1};\">\n", i, i - 1);
  const auto said = refused(file("s.xml", text + "]>\n<System name=\"&a29;\"/>"));
  EXPECT_TRUE(said.contains("s.xml:1: error MLCCA002: a DOCTYPE is refused")) << said;
}

TEST_F(HostileTest, ExternalEntitiesAndDtds) {
  file("secret", "secret-text");
  for (const auto& dtd :
       {fmt::format("<!DOCTYPE System [<!ENTITY x SYSTEM \"file://{}\">]>", path("secret")),
        fmt::format("<!DOCTYPE System SYSTEM \"file://{}\">", path("secret")),
        fmt::format("<!DOCTYPE System [<!ENTITY % x SYSTEM \"{}\"> %x;]>", path("secret"))}) {
    const auto said = refused(file("s.xml", dtd + "\n<System name=\"&x;\"/>"));
    EXPECT_TRUE(said.contains("a DOCTYPE is refused")) << said;
    EXPECT_FALSE(said.contains("secret-text")) << said;
  }
}

TEST_F(HostileTest, AValueOf100Megabytes) {
  const auto name = path("s.xml");
  for (const std::string before :
       {"<System name=\"test\"><EventChannel name=\"a\"><SubjectUID>0x1</SubjectUID><Description>",
        "<System name=\"", "<System><!--", "<System>", "<System><![CDATA["}) {
    std::ofstream out(name, std::ios::binary);
    out << before;
    const std::string megabyte(std::size_t{1} << 20U, 'x');
    for (int i = 0; i < 100; ++i) out << megabyte;
    out.close();
    const auto said = refused(name);
    EXPECT_TRUE(said.contains("s.xml:1: error MLCCA00")) << before << "\n" << said;
  }
}

TEST_F(HostileTest, DeepNesting) {
  std::string text = "<System name=\"test\">";
  for (int i = 0; i < 1'000'000; ++i) text += "<a>";
  const auto said = refused(file("s.xml", text));
  EXPECT_TRUE(said.contains("nested deeper than 256 elements")) << said;
}

TEST_F(HostileTest, MoreThanTheLargestFile) {
  const auto name = file("s.xml", "<System name=\"test\"/>");
  std::filesystem::resize_file(name, std::uintmax_t{1} << 40U);
  const auto said = refused(name);
  EXPECT_TRUE(said.contains("more than 268435456 bytes")) << said;
}

TEST_F(HostileTest, TheSameMistakeIsPrintedTwentyTimes) {
  std::string bindings;
  for (int i = 0; i < 297; ++i)
    bindings += "<Binding channel=\"c" + std::to_string(i) +
                "\"><Identifier form=\"standard\">0x1</Identifier></Binding>\n";
  const auto path = file(
      "s.xml", "<System name=\"s\"><Network name=\"n\"><Kind>can</Kind><Profile>raw</Profile>" +
                   bindings + "</Network></System>");
  const auto outcome = test::run({"check", path});
  std::size_t lines = 0;
  for (auto at = outcome.out.find("MLCCA005"); at != std::string::npos;
       at = outcome.out.find("MLCCA005", at + 1))
    ++lines;
  EXPECT_EQ(lines, 20U) << outcome.out;
  EXPECT_TRUE(outcome.out.contains(" (and 277 more of this kind, which are not shown)"))
      << outcome.out;
  const auto json = test::run({"check", "--format", "json", path}).out;
  EXPECT_FALSE(json.contains("more of this kind")) << "programs get all";
}

TEST_F(HostileTest, AMillionMistakes) {
  std::string text = "<System name=\"test\">\n";
  for (int i = 0; i < 1'000'000; ++i) text += "<Zebra/>\n";
  const auto outcome = test::run({"check", file("s.xml", text + "</System>")});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_LT(outcome.max_rss_kib, kMostMemory);
  EXPECT_TRUE(outcome.out.contains("there are more problems than these")) << outcome.out.size();
  EXPECT_TRUE(outcome.out.ends_with("1001 errors, 0 warnings, 0 notes\n"));
}

}  // namespace
}  // namespace mlcca
