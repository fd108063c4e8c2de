// SPDX-License-Identifier: BSD-2-Clause
// What of a slot changes in place: the traffic that it admits, and how its events are expected.
#include <gtest/gtest.h>

#include <memory>

#include "daemon/gates/slots.hpp"

namespace mlcca::gates {
namespace {

SlotSpec raw(std::uint32_t id) {
  SlotSpec s;
  s.direction = Direction::egress;
  s.pass = true;
  s.id = id;
  s.mask = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_SFF_MASK;
  s.subject = 1;
  return s;
}

SlotChanges adding(std::vector<SlotSpec> specs) {
  SlotChanges changes;
  changes.add = std::move(specs);
  return changes;
}

class SlotTraffic : public ::testing::Test {
 protected:
  SlotTable read() {
    auto table = SlotTable::read({*memory_, {cpus_.get(), 2}, generation_}, GATE_PROFILE_RAW, true,
                                 [] { return Result<void>{}; });
    EXPECT_TRUE(table) << table.error().text;
    return std::move(*table);
  }

  std::uint32_t generation_ = 0;
  std::unique_ptr<gate_table> memory_ = std::make_unique<gate_table>();
  std::unique_ptr<gate_cpu[]> cpus_ = std::make_unique<gate_cpu[]>(2);
};

SlotSpec policed(SlotSpec s, std::uint64_t per_frame, bool excess_passes = false) {
  s.per_frame = per_frame;
  s.tolerance = per_frame / 2;
  s.excess_passes = excess_passes;
  return s;
}

TEST_F(SlotTraffic, PolicingIsNoPartOfTheGrant) {
  auto slots = read();
  ASSERT_TRUE(slots.apply(adding({policed(raw(1), 10)})));
  EXPECT_EQ(slots.present().front(), policed(raw(1), 10));
  const auto number = slots.find(raw(1));
  ASSERT_TRUE(number);
  memory_->slots[*number].due = 7;

  const std::vector wanted = {policed(raw(1), 20, true)};
  const SlotChanges changes = slot_changes_between(slots.present(), wanted);
  EXPECT_TRUE(changes.add.empty() && changes.remove.empty() && changes.close.empty());
  EXPECT_EQ(changes.police, wanted);
  ASSERT_TRUE(slots.apply(changes));
  EXPECT_EQ(slots.present(), wanted);
  EXPECT_EQ(slots.find(raw(1)), number) << "the same slot, with what it has counted";
  EXPECT_EQ(memory_->slots[*number].due, 0U) << "turns at the former rate do not count";
  EXPECT_TRUE(slot_changes_between(slots.present(), wanted).empty());

  memory_->slots[*number].due = 7;
  ASSERT_TRUE(slots.apply(slot_changes_between(slots.present(), std::vector{policed(raw(1), 20)})));
  EXPECT_EQ(memory_->slots[*number].due, 7U) << "the same rate";
  SlotChanges of_nobody;
  of_nobody.police = {raw(2)};
  EXPECT_FALSE(slots.apply(of_nobody));
}

SlotSpec watched(SlotSpec s, std::uint64_t silence) {
  s.period = 50;
  s.silence = silence;
  return s;
}

TEST_F(SlotTraffic, KnowsWhichSlotsToWatchFromNowOn) {
  using Numbers = std::vector<std::uint16_t>;
  auto slots = read();
  auto closed = watched(raw(3), 70);
  closed.pass = false;
  ASSERT_TRUE(slots.apply(adding({watched(raw(1), 70), watched(raw(2), 0), closed})));
  EXPECT_EQ(slots.present().front(), watched(raw(1), 70));
  const std::uint16_t first = slots.watch_of(slots.find(raw(1)).value());
  EXPECT_EQ(slots.watched(), Numbers{first});
  EXPECT_EQ(slots.take_newly_watched(), Numbers{first});
  EXPECT_TRUE(slots.take_newly_watched().empty());

  memory_->watches[first].last = 7;
  SlotChanges changes;
  changes.police = {watched(raw(1), 80)};
  changes.open = {closed};
  ASSERT_TRUE(slots.apply(changes));
  EXPECT_EQ(memory_->watches[first].last, 7U) << "it goes on";
  EXPECT_EQ(slots.take_newly_watched().size(), 2U);

  // Closed and opened again it starts at 0.
  SlotChanges close;
  SlotChanges open;
  close.close = open.open = {raw(1)};
  ASSERT_TRUE(slots.apply(close));
  EXPECT_TRUE(slots.take_newly_watched().empty());
  ASSERT_TRUE(slots.apply(open));
  EXPECT_EQ(memory_->watches[first].last, 0U);
  EXPECT_EQ(slots.take_newly_watched(), Numbers{first});
}

}  // namespace
}  // namespace mlcca::gates
