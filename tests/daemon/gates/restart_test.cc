// SPDX-License-Identifier: BSD-2-Clause
// The gate across restarts, replacements and crashes: slots and verdicts stay, nothing stale
// passes.
#include <gtest/gtest.h>

#include "daemon/gates/gate.hpp"
#include "daemon/gates/interfaces.hpp"
#include "daemon/gates/interrupted.hpp"
#include "tests/daemon/gates/attach_fixture.hpp"

namespace mlcca::gates {
namespace {

TEST_P(Attach, RestartFindsSlotsVerdictsAndCounts) {
  const Bus bus("bus0");
  auto refused = in(0x200);
  refused.pass = false;
  std::vector<SlotSpec> before;
  {
    auto gate = attach(bus);
    admit(gate, {in(0x123), refused});
    bus.inject(frame(0x123));
    before = gate.present();
  }
  bus.inject(frame(0x123));  // no daemon runs
  auto gate = attach(bus);
  EXPECT_TRUE(gate.reused());
  EXPECT_TRUE(gate.attached().value());
  EXPECT_EQ(gate.present(), before);
  expect_passed(gate, in(0x123), 2);
  bus.inject(frame(0x123));
  bus.inject(frame(0x200));
  expect_passed(gate, in(0x123), 3);
  expect_dropped(gate, refused, 1);
}

/// As a daemon leaves it that dies before it steps to the next generation.
void write_next(const std::string& directory, std::uint32_t generation, gate_verdict verdict) {
  const Fd map(bpf_obj_get((directory + "/table").c_str()));
  const Mapped<gate_table> table(map.get(), 1);
  table[0].slots[GATE_FIRST_SLOT].verdict[(generation + 1) & 1] = verdict;
}

TEST_P(Attach, WhatWasWrittenForAStepThatNeverCameIsTakenBack) {
  const Bus bus("bus0");
  const Bus undescribed("bus1");
  auto refused = in(0x123);
  refused.pass = false;
  {
    auto gate = attach(bus);
    attach(undescribed);
    admit(gate, {refused});
    const Mapped<gate_control> word(control_.map_fd(), 1);
    write_next(pins(bus), word[0].generation, GATE_PASS);
  }
  ASSERT_TRUE(undo_interrupted_step(control_));
  // The next daemon closes what is not described any more before it takes over the other gate.
  attach(undescribed).deny_all();
  bus.inject(frame(0x123));
  auto gate = attach(bus);
  expect_dropped(gate, refused, 1);
}

TEST_P(Attach, ReplacementUnderTrafficLosesAndLeaksNothing) {
  const Bus bus("bus0");
  auto first = attach(bus);
  admit(first, {in(0x123)});
  Traffic traffic(bus, first, {0x123, 0x124});
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(attach(bus).reused());
  const auto sent = traffic.stop();
  const auto gate = attach(bus);
  EXPECT_GT(sent, 1000U);
  expect_passed(gate, in(0x123), sent);
  expect_dropped(gate, in(0x123), 0);
  expect_ingress(gate, GATE_R_UNKNOWN, sent);
}

TEST_P(Attach, VerdictsFlipUnderTrafficAndEveryFrameIsCounted) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123), in(0x124)});
  Traffic traffic(bus, gate, {0x123, 0x124});
  SlotChanges close;
  SlotChanges open;
  close.close = open.open = {in(0x124)};
  for (int i = 0; i < 20'000; ++i) {
    ASSERT_TRUE(gate.apply(close));
    ASSERT_TRUE(gate.apply(open));
  }
  const auto sent = traffic.stop();
  expect_passed(gate, in(0x123), sent);
  EXPECT_EQ(eventually(2 * sent, [&] { return seen(gate); }), 2 * sent);
  const auto flipped = gate.counters(in(0x124)).value();
  EXPECT_EQ(flipped.passed + flipped.dropped, sent);
  EXPECT_EQ(flipped.bytes, 8 * flipped.passed);
}

TEST_P(Attach, SlotsComeAndGoUnderTrafficOfOthers) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  auto narrow = in(0x123);
  narrow.max_len = 4;
  admit(gate, {in(0x123)});
  Traffic traffic(bus, gate, {0x123});
  // Neighbours in the same chain, so that the program walks over slots that go.
  SlotChanges add;
  SlotChanges remove;
  add.add = remove.remove = {narrow};
  for (int i = 0; i < 20'000; ++i) {
    ASSERT_TRUE(gate.apply(add));
    ASSERT_TRUE(gate.apply(remove));
  }
  expect_passed(gate, in(0x123), traffic.stop());
}

TEST_P(Attach, PinsOfAVanishedDeviceAreNotUsedForItsSuccessor) {
  constexpr std::uint32_t kIfindex = 4000;
  {
    const Bus bus("bus0", kIfindex);
    auto gate = attach(bus);
    admit(gate, {in(0x123)});
  }
  ASSERT_TRUE(std::filesystem::exists(control_.directory() + "/if4000/table"));
  const Bus successor("bus0", kIfindex);
  const auto gate = attach(successor);
  EXPECT_FALSE(gate.reused());
  EXPECT_TRUE(gate.present().empty());
  successor.inject(frame(0x123));
  expect_ingress(gate, GATE_R_UNKNOWN, 1);
}

TEST_P(Attach, PinsOfVanishedDevicesAreRemovedAndOthersStay) {
  const Bus stays("stays");
  const auto gate = attach(stays);
  std::string gone;
  {
    const Bus vanishes("vanishes");
    attach(vanishes);
    gone = pins(vanishes);
  }
  ASSERT_TRUE(unpin_vanished(control_));
  EXPECT_FALSE(std::filesystem::exists(gone));
  EXPECT_TRUE(std::filesystem::exists(pins(stays) + "/table"));
  EXPECT_TRUE(std::filesystem::exists(control_.directory() + "/control"));
}

TEST_P(Attach, CrashBetweenAttachingAndNamingKeepsTheSlots) {
  const Bus bus("bus0");
  {
    auto gate = attach(bus);
    admit(gate, {in(0x123)});
  }
  // As left by a daemon that died there: the attached programs have their next names only.
  std::filesystem::rename(pins(bus) + "/egress", pins(bus) + "/egress_next");
  std::filesystem::rename(pins(bus) + "/ingress", pins(bus) + "/ingress_next");
  const auto gate = attach(bus);
  EXPECT_TRUE(gate.reused());
  EXPECT_EQ(gate.present(), std::vector{in(0x123)});
  EXPECT_TRUE(attach(bus).reused());
}

TEST_P(Attach, MapsOfAnotherGateUnderOurNamesAreNotUsed) {
  const Bus bus("bus0");
  const Bus other("other");
  attach(bus);
  auto gate = attach(other);
  admit(gate, {in(0x123)});
  std::filesystem::rename(pins(other) + "/table", pins(bus) + "/table");
  EXPECT_FALSE(attach(bus).reused());
}

TEST_P(Attach, AnotherProfileStartsWithoutSlots) {
  const Bus bus("bus0");
  {
    auto gate = attach(bus);
    admit(gate, {in(0x123)});
  }
  const auto gate = attach(bus, core::Profile::famouso);
  EXPECT_FALSE(gate.reused());
  EXPECT_TRUE(gate.present().empty());
}

TEST_P(Attach, DamagedTableIsReplacedByAnEmptyOne) {
  const Bus bus("bus0");
  {
    auto gate = attach(bus);
    admit(gate, {in(0x123)});
  }
  const Fd map(bpf_obj_get((pins(bus) + "/table").c_str()));
  {
    const Mapped<gate_table> table(map.get(), 1);
    table[0].head[GATE_INGRESS][5] = GATE_SLOTS;
  }
  const auto gate = attach(bus);
  EXPECT_FALSE(gate.reused());
  EXPECT_TRUE(gate.present().empty());
  EXPECT_TRUE(gate.attached().value());
}

}  // namespace
}  // namespace mlcca::gates
