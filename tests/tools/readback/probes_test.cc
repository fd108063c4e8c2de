// SPDX-License-Identifier: BSD-2-Clause
// Which frames are sent through copies of gates, and what must become of them.
#include "tools/readback/probes.hpp"

#include <gtest/gtest.h>
#include <linux/can.h>

#include <algorithm>

namespace mlcca::readback {
namespace {

using gates::Direction;
using gates::GateReading;
using gates::SlotSpec;
using Way = Probe::Way;

constexpr std::uint32_t kAll = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_SFF_MASK;

SlotSpec slot(std::uint32_t id, std::uint64_t subject, bool pass = true) {
  SlotSpec s;
  s.id = id;
  s.mask = kAll;
  s.subject = subject;
  s.pass = pass;
  s.max_len = 4;
  return s;
}
SlotSpec out(SlotSpec s, std::uint32_t source) {
  s.direction = Direction::egress;
  s.source = source;
  return s;
}
GateReading gate(std::uint32_t ifindex, std::vector<SlotSpec> slots) {
  GateReading g;
  g.ifindex = ifindex;
  g.profile = GATE_PROFILE_RAW;
  g.slots = std::move(slots);
  return g;
}
bool admitted(const Probe& probe, const GateReading& g) { return is_admitted(probe, g, {&g, 1}); }

bool has(const Probes& probes, const Probe& probe) {
  return std::ranges::find(probes.frames, probe) != probes.frames.end();
}

TEST(Probes, OfASlotAreAFrameThatFitsAndALongerOne) {
  const auto g = gate(3, {slot(0x123, 1)});
  const auto probes = probes_for(g);
  EXPECT_TRUE(has(probes, {.id = 0x123, .len = 4}));
  EXPECT_TRUE(has(probes, {.id = 0x123, .len = 5}));
  EXPECT_TRUE(admitted({.id = 0x123, .len = 4}, g));
  EXPECT_FALSE(admitted({.id = 0x123, .len = 5}, g));
  EXPECT_EQ(probes.untried, 0U);
}

TEST(Probes, EveryGateIsProbedWithAFrameWithoutASlot) {
  std::vector<SlotSpec> slots;
  for (std::uint32_t id = 0x6a0; id < 0x6b0; ++id) slots.push_back(slot(id, id));
  const auto g = gate(3, slots);
  const auto probes = probes_for(g);
  const auto unknown = std::ranges::count_if(probes.frames, [&](const Probe& p) {
    return std::ranges::find(g.slots, p.id, &SlotSpec::id) == g.slots.end();
  });
  EXPECT_EQ(unknown, 2);
  EXPECT_TRUE(has(probes, {.id = 0x6b0, .len = 1}));
}

TEST(Probes, OfFdSlotsHaveALengthThatCanFdHas) {
  auto s = slot(0x123, 1);
  s.formats = GATE_FD;
  for (const auto& [most, len] : {std::pair{5, 5}, {8, 8}, {11, 8}, {12, 12}, {63, 48}, {64, 64}}) {
    s.max_len = static_cast<std::uint16_t>(most);
    EXPECT_TRUE(has(probes_for(gate(3, {s})),
                    {.id = 0x123, .len = static_cast<std::uint16_t>(len), .fd = true}))
        << most;
  }
}

TEST(Probes, CanXlAndWhatTheKernelSendsAreOutOfReach) {
  auto xl = slot(0x123, 1);
  xl.formats = GATE_XL;
  EXPECT_EQ(probes_for(gate(3, {xl, out(slot(0x124, 2), GATE_NO_SOURCE)})).untried, 2U);
}

TEST(Probes, ARefusedSlotAdmitsNothingAndOfTwoOneIsEnough) {
  const Probe probe{.id = 0x123, .len = 1};
  EXPECT_FALSE(admitted(probe, gate(3, {slot(0x123, 1, false)})));
  EXPECT_TRUE(admitted(probe, gate(3, {slot(0x123, 1, false), slot(0x123, 1)})));
}

TEST(Probes, WhatIsRefusedByNameIsNotAdmittedByAMask) {
  auto range = slot(0x120, 2);
  range.mask = kAll & ~0xfU;
  const auto g = gate(3, {range, slot(0x123, 1, false)});
  EXPECT_FALSE(admitted({.id = 0x123, .len = 1}, g));
  EXPECT_TRUE(admitted({.id = 0x124, .len = 1}, g));
  EXPECT_FALSE(admitted({.id = 0x134, .len = 1}, g));
}

TEST(Probes, OfAUserAreSentByThatUser) {
  auto s = out(slot(0x123, 1), 0);
  s.uid = 1000;
  const auto g = gate(3, {s});
  EXPECT_TRUE(has(probes_for(g), {.way = Way::out, .id = 0x123, .len = 4, .uid = 1000}));
  EXPECT_TRUE(admitted({.way = Way::out, .id = 0x123, .len = 4, .uid = 1000}, g));
  EXPECT_FALSE(admitted({.way = Way::out, .id = 0x123, .len = 4, .uid = 1001}, g));
}

TEST(Probes, WhatIsForwardedMustEnterAsTheSameSubject) {
  const Probe probe{.way = Way::through, .id = 0x123, .len = 1, .source = 3};
  const auto leaving = gate(4, {out(slot(0x123, 1), 3)});
  const auto verdict = [&](const GateReading& entering) {
    const std::vector<GateReading> all{entering, leaving};
    return is_admitted(probe, leaving, all);
  };
  EXPECT_TRUE(verdict(gate(3, {slot(0x123, 1)})));
  EXPECT_FALSE(verdict(gate(3, {slot(0x123, 2)}))) << "another subject";
  SlotSpec other = slot(0x123, 1);
  other.origin = 9;
  EXPECT_FALSE(verdict(gate(3, {other}))) << "another publisher";
  EXPECT_FALSE(verdict(gate(3, {slot(0x123, 1, false)}))) << "refused there";
  EXPECT_FALSE(verdict(gate(5, {slot(0x123, 1)}))) << "another interface";
}

TEST(Probes, WhatEntersByAnotherIdentifierIsKnown) {
  const Probe probe{.way = Way::through, .id = 0x123, .len = 1, .source = 3};
  const auto leaving = gate(4, {out(slot(0x123, 1), 3)});
  const auto verdict = [&](const GateReading& entering) {
    const std::vector<GateReading> all{entering, leaving};
    return enters_otherwise(probe, leaving, all);
  };
  EXPECT_FALSE(verdict(gate(3, {slot(0x123, 1)})));
  EXPECT_TRUE(verdict(gate(3, {slot(0x321, 1)})));
}

}  // namespace
}  // namespace mlcca::readback
