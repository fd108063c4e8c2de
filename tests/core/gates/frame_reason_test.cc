// SPDX-License-Identifier: BSD-2-Clause
// The reasons that gates count frames for: the numbers of the kernel, the names of reports, and the
// table in the documentation.
#include "core/gates/frame_reason.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "bpf/gate.h"

namespace mlcca::core {
namespace {

TEST(FrameReasons, HaveTheNumbersOfTheirCounters) {
  for (std::size_t i = 0; i < kFrameReasons.size(); ++i)
    EXPECT_EQ(static_cast<std::size_t>(kFrameReasons.at(i).reason), i) << kFrameReasons.at(i).name;
  EXPECT_EQ(kFrameReasons.size(), std::size_t{GATE_REASONS}) << "the counters are pinned layout";
  EXPECT_EQ(static_cast<int>(FrameReason::passed), GATE_R_PASSED);
  EXPECT_EQ(static_cast<int>(FrameReason::opaque), GATE_R_OPAQUE);
}

/// The kernel compares numbers to find the slot that a frame fulfils furthest.
TEST(FrameReasons, AreOrderedFromNoSlotToARefusingVerdict) {
  EXPECT_LT(FrameReason::unknown, FrameReason::identifier);
  EXPECT_LT(FrameReason::identifier, FrameReason::source);
  EXPECT_LT(FrameReason::source, FrameReason::format);
  EXPECT_LT(FrameReason::format, FrameReason::length);
  EXPECT_LT(FrameReason::length, FrameReason::denied);
}

TEST(FrameReasons, AreFoundByTheirNames) {
  std::set<std::string_view> names;
  for (const FrameReasonRow& row : kFrameReasons) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_EQ(row.name.find(kReasonExplained), std::string_view::npos) << row.name;
    EXPECT_EQ(frame_reason(row.name), row.reason);
  }
  EXPECT_FALSE(frame_reason("not a reason"));
}

TEST(FrameReasons, ThatDropNothingAreKnown) {
  std::set<FrameReason> passing;
  for (const FrameReasonRow& row : kFrameReasons)
    if (!is_drop(row.reason)) passing.insert(row.reason);
  EXPECT_EQ(passing, (std::set{FrameReason::passed, FrameReason::echo, FrameReason::error_in,
                               FrameReason::foreign}));
}

TEST(StatedReasons, AreReadAsTheyWereWritten) {
  for (const FrameReasonRow& row : kFrameReasons)
    for (const bool is_latest : {false, true}) {
      const StatedReason stated{.reason = row.reason, .is_latest = is_latest};
      EXPECT_EQ(stated_reason(to_text(stated)), stated) << to_text(stated);
      EXPECT_EQ(stated_reason(to_text(stated) + ": longer than granted"), stated);
    }
  EXPECT_EQ(stated_reason(to_text(StatedReason{})), StatedReason{});
}

TEST(StatedReasons, OfOtherTextsAreNotKnown) {
  for (const char* text : {"", "refused by whom", "longer", ": refused", "Refused"})
    EXPECT_EQ(stated_reason(text).reason, std::nullopt) << text;
}

TEST(FrameReasons, AreInTheTablesOfTheDocumentation) {
  std::ifstream file("docs/reference/frame-reasons.md");
  const std::string page(std::istreambuf_iterator<char>(file), {});
  for (const bool drops : {true, false}) {
    std::string table = "| reason | what it means |\n|---|---|\n";
    for (const FrameReasonRow& row : kFrameReasons)
      if (is_drop(row.reason) == drops)
        table.append("| `").append(row.name).append("` | ").append(row.text).append(" |\n");
    EXPECT_TRUE(page.contains(table + "\n")) << table;
  }
}

}  // namespace
}  // namespace mlcca::core
