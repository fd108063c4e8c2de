// SPDX-License-Identifier: BSD-2-Clause
// The audit report says who sends in place of the granted sender.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "daemon/gateway/audit_log.hpp"
#include "daemon/gateway/misfit_senders.hpp"
#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr std::uint32_t kSlot = GATE_FIRST_SLOT + 1;  // of c0, see FakeGates::slot_number()

/// The identifier of c0, as a FAMOUSO node sends it; node 5 is described.
constexpr std::uint32_t of_node(std::uint32_t node, std::uint32_t priority = 0x7d) {
  return 0x80000000U | priority << 22U | node << 14U | 0x70U;
}

core::System famouso_system() {
  core::System system = small_system();
  for (core::Network& network : system.networks) {
    if (network.kind != core::NetworkKind::can) continue;
    network.profile = core::Profile::famouso;
    for (core::Binding& binding : network.bindings) {
      binding.id = static_cast<std::uint32_t>(0x70 + binding.channel);
      binding.extended = true;
    }
  }
  system.publishers[0].node = 5;
  return system;
}

class AuditOfSenders : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_FALSE(bench_.start());
    pass();
  }
  std::vector<control::Finding> findings() {
    return std::get<control::Audit>(bench_.ask(control::AuditRequest{}).reply.body).findings;
  }
  /// Those of frames that came in at can0, by their identifiers; 0: of no sender.
  std::map<std::uint32_t, control::Finding> found() {
    std::map<std::uint32_t, control::Finding> out;
    for (const control::Finding& f : findings()) {
      if (f.interface != "can0" || f.egress) continue;
      EXPECT_TRUE(out.emplace(f.can_id, f).second);
    }
    return out;
  }
  void pass() {
    bench_.clock.monotonic += kSecond;
    bench_.clock.wall += kSecond;
    bench_.round();
  }
  static gates::RefusedSender sender(std::size_t place, std::uint32_t can_id,
                                     std::uint64_t frames) {
    return {.place = place,
            .slot = kSlot,
            .reason = core::FrameReason::identifier,
            .frame = {.can_id = can_id, .len = 6, .format = GATE_CLASSIC, .count = frames},
            .source = GATE_NO_SOURCE,
            .uid = GATE_ANY_UID};
  }
  /// The slots of c0 have refused so many frames, among them those of `senders` at can0.
  void refuse(std::uint64_t frames, std::vector<gates::RefusedSender> senders) {
    bench_.gates().senders["can0"] = std::move(senders);
    bench_.gates().misfitting["can0"] = {{kIdentifier, false, {frames, 0}}};
    bench_.gates().counted[1] = {.dropped = frames, .last_reason = kIdentifier};
  }

  static constexpr auto kIdentifier = core::FrameReason::identifier;
  Bench bench_{famouso_system()};
};

/// The first frames came before the grant. Those after it are the publisher's, and too long.
TEST_F(AuditOfSenders, ASenderBeforeAGrantHasNotSentWhatIsRefusedAfterIt) {
  bench_.ask(control::WithdrawRequest{"c0"});
  bench_.act();
  pass();
  refuse(20, {sender(0, of_node(33), 20)});
  bench_.ask(control::ReinstateRequest{"c0"});  // before the next sample
  bench_.act();
  pass();
  const auto before = found();
  const std::uint64_t known =
      before.contains(of_node(33)) ? before.at(of_node(33)).dropped : std::uint64_t{0};
  bench_.gates().misfitting["can0"] = {{kIdentifier, false, {20, 0}},
                                       {core::FrameReason::length, false, {5, 0}}};
  bench_.gates().counted[1] = {.dropped = 25, .last_reason = core::FrameReason::length};
  pass();
  const auto at = found();
  EXPECT_EQ(at.contains(of_node(33)) ? at.at(of_node(33)).dropped : 0U, known)
      << "node 33 has sent nothing since";
  ASSERT_TRUE(at.contains(0));
  EXPECT_EQ(at.at(0).reason, "longer than granted");
  EXPECT_EQ(at.at(0).dropped, 5U);
}

/// The same, without a round between the grant and what is refused after it.
TEST_F(AuditOfSenders, ASenderBeforeAGrantIsNoneOfWhatIsRefusedAtOnceAfterIt) {
  bench_.ask(control::WithdrawRequest{"c0"});
  bench_.act();
  pass();
  refuse(20, {sender(0, of_node(33), 20)});
  bench_.ask(control::ReinstateRequest{"c0"});
  bench_.act();
  refuse(25, {sender(0, of_node(33), 20)});
  pass();
  EXPECT_FALSE(found().contains(of_node(33)));
}

/// The frames come between the readings of the senders and of the slots, of which both are the
/// starting point after a reload.
TEST_F(AuditOfSenders, FramesDuringAReloadAreNotGivenToTheirSenderLater) {
  static_cast<void>(bench_.ask(control::ReloadRequest{}));
  const unsigned reads = bench_.gates().sender_reads;
  bench_.gates().before_frames = [&, reads] {
    if (bench_.gates().sender_reads > reads) refuse(20, {sender(0, of_node(33), 20)});
  };
  bench_.reading().finish();
  bench_.round();
  bench_.gates().before_frames = nullptr;
  pass();
  const auto before = found();
  const std::uint64_t known =
      before.contains(of_node(33)) ? before.at(of_node(33)).dropped : std::uint64_t{0};
  bench_.gates().misfitting["can0"] = {{kIdentifier, false, {20, 0}},
                                       {core::FrameReason::length, false, {5, 0}}};
  bench_.gates().counted[1] = {.dropped = 25, .last_reason = core::FrameReason::length};
  pass();
  const auto at = found();
  EXPECT_EQ(at.contains(of_node(33)) ? at.at(of_node(33)).dropped : 0U, known)
      << "node 33 has sent nothing since";
  ASSERT_TRUE(at.contains(0));
  EXPECT_EQ(at.at(0).dropped, 5U);
}

TEST_F(AuditOfSenders, ANodeThatSendsForAnotherIsAFindingWithItsNumberAndTimes) {
  refuse(20, {sender(0, of_node(33), 20)});
  pass();
  refuse(70, {sender(0, of_node(33), 70)});
  pass();
  const auto at = found();
  ASSERT_EQ(at.size(), 1U) << "none is of another sender";
  const control::Finding& f = at.begin()->second;
  EXPECT_EQ(f.can_id, of_node(33));
  EXPECT_EQ(f.reason, core::to_text(kIdentifier));
  EXPECT_EQ(f.described, "c0");
  EXPECT_EQ(f.channel, "");
  EXPECT_EQ(f.publisher, "");
  EXPECT_EQ(f.dropped, 70U);
  EXPECT_EQ(f.length, 6U);
  EXPECT_EQ(f.last_unix_s, f.first_unix_s + 1);
  EXPECT_EQ(f.busy_gap_ns, kSecond / 50);
  EXPECT_FALSE(f.at_least);
}

TEST_F(AuditOfSenders, FramesOfMoreSendersThanTheGateKeepsAreOfOtherSenders) {
  refuse(100, {sender(0, of_node(33), 20), sender(1, of_node(34), 10)});
  pass();
  const auto at = found();
  ASSERT_EQ(at.size(), 3U);
  EXPECT_EQ(at.at(of_node(33)).dropped, 20U);
  EXPECT_EQ(at.at(of_node(34)).dropped, 10U);
  EXPECT_TRUE(at.at(of_node(33)).at_least);
  const control::Finding& others = at.at(0);
  EXPECT_TRUE(others.others);
  EXPECT_EQ(others.channel, "c0");
  EXPECT_EQ(others.publisher, "p0");
  EXPECT_EQ(others.dropped, 70U);
  EXPECT_FALSE(others.at_least);
}

/// One took the place of another in the table, and begins at 1.
TEST_F(AuditOfSenders, SendersThatTakeTurnsInAPlaceAreAllCounted) {
  refuse(2, {sender(0, of_node(33), 2)});
  pass();
  refuse(5, {sender(0, of_node(34), 3)});
  pass();
  refuse(6, {sender(0, of_node(33), 1)});
  pass();
  const auto at = found();
  ASSERT_EQ(at.size(), 2U);
  EXPECT_EQ(at.at(of_node(33)).dropped, 3U);
  EXPECT_EQ(at.at(of_node(34)).dropped, 3U);
}

/// The gate notes a sender before it counts the frame: what is ahead is not counted twice.
TEST_F(AuditOfSenders, ASenderThatIsNotedBeforeItsFrameIsCountedMakesNoOthers) {
  refuse(2, {sender(0, of_node(33), 2)});
  bench_.gates().before_frames = [&] { refuse(2, {sender(0, of_node(33), 3)}); };
  pass();
  bench_.gates().before_frames = nullptr;
  EXPECT_EQ(found().at(of_node(33)).dropped, 2U);
  refuse(3, {sender(0, of_node(33), 3)});
  pass();
  const auto at = found();
  ASSERT_EQ(at.size(), 1U);
  EXPECT_EQ(at.at(of_node(33)).dropped, 3U);
}

/// The same node with another priority: it is the described publisher, which differs from what it
/// states.
TEST_F(AuditOfSenders, ThePublisherThatSendsWithAnotherPriorityIsNamed) {
  refuse(3, {sender(0, of_node(5, 0x10), 3)});
  pass();
  EXPECT_EQ(found().at(of_node(5, 0x10)).publisher, "p0");
  EXPECT_EQ(found().at(of_node(5, 0x10)).differs, std::vector<std::string>{"priority"});
  constexpr std::uint32_t fragment = 1U << 21U;
  constexpr std::uint32_t remote = 0x40000000;
  refuse(6, {sender(0, of_node(5, 0x10), 3), sender(1, of_node(5) | fragment | remote, 3)});
  pass();
  EXPECT_EQ(found().at(of_node(5) | fragment | remote).differs,
            (std::vector<std::string>{"fragment", "remote"}));
}

TEST_F(AuditOfSenders, ASenderThatIsDescribedNowIsNoFinding) {
  refuse(3, {sender(0, of_node(33), 3)});
  pass();
  ASSERT_EQ(found().size(), 1U);
  core::Publisher another = bench_.system.publishers[0];
  another.name = "p1";
  another.node = 33;
  bench_.system.publishers.push_back(another);
  static_cast<void>(bench_.ask(control::ReloadRequest{}));
  bench_.reading().finish();
  bench_.round();
  EXPECT_FALSE(found().contains(of_node(33)));
}

/// For example the frames of a slot that has got another entry.
TEST_F(AuditOfSenders, WhatNobodyHasAskedForInARoundLapses) {
  MisfitSenders senders(bench_.gates());
  senders.begin_round();
  bench_.gates().senders["can0"] = {sender(0, of_node(33), 9)};
  senders.begin_round();
  core::GateEntry entry;
  entry.subject = 1;
  EXPECT_EQ(senders.of(entry, 2).size(), 1U) << "they came in the last round";
  senders.begin_round();
  EXPECT_TRUE(senders.of(entry, 7).empty());
}

TEST_F(AuditOfSenders, WhatAFormerDaemonHasCountedIsNobodys) {
  bench_.gates().senders["can0"] = {sender(0, of_node(33), 9)};
  MisfitSenders senders(bench_.gates());
  senders.begin_round();
  core::GateEntry entry;
  entry.subject = 1;
  EXPECT_TRUE(senders.of(entry, 5).empty());
  bench_.gates().senders["can0"] = {sender(0, of_node(33), 11)};
  const auto sent = senders.of(entry, 5);
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].frames, 2U);
}

TEST_F(AuditOfSenders, AProgramHasItsUserAndABusItsInterface) {
  gates::RefusedSender program = sender(0, of_node(5), 3);
  program.reason = core::FrameReason::source;
  program.source = 0;
  program.uid = 1007;
  gates::RefusedSender bus = program;
  bus.place = 1;
  bus.source = static_cast<std::uint32_t>(bench_.kernel.interfaces.at("can1").ifindex);
  bus.uid = GATE_ANY_UID;
  bench_.gates().senders["can1"] = {program, bus};
  bench_.gates().counted[1] = {.dropped = 6, .last_reason = core::FrameReason::source};
  pass();
  std::vector<control::Finding> left;
  for (const control::Finding& f : findings())
    if (f.egress && f.channel.empty()) left.push_back(f);
  std::ranges::sort(left, {}, &control::Finding::user);
  ASSERT_EQ(left.size(), 2U);
  EXPECT_EQ(left[0].entered_by, "can1");
  EXPECT_EQ(left[0].entered_network, "can1");
  EXPECT_EQ(left[1].user, "1007");
  EXPECT_EQ(left[1].entered_by, "");
  for (const control::Finding& f : left) EXPECT_EQ(f.described, "c0");
}

/// From the granted bus, but its gate has not admitted it there: the description has this sender.
TEST_F(AuditOfSenders, FramesOfTheGrantedBusThatItsGateHasNotAdmittedAreOfTheDelivery) {
  gates::RefusedSender bus = sender(0, of_node(5), 3);
  bus.reason = core::FrameReason::source;
  bus.source = static_cast<std::uint32_t>(bench_.kernel.interfaces.at("can0").ifindex);
  bench_.gates().senders["can1"] = {bus};
  bench_.gates().counted[1] = {.dropped = 3, .last_reason = core::FrameReason::source};
  pass();
  for (const control::Finding& f : findings()) EXPECT_EQ(f.channel, "c0") << f.interface;
}

/// What is known of a sender does not hide the cause of another delivery.
TEST_F(AuditOfSenders, FramesOfKnownSendersAreNoCauseOfOthers) {
  refuse(50, {sender(0, of_node(33), 30)});
  bench_.gates().misfitting["can0"] = {{kIdentifier, false, {30, 0}},
                                       {core::FrameReason::length, false, {20, 0}}};
  pass();
  const auto at = found();
  EXPECT_EQ(at.at(of_node(33)).dropped, 30U);
  EXPECT_EQ(at.at(0).reason, "longer than granted");
  EXPECT_EQ(at.at(0).dropped, 20U);
  EXPECT_FALSE(at.at(0).others);
}

/// Nor do those of the round before take anything away.
TEST_F(AuditOfSenders, FramesOfFurtherSendersKeepTheirReasonInTheNextRound) {
  refuse(1, {sender(0, of_node(33), 1)});
  pass();
  refuse(241, {sender(0, of_node(33), 1), sender(1, of_node(34), 64)});
  pass();
  const auto at = found();
  EXPECT_EQ(at.at(of_node(34)).dropped, 64U);
  EXPECT_EQ(at.at(0).reason, core::to_text(kIdentifier));
  EXPECT_EQ(at.at(0).dropped, 176U);
  EXPECT_TRUE(at.at(0).others);
}

TEST_F(AuditOfSenders, WhatIsKeptIsGivenBackWhole) {
  refuse(100, {sender(0, of_node(33), 20)});
  pass();
  AuditLog next(bench_.daemon().scene(), bench_.gates(), bench_.clock);
  next.restore(std::get<control::Audit>(bench_.ask(control::AuditRequest{}).reply.body));
  AuditLog last(bench_.daemon().scene(), bench_.gates(), bench_.clock);
  last.restore(next.contents());
  EXPECT_EQ(last.report().findings, findings());
}

/// The priority is open: what differs is the destination, which the gate has in its mask.
TEST(AuditOfDestinations, AFrameToAnotherDestinationIsNotSaidToDifferInItsPriority) {
  core::System system = small_system();
  for (core::Network& network : system.networks) {
    if (network.kind != core::NetworkKind::can) continue;
    network.profile = core::Profile::j1939;
    for (core::Binding& binding : network.bindings) {
      binding.id = static_cast<std::uint32_t>(0xef00 - 0x100 * binding.channel);
      binding.extended = true;
      binding.destination = 0x05;
    }
  }
  system.publishers[0].node = 0x17;
  Bench bench(system);
  ASSERT_FALSE(bench.start());
  const auto pass = [&] {
    bench.clock.monotonic += kSecond;
    bench.clock.wall += kSecond;
    bench.round();
  };
  pass();
  bench.gates().senders["can0"] = {
      {.place = 0,
       .slot = kSlot,
       .reason = core::FrameReason::identifier,
       .frame = {.can_id = 0x8cef0617U, .len = 8, .format = GATE_CLASSIC, .count = 3},
       .source = GATE_NO_SOURCE,
       .uid = GATE_ANY_UID},
      {.place = 1,
       .slot = kSlot,
       .reason = core::FrameReason::identifier,
       .frame = {.can_id = 0x8cef4433U, .len = 8, .format = GATE_CLASSIC, .count = 3},
       .source = GATE_NO_SOURCE,
       .uid = GATE_ANY_UID}};
  bench.gates().counted[1] = {.dropped = 6, .last_reason = core::FrameReason::identifier};
  pass();
  const auto answer = bench.ask(control::AuditRequest{});
  for (const control::Finding& f : std::get<control::Audit>(answer.reply.body).findings)
    if (f.interface == "can0" && !f.egress) {
      EXPECT_EQ(f.described, "") << std::hex << f.can_id << ": c0 is of another destination";
      EXPECT_EQ(f.publisher, "") << std::hex << f.can_id << ": its priority is open";
    }
}

/// The described publisher sends AWDS packets. A datagram over IPv4 whose frame has the same MAC
/// address is of another station: the gate refuses it, so the report must list it.
TEST(AuditOfStations, ADatagramWithTheMacOfAnAwdsPublisherIsListed) {
  core::System system = small_system();
  system.publishers[0].place = {core::Place::Kind::network, 2};
  system.publishers[0].station = *core::station_of("02:00:00:00:00:01");
  Bench bench(system);
  ASSERT_FALSE(bench.start());
  const auto pass = [&] {
    bench.clock.monotonic += kSecond;
    bench.clock.wall += kSecond;
    bench.round();
  };
  pass();
  const std::string interface = system.networks[2].name;
  bench.gates().senders[interface] = {
      {.place = 0,
       .slot = kSlot,
       .reason = core::FrameReason::source,
       .frame =
           {.subject = 1, .len = 8, .count = 3, .station = 0x0a000009, .mac = {2, 0, 0, 0, 0, 1}},
       .source = 0,
       .uid = GATE_ANY_UID}};
  bench.gates().counted[1] = {.dropped = 3, .last_reason = core::FrameReason::source};
  pass();
  const auto answer = bench.ask(control::AuditRequest{});
  const auto& found = std::get<control::Audit>(answer.reply.body).findings;
  EXPECT_TRUE(std::ranges::any_of(found, [](const control::Finding& f) {
    return f.address == "10.0.0.9" && f.dropped == 3;
  })) << found.size();
}

/// A round reads the table of a gate so often, however many slots have refused frames.
TEST(MisfitSendersOfARound, ReadTheTableOfAGateABoundedNumberOfTimes) {
  Bench bench(famouso_system());
  ASSERT_FALSE(bench.start());
  FakeGates& gates = bench.gates();
  MisfitSenders senders(gates);
  core::GateEntry entry;
  entry.subject = 1;
  gates.sender_reads = 0;
  senders.begin_round();
  for (unsigned i = 0; i < 1000; ++i) static_cast<void>(senders.of(entry, 1));
  const auto ports = static_cast<unsigned>(gates.size());
  EXPECT_EQ(gates.sender_reads, MisfitSenders::kReadsOfRound + ports - 1);
  senders.begin_round();
  static_cast<void>(senders.of(entry, 1));
  EXPECT_EQ(gates.sender_reads, MisfitSenders::kReadsOfRound + 2 * ports);
}

}  // namespace
}  // namespace mlcca::test
