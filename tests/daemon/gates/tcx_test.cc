// SPDX-License-Identifier: BSD-2-Clause
// The gate in the order of TCX: its place among others, who takes over from whom, and what outlives
// what.
#include <gtest/gtest.h>
#include <linux/pkt_cls.h>

#include "daemon/gates/attachment.hpp"
#include "daemon/gates/gate.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/interfaces.hpp"
#include "daemon/gates/pins.hpp"
#include "tests/daemon/gates/attach_fixture.hpp"

namespace mlcca::gates {
namespace {

constexpr int kPass = 0;  // TCX_PASS: no other program sees the frame, neither TCX nor clsact

std::uint32_t id_of(const Fd& program) { return program_info(program.get()).id; }

TEST_P(Tcx, GateOutlivesItsDaemon) {
  const Bus bus("bus0");
  const Program listener(bus);
  {
    auto gate = attach(bus);
    EXPECT_EQ(gate.hook(), Hook::tcx);
    admit(gate, {in(0x123)});
  }
  bus.inject(frame(0x124));
  bus.inject(frame(0x123));
  EXPECT_EQ(listener.received(), frame(0x123));
}

/// A failed call gave the number 0. Every program but that one went, and with them the gate's own.
TEST_P(Tcx, WhatNumberAProgramHasIsAnErrorWhereTheKernelDoesNotSay) {
  const auto ids = ids_of({.ingress = -1, .egress = -1});
  ASSERT_FALSE(ids);
  EXPECT_TRUE(ids.error().text.contains("ask for the number of a program: ")) << ids.error().text;
}

TEST_P(Tcx, RemovedQdiscDoesNotConcernIt) {
  const Bus bus("bus0");
  test::add_clsact(bus);
  const auto gate = attach(bus);
  test::remove_clsact(bus);
  EXPECT_TRUE(gate.attached().value());
}

TEST_P(Tcx, ProgramBeforeOursIsNamedAndComesAfterItAgain) {
  const Bus bus("bus0");
  const Program listener(bus);
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  EXPECT_TRUE(gate.ahead().value().empty());
  const Fd foreign = test::load_foreign(kPass);
  const auto link = tcx_attach_first(bus.ifindex(), Direction::ingress, foreign.get());
  ASSERT_TRUE(link) << link.error().text;
  bus.inject(frame(0x124));
  EXPECT_EQ(listener.received(), frame(0x124)) << "it runs first, and ours does not";
  EXPECT_TRUE(gate.attached().value());
  EXPECT_EQ(gate.ahead().value(),
            (std::vector<Ahead>{{Direction::ingress, Hook::tcx, id_of(foreign)}}));

  const auto moved = gate.go_first();
  ASSERT_TRUE(moved) << moved.error().text;
  EXPECT_TRUE(gate.ahead().value().empty());
  EXPECT_TRUE(gate.attached().value());
  EXPECT_EQ(gate.present(), std::vector{in(0x123)});
  bus.inject(frame(0x124));
  bus.inject(frame(0x123));
  EXPECT_EQ(listener.received(), frame(0x123));
  const auto order = tcx_order(bus.ifindex(), Direction::ingress).value().value();
  EXPECT_EQ(order.programs.size(), 2U) << "ours is there once, and the other is not ours to remove";
  EXPECT_EQ(order.programs.back(), id_of(foreign));
  EXPECT_TRUE(attach(bus).reused());
}

TEST_P(Tcx, ProgramAfterOursIsLeftAlone) {
  const Bus bus("bus0");
  const Fd foreign = test::load_foreign(TC_ACT_UNSPEC);
  const auto link = tcx_attach_first(bus.ifindex(), Direction::egress, foreign.get());
  const auto gate = attach(bus);
  EXPECT_TRUE(gate.ahead().value().empty());
}

TEST_P(Tcx, ProgramThatLetsFramesSkipClsactIsNamed) {
  const Bus bus("bus0");
  hook_ = Hook::clsact;
  const auto gate = attach(bus);
  EXPECT_TRUE(gate.ahead().value().empty());
  const Fd foreign = test::load_foreign(kPass);
  const auto link = tcx_attach_first(bus.ifindex(), Direction::egress, foreign.get());
  EXPECT_EQ(gate.ahead().value(),
            (std::vector<Ahead>{{Direction::egress, Hook::tcx, id_of(foreign)}}));
}

TEST_P(Tcx, TakesOverFromClsactAndBackUnderTraffic) {
  const Bus bus("bus0");
  hook_ = Hook::clsact;
  auto first = attach(bus);
  admit(first, {in(0x123)});
  Traffic traffic(bus, first, {0x123, 0x124});
  for (int i = 0; i < 20; ++i) {
    hook_ = i % 2 == 0 ? Hook::tcx : Hook::clsact;
    EXPECT_TRUE(attach(bus).reused());
    EXPECT_EQ(test::filter_at(bus, true, GATE_TC_PRIORITY, GATE_TC_HANDLE) != 0,
              hook_ == Hook::clsact);
    EXPECT_EQ(tcx_order(bus.ifindex(), Direction::ingress).value().value().programs.size(),
              hook_ == Hook::tcx ? 1U : 0U);
  }
  const auto sent = traffic.stop();
  // While both are there a frame is judged twice: none is lost, none passes unjudged.
  const auto counted = first.counters(in(0x123)).value();
  EXPECT_GE(counted.passed, sent);
  EXPECT_EQ(counted.dropped, 0U);
}

TEST_P(Tcx, LostProgramIsNoticedAndPutBack) {
  for (const auto which : kBothDirections) {
    const Bus bus("bus0");
    auto gate = attach(bus);
    admit(gate, {in(0x123)});
    ASSERT_TRUE(tcx_detach(bus.ifindex(), which, open_pin(program_pin(pins(bus), which)).get()));
    EXPECT_FALSE(gate.attached().value());
    ASSERT_TRUE(gate.reattach());
    EXPECT_TRUE(gate.attached().value());
    EXPECT_EQ(gate.present(), std::vector{in(0x123)});
  }
}

TEST_P(Tcx, ProgramWithoutItsNameGoesOnAndGetsItAgain) {
  for (const std::string which : {"ingress", "egress"}) {
    const Bus bus("bus0");
    auto gate = attach(bus);
    admit(gate, {in(0x123)});
    std::filesystem::remove(pins(bus) + "/" + which);
    bus.inject(frame(0x124));
    expect_ingress(gate, GATE_R_UNKNOWN, 1);
    EXPECT_TRUE(gate.attached().value());
    EXPECT_EQ(gate.keep_pinned().value(), std::vector{which});
    ASSERT_TRUE(gate.go_first());
    EXPECT_TRUE(gate.keep_pinned().value().empty());
    EXPECT_EQ(tcx_order(bus.ifindex(), Direction::ingress).value().value().programs.size(), 1U);
  }
}

TEST_P(Tcx, ClosedInterfaceIsHeldAndTakenOver) {
  const Bus bus("bus0");
  EXPECT_EQ(close_interface("bus0", root_).value(), Closing::closed);
  EXPECT_EQ(close_interface("bus0", root_).value(), Closing::was_gated);
  EXPECT_FALSE(Program(bus).send(frame(0x123)));
  auto gate = attach(bus);
  EXPECT_FALSE(gate.reused());
  admit(gate, {in(0x123)});
  bus.inject(frame(0x123));
  expect_passed(gate, in(0x123), 1);
  EXPECT_EQ(tcx_order(bus.ifindex(), Direction::ingress).value().value().programs.size(), 1U);
}

TEST_P(Tcx, ClosedByClsactWhereNoLinkCanBePinned) {
  const Bus bus("bus0");
  std::filesystem::create_directories(pins(bus) + "/egress/of/somebody");
  EXPECT_EQ(close_interface("bus0", root_).value(), Closing::closed);
  EXPECT_NE(test::filter_at(bus, true, GATE_TC_PRIORITY, GATE_TC_HANDLE), 0U);
  std::filesystem::remove_all(pins(bus));
  const auto gate = attach(bus);
  EXPECT_TRUE(gate.attached().value());
  EXPECT_EQ(test::filter_at(bus, true, GATE_TC_PRIORITY, GATE_TC_HANDLE), 0U);
}

INSTANTIATE_TEST_SUITE_P(Kernel, Tcx, ::testing::ValuesIn(tcx_if_there()), name_of);

}  // namespace
}  // namespace mlcca::gates
