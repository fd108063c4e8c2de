// SPDX-License-Identifier: BSD-2-Clause
// Tests of missing events for subscribers with different timeouts, in a complete gateway with
// fakes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/gates/plan.hpp"
#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

/// Channel c0 has events every 50 ms from can0 to can1, where up to six events may be lost, and to
/// eth0, where none may be.
core::System with_two_subscribers() {
  core::System system = small_system();
  for (core::Network& n : system.networks) n.provision.set(Attribute::omission, 0);
  system.gateways[0].provision.set(Attribute::omission, 0);
  system.subscribers[0].attributes.set(Attribute::omission, 6);
  core::Subscriber strict = system.subscribers[0];
  strict.name = "strict";
  strict.place.index = 2;
  strict.attributes.set(Attribute::omission, 0);
  system.subscribers.push_back(strict);
  return system;
}

constexpr std::size_t kPatient = 1;  // index of the network whose subscriber waits longer
constexpr std::size_t kStrict = 2;

class Silence : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_FALSE(bench_.start());
    ASSERT_EQ(bench_.state().granted(), 2U);
    ASSERT_GT(patience(kPatient), 5 * patience(kStrict));
    bench_.log().on_event([this](const control::Event& event) {
      if (event.kind == "missing" || event.kind == "restored")
        said_.push_back(event.kind + " " + event.network);
    });
  }
  /// The timeout of the subscribers on a network.
  [[nodiscard]] Value patience(std::size_t network) const {
    for (const core::Verdict& v : bench_.state().decisions()[0].verdicts)
      if (v.to.index == network) return core::silence_of(v);
    return 0;
  }
  void TearDown() override { bench_.log().on_event({}); }

  void gate_says(std::uint32_t kind, std::uint64_t silent) {
    gate_event event{};
    event.kind = kind;
    event.subject = 1;
    event.silent = silent;
    bench_.control().events.push_back(event);
    bench_.daemon().gates_reported();
  }
  /// Sets the age of the latest event.
  void is_silent_for(std::uint64_t ns) {
    bench_.gates().watched = control::Watch{};
    bench_.gates().watched->period_ns = 50 * kMs;
    bench_.gates().watched->events = 9;
    bench_.gates().watched->since_last_ns = ns;
  }
  std::vector<std::string> after(std::uint64_t ns) {
    bench_.clock.monotonic += ns;
    bench_.round();
    return std::exchange(said_, {});
  }

  /// What `channels` reports about the arrival of the delivery's events on that network.
  [[nodiscard]] control::Watch shown(std::size_t network) {
    const auto answer = bench_.ask(control::ExplainRequest{"c0"});
    for (const control::Channel& one : std::get<control::Channels>(answer.reply.body).channels)
      if (one.to == bench_.system.networks[network].name)
        return one.watch.value_or(control::Watch{});
    return {};
  }
  [[nodiscard]] bool is_shown(std::size_t network) { return shown(network).missing_now; }
  [[nodiscard]] std::uint64_t shown_silence(std::size_t network) {
    return shown(network).silent_ns;
  }

  Bench bench_{with_two_subscribers()};
  std::vector<std::string> said_;
};

using Said = std::vector<std::string>;

TEST_F(Silence, IsReportedToEachSubscriberWhenItsOwnTimeIsOver) {
  gate_says(GATE_E_MISSING, patience(kStrict));
  EXPECT_EQ(std::exchange(said_, {}), Said{"missing eth0"});
  is_silent_for(patience(kPatient) - kMs);
  EXPECT_EQ(after(patience(kPatient) - kMs - patience(kStrict)), Said{}) << "a millisecond is left";
  is_silent_for(patience(kPatient));
  EXPECT_EQ(after(kMs), Said{"missing can1"});
  EXPECT_EQ(after(60 * kMs), Said{}) << "once";
  gate_says(GATE_E_RESTORED, 500 * kMs);
  std::ranges::sort(said_);
  EXPECT_EQ(said_, (Said{"restored can1", "restored eth0"}));
}

TEST_F(Silence, ThatIsOverInTimeIsNotReportedToWhoWaitsLonger) {
  gate_says(GATE_E_MISSING, patience(kStrict));
  gate_says(GATE_E_RESTORED, patience(kStrict) + kMs);
  EXPECT_EQ(std::exchange(said_, {}), (Said{"missing eth0", "restored eth0"}));
  is_silent_for(10 * kMs);
  EXPECT_EQ(after(1'000 * kMs), Said{});
}

/// The gate reports the end of a silence only after events have come for a while.
TEST_F(Silence, IsMeasuredFromTheLatestEvent) {
  gate_says(GATE_E_MISSING, patience(kStrict));
  said_.clear();
  is_silent_for(20 * kMs);
  EXPECT_EQ(after(patience(kPatient) - patience(kStrict)), Said{});
  is_silent_for(patience(kPatient));
  EXPECT_EQ(after(patience(kPatient) - 20 * kMs), Said{"missing can1"});
}

/// Between the two silences the gate was closed and opened again, so it does not report the end of
/// the first one.
TEST_F(Silence, ThatRecursIsReportedAgain) {
  for (int i = 0; i < 2; ++i) {
    gate_says(GATE_E_MISSING, patience(kStrict));
    said_.clear();
    is_silent_for(patience(kPatient));
    EXPECT_EQ(after(patience(kPatient) - patience(kStrict)), Said{"missing can1"}) << i;
  }
}

/// As long as the end of a silence is not reported, even if events have come meanwhile.
TEST_F(Silence, IsShownForWhoWaitsLongerUntilItsEndIsReported) {
  gate_says(GATE_E_MISSING, patience(kStrict));
  EXPECT_FALSE(is_shown(kPatient)) << "its own time is not over";
  is_silent_for(patience(kPatient));
  after(patience(kPatient) - patience(kStrict));
  EXPECT_TRUE(is_shown(kPatient));
  EXPECT_EQ(shown_silence(kPatient), patience(kPatient));
  is_silent_for(10 * kMs);
  EXPECT_TRUE(is_shown(kPatient)) << "the first event has come";
  gate_says(GATE_E_RESTORED, patience(kPatient) + kMs);
  EXPECT_FALSE(is_shown(kPatient));
}

/// A delivery that is granted again has had no event yet. Its own exception says so, whatever was
/// reported before. A gate that gets another subscriber reports the silence once more.
TEST_F(Silence, IsReportedToWhoIsGrantedOrAdmittedMeanwhile) {
  const auto never = [this] {
    gate_event event{};
    event.kind = GATE_E_MISSING;
    event.subject = 1;
    event.silent = patience(kPatient);
    event.never = 1;
    bench_.control().events.push_back(event);
    bench_.daemon().gates_reported();
    auto said = std::exchange(said_, {});
    std::ranges::sort(said);
    return said;
  };
  const Said both{"missing can1", "missing eth0"};
  EXPECT_EQ(never(), both);
  static_cast<void>(bench_.ask(control::WithdrawRequest{"c0"}));
  static_cast<void>(bench_.ask(control::ReinstateRequest{"c0"}));
  bench_.clock.monotonic += 1'000 * kMs;
  EXPECT_EQ(never(), both);
}

/// The reasons why a gateway is degraded in which no event of channel c0 has come for a minute.
std::vector<std::string> reasons_after_a_minute(core::Arrival arrival, std::uint64_t events) {
  core::System system = with_two_subscribers();
  system.subscribers.pop_back();
  system.subscribers[0].attributes.clear(Attribute::omission);
  system.channels[0].arrival = arrival;
  Bench bench{std::move(system)};
  EXPECT_FALSE(bench.start());
  EXPECT_EQ(bench.state().granted(), 1U);
  bench.gates().watched = control::Watch{};
  bench.gates().watched->period_ns = 50 * kMs;
  bench.gates().watched->events = events;
  bench.gates().watched->since_last_ns = 60'000 * kMs;
  bench.clock.monotonic += 60'000 * kMs;
  bench.round();
  return std::get<control::Status>(bench.ask(control::StatusRequest{}).reply.body).health.reasons;
}

TEST(SilenceOfSporadicEvents, IsNoReasonToBeDegraded) {
  for (const std::uint64_t events : {0U, 9U}) {
    EXPECT_EQ(reasons_after_a_minute(core::Arrival::sporadic, events), Said{});
    EXPECT_EQ(reasons_after_a_minute(core::Arrival::periodic, events).size(), 1U);
  }
}

TEST_F(Silence, OfAChannelThatIsGrantedNoMoreIsNotReported) {
  gate_says(GATE_E_MISSING, patience(kStrict));
  said_.clear();
  is_silent_for(400 * kMs);
  bench_.system.subscribers.erase(bench_.system.subscribers.begin());
  static_cast<void>(bench_.ask(control::ReloadRequest{}));
  bench_.reading().finish();
  EXPECT_EQ(after(400 * kMs), Said{});
}

}  // namespace
}  // namespace mlcca::test
