// SPDX-License-Identifier: BSD-2-Clause
// What the gates refuse is found out, kept in bounds, and decides when they enforce.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "daemon/gateway/audit_keeper.hpp"
#include "daemon/gateway/audit_log.hpp"
#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr std::uint64_t kHour = 3600 * kSecond;

class AuditOnTheBench : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_NE(::mkdtemp(folder_.data()), nullptr);
    bench_.state_directory = folder_;
    ASSERT_FALSE(bench_.start());
  }
  void TearDown() override {
    bench_.end();
    std::filesystem::remove_all(folder_);
  }

  control::Audit audit() {
    return std::get<control::Audit>(bench_.ask(control::AuditRequest{}).reply.body);
  }
  control::Status status() {
    return std::get<control::Status>(bench_.ask(control::StatusRequest{}).reply.body);
  }
  bool is_done(const control::ModeRequest& request) {
    return std::holds_alternative<control::Done>(bench_.ask(request).reply.body);
  }
  static std::uint64_t frames_in(const control::Audit& audit) {
    std::uint64_t sum = 0;
    for (const control::Finding& f : audit.findings) sum += f.dropped + f.would_drop;
    return sum;
  }
  void pass(std::uint64_t ns) {
    bench_.clock.monotonic += ns;
    bench_.clock.wall += ns;
    bench_.round();
  }
  /// The gate of an interface has counted so many unknown frames of this identifier.
  void see(const std::string& interface, std::uint32_t can_id, std::uint64_t count,
           std::uint16_t length = 8) {
    auto& seen = bench_.gates().seen[interface];
    std::erase_if(seen, [can_id](const auto& one) { return one.can_id == can_id; });
    seen.push_back({.can_id = can_id,
                    .len = length,
                    .format = GATE_CLASSIC,
                    .count = count,
                    .sequence = ++sequence_});
    UnknownFrames& unknown = bench_.gates().unknown[interface];
    ++(bench_.kernel.mode == gates::Mode::audit ? unknown.would_drop : unknown.dropped);
  }

  Bench bench_{small_system()};
  std::uint64_t sequence_ = 0;

 private:
  std::string folder_ = ::testing::TempDir() + "mlcca-audit-XXXXXX";
};

TEST_F(AuditOnTheBench, UnknownFramesHaveTheirNumberTheirTimesAndTheirLength) {
  ASSERT_TRUE(is_done({"audit"}));
  const std::uint64_t start = bench_.clock.wall / kSecond;
  see("can0", 0x123, 20, 4);
  pass(kSecond);
  see("can0", 0x123, 70, 8);
  pass(kSecond);
  see("can0", 0x123, 80, 6);
  pass(kSecond);
  const control::Audit found = audit();
  EXPECT_EQ(found.mode, "audit");
  EXPECT_EQ(found.since_unix_s, start);
  EXPECT_EQ(found.gateway, "g");
  ASSERT_EQ(found.findings.size(), 1U);
  const control::Finding& f = found.findings[0];
  EXPECT_EQ(f.interface, "can0");
  EXPECT_EQ(f.network, "can0");
  EXPECT_EQ(f.can_id, 0x123U);
  EXPECT_EQ(f.reason, "unknown subject");
  EXPECT_EQ(f.would_drop, 80U);
  EXPECT_EQ(f.dropped, 0U);
  EXPECT_EQ(f.length, 8U);
  EXPECT_EQ(f.first_unix_s, start + 1);
  EXPECT_EQ(f.last_unix_s, start + 3);
  EXPECT_EQ(f.busy_gap_ns, kSecond / 50) << "50 of them came in the second second";
}

/// A gate counts 64 kinds: one that took the place of another begins at 1 each time.
TEST_F(AuditOnTheBench, FramesThatTakeTurnsInAPlaceOfTheGateAreAllCounted) {
  for (int i = 0; i < 3; ++i) {
    bench_.gates().seen.clear();
    see("can0", i % 2 == 0 ? 0x123 : 0x456, 1);
    pass(kSecond);
    see("can0", i % 2 == 0 ? 0x123 : 0x456, 1);
    pass(kSecond);
  }
  const auto findings = audit().findings;
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].can_id, 0x123U) << "most frames first";
  EXPECT_EQ(findings[0].dropped, 4U);
  EXPECT_EQ(findings[1].dropped, 2U);
}

TEST_F(AuditOnTheBench, WhatAFormerDaemonHasCountedIsNoFinding) {
  see("can0", 0x123, 9);
  AuditLog log(bench_.daemon().scene(), bench_.gates(), bench_.clock);
  log.take_up(0, bench_.gates().unknown_frames(0));
  log.poll(0, bench_.gates().unknown_frames(0));
  EXPECT_TRUE(log.contents().findings.empty());
  see("can0", 0x123, 11);
  see("can0", 0x124, 3);
  log.poll(0, bench_.gates().unknown_frames(0));
  const auto findings = log.contents().findings;
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].dropped, 3U);
  EXPECT_EQ(findings[1].dropped, 2U);
}

TEST_F(AuditOnTheBench, WhatIsDescribedNowIsNoFinding) {
  const core::GateState rules = bench_.wanted();
  const auto granted = std::ranges::find_if(rules, [](const core::GateRule& r) {
    return r.pass && r.entry.direction == core::Direction::ingress && r.entry.mask != 0 &&
           r.entry.subject != 0;
  });
  ASSERT_NE(granted, rules.end());
  const std::string interface = bench_.gates().interface_name(granted->entry.port);
  see(interface, granted->entry.id, 3);
  see(interface, 0x7ff, 3);
  pass(kSecond);
  const auto findings = audit().findings;
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].can_id, 0x7ffU);
}

/// Then it lacks a publisher there, and no channel.
TEST_F(AuditOnTheBench, AFrameOfADescribedChannelNamesIt) {
  const core::GateState rules = bench_.wanted();
  const auto granted = std::ranges::find_if(rules, [](const core::GateRule& r) {
    return r.pass && r.entry.direction == core::Direction::ingress && r.entry.mask != 0 &&
           r.entry.subject != 0;
  });
  ASSERT_NE(granted, rules.end());
  const std::string other = bench_.gates().interface_name(1 - granted->entry.port);
  see(other, granted->entry.id, 3);
  see(other, 0x7ff, 3);
  pass(kSecond);
  auto findings = audit().findings;
  ASSERT_EQ(findings.size(), 2U);
  std::ranges::sort(findings, {}, &control::Finding::can_id);
  EXPECT_EQ(findings[0].described.empty(), findings[0].can_id == 0x7ff);
  EXPECT_EQ(findings[1].described.empty(), findings[1].can_id == 0x7ff);
  EXPECT_EQ(findings[0].described + findings[1].described, "c0");
}

TEST_F(AuditOnTheBench, ASubjectOfADescribedChannelNamesIt) {
  const core::Subject known = bench_.system.channels[0].subject;
  auto& seen = bench_.gates().seen["can1"];
  for (const core::Subject subject : {known, known + 99}) {
    auto& frame = seen.emplace_back();
    frame.subject = subject;
    frame.count = 3;
    frame.sequence = ++sequence_;
  }
  ++bench_.gates().unknown["can1"].dropped;
  pass(kSecond);
  const auto findings = audit().findings;
  ASSERT_EQ(findings.size(), 2U);
  for (const control::Finding& f : findings) EXPECT_EQ(f.described, f.subject == known ? "c0" : "");
}

TEST_F(AuditOnTheBench, ARefusedDeliverySaysWhyUntilItIsGranted) {
  bench_.ask(control::WithdrawRequest{"c0"});
  bench_.act();
  bench_.round();
  bench_.gates().counted[1] = {.dropped = 6, .last_reason = core::FrameReason::denied};
  pass(kSecond);
  const auto findings = audit().findings;
  ASSERT_FALSE(findings.empty());
  for (const control::Finding& f : findings) {
    EXPECT_EQ(f.channel, "c0");
    EXPECT_EQ(f.dropped, 6U);
    EXPECT_TRUE(f.reason.starts_with("refused: ")) << f.reason;
    EXPECT_TRUE(f.reason.contains("withdrawn")) << f.reason;
  }
  bench_.ask(control::ReinstateRequest{"c0"});
  bench_.act();
  EXPECT_TRUE(audit().findings.empty());
}

TEST_F(AuditOnTheBench, ExcessIsAFindingWhereItIsDropped) {
  bench_.gates().counted[1] = {.excess = 4, .last_reason = core::FrameReason::excess};
  pass(kSecond);
  EXPECT_TRUE(audit().findings.empty()) << "the port lets it pass";
  bench_.gates().counted[1] = {
      .dropped = 5, .excess = 9, .excess_dropped = 5, .last_reason = core::FrameReason::excess};
  pass(kSecond);
  const auto findings = audit().findings;
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings[0].reason, "more than admitted");
  EXPECT_EQ(findings[0].dropped, 5U);
}

/// A flood of identifiers does not displace what came often.
TEST_F(AuditOnTheBench, OfTooManyFindingsThoseOfTheFewestFramesGiveWay) {
  see("can0", 0x7fe, 1000);
  pass(kSecond);
  std::uint32_t id = 0x80000000;
  for (std::size_t i = 0; i < AuditLog::kMost; i += 64) {
    bench_.gates().seen.clear();
    for (int n = 0; n < 64; ++n) see("can0", ++id, 1);
    pass(kSecond);
  }
  const control::Audit found = audit();
  EXPECT_EQ(found.findings.size(), AuditLog::kMost);
  EXPECT_EQ(found.left_out, 2U) << "one of them for the row of the others";
  EXPECT_EQ(found.findings.front().can_id, 0x7feU) << "most frames first";
  EXPECT_EQ(frames_in(found), 1000 + AuditLog::kMost);
}

/// A gate counts 64 kinds at once: the frames of the others belong to no kind.
TEST_F(AuditOnTheBench, FramesOfKindsThatNoGateCountsAreARowOfTheirOwn) {
  ASSERT_TRUE(is_done({"audit"}));
  see("can0", 0x123, 1);
  pass(kSecond);
  EXPECT_FALSE(audit().findings[0].at_least) << "all of them are counted";
  see("can0", 0x123, 2);
  bench_.gates().unknown["can0"].would_drop += 500;
  bench_.gates().refused["can1"] = {{core::FrameReason::malformed, true, {3, 0}}};
  pass(kSecond);
  const auto found = audit();
  ASSERT_EQ(found.findings.size(), 3U);
  EXPECT_EQ(found.left_out, 0U);
  EXPECT_TRUE(found.findings[0].others) << "most frames first";
  EXPECT_EQ(found.findings[0].interface, "can0");
  EXPECT_EQ(found.findings[0].would_drop, 500U);
  EXPECT_FALSE(found.findings[0].at_least);
  EXPECT_EQ(found.findings[1].reason, "malformed");
  EXPECT_FALSE(found.findings[1].at_least) << "of another interface, and for another reason";
  EXPECT_EQ(found.findings[2].would_drop, 2U);
  EXPECT_TRUE(found.findings[2].at_least);
}

/// A gate counts a kind before it counts the frame: what is ahead is not counted twice.
TEST_F(AuditOnTheBench, AKindThatIsCountedBeforeItsFrameMakesNoOthers) {
  see("can0", 0x123, 2);
  pass(kSecond);
  bench_.gates().unknown["can0"].dropped += 1;
  pass(kSecond);
  const auto found = audit();
  ASSERT_EQ(found.findings.size(), 1U);
  EXPECT_EQ(found.findings[0].dropped, 2U);
}

TEST_F(AuditOnTheBench, TheOthersAreKept) {
  bench_.gates().unknown["can0"].dropped += 500;
  pass(kSecond);
  AuditLog next(bench_.daemon().scene(), bench_.gates(), bench_.clock);
  next.restore(audit());
  ASSERT_EQ(next.report().findings.size(), 1U);
  EXPECT_TRUE(next.report().findings[0].others);
  EXPECT_EQ(next.report().findings, audit().findings);
}

TEST_F(AuditOnTheBench, TheGatesEnforceWhenNothingWouldHaveBeenDroppedForSoLong) {
  ASSERT_TRUE(is_done({"audit"}));
  ASSERT_TRUE(is_done({"enforce", 2 * kHour}));
  EXPECT_EQ(status().mode, "audit");
  EXPECT_EQ(status().when_clean_ns, 2 * kHour);
  pass(kHour);
  see("can0", 0x123, 1);
  pass(kHour - kSecond);
  EXPECT_EQ(status().clean_ns, 0U);
  pass(2 * kHour - kSecond);
  EXPECT_EQ(status().mode, "audit");
  EXPECT_EQ(status().clean_ns, 2 * kHour - kSecond);
  bench_.events.clear();
  pass(kSecond);
  EXPECT_EQ(status().mode, "enforce");
  EXPECT_EQ(status().when_clean_ns, 0U);
  EXPECT_EQ(bench_.kernel.mode, gates::Mode::enforce);
  EXPECT_EQ(std::ranges::count(bench_.events, "mode"), 2);
}

/// What came since the latest poll counts, too.
TEST_F(AuditOnTheBench, AFrameInTheLastSecondKeepsTheGatesFromEnforcing) {
  ASSERT_TRUE(is_done({"audit"}));
  ASSERT_TRUE(is_done({"enforce", kHour}));
  pass(kHour - kSecond);
  bench_.gates().counted[1] = {.would_drop = 1, .last_reason = core::FrameReason::length};
  pass(kSecond);
  EXPECT_EQ(status().mode, "audit");
  pass(kHour);
  EXPECT_EQ(status().mode, "enforce");
}

TEST_F(AuditOnTheBench, TheTimeBeginsAgainWithAuditModeAReloadAndAStart) {
  pass(10 * kHour);
  ASSERT_TRUE(is_done({"audit"}));
  EXPECT_EQ(status().clean_ns, 0U);
  ASSERT_TRUE(is_done({"enforce", kHour}));
  pass(kHour / 2);
  static_cast<void>(bench_.ask(control::ReloadRequest{}));
  bench_.reading().finish();
  EXPECT_EQ(status().clean_ns, 0U);
  EXPECT_EQ(status().when_clean_ns, kHour);
  pass(kHour / 2);
  bench_.end();
  ASSERT_FALSE(bench_.start());
  EXPECT_EQ(status().mode, "audit") << "the kernel has it";
  EXPECT_EQ(status().clean_ns, 0U);
}

TEST_F(AuditOnTheBench, AnotherModeTakesBackThatTheGatesEnforceWhenItIsClean) {
  ASSERT_TRUE(is_done({"audit"}));
  ASSERT_TRUE(is_done({"enforce", kHour}));
  ASSERT_TRUE(is_done({"audit"}));
  EXPECT_EQ(status().when_clean_ns, 0U);
  pass(3 * kHour);
  EXPECT_EQ(status().mode, "audit");
}

TEST_F(AuditOnTheBench, ATimeThatMakesNoSenseIsRefused) {
  EXPECT_FALSE(is_done({"enforce", kHour})) << "they enforce already";
  ASSERT_TRUE(is_done({"audit"}));
  EXPECT_FALSE(is_done({"audit", kHour}));
  EXPECT_FALSE(is_done({"enforce", kSecond - 1}));
  EXPECT_TRUE(is_done({"enforce", kSecond}));
  EXPECT_TRUE(is_done({"enforce", 365 * 24 * kHour}));
  EXPECT_FALSE(is_done({"enforce", 365 * 24 * kHour + 1}));
  EXPECT_EQ(status().when_clean_ns, 365 * 24 * kHour) << "what was refused changed nothing";
}

/// Frames of a delivery for several reasons: a gate counts those by port.
class CausesOnTheBench : public AuditOnTheBench {
 protected:
  /// What the gate of can0 has refused at ingress in all, and of the delivery.
  void refuse(std::uint64_t longer, std::uint64_t source, std::uint64_t of_delivery,
              core::FrameReason latest) {
    bench_.gates().misfitting["can0"] = {{core::FrameReason::length, false, {longer, 0}},
                                         {core::FrameReason::source, false, {source, 0}},
                                         {core::FrameReason::length, true, {77 + longer, 0}}};
    bench_.gates().counted[1] = {.dropped = of_delivery, .last_reason = latest};
  }
  /// Frames at ingress of can0 by reason.
  std::map<std::string, std::uint64_t> causes() {
    std::map<std::string, std::uint64_t> out;
    for (const control::Finding& f : audit().findings)
      if (f.interface == "can0" && !f.egress) out[f.reason] += f.dropped;
    return out;
  }
};

using Counts = std::map<std::string, std::uint64_t>;

TEST_F(CausesOnTheBench, OfOneDeliveryAloneAreExact) {
  pass(kSecond);
  for (std::uint64_t i = 1; i <= 3; ++i) {
    refuse(20 * i, 20 * i, 40 * i, core::FrameReason::length);
    pass(kSecond);
  }
  EXPECT_EQ(causes(), (Counts{{"longer than granted", 60}, {"not from the granted source", 60}}));
}

TEST_F(CausesOnTheBench, AreExactWhereTheGateRefusedForOneReason) {
  pass(kSecond);
  refuse(50, 0, 20, core::FrameReason::length);
  pass(kSecond);
  pass(kSecond);
  refuse(50, 40, 21, core::FrameReason::source);
  pass(kSecond);
  EXPECT_EQ(causes(), (Counts{{"longer than granted", 20}, {"not from the granted source", 1}}));
}

TEST_F(CausesOnTheBench, OfSeveralDeliveriesAtOnceNameTheLatest) {
  pass(kSecond);
  refuse(50, 40, 20, core::FrameReason::length);
  pass(kSecond);
  EXPECT_EQ(causes(), (Counts{{"cause not known, the latest: longer than granted", 20}}));
}

TEST_F(CausesOnTheBench, AreNoExcess) {
  pass(kSecond);
  bench_.gates().misfitting["can0"] = {{core::FrameReason::length, false, {5, 0}}};
  bench_.gates().counted[1] = {
      .dropped = 8, .excess = 3, .excess_dropped = 3, .last_reason = core::FrameReason::excess};
  pass(kSecond);
  EXPECT_EQ(causes(), (Counts{{"longer than granted", 5}, {"more than admitted", 3}}));
}

/// Who it is, if the description says it, is known of what has come from the granted source alone.
TEST_F(AuditOnTheBench, TheSenderIsThePublisherWhereTheGateHasSeenIt) {
  bench_.system.publishers[0].node = 23;
  ASSERT_FALSE(bench_.start());
  pass(kSecond);
  bench_.gates().counted[1] = {.dropped = 3, .last_reason = core::FrameReason::length};
  pass(kSecond);
  ASSERT_FALSE(audit().findings.empty());
  for (const control::Finding& f : audit().findings) EXPECT_EQ(f.sender, "node 23");
  bench_.gates().counted[1] = {.dropped = 5, .last_reason = core::FrameReason::source};
  pass(kSecond);
  for (const control::Finding& f : audit().findings)
    EXPECT_EQ(f.sender, f.reason == "longer than granted" ? "node 23" : "");
}

/// The daemon is killed, and the next one finds what the former had said and seen.
class AuditOfACrash : public AuditOnTheBench {
 protected:
  void crash() {
    bench_.end();
    ASSERT_FALSE(bench_.start());
  }
};

TEST_F(AuditOfACrash, AnAnsweredRequestIsOnTheDisk) {
  ASSERT_TRUE(is_done({"audit"}));
  ASSERT_TRUE(is_done({"enforce", kHour}));
  crash();
  EXPECT_EQ(status().when_clean_ns, kHour);
  ASSERT_TRUE(is_done({"audit"}));
  crash();
  EXPECT_EQ(status().when_clean_ns, 0U) << "it was taken back";
}

TEST_F(AuditOfACrash, ARequestThatCannotBeWrittenIsInForceAndAnError) {
  bench_.state_directory = "/nowhere/at/all";
  crash();
  EXPECT_TRUE(is_done({"audit"})) << "nothing has to be written";
  EXPECT_FALSE(is_done({"enforce", kHour}));
  EXPECT_EQ(status().when_clean_ns, kHour);
}

TEST_F(AuditOfACrash, FindingsOfMoreThanTenSecondsAgoAreKept) {
  see("can0", 0x123, 30);
  pass(kSecond);
  for (int i = 0; i < AuditKeeper::kInterval; ++i) pass(kSecond);
  see("can0", 0x123, 37);
  pass(kSecond);
  crash();
  const auto findings = audit().findings;
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].dropped, 30U);
}

TEST_F(AuditOnTheBench, WhatIsKeptIsGivenBackWhole) {
  see("can0", 0x123, 20);
  pass(kSecond);
  bench_.gates().counted[1] = {.dropped = 6, .last_reason = core::FrameReason::length};
  bench_.gates().refused["can1"] = {{core::FrameReason::malformed, true, {3, 0}}};
  pass(kSecond);
  AuditLog first(bench_.daemon().scene(), bench_.gates(), bench_.clock);
  first.restore(audit());
  AuditLog second(bench_.daemon().scene(), bench_.gates(), bench_.clock);
  second.restore(first.contents());
  EXPECT_EQ(first.report(), second.report());
  EXPECT_EQ(first.report().findings, audit().findings);
}

}  // namespace
}  // namespace mlcca::test
