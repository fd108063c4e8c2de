// SPDX-License-Identifier: BSD-2-Clause
// The examples: the design time says of each what its comments say, by both checkers.
#include <gtest/gtest.h>

#include <string>

#include "description/read.hpp"
#include "tests/description/twin/expected.hpp"
#include "tests/description/twin/twin.hpp"

namespace mlcca::testing {
namespace {

class Example : public ::testing::TestWithParam<const char*> {
 protected:
  static std::string path() { return std::string("examples/") + GetParam() + ".xml"; }
};

TEST_P(Example, IsDecidedByTheTwinAsItsCommentsSay) {
  EXPECT_EQ(listed(twin_findings({path()}).front()), listed(expected_in(text_of(path()))));
}

TEST_P(Example, IsDecidedByTheCheckerAsItsCommentsSay) {
  auto system = description::read(path());
  ASSERT_TRUE(system) << description::to_string(system.error()[0]);
  EXPECT_EQ(listed(findings_of(*system)), listed(in_words(*system, expected_in(text_of(path())))));
  EXPECT_EQ(others_of(*system), others_expected_in(text_of(path())));
}

TEST_P(Example, FitsTheSchema) {
  output_of(
      "xmllint --noout --nonet --xinclude --nofixup-base-uris --schema description/system.xsd " +
      path() + " 2>&1");
}

INSTANTIATE_TEST_SUITE_P(, Example,
                         ::testing::Values("volksbot/robot", "volksbot/moved-switch",
                                           "volksbot/second-bus", "volksbot/video-high",
                                           "volksbot/video-low", "volksbot/video-far",
                                           "volksbot/video-on-can", "mesh/system"),
                         [](const auto& example) {
                           std::string name = example.param;
                           std::erase_if(name, [](char c) { return c == '-' || c == '/'; });
                           return name;
                         });

}  // namespace
}  // namespace mlcca::testing
