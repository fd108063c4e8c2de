// SPDX-License-Identifier: BSD-2-Clause
// The tables of many buses say while they are changed that this goes on.
#include "tests/daemon/gates/slots_fixture.hpp"
#include "tests/support/stretches.hpp"

namespace mlcca::gates {
namespace {

constexpr std::uint32_t kMany = 2'000;
/// Of what is done with all slots: each time at least.
constexpr std::size_t kReports = kMany / 64;

TEST_F(Slots, ProgressIsReportedInEachPhaseOfAChange) {
  auto slots = read();
  std::vector<SlotSpec> all;
  for (std::uint32_t i = 0; i < kMany; ++i) all.push_back(raw(CAN_EFF_FLAG | i));
  {
    test::Stretches stretches;
    ASSERT_TRUE(slots.apply(adding(all)));
    EXPECT_GE(stretches.reports(), 5 * kReports) << "checked, counted, linked, opened, settled";
  }
  {
    test::Stretches stretches;
    EXPECT_EQ(slots.present().size(), all.size());
    EXPECT_GE(stretches.reports(), kReports);
  }
  {
    test::Stretches stretches;
    read(false);
    EXPECT_GE(stretches.reports(), kReports) << "taken over";
  }
  test::Stretches stretches;
  ASSERT_TRUE(slots.apply(removing(all)));
  EXPECT_GE(stretches.reports(), 4 * kReports) << "checked, denied, settled, removed";
}

}  // namespace
}  // namespace mlcca::gates
