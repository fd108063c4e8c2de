// SPDX-License-Identifier: BSD-2-Clause
// Whose events an Ethernet gate waits for, in plain memory.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/daemon/gates/ether_table_fixture.hpp"

namespace mlcca::gates {
namespace {

SlotSpec periodic(std::uint64_t subject) {
  SlotSpec s = slot(subject);
  s.period = 1000;
  s.silence = 3000;
  s.together = 500;
  return s;
}
std::vector<SlotSpec> periodic(std::uint64_t from, std::uint64_t to) {
  std::vector<SlotSpec> all;
  for (std::uint64_t subject = from; subject < to; ++subject) all.push_back(periodic(subject));
  return all;
}

class EtherWatches : public EtherTableTest {
 protected:
  EtherWatches() : EtherTableTest(EtherSizes::for_slots(10'000, 2)) {}
  std::uint16_t watch_of(const SlotSpec& s) { return table_.watch_of(table_.find(s).value()); }
};

TEST_F(EtherWatches, SayWhoseEventsTheyAre) {
  ASSERT_TRUE(add({slot(1), periodic(2)}));
  EXPECT_EQ(watch_of(slot(1)), 0U);
  const auto watch = watch_of(periodic(2));
  ASSERT_NE(watch, 0U);
  EXPECT_EQ(watches_[watch].slot, table_.find(periodic(2)));
  EXPECT_GT(head_.watches_end, watch);
  EXPECT_EQ(present(), (std::vector{slot(1), periodic(2)}));
  EXPECT_EQ(table_.take_newly_watched(), std::vector{watch});
  EXPECT_TRUE(table_.take_newly_watched().empty());
}

TEST_F(EtherWatches, OfSlotsThatDoNotPassAreNotSupervised) {
  SlotSpec refused = periodic(1);
  refused.pass = false;
  ASSERT_TRUE(add({refused}));
  EXPECT_TRUE(table_.take_newly_watched().empty());
  SlotChanges opening;
  opening.open = {refused};
  ASSERT_TRUE(table_.apply(opening));
  EXPECT_EQ(table_.take_newly_watched(), std::vector{watch_of(refused)});
  EXPECT_EQ(table_.watched(), std::vector{watch_of(refused)});
  SlotChanges closing;
  closing.close = {refused};
  ASSERT_TRUE(table_.apply(closing));
  EXPECT_TRUE(table_.watched().empty());
}

TEST_F(EtherWatches, WhoComesLaterThanTheLastOneIsAdmittedAndNotWatched) {
  ASSERT_TRUE(add(periodic(1, ETHER_WATCHES)));
  EXPECT_EQ(table_.unwatched(), 0U) << "4095 are";
  ASSERT_TRUE(add({periodic(5000), periodic(5001)}));
  EXPECT_EQ(table_.unwatched(), 2U);
  EXPECT_EQ(watch_of(periodic(5000)), 0U);
  EXPECT_TRUE(passes(periodic(5000)));
  ASSERT_TRUE(remove({periodic(5000)}));
  EXPECT_EQ(table_.unwatched(), 1U) << "who goes does not wait any more";
}

TEST_F(EtherWatches, WhoWaitsTakesTheOneThatAnotherLeaves) {
  ASSERT_TRUE(add(periodic(1, ETHER_WATCHES)));
  SlotSpec late = periodic(5000);
  ASSERT_TRUE(add({late}));
  SlotChanges police;  // it waits on, with another Period
  late.period *= 3;
  late.silence = 4 * late.period;
  late.together = 5;
  police.police = {late};
  ASSERT_TRUE(table_.apply(police));
  EXPECT_EQ(table_.unwatched(), 1U);
  static_cast<void>(table_.take_newly_watched());

  const auto left = watch_of(periodic(7));
  ASSERT_TRUE(remove({periodic(7)}));
  EXPECT_EQ(waits_, 1) << "a program may still write to it";
  EXPECT_EQ(table_.unwatched(), 0U);
  EXPECT_EQ(watch_of(late), left);
  EXPECT_EQ(std::ranges::count(present(), late), 1) << "with the last Period that was said";
  EXPECT_EQ(table_.take_newly_watched(), std::vector{left}) << "its timer is to start";
}

TEST_F(EtherWatches, AnotherDaemonGoesOnWithWhatWasFound) {
  ASSERT_TRUE(add({periodic(1), periodic(2)}));
  const auto first = watch_of(periodic(1));
  watches_[first].missing = 17;
  table_ = open(false).value();
  EXPECT_EQ(present(), (std::vector{periodic(1), periodic(2)}));
  EXPECT_EQ(watch_of(periodic(1)), first);
  EXPECT_EQ(table_.watched().size(), 2U);
  ASSERT_TRUE(add({periodic(3)}));
  EXPECT_EQ(watches_[first].missing, 17U);
  EXPECT_NE(watch_of(periodic(3)), first);
  watches_[first].slot = 99;
  EXPECT_NE(open(false).error().text.find("is of another"), std::string::npos);
}

}  // namespace
}  // namespace mlcca::gates
