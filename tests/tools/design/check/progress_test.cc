// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/progress.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/tools/design/check/program.hpp"

namespace mlcca {
namespace {

using std::chrono::milliseconds;
using tools::design::ProgressLine;

/// A line whose time the test makes.
class ProgressTest : public ::testing::Test {
 protected:
  ProgressLine::Time now{};
  std::vector<std::string> written;
  [[nodiscard]] auto clock() {
    return [this] { return now; };
  }
  [[nodiscard]] auto writer() {
    return [this](std::string_view text) { written.emplace_back(text); };
  }
};

TEST_F(ProgressTest, SaysNothingInTheFirstSecondAndLeavesNothing) {
  {
    ProgressLine line(clock(), writer());
    line.show("reading", 0.1);
    now += milliseconds(999);
    line.show("reading", 0.9);
  }
  EXPECT_TRUE(written.empty());
}

TEST_F(ProgressTest, IsRewrittenAtMostTenTimesASecondAndErasedAtTheEnd) {
  {
    ProgressLine line(clock(), writer());
    now += milliseconds(1000);
    for (int i = 0; i < 1000; ++i, now += milliseconds(1)) line.show("reading", i / 1000.0);
  }
  ASSERT_EQ(written.size(), 11U);
  EXPECT_EQ(written[0], "\rreading 0 %\x1b[K");
  EXPECT_EQ(written[5], "\rreading 50 %\x1b[K");
  EXPECT_EQ(written[10], "\r\x1b[K");
}

TEST_F(ProgressTest, NeverSaysMoreThanAllOrLessThanNothing) {
  ProgressLine line(clock(), writer());
  now += milliseconds(1000);
  line.show("checking", 1.7);
  now += milliseconds(100);
  line.show("checking", -1);
  EXPECT_EQ(written, (std::vector<std::string>{"\rchecking 100 %\x1b[K", "\rchecking 0 %\x1b[K"}));
}

class ProgressOnTerminal : public test::CheckTest {};

TEST_F(ProgressOnTerminal, IsNotShownForAShortWorkNorIntoAFile) {
  const auto name = file("s.xml", test::system_of(test::delivery(2, 2)));
  EXPECT_EQ(test::run({"check", name}).error, "");
  test::Running terminal({"check", name}, test::Running::Where::terminal);
  const auto all = terminal.await_end();
  EXPECT_FALSE(all.contains('%')) << all;
  EXPECT_TRUE(all.contains("1 fit")) << all;
  EXPECT_EQ(terminal.wait(), 0);
}

}  // namespace
}  // namespace mlcca
