// SPDX-License-Identifier: BSD-2-Clause
// The order of a turn, and what requests may do, in a whole gateway among fakes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "daemon/gateway/requests/table.hpp"
#include "tests/daemon/gateway/bench.hpp"
#include "tests/daemon/gateway/held.hpp"

namespace mlcca::test {
namespace {

class OnTheBench : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_FALSE(bench_.start());
    bench_.commits.clear();
  }
  static bool is_error(const serve::Answer& answer) {
    return std::holds_alternative<control::Error>(answer.reply.body);
  }
  std::mt19937 random_;
  Bench bench_{small_system()};
};

TEST_F(OnTheBench, WhatIsGrantedIsHeldByTheGatesAndAnsweredWhenTheDiskHasIt) {
  const auto answer = bench_.ask(newcomer());
  ASSERT_FALSE(is_error(answer));
  EXPECT_TRUE(answer.held);
  EXPECT_EQ(wrong_gate(bench_), "") << "the kernel obeys before the answer";
  EXPECT_TRUE(bench_.commits.empty());
  bench_.act();
  ASSERT_EQ(bench_.commits.size(), 1U);
  EXPECT_TRUE(bench_.commits.front());
  EXPECT_EQ(bench_.recorded(random_).admissions.size(), 1U);
}

TEST_F(OnTheBench, AGateThatIsClosedBecauseNothingDescribesItIsAReasonOfTheHealth) {
  bench_.gates().closed_interfaces = {"can7"};
  const auto answer = bench_.ask(control::StatusRequest{});
  const auto* status = std::get_if<control::Status>(&answer.reply.body);
  ASSERT_NE(status, nullptr);
  EXPECT_EQ(status->health.state, control::HealthState::degraded);
  EXPECT_EQ(status->health.reasons,
            std::vector<std::string>{
                "can7 is not described, or without a profile: its gate stays closed"});
}

/// Nothing may depend on that a further change is stored.
TEST_F(OnTheBench, WhatTheDiskRefusedAndCouldNotUndoIsUndoneByTheNextRound) {
  ASSERT_TRUE(bench_.ask(newcomer()).held);
  bench_.act();
  const auto id = bench_.state().admissions().begin()->first;
  // The sync and the undoing fail: a loss of power now might leave the release on the disk.
  bench_.disk().trouble(store::test::Trouble::fail, 2, EIO, 2);
  control::ReleaseRequest release;
  release.admission = id;
  const auto refused = bench_.ask(release);
  ASSERT_TRUE(is_error(refused));
  bench_.disk().trouble(store::test::Trouble::fail, 1, 0, 0);
  bench_.daemon().begin_round();
  for (int i = 0; i < 1'000 && bench_.daemon().has_work(); ++i) bench_.daemon().work();
  for (int i = 0; i < 50; ++i)
    ASSERT_NE(bench_.recorded(random_).admissions.find(id), nullptr) << "loss of power " << i;
}

TEST_F(OnTheBench, WhatTheDiskRefusesIsNotGranted) {
  ASSERT_TRUE(bench_.ask(newcomer()).held);
  bench_.disk().trouble(store::test::Trouble::fail, 1, ENOSPC, 100);
  bench_.act();
  ASSERT_EQ(bench_.commits.size(), 1U);
  EXPECT_FALSE(bench_.commits.front());
  EXPECT_TRUE(bench_.state().admissions().empty());
  EXPECT_EQ(wrong_gate(bench_), "");
  EXPECT_EQ(std::ranges::count(bench_.events, "refused"), 1);
  EXPECT_EQ(std::ranges::count(bench_.events, "withdrawn"), 0) << "it was never granted";
}

TEST_F(OnTheBench, WhatTheKernelRefusesLeavesNothing) {
  bench_.kernel.calls.refuse(2);
  EXPECT_TRUE(is_error(bench_.ask(newcomer())));
  EXPECT_TRUE(bench_.state().admissions().empty());
  EXPECT_EQ(wrong_gate(bench_), "");
  bench_.act();
  EXPECT_TRUE(bench_.recorded(random_).admissions.empty());
}

/// It is on disk and denied: an error would say that it is not.
TEST_F(OnTheBench, WhatIsReleasedOrWithdrawnIsAnsweredSoWhateverTheKernelSays) {
  ASSERT_TRUE(bench_.ask(newcomer()).held);
  bench_.act();
  bench_.kernel.calls.refuse(1, 100);
  EXPECT_FALSE(is_error(bench_.ask(control::ReleaseRequest{"", 1, ""})));
  EXPECT_FALSE(is_error(bench_.ask(control::WithdrawRequest{"c0"})));
  bench_.kernel.calls.relent();
  EXPECT_TRUE(bench_.recorded(random_).admissions.empty());
  EXPECT_EQ(bench_.recorded(random_).released.size(), 1U);
  EXPECT_EQ(wrong_gate(bench_), "");
}

TEST_F(OnTheBench, AReloadReportsOnlyWhatBecameDifferent) {
  const auto reload = [this] {
    bench_.events.clear();
    static_cast<void>(bench_.ask(control::ReloadRequest{}));
    bench_.reading().finish();
    return bench_.events;
  };
  EXPECT_EQ(reload(), std::vector<std::string>{"reload"});
  bench_.system.publishers[0].attributes.set(Attribute::period, 40'000'000);
  EXPECT_EQ(reload(), (std::vector<std::string>{"reload", "granted"}));
  EXPECT_EQ(reload(), std::vector<std::string>{"reload"});
  bench_.system.subscribers.clear();
  EXPECT_EQ(reload(), (std::vector<std::string>{"reload", "removed"}));
  EXPECT_EQ(reload(), std::vector<std::string>{"reload"});
}

TEST_F(OnTheBench, ObservesAndSettlesBeforeItEnforcesAndOpens) {
  bench_.kernel.order.clear();
  bench_.kernel.unplug("can1");
  bench_.daemon().links_changed();
  EXPECT_EQ(bench_.state().granted(), 0U);
  EXPECT_EQ(bench_.kernel.order, (std::vector<std::string>{"apply", "sync", "open"}));
  EXPECT_EQ(wrong_gate(bench_), "");
}

TEST_F(OnTheBench, ARequestThatChangesSomethingIsForMembers) {
  const auto is_forbidden = [](const serve::Answer& answer) {
    const auto* error = std::get_if<control::Error>(&answer.reply.body);
    return error != nullptr && error->kind == control::ErrorKind::forbidden;
  };
  EXPECT_TRUE(is_forbidden(bench_.ask(newcomer(), outsider())));
  EXPECT_TRUE(is_forbidden(bench_.ask(control::ReleaseRequest{"", 1, ""}, outsider())));
  EXPECT_TRUE(is_forbidden(bench_.ask(control::WithdrawRequest{"c0"}, outsider())));
  EXPECT_TRUE(is_forbidden(bench_.ask(control::ReinstateRequest{"c0"}, outsider())));
  EXPECT_TRUE(is_forbidden(bench_.ask(control::RenewRequest{1, ""}, outsider())));
  EXPECT_TRUE(is_forbidden(bench_.ask(control::ModeRequest{"audit"}, outsider())));
  EXPECT_TRUE(is_forbidden(bench_.ask(control::ReloadRequest{}, outsider())));
  EXPECT_FALSE(bench_.reading().busy());
  EXPECT_EQ(bench_.kernel.mode, gates::Mode::enforce);
  control::Query query;
  static_cast<control::ChannelRequest&>(query) = newcomer();
  EXPECT_FALSE(is_forbidden(bench_.ask(query, outsider())));
}

/// The schema has the fields of an admission in a query, too: they do nothing there.
TEST_F(OnTheBench, AQueryWithAKeyAndALeaseHoldsNothing) {
  control::Query query;
  static_cast<control::ChannelRequest&>(query) = newcomer();
  query.key = "camera";
  query.lease_ns = 5'000'000'000;
  query.hold = true;
  const auto answer = bench_.ask(query);
  ASSERT_FALSE(is_error(answer));
  EXPECT_FALSE(answer.held);
  for (const auto& channel : std::get<control::Channels>(answer.reply.body).channels)
    EXPECT_EQ(channel.admission, 0U) << "nothing could be released by that number";
  bench_.act();
  EXPECT_TRUE(bench_.state().admissions().empty());
  EXPECT_TRUE(bench_.recorded(random_).admissions.empty());
  EXPECT_TRUE(is_error(bench_.ask(control::RenewRequest{0, "camera"}))) << "no key is known";
}

TEST_F(OnTheBench, ALeaseThatIsNotRenewedEnds) {
  auto request = newcomer();
  request.lease_ns = 5'000'000'000;
  ASSERT_TRUE(bench_.ask(request).held);
  bench_.act();
  bench_.round();
  EXPECT_EQ(bench_.state().admissions().size(), 1U);
  bench_.clock.monotonic += 5'000'000'000;
  bench_.clock.wall -= 3'600'000'000'000;
  bench_.round();
  EXPECT_TRUE(bench_.state().admissions().empty());
  EXPECT_TRUE(bench_.recorded(random_).admissions.empty());
  EXPECT_EQ(wrong_gate(bench_), "");
}

TEST_F(OnTheBench, AForwarderThatEndsIsReportedAfterItsLastFrame) {
  auto& passed = bench_.gates().passed;
  const auto troubles = [&] {
    const auto answer = bench_.ask(control::ExplainRequest{"c0"});
    return std::get<control::Channels>(answer.reply.body).channels.at(0).problems;
  };
  const auto pass = [&](std::uint64_t in, std::uint64_t out) {
    passed = {{core::Direction::ingress, in}, {core::Direction::egress, out}};
  };
  using Lines = std::vector<std::string>;
  pass(20, 20);
  bench_.round();
  pass(60, 60);
  EXPECT_EQ(troubles(), Lines{}) << "between two polls";
  bench_.round();
  pass(100, 60);
  bench_.round();
  EXPECT_EQ(troubles(), Lines{"40 frames came in from can0 since the latest left to can1: nothing "
                              "forwards them"});
  pass(101, 61);
  bench_.round();
  EXPECT_EQ(troubles(), Lines{}) << "they leave again";
  pass(5, 0);
  bench_.round();
  EXPECT_EQ(troubles(), Lines{"5 frames came in from can0 and none left to can1: nothing forwards "
                              "them"})
      << "slots that were made again";
}

/// Slots outlive a reload and a daemon, and what they have counted says nothing of a new grant.
TEST_F(OnTheBench, FramesFromBeforeAReloadAreNotMissedBehindIt) {
  const auto troubles = [&] {
    const auto answer = bench_.ask(control::ExplainRequest{"c0"});
    return std::get<control::Channels>(answer.reply.body).channels.at(0).problems;
  };
  bench_.gates().passed = {{core::Direction::ingress, 422}, {core::Direction::egress, 0}};
  static_cast<void>(bench_.ask(control::ReloadRequest{}));
  bench_.reading().finish();
  bench_.round();
  EXPECT_EQ(troubles(), std::vector<std::string>{});
  bench_.gates().passed = {{core::Direction::ingress, 430}, {core::Direction::egress, 0}};
  bench_.round();
  EXPECT_EQ(troubles(), std::vector<std::string>{"8 frames came in from can0 and none left to "
                                                 "can1: nothing forwards them"});
}

TEST_F(OnTheBench, AReloadIsOneStepOrNothing) {
  bench_.readable = false;
  auto answer = bench_.ask(control::ReloadRequest{});
  ASSERT_TRUE(answer.slices);
  EXPECT_FALSE(answer.slices()) << "it is being read";
  EXPECT_TRUE(is_error(bench_.ask(control::ReloadRequest{}))) << "one at a time";
  bench_.reading().finish();
  EXPECT_TRUE(std::holds_alternative<control::Error>(answer.slices()->body));
  EXPECT_EQ(bench_.state().granted(), 1U);
  bench_.readable = true;
  bench_.system.publishers.clear();
  answer = bench_.ask(control::ReloadRequest{});
  bench_.reading().finish();
  EXPECT_TRUE(std::holds_alternative<control::Done>(answer.slices()->body));
  EXPECT_EQ(bench_.state().granted(), 0U);
  EXPECT_EQ(wrong_gate(bench_), "");
}

TEST_F(OnTheBench, WhatAnotherProgramUnpinsIsPinnedAgain) {
  bench_.kernel.pinned = false;
  bench_.events.clear();
  bench_.round();
  EXPECT_TRUE(bench_.kernel.pinned);
  ASSERT_FALSE(bench_.events.empty());
  EXPECT_EQ(bench_.events.front(), "drift");
}

TEST_F(OnTheBench, GatesThatClosedForWantOfAHeartBeatAreReconciledAndOpened) {
  bench_.clock.monotonic += 60'000'000'000;
  bench_.kernel.advance_to(bench_.clock.monotonic);
  ASSERT_FALSE(bench_.kernel.passes());
  bench_.daemon().beat();
  EXPECT_TRUE(bench_.kernel.passes());
  EXPECT_EQ(bench_.events.back(), "lapsed");
}

TEST_F(OnTheBench, ALapseIsAReasonOfTheHealthForFiveMinutes) {
  const auto reasons = [this] {
    return std::get<control::Status>(bench_.ask(control::StatusRequest{}).reply.body)
        .health.reasons;
  };
  ASSERT_EQ(reasons(), std::vector<std::string>{});
  bench_.clock.monotonic += 60'000'000'000;
  bench_.kernel.advance_to(bench_.clock.monotonic);
  bench_.daemon().beat();
  bench_.clock.monotonic += 3'000'000'000;
  EXPECT_EQ(reasons(), std::vector<std::string>{
                           "the gates were closed until 3 s ago, because the daemon gave no "
                           "heart-beat for more than the grace"});
  bench_.clock.monotonic += 297'000'000'000;
  EXPECT_EQ(reasons(), std::vector<std::string>{});
}

/// Of a channel that was refused, frames do not differ from what it is granted later.
TEST_F(OnTheBench, WhatWasDroppedWhileAChannelWasRefusedIsNoReasonAfterIt) {
  const auto reasons = [this] {
    return std::get<control::Status>(bench_.ask(control::StatusRequest{}).reply.body)
        .health.reasons;
  };
  bench_.round();
  bench_.ask(control::WithdrawRequest{"c0"});
  bench_.act();
  bench_.round();
  bench_.gates().counted[1].dropped = 61;
  bench_.events.clear();
  bench_.ask(control::ReinstateRequest{"c0"});
  bench_.act();
  EXPECT_EQ(std::ranges::count(bench_.events, "dropped"), 1) << "they are reported all the same";
  bench_.round();
  EXPECT_EQ(reasons(), std::vector<std::string>{});
  bench_.gates().counted[1].dropped = 63;
  bench_.clock.monotonic += 1'000'000'000;
  bench_.round();
  ASSERT_FALSE(reasons().empty());
  for (const std::string& reason : reasons())
    EXPECT_TRUE(reason.contains("2 frames on ")) << reason << ": those that came since";
}

/// Two gateways "a" and "b" that join the same networks: a forwards the channel, this one is b.
TEST(StandBy, WhatAnotherGatewayForwardsIsNoTroubleOfThisOne) {
  core::System system = small_system();
  system.gateways.push_back(system.gateways[0]);
  system.gateways[0].name = "a";
  system.gateways[1].name = "b";
  for (core::Network& network : system.networks)
    network.subscriptions.accept = core::Subscribing::gateways;
  for (core::Gateway& gateway : system.gateways) {
    gateway.presence = 500 * kMs;
    for (core::Port& port : gateway.ports) port.control_uid = member().uid;
  }
  Bench bench(system);
  bench.self = 1;
  ASSERT_FALSE(bench.start());
  const auto status = [&] {
    return std::get<control::Status>(bench.ask(control::StatusRequest{}).reply.body);
  };
  const auto channel = [&] {
    return std::get<control::Channels>(bench.ask(control::ExplainRequest{"c0"}).reply.body)
        .channels.at(0);
  };
  bench.round();
  bench.events.clear();
  bench.gates().watched = control::Watch{.period_ns = 50 * kMs, .since_last_ns = 9'000 * kMs};
  bench.gates().counted[1] = {.dropped = 61, .last_reason = core::FrameReason::denied};
  for (int second = 0; second < 3; ++second) {
    bench.clock.monotonic += 1'000'000'000;
    bench.gates().counted[1].dropped += 20;
    bench.round();
  }
  EXPECT_TRUE(channel().granted);
  EXPECT_EQ(channel().carried_by, std::vector<std::string>{"a"});
  EXPECT_EQ(channel().problems, std::vector<std::string>{});
  EXPECT_TRUE(channel().crosses_no_gate);
  EXPECT_EQ(channel().dropped, 0U);
  EXPECT_EQ(status().health.state, control::HealthState::healthy);
  EXPECT_EQ(status().health.reasons, std::vector<std::string>{});
  EXPECT_EQ(std::ranges::count(bench.events, "dropped"), 0);

  gate_event missing{};
  missing.kind = GATE_E_MISSING;
  missing.subject = 1;
  missing.silent = 9'000 * kMs;
  bench.control().events.push_back(missing);
  bench.daemon().gates_reported();
  EXPECT_EQ(std::ranges::count(bench.events, "missing"), 0) << "a supervises it";

  // It takes over: what was dropped until then does not differ from its grant.
  bench.gates().watched.reset();
  for (int step = 0; step < 300 && channel().carried_by == std::vector<std::string>{"a"}; ++step) {
    bench.clock.monotonic += 100'000'000;
    ASSERT_TRUE(std::holds_alternative<control::Presence>(
        bench.ask(control::PresenceRequest{}).reply.body));
    bench.act();
  }
  bench.round();
  EXPECT_EQ(channel().carried_by, std::vector<std::string>{});
  EXPECT_TRUE(channel().granted);
  EXPECT_EQ(channel().problems, std::vector<std::string>{});
  EXPECT_EQ(std::ranges::count(bench.events, "dropped"), 0);
}

}  // namespace
}  // namespace mlcca::test
