// SPDX-License-Identifier: BSD-2-Clause
// A test bench for gateways that can replace each other and announce themselves, in simulated time.
#pragma once
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

#include "core/model/presence.hpp"
#include "daemon/gateway/gateway_presence.hpp"
#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test::presence {

inline constexpr Value kInterval = 500 * kMs;
inline constexpr Value kGrace = 2'000 * kMs;
inline constexpr Value kStep = 10 * kMs;
inline constexpr Value kLasts = 3 * kInterval + kGrace;
inline constexpr std::size_t kEthernet = 2;
inline constexpr uid_t kRelay = 990;

/// Two or three gateways that join the same two buses and an Ethernet. Channel c0 goes from bus to
/// bus.
inline core::System side_by_side(std::size_t gateways) {
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

/// One gateway: its daemon, the program that announces it, and its gates.
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
  /// Ends the daemon. The gates stay as they are until the grace has passed.
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

  /// Makes a network available or not, seen from this gateway.
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
  bool program = true;  ///< whether mlcca-famouso runs

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

/// Several nodes, and the messages between them.
class PresenceTest : public ::testing::Test {
 protected:
  /// Nodes of so many gateways, in the place of former ones.
  void set_up(std::size_t gateways) {
    nodes_.clear();
    none_ = several_ = longest_none_ = longest_several_ = 0;
    system_ = side_by_side(gateways);
    for (std::size_t g = 0; g < gateways; ++g)
      nodes_.push_back(std::make_unique<Node>(system_, g, clock_));
    cut_.assign(gateways, std::vector<bool>(system_.networks.size(), false));
    losses_.assign(gateways * gateways * system_.networks.size(), 0);
  }

  /// Two or three gateways, whose messages are lost at random.
  void set_up_at_random(std::uint64_t seed) {
    random_.seed(seed);
    loss_ = 30;
    set_up(2 + seed % 2);
  }

  /// Delivers the announcement of a gateway to all others, on each network that both reach.
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
  /// Whether a message is lost; at most two in a row are.
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
        // Gateways do not announce themselves at the same moment.
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
  /// By gateway and network: the gateway is in the part of the network that is cut off.
  std::vector<std::vector<bool>> cut_;
  std::vector<std::size_t> losses_;
  unsigned loss_ = 0;  ///< percent of the messages
  Random random_{42};
  Value none_ = 0;
  Value several_ = 0;
  Value longest_none_ = 0;
  Value longest_several_ = 0;
};

}  // namespace mlcca::test::presence
