// SPDX-License-Identifier: BSD-2-Clause
// The real gate on real interfaces: what passes, foreign filters, repair, closing.
#include <gtest/gtest.h>
#include <linux/pkt_cls.h>

#include "daemon/gates/gate.hpp"
#include "daemon/gates/interfaces.hpp"
#include "tests/daemon/gates/attach_fixture.hpp"

namespace mlcca::gates {
namespace {

TEST_P(Attach, NewGateIsInPlaceAndEmpty) {
  const Bus bus("bus0");
  const auto gate = attach(bus);
  EXPECT_TRUE(gate.attached().value());
  EXPECT_FALSE(gate.reused());
  EXPECT_TRUE(gate.present().empty());
  EXPECT_EQ(gate.name(), "bus0");
  EXPECT_EQ(gate.ifindex(), bus.ifindex());
}

TEST_P(Attach, AdmittedFramePassesIngressAndNoOther) {
  const Bus bus("bus0");
  const Program listener(bus);
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  bus.inject(frame(0x124));
  bus.inject(frame(0x123));
  EXPECT_EQ(listener.received(), frame(0x123)) << "the first that arrives is the admitted one";
  expect_ingress(gate, GATE_R_PASSED, 1);
  expect_ingress(gate, GATE_R_UNKNOWN, 1);
  ASSERT_EQ(gate.unknown().size(), 1U);
  EXPECT_EQ(gate.unknown().front().can_id, 0x124U);
}

TEST_P(Attach, BufferThatIsNoCanFrameIsMalformed) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  // 72 bytes are an FD frame only under the FD protocol.
  for (const std::size_t size : {1U, 4U, 8U, 15U, 17U, 71U, 72U, 73U, 2000U})
    bus.inject(Bytes(size));
  expect_ingress(gate, GATE_R_MALFORMED, 9);
}

TEST_P(Attach, ForwardedFrameLeavesWhereItsSourceIsGranted) {
  const Bus from("from");
  const Bus to("to");
  auto ingress = attach(from);
  auto egress = attach(to);
  forward(from, to);
  admit(ingress, {in(0x123), in(0x124)});
  admit(egress, {out(0x123, from.ifindex())});
  from.inject(frame(0x125));
  from.inject(frame(0x124));
  from.inject(frame(0x123));
  EXPECT_EQ(to.sent(), frame(0x123));
  expect_passed(egress, out(0x123, from.ifindex()), 1);
  expect_egress(egress, GATE_R_UNKNOWN, 1);  // 0x124; the other never came here
}

TEST_P(Attach, ThirdBusDoesNotReachTheNetwork) {
  const Bus from("from");
  const Bus third("third");
  const Bus to("to");
  auto ingress = attach(from);
  auto other = attach(third);
  auto egress = attach(to);
  forward(from, to);
  forward(third, to);
  admit(ingress, {in(0x123)});
  admit(other, {in(0x123)});
  admit(egress, {out(0x123, from.ifindex())});
  third.inject(frame(0x123));
  from.inject(frame(0x123));
  EXPECT_EQ(to.sent(), frame(0x123));
  expect_egress(egress, GATE_R_SOURCE, 1);
  expect_egress(egress, GATE_R_PASSED, 1);
}

TEST_F(Clsact, BusWithoutAGateDoesNotReachTheNetwork) {
  const Bus from("from");
  const Bus to("to");
  test::add_clsact(from);
  forward(from, to);
  auto egress = attach(to);
  admit(egress, {out(0x123, from.ifindex())});
  from.inject(frame(0x123));
  expect_egress(egress, GATE_R_SOURCE, 1);
}

TEST_P(Attach, LocalProgramLeavesOnlyWhereItsUserIsGranted) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {user(out(0x123, 0), 1000), out(0x124, 0), out(0x125, 99)});
  const Program granted(bus, 1000);
  const Program other(bus, 1001);
  EXPECT_FALSE(other.send(frame(0x123)));
  const auto senders = gate.refused_senders();
  ASSERT_EQ(senders.size(), 1U);
  EXPECT_EQ(senders[0].uid, 1001U);
  EXPECT_EQ(senders[0].frame.can_id, 0x123U);
  EXPECT_EQ(senders[0].slot, gate.number_of(user(out(0x123, 0), 1000)));
  EXPECT_TRUE(granted.send(frame(0x123)));
  EXPECT_EQ(bus.sent(), frame(0x123));
  EXPECT_TRUE(other.send(frame(0x124)));
  EXPECT_EQ(bus.sent(), frame(0x124));
  EXPECT_FALSE(granted.send(frame(0x125))) << "granted to forwarded frames only";
  expect_egress(gate, GATE_R_SOURCE, 2);
}

TEST_F(Clsact, ForeignFiltersAreLeftAlone) {
  const Bus bus("bus0");
  test::add_clsact(bus);
  test::add_foreign_filter(bus, 7, 1);
  test::add_foreign_filter(bus, GATE_TC_PRIORITY, 2);
  const auto other = test::filter_at(bus, true, 7, 1);
  const auto beside = test::filter_at(bus, true, GATE_TC_PRIORITY, 2);
  ASSERT_NE(other, 0U);
  ASSERT_NE(beside, 0U);
  attach(bus);
  const auto gate = attach(bus);
  EXPECT_TRUE(gate.attached().value());
  EXPECT_EQ(test::filter_at(bus, true, 7, 1), other);
  EXPECT_EQ(test::filter_at(bus, true, GATE_TC_PRIORITY, 2), beside);
}

TEST_F(Clsact, RemovedClsactIsNoticedAndRepaired) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  test::remove_clsact(bus);
  EXPECT_FALSE(gate.attached().value());
  ASSERT_TRUE(gate.reattach());
  EXPECT_TRUE(gate.attached().value());
  bus.inject(frame(0x123));
  bus.inject(frame(0x124));
  expect_passed(gate, in(0x123), 1);
  expect_ingress(gate, GATE_R_UNKNOWN, 1);
}

TEST_F(Clsact, OneRemovedFilterIsNoticedAndTheSlotsSurviveARestart) {
  for (const bool ingress : {true, false}) {
    const Bus bus("bus0");
    {
      auto gate = attach(bus);
      admit(gate, {in(0x123)});
      test::remove_our_filter(bus, ingress);
      EXPECT_FALSE(gate.attached().value());
    }
    const auto gate = attach(bus);
    EXPECT_TRUE(gate.reused());
    EXPECT_TRUE(gate.attached().value());
    EXPECT_EQ(gate.present(), std::vector{in(0x123)});
  }
}

TEST_F(Clsact, FilterOfAnotherInOurPlaceIsNoticed) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  test::remove_our_filter(bus, true);
  test::add_foreign_filter(bus, GATE_TC_PRIORITY, GATE_TC_HANDLE);
  EXPECT_FALSE(gate.attached().value());
  ASSERT_TRUE(gate.reattach());
  EXPECT_TRUE(gate.attached().value());
}

TEST_P(Attach, OneWordClosesEveryGate) {
  const Bus a("a");
  const Bus b("b");
  auto gate_a = attach(a);
  auto gate_b = attach(b);
  admit(gate_a, {in(0x123)});
  admit(gate_b, {in(0x123)});
  control_.close_all();
  a.inject(frame(0x123));
  b.inject(frame(0x123));
  expect_ingress(gate_a, GATE_R_CLOSED, 1);
  expect_ingress(gate_b, GATE_R_CLOSED, 1);
  control_.open();
  a.inject(frame(0x123));
  expect_passed(gate_a, in(0x123), 1);
}

TEST_P(Attach, AuditLetsThroughWhatItCounts) {
  const Bus bus("bus0");
  const Program listener(bus);
  const auto gate = attach(bus);
  control_.set_mode(Mode::audit);
  bus.inject(frame(0x124));
  EXPECT_EQ(listener.received(), frame(0x124));
  EXPECT_EQ(gate.would_drop(Direction::ingress).at(GATE_R_UNKNOWN), 1U);
  EXPECT_EQ(gate.reasons(Direction::ingress).at(GATE_R_UNKNOWN), 0U);
}

TEST_P(Attach, WhatAuditLetThroughIsNoDropAfterwards) {
  constexpr std::uint32_t frames = 20;
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  gate.deny_all();
  const auto counted = [&] { return gate.counters(in(0x123)).value(); };
  control_.set_mode(Mode::audit);
  for (std::uint32_t i = 0; i < frames; ++i) bus.inject(frame(0x123));
  EXPECT_EQ(eventually(frames, [&] { return counted().would_drop; }), frames);
  EXPECT_EQ(counted().dropped, 0U);
  control_.set_mode(Mode::enforce);
  for (std::uint32_t i = 0; i < frames; ++i) bus.inject(frame(0x123));
  expect_ingress(gate, GATE_R_DENIED, frames);
  EXPECT_EQ(counted().dropped, frames);
  EXPECT_EQ(counted().would_drop, frames);
  EXPECT_EQ(gate.would_drop(Direction::ingress).at(GATE_R_DENIED), frames);
}

TEST_P(Attach, DenyAllStopsEverythingAndKeepsTheGate) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  gate.deny_all();
  bus.inject(frame(0x123));
  expect_ingress(gate, GATE_R_DENIED, 1);
  EXPECT_EQ(gate.counters(in(0x123)).value().last_reason, core::FrameReason::denied);
  EXPECT_TRUE(gate.attached().value());
}

TEST_P(Attach, AbsentInterfaceIsAnErrorInWords) {
  GateConfig config;
  config.ifindex = 31337;
  config.name = "nowhere";
  const auto gate = Gate::attach(config, control_);
  ASSERT_FALSE(gate);
  EXPECT_NE(gate.error().text.find("gate of nowhere"), std::string::npos) << gate.error().text;
  EXPECT_NE(gate.error().text.find("No such device"), std::string::npos) << gate.error().text;
}

TEST_P(Attach, CountersOfAnAbsentSlotAreNone) {
  const Bus bus("bus0");
  EXPECT_FALSE(attach(bus).counters(in(0x123)));
}

TEST_F(Clsact, ClosedInterfaceDropsAndIsClosedOnce) {
  const Bus bus("bus0");
  const Program local(bus);
  EXPECT_EQ(close_interface("bus0", root_, hook_).value(), Closing::closed);
  const auto ingress = test::filter_at(bus, true, GATE_TC_PRIORITY, GATE_TC_HANDLE);
  EXPECT_NE(ingress, 0U);
  EXPECT_FALSE(local.send(frame(0x123)));
  EXPECT_EQ(close_interface("bus0", root_, hook_).value(), Closing::was_gated);
  EXPECT_EQ(test::filter_at(bus, true, GATE_TC_PRIORITY, GATE_TC_HANDLE), ingress);
}

TEST_P(Attach, ClosingAGatedInterfaceChangesNothing) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  EXPECT_EQ(close_interface("bus0", root_, hook_).value(), Closing::was_gated);
  EXPECT_TRUE(gate.attached().value());
  bus.inject(frame(0x123));
  expect_passed(gate, in(0x123), 1);
}

TEST_F(Clsact, ClosingFillsTheSideThatIsOpenOnly) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  test::remove_our_filter(bus, false);
  EXPECT_EQ(close_interface("bus0", root_, hook_).value(), Closing::closed);
  bus.inject(frame(0x123));
  expect_passed(gate, in(0x123), 1);
  EXPECT_FALSE(Program(bus).send(frame(0x123)));
}

TEST_P(Attach, DaemonTakesOverAClosedInterface) {
  const Bus bus("bus0");
  ASSERT_TRUE(close_interface("bus0", root_, hook_));
  auto gate = attach(bus);
  EXPECT_FALSE(gate.reused());
  EXPECT_TRUE(gate.attached().value());
  admit(gate, {in(0x123)});
  bus.inject(frame(0x123));
  expect_passed(gate, in(0x123), 1);
}

TEST_P(Attach, AnInterfaceIsClosedWithoutABpffsAndTakenOverWhenThereIsOne) {
  const Bus bus("bus0");
  const auto closing = close_interface("bus0", "/proc/no-bpffs", hook_);
  ASSERT_TRUE(closing) << closing.error().text;
  EXPECT_EQ(*closing, Closing::closed);
  EXPECT_FALSE(Program(bus).send(frame(0x123)));
  EXPECT_EQ(close_interface("bus0", "/proc/no-bpffs", hook_).value(), Closing::was_gated);
  auto gate = attach(bus);
  EXPECT_TRUE(gate.attached().value());
  admit(gate, {in(0x123)});
  bus.inject(frame(0x123));
  expect_passed(gate, in(0x123), 1);
}

TEST_P(Attach, ClosingAnAbsentInterfaceIsAnErrorInWords) {
  const auto closing = close_interface("nowhere", root_);
  ASSERT_FALSE(closing);
  EXPECT_NE(closing.error().text.find("close nowhere"), std::string::npos);
}

TEST_F(Clsact, ForeignFilterBeforeOursComesAfterItAgain) {
  const Bus bus("bus0");
  const Program listener(bus);
  auto gate = attach(bus);
  admit(gate, {in(0x123)});
  test::add_foreign_filter(bus, GATE_TC_PRIORITY, 2, TC_ACT_OK);
  bus.inject(frame(0x124));
  EXPECT_EQ(listener.received(), frame(0x124)) << "it runs first, and ours does not";
  ASSERT_TRUE(gate.go_first());
  EXPECT_TRUE(gate.attached().value());
  bus.inject(frame(0x124));
  bus.inject(frame(0x123));
  EXPECT_EQ(listener.received(), frame(0x123));
  expect_ingress(gate, GATE_R_UNKNOWN, 1);
  EXPECT_NE(test::filter_at(bus, true, GATE_TC_PRIORITY, 2), 0U) << "it is not ours to remove";
  EXPECT_EQ(test::filter_at(bus, true, GATE_TC_PRIORITY, GATE_TC_HANDLE + 1), 0U);
}

INSTANTIATE_TEST_SUITE_P(Hooks, Attach, ::testing::ValuesIn([] {
                           auto hooks = tcx_if_there();
                           hooks.push_back(Hook::clsact);
                           return hooks;
                         }()),
                         name_of);

TEST(GracePeriod, BothWaysToItWork) {
  EXPECT_TRUE(wait_for_grace_period());
  EXPECT_TRUE(detail::wait_by_membarrier());
  EXPECT_TRUE(detail::wait_by_map_of_maps());
}

}  // namespace
}  // namespace mlcca::gates
