// SPDX-License-Identifier: BSD-2-Clause
// Frames that no description can admit, as malformed ones, are in the audit report with what a gate
// has read of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "daemon/gateway/audit_log.hpp"
#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

using core::FrameReason;

constexpr std::uint64_t kSecond = 1'000'000'000;

class AuditWithoutSlot : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_FALSE(bench_.start());
    pass();
  }
  void pass() {
    bench_.clock.monotonic += kSecond;
    bench_.clock.wall += kSecond;
    bench_.round();
  }
  std::vector<control::Finding> findings() {
    return std::get<control::Audit>(bench_.ask(control::AuditRequest{}).reply.body).findings;
  }
  /// The only finding.
  control::Finding only() {
    const auto found = findings();
    EXPECT_EQ(found.size(), 1U);
    return found.empty() ? control::Finding{} : found.front();
  }
  /// A program of user 1000 has sent so many frames that are malformed.
  static gates::RefusedSender program(std::uint64_t frames, std::uint32_t can_id = 0x123) {
    return {.place = 0,
            .slot = GATE_EGRESS,
            .reason = FrameReason::malformed,
            .frame = {.can_id = can_id,
                      .len = 12,
                      .format = GATE_CLASSIC,
                      .direction = gates::Direction::egress,
                      .count = frames},
            .source = 0,
            .uid = 1000};
  }
  void malformed(UnknownFrames frames, std::vector<gates::RefusedSender> senders) {
    bench_.gates().refused["can1"] = {{FrameReason::malformed, true, frames}};
    bench_.gates().senders["can1"] = std::move(senders);
  }

  Bench bench_{small_system()};
};

TEST_F(AuditWithoutSlot, MalformedFramesHaveTheirIdentifierTheirLengthAndWhoSendsThem) {
  malformed({3, 0}, {program(3)});
  pass();
  const auto f = only();
  EXPECT_EQ(f.reason, "malformed");
  EXPECT_EQ(f.interface, "can1");
  EXPECT_TRUE(f.egress);
  EXPECT_EQ(f.can_id, 0x123U);
  EXPECT_EQ(f.length, 12U);
  EXPECT_EQ(f.user, "1000");
  EXPECT_EQ(f.dropped, 3U);
  EXPECT_FALSE(f.others || f.at_least);
  malformed({3, 5}, {program(8)});
  pass();
  EXPECT_EQ(only().dropped, 3U);
  EXPECT_EQ(only().would_drop, 5U) << "in audit mode";
}

/// The gate notes a sender before it counts the frame.
TEST_F(AuditWithoutSlot, AFrameThatIsNotCountedYetIsLeftToTheNextPoll) {
  malformed({3, 0}, {program(4)});
  pass();
  EXPECT_EQ(only().dropped, 3U);
  malformed({4, 0}, {program(4)});
  pass();
  EXPECT_EQ(only().dropped, 4U);
}

TEST_F(AuditWithoutSlot, FramesOfSendersThatTheGateDoesNotKeepAreARowOfTheirOwn) {
  malformed({10, 0}, {program(4)});
  pass();
  const auto found = findings();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_TRUE(found[0].others);
  EXPECT_EQ(found[0].dropped, 6U);
  EXPECT_EQ(found[1].dropped, 4U);
  EXPECT_TRUE(found[1].at_least);
}

/// Another sender has taken the place in the gate, and a new gate counts from 0.
TEST_F(AuditWithoutSlot, ASenderThatTakesTheOtherPlaceCountsFromTheStart) {
  malformed({4, 0}, {program(4)});
  pass();
  malformed({9, 0}, {program(5, 0x124)});
  pass();
  malformed({2, 0}, {program(2, 0x124)});
  pass();
  std::map<std::uint32_t, std::uint64_t> frames;
  for (const auto& f : findings()) frames[f.can_id] = f.dropped;
  EXPECT_EQ(frames, (std::map<std::uint32_t, std::uint64_t>{{0x123, 4}, {0x124, 7}}));
}

TEST_F(AuditWithoutSlot, ADescribedIdentifierNamesItsChannel) {
  const core::System system = small_system();
  const core::Binding& binding = system.networks.at(1).bindings.at(0);
  malformed({1, 0}, {program(1, binding.id)});
  pass();
  EXPECT_EQ(only().described, system.channels.at(binding.channel).name);
}

TEST_F(AuditWithoutSlot, AClosedGateNamesNoSender) {
  bench_.gates().refused["can1"] = {{FrameReason::closed, true, {3, 0}}};
  pass();
  EXPECT_EQ(only().reason, "gate closed");
  EXPECT_TRUE(only().egress);
  EXPECT_FALSE(only().others);
}

// --- parts of messages ---------------------------------------------------------------------------

class AuditOfParts : public AuditWithoutSlot {
 protected:
  /// Frames that continue what was not admitted have come to can0, among `all` without a slot.
  void parts(std::uint64_t all, std::uint64_t parts, std::uint64_t of_sender = 0) {
    bench_.gates().slotless["can0"] = {{.egress = false, .all = {all, 0}, .parts = {parts, 0}}};
    bench_.gates().senders["can0"] = {
        {.place = 0,
         .slot = GATE_INGRESS,
         .reason = FrameReason::fragment,
         .frame = {.can_id = 0x98ebff17, .len = 8, .format = GATE_CLASSIC, .count = of_sender},
         .source = GATE_NO_SOURCE,
         .uid = GATE_ANY_UID}};
  }
};

TEST_F(AuditOfParts, WhatNothingAnnouncedIsAFindingOfItsSender) {
  parts(5, 5, 5);
  pass();
  const auto f = only();
  EXPECT_EQ(f.reason, "part of no admitted message");
  EXPECT_EQ(f.can_id, 0x98ebff17U);
  EXPECT_EQ(f.dropped, 5U);
}

/// A later part of a datagram may be refused since its slot was denied, or for its source.
TEST_F(AuditOfParts, WhateverRefusesALaterPartItIsCountedOnce) {
  parts(2, 2, 2);
  bench_.gates().senders["can0"][0].reason = FrameReason::denied;
  pass();
  EXPECT_EQ(only().reason, "part of no admitted message");
  EXPECT_EQ(only().dropped, 2U);
}

TEST_F(AuditOfParts, FramesThatCameWhileTheCountsWereReadAreNeitherLostNorCountedTwice) {
  parts(10, 5, 5);
  pass();
  parts(12, 4, 5);  // two others came meanwhile
  pass();
  EXPECT_EQ(only().dropped, 5U);
  parts(13, 6, 6);
  pass();
  EXPECT_EQ(only().dropped, 6U);
  parts(3, 3, 3);  // a new gate
  pass();
  EXPECT_EQ(only().dropped, 9U);
}

// --- over restarts -------------------------------------------------------------------------------

TEST_F(AuditWithoutSlot, FramesOfWhichNothingIsKnownStayOneFindingOverARestart) {
  gates::RefusedSender nobody{.place = 0,
                              .slot = GATE_INGRESS,
                              .reason = FrameReason::malformed,
                              .frame = {.len = 15, .count = 1},
                              .source = GATE_NO_SOURCE,
                              .uid = GATE_ANY_UID};
  malformed({1, 0}, {program(1)});
  bench_.gates().refused["can0"] = {{FrameReason::malformed, false, {1, 0}}};
  bench_.gates().senders["can0"] = {nobody};
  pass();
  AuditLog next(bench_.daemon().scene(), bench_.gates(), bench_.clock);
  next.restore(std::get<control::Audit>(bench_.ask(control::AuditRequest{}).reply.body));
  for (std::size_t port = 0; port < bench_.gates().size(); ++port) next.poll(port, {});
  const auto found = next.contents().findings;
  ASSERT_EQ(found.size(), 2U);
  for (const auto& f : found) EXPECT_EQ(f.dropped, 2U) << f.interface;
}

}  // namespace
}  // namespace mlcca::test
