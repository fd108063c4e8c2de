// SPDX-License-Identifier: BSD-2-Clause
// The files of docs/reference/format.md work as it says.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "description/read.hpp"
#include "tests/description/twin/expected.hpp"
#include "tests/description/twin/twin.hpp"

namespace mlcca::testing {
namespace {

/// Each "```xml" block as a file; a comment in its first line says how it is called.
class Guide : public ::testing::Test {
 protected:
  Guide() {
    static const std::string start = "```xml\n<!-- ";
    for (auto at = text_.find(start); at != std::string::npos; at = text_.find(start, at + 1)) {
      const auto name = at + start.size();
      const auto name_end = text_.find(" -->\n", name);
      const auto block = name_end + std::string(" -->\n").size();
      files_.insert(folder_.add(text_.substr(name, name_end - name),
                                text_.substr(block, text_.find("```", block) - block)));
    }
  }

  [[nodiscard]] std::string file(const std::string& name) const {
    for (const auto& path : files_)
      if (path.ends_with("/" + name)) return path;
    ADD_FAILURE() << name << " is not in the guide";
    return {};
  }

  std::string text_ = text_of("docs/reference/format.md");
  Folder folder_;
  std::set<std::string> files_;
};

TEST_F(Guide, HasOnlyPartsThatFitTheSchema) {
  EXPECT_GE(files_.size(), 10U);
  for (const auto& path : files_)
    for (const auto& problem : description::check_part(path))
      ADD_FAILURE() << description::to_string(problem);
}

TEST_F(Guide, FirstSystemFits) {
  const auto system = description::read(file("robot.xml"));
  ASSERT_TRUE(system) << description::to_string(system.error()[0]);
  EXPECT_EQ(system->subscribers.size(), 1U);
  EXPECT_EQ(findings_of(*system), Keys{});
  EXPECT_EQ(others_of(*system), std::set<std::string>{});
}

TEST_F(Guide, MovedSwitchIsRefusedInTheWordsOfTheGuide) {
  const auto out =
      output_of("xsltproc --xinclude --nonet description/check.xsl '" + file("moved.xml") + "'");
  EXPECT_NE(text_.find("```text\n" + out + "```"), std::string::npos) << out;
  const auto system = description::read(file("moved.xml"));
  ASSERT_TRUE(system) << description::to_string(system.error()[0]);
  EXPECT_EQ(listed(findings_of(*system)),
            listed(in_words(*system, twin_findings({file("moved.xml")}).front())));
}

}  // namespace
}  // namespace mlcca::testing
