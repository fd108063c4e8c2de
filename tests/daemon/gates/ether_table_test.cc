// SPDX-License-Identifier: BSD-2-Clause
// The subjects of an interface in plain memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <memory>
#include <random>

#include "daemon/gates/slots.hpp"
#include "tests/daemon/gates/ether_table_fixture.hpp"

namespace mlcca::gates {
namespace {

TEST_F(EtherTableTest, HoldsWhatWasAdded) {
  const std::vector<SlotSpec> both{slot(1), slot(2, false)};
  ASSERT_TRUE(add(both));
  EXPECT_EQ(present(), both);
  EXPECT_TRUE(passes(both[0]));
  EXPECT_FALSE(passes(both[1]));
}

TEST_F(EtherTableTest, SlotsOfOneContractShareIt) {
  ASSERT_TRUE(add({slot(1), slot(2)}));
  const auto contract = [&](const SlotSpec& s) { return slots_[table_.find(s).value()].contract; };
  EXPECT_EQ(contract(slot(1)), contract(slot(2)));
  SlotChanges police;
  SlotSpec slower = slot(2);
  slower.per_frame = 5;
  police.police = {slower};
  ASSERT_TRUE(table_.apply(police));
  EXPECT_NE(contract(slot(1)), contract(slot(2)));
  EXPECT_EQ(present(), (std::vector{slot(1), slower}));
}

TEST_F(EtherTableTest, AnotherDaemonFindsItAsItWas) {
  SlotSpec policed = slot(3);
  policed.per_byte = 7;
  policed.tolerance = 9;
  policed.excess_passes = true;
  policed.direction = Direction::egress;
  policed.source = 4;
  const std::vector<SlotSpec> all{slot(1), slot(2, false), policed};
  ASSERT_TRUE(add(all));
  table_ = open(false).value();
  EXPECT_EQ(present(), all);
  ASSERT_TRUE(add({slot(5)}));
  EXPECT_EQ(waits_, 1) << "what the one before has removed lately is not known";
  ASSERT_TRUE(remove(all));
  EXPECT_EQ(present(), std::vector{slot(5)});
}

/// In the order in which the program meets them.
TEST_F(EtherTableTest, SlotsOfStationsStandBeforeTheWildcard) {
  const auto of = [](std::uint64_t station) {
    SlotSpec s = slot(1);
    s.station = station;
    return s;
  };
  ASSERT_TRUE(add({of(1), of(0)}));
  SlotSpec longer = of(0);
  longer.max_len = 99;
  ASSERT_TRUE(add({of(ETHER_MAC | 0x0100000000), longer, of(2)}));
  const auto chain = table_.present();
  ASSERT_EQ(chain.size(), 5U);
  for (std::size_t i = 0; i < chain.size(); ++i) EXPECT_EQ(chain[i].station != 0, i < 3);
  table_ = open(false).value();
  EXPECT_EQ(table_.present(), chain);
  ASSERT_TRUE(remove({of(2), longer}));
  EXPECT_EQ(present(), (std::vector{of(0), of(1), of(ETHER_MAC | 0x0100000000)}));
}

TEST_F(EtherTableTest, AStationBehindTheWildcardIsRefused) {
  SlotSpec own = slot(1);
  own.station = 7;
  ASSERT_TRUE(add({slot(1), own}));
  std::swap(slots_[table_.find(own).value()].station, slots_[table_.find(slot(1)).value()].station);
  EXPECT_NE(open(false).error().text.find("stands behind others"), std::string::npos);
}

class LargeEtherTable : public EtherTableTest {
 protected:
  LargeEtherTable() : EtherTableTest(EtherSizes::for_slots(ETHER_PREFILTERED_SLOTS, 2)) {}
  [[nodiscard]] std::size_t bits() const {
    std::size_t out = 0;
    for (const ether_prefilter_part& front : prefilters_)
      for (const std::uint8_t octet : front.bits)
        out += static_cast<std::size_t>(std::popcount(octet));
    return out;
  }
};

TEST_F(LargeEtherTable, KnowsInFrontOfItsBucketsWhatIsInThem) {
  EXPECT_FALSE(
      EtherSizes::for_slots(ETHER_PREFILTERED_SLOTS - ETHER_FIRST_SLOT, 2).has_prefilter());
  EXPECT_EQ(prefilters_.size() * ETHER_PREFILTER_BUCKETS, buckets_.size());
  std::vector<SlotSpec> specs;
  for (std::uint64_t subject = 0; subject < 1000; ++subject) specs.push_back(slot(subject));
  ASSERT_TRUE(add(specs));
  EXPECT_GT(bits(), 1000U);
  EXPECT_LE(bits(), 2000U);
  EXPECT_EQ(sorted(open(false).value().present()), specs);
  ASSERT_TRUE(remove({specs.begin() + 1, specs.end()}));
  EXPECT_LE(bits(), 2U);
  ASSERT_TRUE(remove({specs.front()}));
  EXPECT_EQ(bits(), 0U);
}

TEST_F(LargeEtherTable, WithoutTheBitsOfASubjectItIsRefused) {
  ASSERT_TRUE(add({slot(1)}));
  for (ether_prefilter_part& front : prefilters_) front = {};
  EXPECT_NE(open(false).error().text.find("wrong bucket"), std::string::npos);
}

TEST_F(EtherTableTest, AnotherSizeOrLayoutIsRefused) {
  head_.slots = 17;
  EXPECT_EQ(open(false).error().text, "subject table: of another size");
  head_.layout_version = 0;
  EXPECT_NE(open(false).error().text.find("layout 0"), std::string::npos);
}

TEST_F(EtherTableTest, ABrokenChainIsRefused) {
  ASSERT_TRUE(add({slot(1)}));
  slots_[table_.find(slot(1)).value()].next = table_.find(slot(1)).value();
  EXPECT_NE(open(false).error().text.find("broken chain"), std::string::npos);
}

TEST_F(EtherTableTest, WhatIsWrongChangesNothing) {
  ASSERT_TRUE(add({slot(1)}));
  const auto refused = [&](SlotChanges c, const std::string& why) {
    c.close.push_back(slot(1));
    const std::string text = error_of(table_.apply(c));
    EXPECT_NE(text.find(why), std::string::npos) << text;
    EXPECT_EQ(present(), std::vector{slot(1)});
  };
  SlotSpec bad = slot(2);
  bad.formats = 0;
  refused(adding({bad}), "neither unfragmented events nor fragments");
  bad = slot(2);
  bad.id = 1;
  refused(adding({bad}), "no identifier");
  bad = slot(2);
  bad.max_len = ETHER_MAX_PAYLOAD + 1;
  refused(adding({bad}), "at most 8183 bytes");
  bad = slot(2);
  bad.station = 2 * ETHER_SHORT;
  refused(adding({bad}), "no address of a station");
  refused(adding({slot(1)}), "there already");
  refused(adding({slot(2), slot(2)}), "there twice");
  refused(removing({slot(2)}), "is not there");
  SlotChanges both = removing({slot(1)});
  both.open = {slot(1)};
  refused(both, "opened and removed");
  bad = slot(2);
  bad.max_len = ETHER_MAX_PAYLOAD;
  EXPECT_TRUE(add({bad}));
}

TEST_F(EtherTableTest, ASubjectHasSoManyPublishers) {
  std::vector<SlotSpec> publishers;
  for (std::uint32_t uid = 0; uid < ETHER_CHAIN; ++uid) {
    publishers.push_back(slot(1));
    publishers.back().uid = uid;
  }
  ASSERT_TRUE(add(publishers));
  EXPECT_NE(error_of(add({slot(1)})).find("more than 8 publishers"), std::string::npos);
  SlotChanges exchange;
  exchange.add = {slot(1)};
  exchange.remove = {publishers.front()};
  EXPECT_TRUE(table_.apply(exchange));
}

TEST_F(EtherTableTest, TheTableIsFullAtItsLastSlot) {
  std::vector<SlotSpec> all;
  for (std::uint64_t s = 1; s <= sizes_.slots - ETHER_FIRST_SLOT; ++s) all.push_back(slot(s));
  ASSERT_TRUE(add(all));
  EXPECT_NE(error_of(add({slot(0)})).find("more than 4094 slots"), std::string::npos);
  SlotChanges exchange;
  exchange.add = {slot(0)};
  exchange.remove = {slot(1)};
  ASSERT_TRUE(table_.apply(exchange));
  EXPECT_EQ(waits_, 1) << "the slot that went is the only one";
  EXPECT_TRUE(table_.find(slot(0)));
}

TEST_F(EtherTableTest, ContractsRunOut) {
  std::vector<SlotSpec> all;
  for (std::uint64_t s = 1; s < sizes_.contracts - 1; ++s) {
    all.push_back(slot(s));
    all.back().per_frame = s;
  }
  ASSERT_TRUE(add(all));
  SlotChanges police;
  police.police = {all[0], all[1]};
  police.police[0].per_frame = 1'000'000;
  ASSERT_TRUE(table_.apply(police)) << "one is left";
  police.police = {all[2], all[3], all[4]};
  for (auto& s : police.police) s.per_frame += 2'000'000;
  const std::string text = error_of(table_.apply(police));
  EXPECT_NE(text.find("different contracts"), std::string::npos) << text;
}

TEST_F(EtherTableTest, AContractThatGoesMakesRoomForAnother) {
  std::vector<SlotSpec> all;
  for (std::uint64_t s = 1; s < sizes_.contracts; ++s) {
    all.push_back(slot(s % 4000));
    all.back().per_frame = s;
    all.back().uid = static_cast<std::uint32_t>(s / 4000);
  }
  ASSERT_EQ(all.size(), 4095U);
  all.pop_back();  // there is room for 4094 slots
  ASSERT_TRUE(add(all));
  SlotChanges exchange = removing({all[0], all[1]});
  exchange.add = {all[0], all[1]};
  for (auto& s : exchange.add) {
    s.per_frame += 1'000'000;
    s.uid = 77;
  }
  EXPECT_TRUE(table_.apply(exchange)) << "one of them is free, the other becomes it";
  EXPECT_TRUE(passes(exchange.add[1]));
}

TEST_F(EtherTableTest, AnyNumberOfVerdictsIsOneGeneration) {
  ASSERT_TRUE(add({slot(1), slot(2, false), slot(3)}));
  EXPECT_EQ(generation_, 1U);
  SlotChanges change;
  change.close = {slot(1)};
  change.open = {slot(2)};
  change.remove = {slot(3)};
  change.add = {slot(4)};
  ASSERT_TRUE(table_.apply(change));
  EXPECT_EQ(generation_, 2U);
  EXPECT_EQ(present(), (std::vector{slot(1, false), slot(2), slot(4)}));
}

TEST_F(EtherTableTest, AStepThatAFormerDaemonDidNotFinishIsUndone) {
  ASSERT_TRUE(add({slot(1), slot(2, false)}));
  for (const std::uint64_t s : {1, 2})
    slots_[table_.find(slot(s)).value()].verdict[(generation_ + 1) & 1] ^= 1;
  table_ = open(false).value();
  for (const std::uint64_t s : {1, 2}) {
    const auto& halves = slots_[table_.find(slot(s)).value()].verdict;
    EXPECT_EQ(halves[0], halves[1]);
  }
  EXPECT_EQ(present(), (std::vector{slot(1), slot(2, false)}));
}

TEST_F(EtherTableTest, ChangesBesidesACanTableAreOneGeneration) {
  ASSERT_TRUE(add({slot(1)}));
  const auto memory = std::make_unique<gate_table>();
  auto can = SlotTable::read({*memory, {}, generation_}, GATE_PROFILE_RAW, true, nullptr).value();
  SlotSpec raw;
  raw.pass = true;
  raw.id = 5;
  raw.mask = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_SFF_MASK;
  const SlotChanges away = removing({slot(1)});
  const SlotChanges here = adding({raw});
  const auto before = generation_;
  ASSERT_TRUE(VerdictTable::apply_together(
      std::vector<VerdictTable::Change>{{&table_, &away}, {&can, &here}}));
  EXPECT_EQ(generation_, before + 1);
  EXPECT_TRUE(present().empty());
  EXPECT_EQ(can.present(), std::vector{raw});
  // One that refuses changes none.
  const auto refused = VerdictTable::apply_together(
      std::vector<VerdictTable::Change>{{&can, &away}, {&table_, &away}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().change, 0U);
  const SlotChanges again = adding({slot(1)});
  EXPECT_EQ(VerdictTable::apply_together(
                std::vector<VerdictTable::Change>{{&table_, &again}, {&can, &here}})
                .error()
                .change,
            1U);
  EXPECT_EQ(generation_, before + 1);
  EXPECT_TRUE(present().empty());
}

TEST_F(EtherTableTest, WithoutAGracePeriodNothingIsUsedAgain) {
  std::vector<SlotSpec> all;
  for (std::uint64_t s = 1; s <= sizes_.slots - ETHER_FIRST_SLOT; ++s) all.push_back(slot(s));
  ASSERT_TRUE(add(all));
  ASSERT_TRUE(remove({slot(1)}));
  grace_ = false;
  EXPECT_EQ(error_of(add({slot(0)})), "no grace");
  EXPECT_FALSE(table_.find(slot(0)));
  grace_ = true;
  EXPECT_TRUE(add({slot(0)}));
}

TEST_F(EtherTableTest, ThePrefilterHasTheSubjectsOfTheChainAndNoOthers) {
  std::mt19937_64 random(3);
  std::vector<SlotSpec> all;
  for (int i = 0; i < 4000; ++i) all.push_back(slot(random()));
  ASSERT_TRUE(add(all));
  std::ranges::shuffle(all, random);
  ASSERT_TRUE(remove({all.begin() + 100, all.end()}));
  all.resize(100);
  std::vector<std::uint64_t> want(buckets_.size());
  for (const auto& s : all) {
    const std::uint64_t hash = ether_hash(42, s.subject, GATE_INGRESS);
    want[hash & (sizes_.buckets - 1)] |= ether_fingerprint(hash);
  }
  for (std::size_t b = 0; b < buckets_.size(); ++b)
    ASSERT_EQ(buckets_[b] >> 32 << 32, want[b]) << b;
  EXPECT_EQ(present(), sorted(all));
  ASSERT_TRUE(remove(all));
  for (const auto bucket : buckets_) ASSERT_EQ(bucket, 0U);
}

TEST_F(EtherTableTest, CountersOfAReusedSlotBeginAtNothing) {
  ASSERT_TRUE(add({slot(1)}));
  const auto at = table_.find(slot(1)).value();
  for (std::size_t bank = 0; bank < 2; ++bank) counts_[bank * sizes_.slots + at].passed = 5;
  audits_[at] = {.would_drop = 3, .would_exceed = 1};
  ASSERT_TRUE(remove({slot(1)}));
  table_ = open(false).value();
  std::vector<SlotSpec> all;
  for (std::uint64_t s = 1; s <= sizes_.slots - ETHER_FIRST_SLOT; ++s) all.push_back(slot(s));
  ASSERT_TRUE(add(all));
  EXPECT_EQ(counts_[at].passed + counts_[sizes_.slots + at].passed + audits_[at].would_drop, 0U);
}

TEST(EtherSizes, FollowWhatIsNeeded) {
  const auto small = EtherSizes::for_slots(0, 8);
  EXPECT_EQ(small.slots, unsigned{ETHER_MIN_SLOTS});
  EXPECT_EQ(small.banks, 8U);
  const auto banked = EtherSizes::for_slots(ETHER_BANKED_SLOTS - ETHER_FIRST_SLOT, 8);
  EXPECT_EQ(banked.banks, 8U);
  const auto large = EtherSizes::for_slots(ETHER_BANKED_SLOTS - ETHER_FIRST_SLOT + 1, 8);
  EXPECT_EQ(large.banks, 1U);
  EXPECT_EQ(large.buckets, 32768U);
  EXPECT_EQ(EtherSizes::for_slots(10'000'000, 8).slots, unsigned{ETHER_MAX_SLOTS});
}

}  // namespace
}  // namespace mlcca::gates
