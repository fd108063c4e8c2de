// SPDX-License-Identifier: BSD-2-Clause
// Which slots of a gate with very many a report lists.
#include "daemon/ports/gate_report.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace mlcca {
namespace {

using gates::Direction;

constexpr std::size_t kMost = 10;
constexpr std::uint64_t kControl = 0;

/// So many slots of channels in a direction, the last identifier first.
std::vector<gates::SlotSpec> channels(Direction direction, std::uint32_t count) {
  std::vector<gates::SlotSpec> out;
  for (std::uint32_t id = count; id > 0; --id)
    out.push_back({.direction = direction, .id = id, .subject = 0x100U + id});
  return out;
}

struct Listed {
  std::vector<std::uint32_t> control, entering, leaving;  ///< identifiers
};

Listed listed(const std::vector<gates::SlotSpec>& slots) {
  Listed out;
  for (const gates::SlotSpec& slot :
       listed_slots(std::move(slots), kMost, [](const auto& s) { return s.subject == kControl; }))
    (slot.subject == kControl               ? out.control
     : slot.direction == Direction::ingress ? out.entering
                                            : out.leaving)
        .push_back(slot.id);
  return out;
}

std::vector<gates::SlotSpec> gate_of(std::uint32_t entering, std::uint32_t leaving) {
  auto out = channels(Direction::ingress, entering);
  const auto others = channels(Direction::egress, leaving);
  out.insert(out.end(), others.begin(), others.end());
  out.push_back({.direction = Direction::egress, .id = 7, .subject = kControl});
  return out;
}

std::vector<std::uint32_t> first(std::uint32_t count) {
  std::vector<std::uint32_t> out;
  for (std::uint32_t id = 1; id <= count; ++id) out.push_back(id);
  return out;
}

void expect_listed(std::uint32_t entering, std::uint32_t leaving, std::uint32_t listed_entering,
                   std::uint32_t listed_leaving) {
  const Listed all = listed(gate_of(entering, leaving));
  EXPECT_EQ(all.control, std::vector<std::uint32_t>{7}) << "control traffic is never left out";
  EXPECT_EQ(all.entering, first(listed_entering)) << entering << " and " << leaving;
  EXPECT_EQ(all.leaving, first(listed_leaving)) << entering << " and " << leaving;
}

TEST(GateReport, ListsAllThereIsWhereItHasPlace) {
  expect_listed(0, 0, 0, 0);
  expect_listed(4, 6, 4, 6);
  expect_listed(10, 0, 10, 0);
  expect_listed(0, 10, 0, 10);
}

TEST(GateReport, LeavesPlaceForBothDirections) {
  expect_listed(100, 100, 5, 5);
  expect_listed(100, 2, 8, 2);
  expect_listed(2, 100, 2, 8);
  expect_listed(100, 0, 10, 0);
  expect_listed(0, 100, 0, 10);
}

}  // namespace
}  // namespace mlcca
