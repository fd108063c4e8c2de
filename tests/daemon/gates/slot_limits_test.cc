// SPDX-License-Identifier: BSD-2-Clause
// What a slot table takes and what it refuses: each limit from both sides.
#include "tests/daemon/gates/slots_fixture.hpp"

namespace mlcca::gates {
namespace {

TEST_F(Slots, LimitOfSlotsIsExact) {
  auto slots = read();
  std::vector<SlotSpec> all;
  for (std::uint32_t i = 0; i < GATE_SLOTS - GATE_FIRST_SLOT; ++i) all.push_back(raw(i / 2, i % 2));
  auto more = all;
  more.push_back(raw(0x7ff, 5));
  EXPECT_NE(error(slots, adding(more)).find("more than 4094 slots"), std::string::npos);
  ASSERT_TRUE(slots.apply(adding(all)));
  EXPECT_NE(error(slots, adding({raw(0x7ff, 5)})).find("more than 4094 slots"), std::string::npos);
}

TEST_F(Slots, FullTableIsExchangedAsAWhole) {
  auto slots = read();
  std::vector<SlotSpec> old_slots;
  std::vector<SlotSpec> new_slots;
  for (std::uint32_t i = 0; i < GATE_SLOTS - GATE_FIRST_SLOT; ++i) {
    old_slots.push_back(raw(i / 2, i % 2));
    new_slots.push_back(raw(CAN_EFF_FLAG | i));
  }
  ASSERT_TRUE(slots.apply(adding(old_slots)));
  ASSERT_TRUE(slots.apply(slot_changes_between(slots.present(), new_slots)));
  EXPECT_EQ(sorted(slots.present()), sorted(new_slots));
}

TEST_F(Slots, LimitOfPublishersIsExact) {
  auto slots = read();
  for (std::uint32_t i = 0; i < GATE_CHAIN; ++i)
    ASSERT_TRUE(slots.apply(adding({raw(0x10, i)}))) << i;
  EXPECT_NE(error(slots, adding({raw(0x10, GATE_CHAIN)})).find("more than 16 publishers"),
            std::string::npos);
  ASSERT_TRUE(slots.apply(removing({raw(0x10, 3)})));
  EXPECT_TRUE(slots.apply(adding({raw(0x10, GATE_CHAIN)})));
}

TEST_F(Slots, LimitOfIdentifiersThatFallTogetherIsExact) {
  auto slots = read();
  const auto ids = colliding(GATE_WALK + 1);
  for (std::uint32_t i = 0; i < GATE_WALK; ++i)
    ASSERT_TRUE(slots.apply(adding({raw(ids[i])}))) << i;
  EXPECT_NE(error(slots, adding({raw(ids.back())})).find("more than 32 slots"), std::string::npos);
  auto changes = adding({raw(ids.back())});
  changes.remove = {raw(ids.front())};
  EXPECT_TRUE(slots.apply(changes)) << "room is made first";
}

TEST_F(Slots, PublishersOfEachCollidingIdentifierFit) {
  auto slots = read();
  for (const auto id : colliding(GATE_WALK / GATE_CHAIN))
    for (std::uint32_t i = 0; i < GATE_CHAIN; ++i) ASSERT_TRUE(slots.apply(adding({raw(id, i)})));
}

TEST_F(Slots, FamousoSlotsOfOneEtagShareABucket) {
  auto slots = read(true, GATE_PROFILE_FAMOUSO);
  ASSERT_TRUE(slots.apply(adding({raw(CAN_EFF_FLAG | 5U << 14 | 0x64)})));
  ASSERT_TRUE(slots.apply(adding({raw(CAN_EFF_FLAG | 6U << 14 | 0x64)})));
  EXPECT_NE(memory_->slots[memory_->head[GATE_EGRESS][0x64]].next, 0);
}

SlotSpec masked(std::uint32_t id, std::uint32_t open) {
  auto s = raw(id);
  s.mask &= ~open;
  return s;
}

TEST_F(Slots, MaskedSlotsOutliveARestart) {
  auto slots = read();
  const std::vector specs = {masked(0x120, 0xf), refused(masked(CAN_EFF_FLAG, 0xff)), raw(0x123)};
  ASSERT_TRUE(slots.apply(adding(specs)));
  EXPECT_EQ(sorted(read(false).present()), sorted(specs));
  ASSERT_TRUE(slots.apply(removing({specs[0], specs[1]})));
  EXPECT_EQ(memory_->masked[GATE_EGRESS], 0);
  EXPECT_EQ(slots.present(), std::vector{raw(0x123)});
}

TEST_F(Slots, LimitOfMaskedSlotsIsExact) {
  auto slots = read(true, GATE_PROFILE_CANOPEN);
  for (std::uint32_t i = 0; i < GATE_WALK; ++i)
    ASSERT_TRUE(slots.apply(adding({masked(i << 4, 0xf)}))) << i;
  EXPECT_NE(error(slots, adding({masked(0x700, 0x7f)}))
                .find("more than 32 slots with a mask in one direction"),
            std::string::npos);
  auto in = masked(0x700, 0x7f);
  in.direction = Direction::ingress;
  EXPECT_TRUE(slots.apply(adding({in}))) << "the other direction has a chain of its own";
  ASSERT_TRUE(slots.apply(removing({masked(0x10, 0xf)})));
  EXPECT_TRUE(slots.apply(adding({masked(0x700, 0x7f)})));
}

TEST_F(Slots, DestinationIsNoKeyOfJ1939) {
  auto slots = read(true, GATE_PROFILE_J1939);
  EXPECT_TRUE(slots.apply(adding({masked(CAN_EFF_FLAG | 0x18ee0080, 0xff00)})));
  EXPECT_NE(error(slots, adding({masked(CAN_EFF_FLAG | 0x18f00080, 0xff00)})).find("key open"),
            std::string::npos);
}

struct BadSpec {
  const char* name;
  std::uint32_t profile;
  void (*spoil)(SlotSpec&);
  const char* text;
};

class BadSlots : public Slots, public ::testing::WithParamInterface<BadSpec> {};

TEST_P(BadSlots, AreRefusedWithoutAChange) {
  auto slots = read(true, GetParam().profile);
  auto spec = raw(GetParam().profile == GATE_PROFILE_RAW ? 0x10 : CAN_EFF_FLAG | 0x10);
  auto good = spec;
  good.subject = 2;
  GetParam().spoil(spec);
  const auto text = error(slots, adding({good, spec}));
  EXPECT_NE(text.find(GetParam().text), std::string::npos) << text;
}

INSTANTIATE_TEST_SUITE_P(
    Table, BadSlots,
    ::testing::Values(
        BadSpec{"StandardIdInFamouso", GATE_PROFILE_FAMOUSO, [](auto& s) { s.id = 0x10; },
                "no such identifier"},
        BadSpec{"NoProfile", GATE_PROFILE_NONE, [](auto&) {}, "no such identifier"},
        BadSpec{"BitsOutsideTheMask", GATE_PROFILE_RAW,
                [](auto& s) { s.mask = kStandard & ~0x10U; }, "outside its mask"},
        BadSpec{"FormOpen", GATE_PROFILE_RAW, [](auto& s) { s.mask &= ~CAN_EFF_FLAG; },
                "11 or 29 bits"},
        BadSpec{"EtagBitOpen", GATE_PROFILE_FAMOUSO, [](auto& s) { s.mask &= ~0x2000U; },
                "part of the key"},
        BadSpec{"PgnBitOpen", GATE_PROFILE_J1939, [](auto& s) { s.mask &= ~0x10000U; },
                "part of the key"},
        BadSpec{"SubjectBitOpen", GATE_PROFILE_CYPHAL, [](auto& s) { s.mask &= ~0x100U; },
                "part of the key"},
        BadSpec{"ServiceInCyphal", GATE_PROFILE_CYPHAL, [](auto& s) { s.id |= 1U << 25; },
                "no such identifier"},
        BadSpec{"ExtendedIdInCanopen", GATE_PROFILE_CANOPEN, [](auto&) {}, "no such identifier"},
        BadSpec{"XlWith29Bits", GATE_PROFILE_RAW,
                [](auto& s) { s = raw(CAN_EFF_FLAG | 1), s.formats = GATE_XL; }, "CAN XL has 11"},
        BadSpec{"StandardIdTooLarge", GATE_PROFILE_RAW,
                [](auto& s) { s.id = 0x800, s.mask = kExtended; }, "at most 0x7ff"},
        BadSpec{"ErrorFrame", GATE_PROFILE_RAW,
                [](auto& s) { s.id |= CAN_ERR_FLAG, s.mask |= CAN_ERR_FLAG; }, "error frames"},
        BadSpec{"NoFormat", GATE_PROFILE_RAW, [](auto& s) { s.formats = 0; }, "neither classic"},
        BadSpec{"UnknownFormat", GATE_PROFILE_RAW, [](auto& s) { s.formats = 4; },
                "neither classic"},
        BadSpec{"TransportOfAnotherProfile", GATE_PROFILE_RAW,
                [](auto& s) { s.formats = GATE_CLASSIC | GATE_TRANSPORT; }, "is of J1939"},
        BadSpec{"TransportAlone", GATE_PROFILE_J1939, [](auto& s) { s.formats = GATE_TRANSPORT; },
                "neither classic"},
        BadSpec{"TransportInFdFrames", GATE_PROFILE_J1939,
                [](auto& s) { s.formats = GATE_FD | GATE_TRANSPORT; }, "in classic frames"},
        BadSpec{"NoIfindexAsSource", GATE_PROFILE_RAW, [](auto& s) { s.source = 0x80000000; },
                "no interface"},
        BadSpec{"NoOriginAsOrigin", GATE_PROFILE_RAW,
                [](auto& s) { s.source = 9, s.origin = 0x80000000; }, "no origin"},
        BadSpec{"ProgramWithOrigin", GATE_PROFILE_RAW, [](auto& s) { s.origin = 1; },
                "programs have users"},
        BadSpec{"InterfaceWithUser", GATE_PROFILE_RAW, [](auto& s) { s.source = 9, s.uid = 0; },
                "programs have users"},
        BadSpec{"TheSameTwice", GATE_PROFILE_RAW, [](auto& s) { s.subject = 2; }, "there already"}),
    [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace mlcca::gates
