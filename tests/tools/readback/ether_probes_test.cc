// SPDX-License-Identifier: BSD-2-Clause
// Which datagrams are sent through copies of Ethernet gates, and what must become of them.
#include "tools/readback/ether_probes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "bpf/ether.h"

namespace mlcca::readback {
namespace {

using gates::Direction;
using gates::GateReading;
using gates::SlotSpec;

SlotSpec slot(std::uint64_t subject, Direction direction = Direction::ingress) {
  SlotSpec s;
  s.subject = subject;
  s.direction = direction;
  s.pass = true;
  s.max_len = 100;
  s.formats = ETHER_UNFRAGMENTED | ETHER_FRAGMENT;
  return s;
}
GateReading gate(std::vector<SlotSpec> slots) {
  GateReading g;
  g.ethernet = true;
  g.slots = std::move(slots);
  return g;
}
/// From 192.0.2.1 where no station is stated.
bool has(const EtherProbes& probes, EtherProbe probe) {
  if (probe.station == 0) probe.station = 0xc0000201;
  return std::ranges::find(probes.probes(), probe) != probes.probes().end();
}

TEST(EtherProbes, OfASlotAreADatagramThatFitsAndALongerOne) {
  const auto g = gate({slot(7)});
  const EtherProbes probes(g);
  EXPECT_TRUE(has(probes, {.subject = 7, .payload = 100}));
  EXPECT_TRUE(has(probes, {.subject = 7, .payload = 101}));
  EXPECT_TRUE(probes.is_admitted({.subject = 7, .payload = 100}));
  EXPECT_FALSE(probes.is_admitted({.subject = 7, .payload = 101}));
  EXPECT_FALSE(probes.is_admitted({.out = true, .subject = 7, .payload = 100}));
  EXPECT_TRUE(probes.untried().empty());
}

TEST(EtherProbes, UnknownSubjectsComeInAndGoOut) {
  // The subject that would be taken first has a slot.
  const auto g = gate({slot(0x6d6c636361000000)});
  const EtherProbes probes(g);
  EXPECT_TRUE(has(probes, {.out = false, .subject = 0x6d6c636361000001}));
  EXPECT_TRUE(has(probes, {.out = true, .subject = 0x6d6c636361000001}));
}

TEST(EtherProbes, OfAStationComeFromItAndFromNoOther) {
  auto s = slot(7);
  s.station = 0xc0000201;  // that would meet the wildcard
  auto wildcard = slot(8);
  wildcard.pass = false;
  const auto g = gate({s, wildcard});
  const EtherProbes probes(g);
  const EtherProbe own{.subject = 7, .payload = 100, .station = 0xc0000201};
  const EtherProbe another{.subject = 7, .payload = 100, .station = 0xc0000202};
  EXPECT_TRUE(has(probes, own));
  EXPECT_TRUE(has(probes, another));
  EXPECT_TRUE(probes.is_admitted(own));
  EXPECT_FALSE(probes.is_admitted(another));
}

TEST(EtherProbes, WhoHasASlotOfHisOwnNeverMeetsTheWildcard) {
  auto own = slot(7);
  own.station = 0xc0000205;
  own.pass = false;
  const auto g = gate({own, slot(7)});
  const EtherProbes probes(g);
  EXPECT_FALSE(probes.is_admitted({.subject = 7, .payload = 1, .station = 0xc0000205}));
  EXPECT_TRUE(probes.is_admitted({.subject = 7, .payload = 1, .station = 0xc0000206}));
}

TEST(EtherProbes, OfAUserAreSentByThatUser) {
  auto s = slot(7, Direction::egress);
  s.uid = 1000;
  const auto g = gate({s});
  const EtherProbes probes(g);
  EXPECT_TRUE(has(probes, {.out = true, .subject = 7, .payload = 100, .uid = 1000}));
  EXPECT_TRUE(probes.is_admitted({.out = true, .subject = 7, .payload = 1, .uid = 1000}));
  EXPECT_FALSE(probes.is_admitted({.out = true, .subject = 7, .payload = 1, .uid = 0}));
}

TEST(EtherProbes, WhatIsForwardedIsOutOfReachAndSaidToBe) {
  auto s = slot(7, Direction::egress);
  s.source = 3;
  const auto g = gate({s});
  EXPECT_EQ(EtherProbes(g).untried().size(), 1U);
}

TEST(EtherProbes, OfManySlotsEveryNthIsTried) {
  for (const std::size_t count : {EtherProbes::kMost, EtherProbes::kMost + 1}) {
    std::vector<SlotSpec> slots;
    for (std::uint64_t s = 1; s <= count; ++s) slots.push_back(slot(s));
    const auto g = gate(std::move(slots));
    const EtherProbes probes(g);
    const bool all = count == EtherProbes::kMost;
    EXPECT_EQ(probes.probes().size(), 2 * (all ? count : (count + 1) / 2) + 2);
    EXPECT_EQ(probes.untried().empty(), all);
  }
}

TEST(EtherProbes, AFrameIsWhatTheGateReads) {
  const auto frame = frame_of({.subject = 0x44697374616e6365, .payload = 3});
  ASSERT_EQ(frame.size(), 14U + 20 + 8 + 9 + 3);
  EXPECT_EQ(frame[14 + 3], 20 + 8 + 9 + 3) << "total length";
  EXPECT_EQ(frame[14 + 20 + 5], 8 + 9 + 3) << "UDP length";
  EXPECT_EQ(std::string(frame.begin() + 42, frame.begin() + 50), "Distance");
}

TEST(EtherProbes, OnWpanAreFramesOfItsStations) {
  auto brief = slot(0x44697374616e6365);
  brief.station = ETHER_SHORT | 0xbeef0002;
  auto extended = slot(8);
  extended.station = ETHER_EXTENDED | 0x0200000000000001;
  auto g = gate({brief, extended});
  g.wpan = true;
  const EtherProbes probes(g);
  const std::uint64_t another = ETHER_SHORT | 0x6d6c0001;
  const EtherProbe fits{.subject = brief.subject, .payload = 100, .station = brief.station};
  EXPECT_TRUE(has(probes, fits));
  EXPECT_TRUE(has(probes, {.subject = brief.subject, .payload = 100, .station = another}));
  EXPECT_TRUE(has(probes, {.subject = 0x6d6c636361000000, .station = another}));
  EXPECT_TRUE(has(probes, {.out = true, .subject = 0x6d6c636361000000, .station = another}));
  EXPECT_TRUE(probes.is_admitted(fits));

  auto frame = frame_of(fits);
  EXPECT_EQ(frame.size(), 9U + 8U + 100U);
  frame.resize(17);
  EXPECT_EQ(frame, (std::vector<std::uint8_t>{0x41, 0x88, 0, 0xef, 0xbe, 0xff, 0xff, 2, 0, 0x44,
                                              0x69, 0x73, 0x74, 0x61, 0x6e, 0x63, 0x65}));
  EXPECT_EQ(ethertype_of(fits), 0x7461) << "octets of the subject are where Ethernet has it";
  auto long_frame = frame_of({.subject = 8, .station = extended.station});
  EXPECT_EQ(long_frame,
            (std::vector<std::uint8_t>{0x41, 0xc8, 0, 0x6c, 0x6d, 0xff, 0xff, 1, 0, 0, 0, 0,
                                       0,    0,    2, 0,    0,    0,    0,    0, 0, 0, 8}));
  EXPECT_EQ(ethertype_of({.subject = 8, .station = extended.station}), 4) << "ETH_P_802_2";
  EXPECT_EQ(to_text(fits), "0x44697374616e6365 of 100 bytes from 0xbeef:0x0002");
}

}  // namespace
}  // namespace mlcca::readback
