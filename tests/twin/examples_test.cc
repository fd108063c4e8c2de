// SPDX-License-Identifier: BSD-2-Clause
// The variants of the case study: the design time says of each what its comments say, by both
// checkers.
#include <gtest/gtest.h>

#include <string>

#include "description/read.hpp"
#include "twin/expected.hpp"
#include "twin/twin.hpp"

namespace mlcca::testing {
namespace {

class Volksbot : public ::testing::TestWithParam<const char*> {
 protected:
  static std::string path() { return std::string("examples/volksbot/") + GetParam() + ".xml"; }
};

TEST_P(Volksbot, IsDecidedByTheTwinAsItsCommentsSay) {
  EXPECT_EQ(listed(twin_findings({path()}).front()), listed(expected_in(text_of(path()))));
}

TEST_P(Volksbot, IsDecidedByTheCheckerAsItsCommentsSay) {
  auto system = description::read(path());
  ASSERT_TRUE(system) << description::to_string(system.error()[0]);
  EXPECT_EQ(listed(findings_of(*system)), listed(in_words(*system, expected_in(text_of(path())))));
  EXPECT_EQ(others_of(*system), others_expected_in(text_of(path())));
}

TEST_P(Volksbot, FitsTheSchema) {
  output_of(
      "xmllint --noout --nonet --xinclude --nofixup-base-uris --schema description/system.xsd " +
      path() + " 2>&1");
}

INSTANTIATE_TEST_SUITE_P(, Volksbot,
                         ::testing::Values("robot", "moved-switch", "second-bus", "video-high",
                                           "video-low", "video-far", "video-on-can"),
                         [](const auto& variant) {
                           std::string name = variant.param;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace mlcca::testing
