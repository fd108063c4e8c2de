// SPDX-License-Identifier: BSD-2-Clause
// What is suggested for a name that is not known.
#include "description/suggest.hpp"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace mlcca::description {
namespace {

using Names = std::vector<std::string_view>;

TEST(Closest, FindsSlipsAndNotOtherNames) {
  const Names known{"robot-can", "second-can", "air"};
  EXPECT_EQ(closest("robot-cam", known), "robot-can");
  EXPECT_EQ(closest("robotcan", known), "robot-can");
  EXPECT_EQ(closest("Robot-Can", known), "robot-can");
  EXPECT_EQ(closest("robto-cna", known), "robot-can");
  EXPECT_EQ(closest("robot", known), "");
  EXPECT_EQ(closest("ari", known), "air");
  EXPECT_EQ(closest("abc", known), "");
  EXPECT_EQ(closest("", known), "");
  EXPECT_EQ(closest(std::string(100, 'a'), known), "");
}

TEST(KnownNames, ListsNineAndCountsTheRest) {
  const Names nine{"n0", "n1", "n2", "n3", "n4", "n5", "n6", "n7", "n8"};
  EXPECT_EQ(known_names("x", nine), "known: n0, n1, n2, n3, n4, n5, n6, n7, n8");
  auto ten = nine;
  ten.push_back("other");
  EXPECT_EQ(known_names("x", ten), "known: n0, n1, n2, n3, n4, n5, n6, n7, n8 and 1 more");
  EXPECT_EQ(known_names("othr", ten),
            "did you mean other? Known: n0, n1, n2, n3, n4, n5, n6, n7, n8 and 1 more");
  EXPECT_EQ(known_names("x", {}), "none is described");
}

}  // namespace
}  // namespace mlcca::description
