// SPDX-License-Identifier: BSD-2-Clause
#include "base/many.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace mlcca {
namespace {

TEST(Many, OneIsNoPlural) {
  EXPECT_EQ(many(0, "frame"), "0 frames");
  EXPECT_EQ(many(1, "frame"), "1 frame");
  EXPECT_EQ(many(2, "frame"), "2 frames");
  EXPECT_EQ(many(UINT64_MAX, "frame"), "18446744073709551615 frames");
}

TEST(Many, OtherPluralsAreStated) {
  EXPECT_EQ(many(1, "entry", "entries"), "1 entry");
  EXPECT_EQ(many(3, "entry", "entries"), "3 entries");
  EXPECT_EQ(many(1, "event is", "events are"), "1 event is");
}

}  // namespace
}  // namespace mlcca
