// SPDX-License-Identifier: BSD-2-Clause
// Rings of gateways between networks whose frames name the subject: each event comes to each
// network once, and to none that its publisher is not granted.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/admission/state.hpp"
#include "core/model/text.hpp"

namespace mlcca::core {
namespace {

constexpr Value kMs = 1'000'000;

Place network(std::size_t n) { return {Place::Kind::network, n}; }

AttributeSet beats() {
  return AttributeSet{}
      .set(Attribute::period, 50 * kMs)
      .set(Attribute::omission, 2)
      .set(Attribute::max_payload, 8);
}

/// UDP networks "n0", "n1", …, and gateways between the pairs that are named.
System joined(std::size_t networks, const std::vector<std::pair<std::size_t, std::size_t>>& pairs) {
  System system;
  EventChannel& channel = system.channels.emplace_back();
  channel.name = "beat";
  channel.subject = 1;
  channel.attributes = beats();
  for (std::size_t n = 0; n < networks; ++n) {
    Network& one = system.networks.emplace_back();
    one.name = "n" + std::to_string(n);
    one.kind = NetworkKind::udp_multicast;
    one.profile = Profile::famouso;
    one.provision = AttributeSet{}
                        .set(Attribute::latency, kMs)
                        .set(Attribute::jitter, kMs)
                        .set(Attribute::period, kMs)
                        .set(Attribute::omission, 0)
                        .set(Attribute::max_payload, 1'400);
  }
  for (const auto& [a, b] : pairs) {
    Gateway& one = system.gateways.emplace_back();
    one.name = "g" + std::to_string(system.gateways.size() - 1);
    one.provision = AttributeSet{}
                        .set(Attribute::latency, kMs)
                        .set(Attribute::jitter, kMs)
                        .set(Attribute::omission, 0);
    one.relay = 990;
    for (const std::size_t n : {a, b}) one.ports.emplace_back().network = n;
  }
  return system;
}

void publish(System& system, std::size_t at, std::uint64_t address) {
  Publisher& one = system.publishers.emplace_back();
  one.name = "p" + std::to_string(system.publishers.size() - 1);
  one.place = network(at);
  one.attributes = beats();
  one.station.bits = address;
}

void subscribe(System& system, std::size_t at) {
  Subscriber& one = system.subscribers.emplace_back();
  one.name = "s" + std::to_string(system.subscribers.size() - 1);
  one.place = network(at);
  one.attributes = beats();
}

/// What each gateway carries, by what it takes from whom.
class Propagation {
 public:
  Propagation(const System& system, const Decision& decision) : system_(system) {
    for (const Verdict& v : decision.verdicts) {
      if (!v.granted) continue;
      to_[v.publisher].insert(v.to.index);
      for (std::size_t i = 1; i + 1 < v.route.size(); i += 2) {
        to_[v.publisher].insert(v.route[i + 1].index);
        carried_[v.route[i].index].insert({v.route[i - 1].index,
                                           i == 1 ? system.publishers[v.publisher].station.bits : 0,
                                           v.route[i + 1].index});
      }
    }
  }

  /// Lets an event go on for so long that a ring would have carried it round; what is wrong.
  [[nodiscard]] std::string send(std::size_t publisher) const {
    const Publisher& p = system_.publishers[publisher];
    std::map<std::size_t, int> came;
    std::vector<Copy> now = {{p.place.index, kNobody, p.station.bits}};
    for (int step = 0; step < 20 && !now.empty(); ++step) {
      std::vector<Copy> next;
      for (const Copy& copy : now)
        for (const auto& [gateway, flows] : carried_) carry(copy, gateway, flows, next);
      for (const Copy& copy : next) ++came[copy.network];
      now = std::move(next);
    }
    std::string wrong;
    for (const auto& [n, times] : came) {
      const bool granted = to_.contains(publisher) && to_.at(publisher).contains(n);
      if (times > 1) wrong += p.name + " comes to n" + std::to_string(n) + " more than once; ";
      if (!granted) wrong += p.name + " comes to n" + std::to_string(n) + " without a grant; ";
    }
    if (came.contains(p.place.index)) wrong += p.name + " comes back; ";
    return wrong;
  }

 private:
  static constexpr std::size_t kNobody = ~std::size_t{0};
  struct Copy {
    std::size_t network;
    std::size_t sender;     ///< a gateway
    std::uint64_t address;  ///< of the publisher; 0: of nobody that is described
  };
  struct Flow {
    std::size_t from;
    std::uint64_t address;
    std::size_t to;
    auto operator<=>(const Flow&) const = default;
  };

  static void carry(const Copy& copy, std::size_t gateway, const std::set<Flow>& flows,
                    std::vector<Copy>& next) {
    if (gateway == copy.sender) return;
    std::set<std::size_t> to;
    for (const Flow& flow : flows)
      // Gates refuse an address that is described and was not admitted there.
      if (flow.from == copy.network && flow.address == copy.address) to.insert(flow.to);
    for (const std::size_t n : to) next.push_back({n, gateway, 0});
  }

  const System& system_;
  std::map<std::size_t, std::set<std::size_t>> to_;  ///< by publisher
  std::map<std::size_t, std::set<Flow>> carried_;    ///< by gateway
};

std::string wrong_with(const System& system) {
  State state(system);
  state.settle();
  const Propagation world(system, state.decisions()[0]);
  std::string wrong;
  for (std::size_t p = 0; p < system.publishers.size(); ++p) wrong += world.send(p);
  return wrong;
}

std::size_t granted(const System& system) {
  State state(system);
  state.settle();
  return state.granted();
}

System ring(bool addresses) {
  System system = joined(3, {{0, 1}, {1, 2}, {2, 0}});
  for (std::size_t n = 0; n < 3; ++n) {
    publish(system, n, addresses ? n + 1 : 0);
    subscribe(system, n);
  }
  return system;
}

TEST(EchoesTest, AroundARingTwoOfThreeGatewaysCarryWhatHasNoAddress) {
  const System system = ring(false);
  EXPECT_EQ(wrong_with(system), "");
  EXPECT_EQ(granted(system), 9U) << "all of them, and three where they are";
}

TEST(EchoesTest, WithAddressesEachTakesTheShortestWay) {
  const System system = ring(true);
  EXPECT_EQ(wrong_with(system), "");
  State state(system);
  state.settle();
  EXPECT_EQ(state.granted(), 9U);
  for (const Verdict& v : state.decisions()[0].verdicts) EXPECT_LE(v.route.size(), 3U);
}

/// Or else what is refused would be carried as what is granted.
TEST(EchoesTest, WhatLooksLikeARefusedEventIsRefusedWhereItWouldBeTakenForIt) {
  System system = joined(3, {{0, 1}, {1, 2}});
  publish(system, 0, 0);
  publish(system, 1, 0);
  subscribe(system, 1);
  subscribe(system, 2);
  EXPECT_EQ(granted(system), 4U);
  // The first publisher is too late for the last network now, and the second one is not.
  system.subscribers[1].attributes.set(Attribute::deadline, 4 * kMs);
  EXPECT_EQ(wrong_with(system), "");
  State state(system);
  state.settle();
  EXPECT_EQ(state.granted(), 2U);
  const Verdict& second = state.decisions()[0].verdicts.at(3);
  EXPECT_EQ(second.obstacle, Obstacle::echo);
  EXPECT_EQ(reason(state.system(), state.members(), second),
            "gateway g1 could not distinguish these events from those that another gateway brings, "
            "and would carry both: they would arrive twice, or go round");
  system.publishers[1].station.bits = 7;
  EXPECT_EQ(wrong_with(system), "");
  EXPECT_EQ(granted(system), 3U) << "with its address it is distinguished";
}

TEST(EchoesTest, OfOnePublisherEachNetworkIsReachedByOneWay) {
  // To the network behind both there are two ways, and each is the shortest to one of them.
  System system = joined(5, {{0, 1}, {0, 2}, {1, 3}, {2, 3}, {3, 4}});
  publish(system, 0, 0);
  for (const std::size_t n : {1U, 2U, 3U, 4U}) subscribe(system, n);
  EXPECT_EQ(wrong_with(system), "");
  EXPECT_EQ(granted(system), 4U);
}

TEST(EchoesTest, NoEventComesTwiceOrWithoutAGrantOverAnyGateways) {
  std::mt19937 random(11);
  const auto below = [&random](std::size_t n) { return random() % n; };
  std::size_t rings = 0;
  std::size_t all = 0;
  std::size_t refused = 0;
  for (int round = 0; round < 2'000; ++round) {
    const std::size_t networks = 3 + below(4);
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (std::size_t n = 1; n < networks; ++n) pairs.emplace_back(below(n), n);
    for (std::size_t more = below(4); more > 0; --more) {
      const std::size_t a = below(networks);
      const std::size_t b = below(networks);
      if (a != b) pairs.emplace_back(a, b);
    }
    rings += pairs.size() >= networks ? 1 : 0;
    System system = joined(networks, pairs);
    const std::size_t publishers = 1 + below(4);
    for (std::size_t p = 0; p < publishers; ++p)
      publish(system, below(networks), below(2) == 0 ? 0 : p + 1);
    const std::size_t subscribers = 1 + below(4);
    for (std::size_t s = 0; s < subscribers; ++s) {
      subscribe(system, below(networks));
      if (below(4) == 0)
        system.subscribers.back().attributes.set(Attribute::deadline, (1 + below(8)) * kMs);
    }
    ASSERT_EQ(wrong_with(system), "") << "round " << round;
    State state(system);
    state.settle();
    all += state.granted();
    for (const Verdict& v : state.decisions()[0].verdicts)
      refused += v.obstacle == Obstacle::echo ? 1 : 0;
  }
  EXPECT_GT(rings, 500U);
  EXPECT_GT(all, 5'000U);
  EXPECT_LT(refused, all / 10);
  RecordProperty("refused", static_cast<int>(refused));
}

}  // namespace
}  // namespace mlcca::core
