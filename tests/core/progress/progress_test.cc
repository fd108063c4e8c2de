// SPDX-License-Identifier: BSD-2-Clause
// Whatever is done to all channels at once says in between that it goes on.
#include "core/model/progress.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/admission/state.hpp"
#include "core/gates/control_traffic.hpp"
#include "tests/core/robot.hpp"
#include "tests/support/stretches.hpp"

namespace mlcca::core::testing {
namespace {

using test::Stretches;

constexpr std::size_t kChannels = 10'000;
/// Allocations: what some tens of channels need, however many there are.
constexpr std::size_t kLongest = 2'000;

/// Of each channel a publisher on one network and a subscriber on the gateway. `capacity`: of the
/// network, in channels; nothing: it is not stated.
System many(NetworkKind kind, std::optional<std::size_t> capacity = {}) {
  System system;
  Network wire;
  wire.name = "wire";
  wire.kind = kind;
  wire.profile = Profile::famouso;
  wire.provision.set(Attribute::latency, kMs).set(Attribute::period, kMs);
  wire.provision.set(Attribute::omission, 0).set(Attribute::max_payload, 64);
  if (capacity) wire.provision.set(Attribute::bandwidth, *capacity * 8000 / 50);
  Gateway bridge;
  bridge.name = "bridge";
  bridge.provision.set(Attribute::latency, kMs).set(Attribute::omission, 0);
  Port port;
  port.network = 0;
  port.identity.name = "eth0";
  bridge.ports = {port};
  system.gateways = {bridge};
  for (std::size_t c = 0; c < kChannels; ++c) {
    EventChannel channel;
    channel.name = "c" + std::to_string(c);
    channel.subject = c + 1;
    channel.attributes = heart_beat();
    system.channels.push_back(channel);
    Publisher publisher;
    publisher.name = "p" + std::to_string(c);
    publisher.channel = c;
    publisher.place = network(0);
    publisher.attributes = heart_beat();
    system.publishers.push_back(publisher);
    system.subscribers.push_back(subscriber("s" + std::to_string(c), gateway(0), heart_beat()));
    system.subscribers.back().channel = c;
    Binding binding;
    binding.channel = c;
    binding.id = static_cast<std::uint32_t>(c + 16);
    binding.extended = true;
    if (kind == NetworkKind::can) wire.bindings.push_back(binding);
  }
  system.networks = {wire};
  return system;
}

Condition down() {
  Condition condition;
  condition.available = false;
  condition.problem = "eth0 is down";
  return condition;
}

std::size_t longest_of(const auto& work) {
  Stretches stretches;
  work();
  return stretches.longest();
}

TEST(ProgressTest, IsCalledWhileTheOnlyNetworkOfManyChannelsGoesAndComes) {
  State state(many(NetworkKind::udp_multicast));
  ASSERT_EQ(state.granted(), kChannels);
  for (const Condition& condition : {down(), Condition{}}) {
    state.set_condition(0, condition);
    std::vector<DecisionChange> changes;
    EXPECT_LE(longest_of([&] { changes = state.settle(); }), kLongest);
    ASSERT_EQ(changes.size(), kChannels);
    EXPECT_LE(longest_of([&] { static_cast<void>(state.gate_changes(changes, 0)); }), kLongest);
  }
}

TEST(ProgressTest, IsReportedWhileChannelsThatShareANetworkAreDegraded) {
  State state(many(NetworkKind::udp_multicast, kChannels / 2));
  ASSERT_NE(state.granted(), 0U);
  ASSERT_NE(state.refused(), 0U);
  for (const Condition& condition : {down(), Condition{}}) {
    state.set_condition(0, condition);
    EXPECT_LE(longest_of([&] { static_cast<void>(state.settle()); }), kLongest);
  }
  ASSERT_NE(state.granted(), 0U);
}

TEST(ProgressTest, IsReportedWhileEverythingIsInvalidated) {
  State state(many(NetworkKind::udp_multicast));
  EXPECT_LE(longest_of([&] {
              state.invalidate_all();
              static_cast<void>(state.settle());
            }),
            kLongest);
  EXPECT_LE(longest_of([&] { state.decide(); }), kLongest);
}

TEST(ProgressTest, IsCalledWhileTheRulesOfAllGatesArePlannedAndCompared) {
  const State state(many(NetworkKind::udp_multicast));
  GateState all;
  EXPECT_LE(longest_of([&] { all = state.gate_state(0); }), kLongest);
  ASSERT_EQ(all.size(), kChannels);
  Stretches stretches;
  EXPECT_EQ(gate_changes_between({}, all).add.size(), kChannels);
  EXPECT_TRUE(gate_changes_between(all, all).empty());
  EXPECT_GE(stretches.reports(), 2 * kChannels / 64);
}

TEST(ProgressTest, IsCalledWhileControlTrafficIsHeldAgainstAllBindings) {
  const System system = many(NetworkKind::can);
  Stretches stretches;
  ASSERT_FALSE(control_rules(system, 0, {}).empty());
  EXPECT_GE(stretches.reports(), kChannels / 64);
}

TEST(ProgressTest, ManyShortStepsAreReportedAsOne) {
  int called = 0;
  const auto steps = [](int count) {
    for (int i = 0; i < count; ++i) Progress::step();
  };
  steps(1000);
  {
    const Progress outer([&] { ++called; });
    {
      const Progress inner([] {});
      steps(1000);
      Progress::made();
    }
    EXPECT_EQ(called, 0) << "the latest one is called";
    Progress::made();
    EXPECT_EQ(called, 1);
    steps(1000);
    EXPECT_GT(called, 10);
    EXPECT_LT(called, 100);
  }
  const int before = called;
  steps(1000);
  Progress::made();
  EXPECT_EQ(called, before);
}

}  // namespace
}  // namespace mlcca::core::testing
