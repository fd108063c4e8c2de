// SPDX-License-Identifier: BSD-2-Clause
#include <gtest/gtest.h>

#include <string>

#include "daemon/store/history.hpp"
#include "tests/daemon/store/worlds.hpp"

namespace mlcca::store::test {
namespace {

TEST(History, KeepsTheNotesOfOthersByTheirNames) {
  const Folder folder;
  const std::string bytes("\0\x01'\xff", 4);
  {
    auto history = History::open(folder.path());
    EXPECT_EQ(history.note("audit").value(), "");
    ASSERT_TRUE(history.keep_note("audit", "former"));
    ASSERT_TRUE(history.keep_note("audit", bytes));
    ASSERT_TRUE(history.keep_note("other", "else"));
  }
  auto history = History::open(folder.path());
  EXPECT_EQ(history.note("audit").value(), bytes);
  EXPECT_EQ(history.note("other").value(), "else");
  EXPECT_TRUE(history.take_troubles().empty());
}

}  // namespace
}  // namespace mlcca::store::test
