// SPDX-License-Identifier: BSD-2-Clause
// The slot table on plain memory: no kernel, no root.
#include <cstring>
#include <random>

#include "daemon/gates/counters.hpp"
#include "tests/daemon/gates/slots_fixture.hpp"

namespace mlcca::gates {
namespace {

TEST_F(Slots, FreshTableIsEmpty) {
  const auto slots = read();
  EXPECT_EQ(slots.size(), 0U);
  EXPECT_TRUE(slots.present().empty());
}

TEST_F(Slots, PresentGivesBackWhatWasAdded) {
  auto slots = read();
  auto full = raw(CAN_EFF_FLAG | 0x1fffffff, 9);
  full.direction = Direction::ingress;
  full.max_len = 64;
  full.formats = GATE_FD;
  full.origin = 0x7fffffff;
  full.subject = 0xa4efeccc3210b497;
  const std::vector specs = {raw(0), raw(0x7ff, 7), refused(raw(0x123)), full};
  ASSERT_TRUE(slots.apply(adding(specs)));
  EXPECT_EQ(sorted(slots.present()), sorted(specs));
}

TEST_F(Slots, RestartReadsTheSameSlots) {
  std::vector<SlotSpec> specs;
  for (std::uint32_t i = 0; i < 300; ++i) specs.push_back(raw(i * 5 % 2048, i % 3));
  for (std::uint32_t i = 0; i < 300; ++i) specs.push_back(raw(CAN_EFF_FLAG | i * 7919));
  auto before = read();
  ASSERT_TRUE(before.apply(adding(specs)));
  const auto after = read(false);
  EXPECT_EQ(after.present(), before.present());
  EXPECT_EQ(after.size(), specs.size());
}

TEST_F(Slots, NewSlotIsLinkedAndOpenedOnlyWhenItPasses) {
  auto slots = read();
  ASSERT_TRUE(slots.apply(adding({raw(0x10), refused(raw(0x11))})));
  EXPECT_EQ(verdict_of(memory_->head[GATE_EGRESS][0x10]), unsigned{GATE_PASS});
  EXPECT_EQ(verdict_of(memory_->head[GATE_EGRESS][0x11]), unsigned{GATE_DENY});
  EXPECT_EQ(memory_->head[GATE_INGRESS][0x10], 0);
}

TEST_F(Slots, FlipChangesNothingButTheVerdict) {
  auto slots = read();
  ASSERT_TRUE(slots.apply(adding({raw(0x10), raw(0x10, 3)})));
  const gate_table before = *memory_;
  SlotChanges close;
  close.close = {raw(0x10)};
  ASSERT_TRUE(slots.apply(close));
  const auto slot = slots.find(raw(0x10)).value();
  EXPECT_EQ(verdict_of(slot), unsigned{GATE_DENY});
  SlotChanges open;
  open.open = {raw(0x10)};
  ASSERT_TRUE(slots.apply(open));
  EXPECT_GE(memory_->watches[slot].since, before.watches[slot].since)
      << "the silence timer restarts";
  memory_->watches[slot].since = before.watches[slot].since;
  EXPECT_EQ(std::memcmp(&before, memory_.get(), sizeof(before)), 0);
}

TEST_F(Slots, AnyNumberOfVerdictsIsOneGeneration) {
  auto slots = read();
  ASSERT_TRUE(slots.apply(adding({raw(1), refused(raw(2)), raw(3)})));
  EXPECT_EQ(generation_, 1U);
  SlotChanges change;
  change.close = {raw(1)};
  change.open = {raw(2)};
  change.remove = {raw(3)};
  change.add = {raw(4)};
  ASSERT_TRUE(slots.apply(change));
  EXPECT_EQ(generation_, 2U);
  EXPECT_EQ(sorted(slots.present()), (std::vector{refused(raw(1)), raw(2), raw(4)}));
}

TEST_F(Slots, GenerationsGoOnWhereTheNumberEnds) {
  generation_ = 0xffffffff;
  auto slots = read();
  ASSERT_TRUE(slots.apply(adding({raw(1)})));
  EXPECT_EQ(generation_, 0U);
  EXPECT_EQ(slots.present(), std::vector{raw(1)});
}

TEST_F(Slots, ChangesOfTwoTablesAreOneGeneration) {
  auto slots = read();
  ASSERT_TRUE(slots.apply(adding({raw(1)})));
  const auto other_memory = std::make_unique<gate_table>();
  auto other = SlotTable::read({*other_memory, {}, generation_}, GATE_PROFILE_RAW, true, nullptr);
  ASSERT_TRUE(other) << other.error().text;
  const auto before = generation_;
  const SlotChanges away = removing({raw(1)});
  const SlotChanges here = adding({raw(2)});
  const std::vector<SlotTable::Change> both = {{&slots, &away}, {&*other, &here}};
  ASSERT_TRUE(SlotTable::apply_together(both));
  EXPECT_EQ(generation_, before + 1);
  EXPECT_TRUE(slots.present().empty());
  EXPECT_EQ(other->present(), std::vector{raw(2)});
}

TEST_F(Slots, OneTableThatRefusesChangesNone) {
  auto slots = read();
  ASSERT_TRUE(slots.apply(adding({raw(1)})));
  const auto other_memory = std::make_unique<gate_table>();
  auto other = SlotTable::read({*other_memory, {}, generation_}, GATE_PROFILE_RAW, true, nullptr);
  const auto before = generation_;
  const SlotChanges away = removing({raw(1)});
  const std::vector<SlotTable::Change> both = {{&slots, &away}, {&*other, &away}};
  const auto done = SlotTable::apply_together(both);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().change, 1U);
  EXPECT_EQ(generation_, before);
  EXPECT_EQ(slots.present(), std::vector{raw(1)});
}

TEST_F(Slots, StepThatAFormerDaemonDidNotFinishIsUndone) {
  {
    auto slots = read();
    ASSERT_TRUE(slots.apply(adding({raw(1), refused(raw(2))})));
  }
  for (const std::uint32_t id : {1U, 2U})
    memory_->slots[memory_->head[GATE_EGRESS][id]].verdict[(generation_ + 1) & 1] ^= 1;
  auto slots = read(false);
  EXPECT_EQ(sorted(slots.present()), (std::vector{raw(1), refused(raw(2))}));
  ASSERT_TRUE(slots.apply(adding({raw(3)})));
  EXPECT_EQ(sorted(slots.present()), (std::vector{raw(1), refused(raw(2)), raw(3)}));
}

TEST_F(Slots, RemovalKeepsTheRestOfTheChain) {
  for (std::size_t gone = 0; gone < 3; ++gone) {
    *memory_ = {};
    auto slots = read();
    std::vector specs = {raw(0x10, 1), raw(0x10, 2), raw(0x10, 3)};
    ASSERT_TRUE(slots.apply(adding(specs)));
    const auto slot = slots.find(specs[gone]).value();
    const auto next = memory_->slots[slot].next;
    ASSERT_TRUE(slots.apply(removing({specs[gone]})));
    EXPECT_FALSE(slots.find(specs[gone]));
    EXPECT_EQ(verdict_of(slot), unsigned{GATE_DENY});
    EXPECT_EQ(memory_->slots[slot].next, next) << "a program that stands on it must find the rest";
    specs.erase(specs.begin() + static_cast<std::ptrdiff_t>(gone));
    EXPECT_EQ(sorted(slots.present()), sorted(specs));
  }
}

TEST_F(Slots, RemovedSlotsAreReusedOnlyAfterAGracePeriod) {
  auto slots = read();
  std::vector<SlotSpec> all;
  for (std::uint32_t i = 0; i < GATE_SLOTS - GATE_FIRST_SLOT; ++i) all.push_back(raw(i / 2, i % 2));
  ASSERT_TRUE(slots.apply(adding(all)));
  ASSERT_TRUE(slots.apply(removing({all[0], all[1]})));
  EXPECT_EQ(waits_, 0);
  ASSERT_TRUE(slots.apply(adding({raw(0x7ff, 5)})));
  EXPECT_EQ(waits_, 1);
  ASSERT_TRUE(slots.apply(adding({raw(0x7ff, 6)})));
  EXPECT_EQ(waits_, 1);
}

TEST_F(Slots, FreeSlotsOfARunningGateWaitForAGracePeriod) {
  read();
  auto slots = read(false);
  ASSERT_TRUE(slots.apply(adding({raw(1)})));
  EXPECT_EQ(waits_, 1);
}

TEST_F(Slots, FailedGracePeriodAddsNothing) {
  read();
  auto slots = read(false);
  wait_result_ = fail("no grace");
  EXPECT_EQ(error(slots, adding({raw(1)})), "no grace");
}

TEST_F(Slots, ReusedSlotCountsFromZero) {
  auto slots = read();
  ASSERT_TRUE(slots.apply(adding({raw(1)})));
  const auto first = slots.find(raw(1)).value();
  cpus_[1].slots[first] = {.passed = 5, .dropped = 6, .bytes = 7, .excess = 8};
  memory_->audit[first] = {.would_drop = 3, .would_exceed = 1};
  memory_->last_reason[first] = GATE_R_LENGTH;
  ASSERT_TRUE(slots.apply(removing({raw(1)})));
  for (std::uint32_t i = 0; i < 2047; ++i) ASSERT_TRUE(slots.apply(adding({raw(i, 1), raw(i, 2)})));
  ASSERT_EQ(slots.size(), std::size_t{GATE_SLOTS - GATE_FIRST_SLOT});
  const auto count = slot_counters(*memory_, {cpus_.get(), 2}, first);
  EXPECT_EQ(count.passed + count.dropped + count.bytes, 0U);
  EXPECT_EQ(count.would_drop + count.would_exceed, 0U);
  EXPECT_EQ(count.last_reason, core::FrameReason::passed);
}

TEST_F(Slots, ChangesOfAbsentSlotsAreRefused) {
  auto slots = read();
  ASSERT_TRUE(slots.apply(adding({raw(1)})));
  EXPECT_NE(error(slots, adding({raw(1)})), "");
  EXPECT_NE(error(slots, adding({refused(raw(1))})), "") << "the verdict does not make it another";
  EXPECT_NE(error(slots, removing({raw(2)})), "");
  EXPECT_NE(error(slots, removing({raw(1), raw(1)})), "");
  SlotChanges close;
  close.close = {raw(1), raw(2)};
  EXPECT_NE(error(slots, close), "");
  SlotChanges open;
  open.open = {raw(2)};
  EXPECT_NE(error(slots, open), "");
  auto both = removing({raw(1)});
  both.open = {raw(1)};
  EXPECT_NE(error(slots, both), "");
}

TEST_F(Slots, DenyAllKeepsTheSlots) {
  auto slots = read();
  ASSERT_TRUE(slots.apply(adding({raw(1), raw(2), refused(raw(3))})));
  slots.deny_all();
  EXPECT_EQ(sorted(slots.present()),
            (std::vector{refused(raw(1)), refused(raw(2)), refused(raw(3))}));
}

TEST_F(Slots, DamagedTablesAreNotRead) {
  const auto bad = [this](std::uint32_t profile = GATE_PROFILE_RAW) {
    return !SlotTable::read({*memory_, {cpus_.get(), 2}, generation_}, profile, false, nullptr)
                .has_value();
  };
  EXPECT_TRUE(bad()) << "no layout version";
  {
    auto slots = read();
    ASSERT_TRUE(slots.apply(adding({raw(1), raw(1, 5), raw(2)})));
  }
  EXPECT_FALSE(bad());
  EXPECT_TRUE(bad(GATE_PROFILE_FAMOUSO));
  const gate_table good = *memory_;
  memory_->slots[memory_->head[GATE_EGRESS][2]].next = memory_->head[GATE_EGRESS][1];
  EXPECT_TRUE(bad()) << "two chains meet";
  *memory_ = good;
  memory_->slots[memory_->head[GATE_EGRESS][2]].next = memory_->head[GATE_EGRESS][2];
  EXPECT_TRUE(bad()) << "a circle";
  *memory_ = good;
  memory_->head[GATE_EGRESS][7] = GATE_SLOTS;
  EXPECT_TRUE(bad()) << "no such slot";
  *memory_ = good;
  memory_->head[GATE_EGRESS][7] = 1;
  EXPECT_TRUE(bad()) << "a counting slot";
  *memory_ = good;
  memory_->layout_version = GATE_LAYOUT_VERSION + 1;
  EXPECT_TRUE(bad());
}

TEST(Difference, OfEqualStatesIsNothing) {
  const std::vector specs = {raw(1), refused(raw(2))};
  EXPECT_TRUE(slot_changes_between(specs, specs).empty());
}

TEST(Difference, NamesOnlyWhatChanges) {
  const std::vector present = {raw(1), refused(raw(2)), raw(3), raw(4)};
  const std::vector wanted = {refused(raw(1)), raw(2), raw(3), raw(5)};
  const auto changes = slot_changes_between(present, wanted);
  EXPECT_EQ(changes.close, std::vector{raw(1)});
  EXPECT_EQ(changes.open, std::vector{refused(raw(2))});
  EXPECT_EQ(changes.remove, std::vector{raw(4)});
  EXPECT_EQ(changes.add, std::vector{raw(5)});
}

/// Whether or not something comes in its place.
TEST_F(Slots, WhatGoesIsDeniedInTheStepInWhichWhatComesOpens) {
  auto slots = read();
  ASSERT_TRUE(slots.apply(adding({raw(1), raw(2)})));
  const std::uint32_t before = generation_;
  const auto gone = slots.find(raw(2)).value();
  auto longer = raw(1);
  longer.max_len = 64;
  const auto former = slots.find(raw(1)).value();
  ASSERT_TRUE(slots.apply(slot_changes_between(slots.present(), std::vector{longer, raw(3)})));
  EXPECT_EQ(generation_, before + 1) << "one step";
  for (const auto slot : {gone, former}) EXPECT_EQ(verdict_of(slot), unsigned{GATE_DENY});
  EXPECT_EQ(verdict_of(slots.find(longer).value()), unsigned{GATE_PASS});
  EXPECT_EQ(slots.size(), 2U);
}

TEST(Difference, PublishersWithOneGrantShareASlotThatPassesForEither) {
  const auto changes =
      slot_changes_between({}, std::vector{refused(raw(1)), raw(1), refused(raw(1))});
  EXPECT_EQ(changes.add, std::vector{raw(1)});
}

TEST_F(Slots, RandomStatesAreReachedFromOneAnother) {
  std::mt19937 random(7);
  const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
  auto slots = read();
  for (int round = 0; round < 300; ++round) {
    std::vector<SlotSpec> wanted;
    for (std::uint32_t i = below(60); i > 0; --i) {
      auto s = raw(below(2) == 0 ? below(8) : CAN_EFF_FLAG | below(8), below(6));
      s.pass = below(3) != 0;
      if (std::ranges::none_of(wanted, [&](const auto& t) { return t.same_grant(s); }))
        wanted.push_back(s);
    }
    ASSERT_TRUE(slots.apply(slot_changes_between(slots.present(), wanted))) << round;
    ASSERT_EQ(sorted(slots.present()), sorted(wanted));
    ASSERT_EQ(read(false).present(), slots.present());
  }
}

}  // namespace
}  // namespace mlcca::gates
