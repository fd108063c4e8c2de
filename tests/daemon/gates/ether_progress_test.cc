// SPDX-License-Identifier: BSD-2-Clause
// A large table says while it is changed that this goes on.
#include "tests/daemon/gates/ether_table_fixture.hpp"
#include "tests/support/stretches.hpp"

namespace mlcca::gates {
namespace {

constexpr std::size_t kMany = 10'000;
/// Of what is done with all slots: each time at least.
constexpr std::size_t kReports = kMany / 64;

class EtherProgressTest : public EtherTableTest {
 protected:
  EtherProgressTest() : EtherTableTest(EtherSizes::for_slots(2 * kMany, 1)) {
    for (std::size_t i = 0; i < kMany; ++i) all_.push_back(slot(i + 1));
  }
  std::vector<SlotSpec> all_;
};

TEST_F(EtherProgressTest, IsReportedInEachPhaseOfAChange) {
  {
    test::Stretches stretches;
    ASSERT_TRUE(add(all_));
    EXPECT_GE(stretches.reports(), 6 * kReports) << "checked, sorted, linked, opened";
  }
  SlotChanges others;
  others.close = all_;
  {
    test::Stretches stretches;
    ASSERT_TRUE(table_.apply(others));
    EXPECT_GE(stretches.reports(), 3 * kReports) << "checked, staged, settled";
  }
  test::Stretches stretches;
  ASSERT_TRUE(remove(all_));
  EXPECT_GE(stretches.reports(), 6 * kReports) << "checked, sorted, denied, removed";
}

TEST_F(EtherProgressTest, IsReportedWhileItIsReadComparedAndDenied) {
  ASSERT_TRUE(add(all_));
  test::Stretches stretches;
  const auto found = table_.present();
  EXPECT_GE(stretches.reports(), kReports);
  ASSERT_EQ(found.size(), kMany);
  {
    test::Stretches compared;
    EXPECT_TRUE(slot_changes_between(found, all_).empty());
    EXPECT_EQ(slot_changes_between({}, all_).add.size(), kMany);
    EXPECT_LE(compared.longest(), 2'000U) << "allocations";
    EXPECT_GE(compared.reports(), 4 * kReports);
  }
  test::Stretches denied;
  table_.deny_all();
  EXPECT_GE(denied.reports(), 2 * kReports);
}

TEST_F(EtherProgressTest, IsReportedWhileATableIsTakenOver) {
  ASSERT_TRUE(add(all_));
  test::Stretches stretches;
  ASSERT_TRUE(open(false));
  EXPECT_GE(stretches.reports(), 2 * kReports);
}

}  // namespace
}  // namespace mlcca::gates
