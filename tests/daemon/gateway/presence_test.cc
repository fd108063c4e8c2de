// SPDX-License-Identifier: BSD-2-Clause
// Gateways side by side that announce themselves: one of them forwards, whatever fails, but for
// bounded times.
#include "core/model/presence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "daemon/gateway/gateway_presence.hpp"
#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

constexpr Value kInterval = 500 * kMs;
constexpr Value kGrace = 2'000 * kMs;
constexpr Value kStep = 10 * kMs;
constexpr Value kLasts = 3 * kInterval + kGrace;
constexpr std::size_t kEthernet = 2;
constexpr uid_t kRelay = 990;

/// Two gateways, or three, join the same two buses and an Ethernet; c0 goes from bus to bus.
core::System side_by_side(std::size_t gateways) {
  core::System system = small_system();
  for (core::Network& network : system.networks)
    network.subscriptions.accept = core::Subscribing::gateways;
  const core::Gateway one = system.gateways[0];
  system.gateways.clear();
  for (std::size_t g = 0; g < gateways; ++g) {
    system.gateways.push_back(one);
    system.gateways.back().name = std::string(1, static_cast<char>('a' + g));
    system.gateways.back().presence = kInterval;
    system.gateways.back().relay = kRelay;
  }
  return system;
}

/// One gateway with its daemon, the program that announces it, and what its gates do.
class Node {
 public:
  Node(core::System system, std::size_t self, const FakeClock& clock)
      : system_(std::move(system)), self_(self), clock_(clock) {
    start();
  }

  void start() {
    log_ = std::make_unique<EventLog>(SystemLog::to_journald("/nowhere/at/all"));
    scene_ = std::make_unique<Scene>();
    scene_->state = std::make_unique<core::State>(system_);
    scene_->self = self_;
    control_.set_grace(kGrace).value();
    control_.open();
    presence = std::make_unique<GatewayPresence>(
        GatewayPresence::Parts{*scene_, control_, carriers_, *log_, clock_});
    presence->start();
    relay(true);
    died_at_.reset();
    act();
  }
  /// Its gates stay as they are until the grace is over.
  void kill() {
    presence.reset();
    died_at_ = clock_.monotonic_ns();
  }
  [[nodiscard]] bool runs() const { return presence != nullptr; }

  void act() {
    presence->apply(*scene_->state);
    static_cast<void>(scene_->state->settle());
  }
  [[nodiscard]] bool forwards() const {
    if (died_at_ && clock_.monotonic_ns() - *died_at_ >= kGrace) return false;
    const auto& verdicts = scene_->state->decisions()[0].verdicts;
    return std::ranges::any_of(verdicts, [this](const core::Verdict& v) {
      return v.granted && std::ranges::find(v.route, core::Place{core::Place::Kind::gateway,
                                                                 self_}) != v.route.end();
    });
  }

  /// A network of its own side is there, or not.
  void plug(std::size_t network, bool there) {
    core::Condition condition;
    condition.available = there;
    scene_->state->set_condition(network, std::move(condition));
    act();
  }
  FakeControl& control() { return control_; }
  void relay(bool connected) {
    if (connected)
      carriers_.add(1, kRelay);
    else
      carriers_.session_closed(1);
  }

  std::unique_ptr<GatewayPresence> presence;
  bool program = true;  ///< mlcca-famouso runs

 private:
  core::System system_;
  std::size_t self_;
  const FakeClock& clock_;
  FakeKernel kernel_;
  FakeControl control_{kernel_};
  Carriers carriers_;
  std::unique_ptr<EventLog> log_;
  std::unique_ptr<Scene> scene_;
  std::optional<std::uint64_t> died_at_;
};

class PresenceTest : public ::testing::Test {
 protected:
  void set_up(std::size_t gateways) {
    system_ = side_by_side(gateways);
    for (std::size_t g = 0; g < gateways; ++g)
      nodes_.push_back(std::make_unique<Node>(system_, g, clock_));
    cut_.assign(gateways, std::vector<bool>(system_.networks.size(), false));
    losses_.assign(gateways * gateways * system_.networks.size(), 0);
  }

  /// What a gateway announces, to all others on each network that both reach.
  void announce(std::size_t from) {
    const control::Presence own = nodes_[from]->presence->announce();
    for (std::size_t to = 0; to < nodes_.size(); ++to)
      for (std::size_t n = 0; n < system_.networks.size(); ++n) {
        if (to == from || !nodes_[to]->runs() || !nodes_[to]->program) continue;
        if (cut_[from][n] != cut_[to][n] || loses(from, to, n)) continue;
        EXPECT_TRUE(nodes_[to]->presence->receive({.network = system_.networks[n].name,
                                                   .gateway = own.gateway,
                                                   .lasts_ns = own.lasts_ns,
                                                   .forwards = own.forwards,
                                                   .not_received = own.not_received}));
        nodes_[to]->act();
      }
  }
  /// At most two messages in a row.
  bool loses(std::size_t from, std::size_t to, std::size_t n) {
    std::size_t& in_a_row = losses_[(from * nodes_.size() + to) * system_.networks.size() + n];
    in_a_row = in_a_row < 2 && chance(random_, loss_) ? in_a_row + 1 : 0;
    return in_a_row != 0;
  }

  void run(Value time) {
    for (const Value end = clock_.monotonic + time; clock_.monotonic < end;) {
      clock_.monotonic += kStep;
      for (std::size_t g = 0; g < nodes_.size(); ++g) {
        if (!nodes_[g]->runs()) continue;
        // Not all at the same moment.
        if (nodes_[g]->program && clock_.monotonic % kInterval == g * 3 * kStep) announce(g);
        nodes_[g]->act();
      }
      watch();
    }
  }
  void watch() {
    const auto now = forwarders().size();
    none_ = now == 0 ? none_ + kStep : 0;
    several_ = now > 1 ? several_ + kStep : 0;
    longest_none_ = std::max(longest_none_, none_);
    longest_several_ = std::max(longest_several_, several_);
  }
  [[nodiscard]] std::string forwarders() const {
    std::string out;
    for (std::size_t g = 0; g < nodes_.size(); ++g)
      if (nodes_[g]->forwards()) out += system_.gateways[g].name;
    return out;
  }

  FakeClock clock_;
  core::System system_;
  std::vector<std::unique_ptr<Node>> nodes_;
  std::vector<std::vector<bool>> cut_;  ///< by gateway and network: on the other half of it
  std::vector<std::size_t> losses_;
  unsigned loss_ = 0;  ///< percent
  Random random_{42};
  Value none_ = 0;
  Value several_ = 0;
  Value longest_none_ = 0;
  Value longest_several_ = 0;
};

TEST_F(PresenceTest, TheFirstOneForwardsWhileAllAreThere) {
  set_up(3);
  run(10'000 * kMs);
  EXPECT_EQ(forwarders(), "a");
  EXPECT_EQ(longest_several_, 0U);
  EXPECT_EQ(longest_none_, 0U);
}

TEST_F(PresenceTest, TheNextOneTakesOverWithinThreeIntervalsAndTheGraceAndGivesBack) {
  set_up(3);
  run(3'000 * kMs);
  nodes_[0]->kill();
  run(kGrace - 2 * kStep);
  EXPECT_EQ(forwarders(), "a") << "its gates are as they were, and nobody else forwards";
  run(kLasts - kGrace + 3 * kStep);
  EXPECT_EQ(forwarders(), "b");
  EXPECT_LE(longest_none_, 3 * kInterval + kStep);
  nodes_[0]->start();
  run(2 * kInterval);
  EXPECT_EQ(forwarders(), "a");
  EXPECT_LE(longest_several_, kInterval + kStep);
}

TEST_F(PresenceTest, WhoDoesNotAnnounceItselfLeavesForwardingToOthersBeforeTheyTakeIt) {
  set_up(2);
  run(3'000 * kMs);
  nodes_[0]->program = false;
  run(2 * kInterval + 10 * kStep);
  EXPECT_EQ(forwarders(), "");
  ASSERT_EQ(nodes_[0]->presence->problems().size(), 1U);
  EXPECT_EQ(nodes_[0]->presence->problems().front(),
            "gateway a leaves to others what they can forward: mlcca-famouso --subscriptions does "
            "not ask what to announce, so others may take its place");
  run(kLasts);
  EXPECT_EQ(forwarders(), "b");
  EXPECT_EQ(longest_several_, 0U);
  nodes_[0]->program = true;
  run(2 * kInterval);
  EXPECT_EQ(forwarders(), "a");
}

TEST_F(PresenceTest, TheLastOneForwardsAlsoWhenAllOthersAreGone) {
  set_up(2);
  run(3'000 * kMs);
  nodes_[0]->kill();
  run(2 * kLasts);
  EXPECT_EQ(forwarders(), "b");
  nodes_[1]->kill();
  nodes_[0]->start();
  run(2 * kLasts);
  EXPECT_EQ(forwarders(), "a");
}

TEST_F(PresenceTest, OneNetworkIsEnoughToBeThere) {
  set_up(2);
  run(3'000 * kMs);
  cut_[0][kEthernet] = true;
  run(2 * kLasts);
  EXPECT_EQ(forwarders(), "a") << "the buses still have its announcements";
  EXPECT_TRUE(nodes_[1]->presence->problems().empty());
}

TEST_F(PresenceTest, GatewaysThatAreCutOffFromEachOtherBothForward) {
  set_up(2);
  run(3'000 * kMs);
  cut_[0].assign(cut_[0].size(), true);
  run(2 * kLasts);
  EXPECT_EQ(forwarders(), "ab");
  cut_[0].assign(cut_[0].size(), false);
  run(kInterval + kStep);
  EXPECT_EQ(forwarders(), "a");
}

TEST_F(PresenceTest, WhoIsNotReceivedAnywhereGivesWay) {
  set_up(2);
  run(3'000 * kMs);
  // Frames of the first one do not reach the second one; the other way they do.
  control::PresenceRequest from_b{.network = system_.networks[0].name,
                                  .gateway = "b",
                                  .lasts_ns = kLasts,
                                  .forwards = true,
                                  .not_received = {"a"}};
  ASSERT_TRUE(nodes_[0]->presence->receive(from_b));
  EXPECT_TRUE(nodes_[0]->presence->announce().forwards) << "it may not have received it yet";
  EXPECT_FALSE(nodes_[0]->presence->announce().forwards);
  nodes_[0]->act();
  EXPECT_FALSE(nodes_[0]->forwards());
  EXPECT_EQ(nodes_[0]->presence->problems().front(),
            "gateway a leaves to others what they can forward: b receives nothing of it, and "
            "forwards instead");
  EXPECT_FALSE(nodes_[0]->presence->announce().forwards);
  from_b.not_received.clear();
  ASSERT_TRUE(nodes_[0]->presence->receive(from_b));
  nodes_[0]->act();
  EXPECT_TRUE(nodes_[0]->forwards());
}

TEST_F(PresenceTest, WhoCannotForwardSaysSoAndTheNextOneDoesAtOnce) {
  set_up(2);
  run(3'000 * kMs);
  nodes_[0]->plug(1, false);
  run(kInterval + kStep);
  EXPECT_EQ(forwarders(), "b");
  EXPECT_EQ(nodes_[0]->presence->problems().front(),
            "gateway a leaves to others what they can forward: " + system_.networks[1].name +
                " is not available here");
  EXPECT_EQ(nodes_[1]->presence->problems().front(),
            "gateway a has failed: it says that it cannot forward");
  nodes_[0]->plug(1, true);
  run(kInterval + kStep);
  EXPECT_EQ(forwarders(), "a");
  // Nobody can: that is as it was without a second one.
  nodes_[0]->plug(1, false);
  nodes_[1]->plug(1, false);
  run(kInterval + kStep);
  EXPECT_EQ(forwarders(), "");
  nodes_[0]->control().close_all();
  EXPECT_FALSE(nodes_[0]->presence->announce().forwards);
}

TEST_F(PresenceTest, WithoutItsRelayAGatewayLeavesWhatThatWouldCarry) {
  set_up(2);
  run(3'000 * kMs);
  nodes_[0]->relay(false);
  run(3'000 * kMs);
  EXPECT_EQ(forwarders(), "a") << "c0 goes from bus to bus, by can-gw";
  nodes_.clear();
  system_.subscribers[0].place = {core::Place::Kind::network, kEthernet};
  for (std::size_t g = 0; g < 2; ++g) nodes_.push_back(std::make_unique<Node>(system_, g, clock_));
  run(3'000 * kMs);
  EXPECT_EQ(forwarders(), "a");
  nodes_[0]->relay(false);
  run(2 * kInterval - kStep);
  EXPECT_EQ(forwarders(), "a") << "it may be starting again";
  run(3 * kInterval);
  EXPECT_EQ(forwarders(), "b");
  EXPECT_EQ(nodes_[0]->presence->problems().front(),
            "gateway a leaves to others what they can forward: mlcca-relay is not connected");
  nodes_[0]->relay(true);
  run(kInterval + kStep);
  EXPECT_EQ(forwarders(), "a");
}

TEST_F(PresenceTest, WhatWasKnownCountsWhileNothingIsAnnounced) {
  set_up(2);
  run(3'000 * kMs);
  nodes_[1]->kill();
  run(2 * kLasts);
  EXPECT_EQ(forwarders(), "a");
  nodes_[0]->program = false;
  run(2 * kLasts);
  EXPECT_EQ(forwarders(), "a") << "the other one was gone before";
}

TEST_F(PresenceTest, ANetworkThatComesBackHasATimeOfItsOwn) {
  set_up(2);
  run(3'000 * kMs);
  for (std::size_t n = 0; n < system_.networks.size(); ++n) nodes_[1]->plug(n, false);
  run(3 * kLasts);
  for (std::size_t n = 0; n < system_.networks.size(); ++n) nodes_[1]->plug(n, true);
  EXPECT_TRUE(nodes_[1]->presence->announce().not_received.empty());
  run(2 * kInterval);
  EXPECT_EQ(forwarders(), "a");
  EXPECT_EQ(longest_several_, 0U);
}

TEST_F(PresenceTest, OnlyGatewaysThatAnnounceThemselvesThereAreTaken) {
  set_up(2);
  const std::string bus = system_.networks[0].name;
  const auto receive = [&](const std::string& network, const std::string& gateway) {
    const auto taken = nodes_[0]->presence->receive(
        {.network = network, .gateway = gateway, .lasts_ns = kLasts, .forwards = true});
    return taken ? std::string() : taken.error().text;
  };
  EXPECT_EQ(receive(bus, "b"), "");
  EXPECT_EQ(receive(bus, "a"), "'a' is not described as another gateway");
  EXPECT_EQ(receive(bus, "z"), "'z' is not described as another gateway");
  EXPECT_EQ(receive("nowhere", "b"), "b does not announce itself to this gateway on 'nowhere'");
}

TEST_F(PresenceTest, TimesThatNoGatewayCanStateAreRefused) {
  set_up(2);
  const auto receive = [&](Value lasts) {
    return nodes_[0]
        ->presence
        ->receive({.network = system_.networks[0].name,
                   .gateway = "b",
                   .lasts_ns = lasts,
                   .forwards = true})
        .has_value();
  };
  EXPECT_FALSE(receive(0));
  EXPECT_FALSE(receive(3 * kInterval - 1));
  EXPECT_TRUE(receive(3 * kInterval));
  EXPECT_TRUE(receive(3 * kInterval + core::kLongestPresenceGrace));
  EXPECT_FALSE(receive(3 * kInterval + core::kLongestPresenceGrace + 1));
  EXPECT_FALSE(receive(~Value{0}));
}

/// A whole daemon: what takes another way is reported, so that programs ask where they send now.
TEST(PresenceOfADaemon, ReportsWhatTakesAnotherWay) {
  core::System system = side_by_side(2);
  for (core::Port& port : system.gateways[0].ports) port.control_uid = 991;
  system.gateways[0].name = "g";
  Bench bench(std::move(system));
  ASSERT_FALSE(bench.start());
  const serve::Peer program{.pid = 9, .uid = 991, .session = 7};
  const auto ask = [&](const serve::Peer& peer) {
    return bench.ask(control::PresenceRequest{}, peer).reply.body;
  };
  EXPECT_TRUE(std::holds_alternative<control::Error>(ask(member())));
  const auto own = ask(program);
  ASSERT_TRUE(std::holds_alternative<control::Presence>(own));
  EXPECT_TRUE(std::get<control::Presence>(own).forwards);
  EXPECT_EQ(std::get<control::Presence>(own).others, std::vector<std::string>{"b"});
  bench.events.clear();
  bench.clock.monotonic += 2 * kInterval + 1;
  bench.act();
  EXPECT_EQ(bench.events, (std::vector<std::string>{"gateway", "rerouted"}));
  bench.events.clear();
  ask(program);
  bench.act();
  EXPECT_EQ(bench.events, (std::vector<std::string>{"gateway", "rerouted"}));
}

/// Daemons and programs die at any time and come back, and messages are lost, two in a row at most.
TEST_F(PresenceTest, AtRandomOneForwardsButForBoundedTimes) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    random_.seed(seed);
    nodes_.clear();
    none_ = several_ = longest_none_ = longest_several_ = 0;
    loss_ = 30;
    set_up(2 + seed % 2);
    for (int step = 0; step < 30; ++step) {
      Node& one = *nodes_[below(random_, nodes_.size())];
      const bool last =
          std::ranges::count_if(nodes_, [](const auto& n) { return n->runs() && n->program; }) < 2;
      if (!one.runs())
        one.start();
      else if (!last && chance(random_, 50))
        one.kill();
      else if (!last)
        one.program = false;
      // The times are those after each event.
      none_ = several_ = 0;
      run((100 + below(random_, 8'000)) * kMs);
      ASSERT_LE(longest_several_, kLasts) << "seed " << seed;
      ASSERT_LE(longest_none_, kLasts + kInterval) << "seed " << seed;
      // A gateway that nobody announces does not learn who is back, so systemd starts its program
      // again; what others know then has to be true before the next one fails.
      if (!std::exchange(one.program, true)) run(kLasts);
    }
  }
}

}  // namespace
}  // namespace mlcca::test
