// SPDX-License-Identifier: BSD-2-Clause
// Who gets what when a network changes: keep, degrade, admit waiting, upgrade.
#include "core/admission/allocation.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

constexpr Value kHigh = 400;
constexpr Value kLow = 100;

AttributeSet rate(Value bytes_per_second) {
  return AttributeSet{}.set(Attribute::bandwidth, bytes_per_second).set(Attribute::max_payload, 8);
}

/// A mesh of so many nodes, without overhead and links, that may be used up to the last moment.
System mesh_of(std::uint32_t nodes) {
  System system;
  Network net;
  net.name = "air";
  net.kind = NetworkKind::mesh;
  mesh::Mesh m;
  m.limit = mesh::kWhole;
  m.header_bytes = 0;
  for (std::uint32_t n = 0; n < nodes; ++n) {
    const std::string name(1, static_cast<char>('a' + n));
    m.nodes.push_back({name, name, {}, {}});
  }
  net.mesh = m;
  system.networks.push_back(net);
  return system;
}

/// A channel of two attribute sets, high and low, from a node to the next one.
void add_channel(System& system, std::uint32_t from, std::uint8_t importance = 0) {
  const std::size_t c = system.channels.size();
  EventChannel channel;
  channel.name = "c" + std::to_string(c);
  channel.subject = c + 1;
  channel.importance = importance;
  channel.priority = 2;
  channel.attributes = rate(kHigh);
  channel.lower = {{1, rate(kLow), {}}};
  system.channels.push_back(channel);
  Publisher p;
  p.name = "p" + std::to_string(c);
  p.channel = c;
  p.place = network(0);
  p.attributes = channel.attributes;
  p.lower = channel.lower;
  p.mesh_node = from;
  system.publishers.push_back(p);
  Subscriber s;
  s.name = "s" + std::to_string(c);
  s.channel = c;
  s.place = network(0);
  s.attributes = channel.attributes;
  s.lower = channel.lower;
  s.mesh_node = from + 1;
  system.subscribers.push_back(s);
}

/// From a node to the next one: so many bytes/s, and 1 % more, since shares are rounded up.
mesh::Link link(std::uint32_t from, Value bytes_per_second) {
  mesh::Link l;
  l.from = from;
  l.to = from + 1;
  l.quality.rate = bytes_per_second * 8 * 101 / 100;
  l.quality.kind = mesh::RateKind::effective;
  return l;
}

/// 'h', 'l' or '-' for each channel.
std::string service_of(const State& state) {
  std::string all;
  for (const Decision& d : state.decisions()) all += d.granted == 0 ? '-' : d.set == 0 ? 'h' : 'l';
  return all;
}

/// Channels that share one link of a mesh between two nodes.
class Scarce {
 public:
  explicit Scarce(const std::vector<std::uint8_t>& importances) {
    System system = mesh_of(2);
    system.networks[0].provision.set(Attribute::max_payload, 1400);
    for (const std::uint8_t importance : importances) add_channel(system, 0, importance);
    state_ = std::make_unique<State>(std::move(system));
  }

  std::vector<DecisionChange> carries(Value bytes_per_second) {
    mesh::Graph graph;
    graph.nodes = 2;
    if (bytes_per_second != 0) graph.links = {link(0, bytes_per_second)};
    state_->set_graph(0, graph);
    return state_->settle();
  }
  void decide() { state_->decide(); }

  [[nodiscard]] std::string service() const { return service_of(*state_); }
  State& state() { return *state_; }

 private:
  std::unique_ptr<State> state_;
};

TEST(AllocationTest, NothingIsGrantedOverUnknownLinks) {
  Scarce s({0, 0});
  EXPECT_EQ(s.service(), "--");
  EXPECT_EQ(s.state().decisions()[0].verdicts.at(0).obstacle, Obstacle::none);
  s.carries(0);
  EXPECT_EQ(s.service(), "--");
  EXPECT_EQ(s.state().decisions()[0].verdicts.at(0).obstacle, Obstacle::no_path);
}

TEST(AllocationTest, TheVideoGoesDownAndComesBackByItself) {
  Scarce s({0});
  s.carries(500);
  EXPECT_EQ(s.service(), "h");
  s.carries(300);
  EXPECT_EQ(s.service(), "l");
  s.carries(50);
  EXPECT_EQ(s.service(), "-");
  s.carries(150);
  EXPECT_EQ(s.service(), "l");
  s.carries(500);
  EXPECT_EQ(s.service(), "h");
}

TEST(AllocationTest, ChannelsAreDegradedBeforeOneIsWithdrawn) {
  Scarce s({0, 0, 0});
  s.carries(1200);
  EXPECT_EQ(s.service(), "hhh");
  s.carries(900);
  EXPECT_EQ(s.service(), "hhl");
  s.carries(300);
  EXPECT_EQ(s.service(), "lll");
  s.carries(250);
  EXPECT_EQ(s.service(), "ll-") << "the youngest";
}

TEST(AllocationTest, TheMoreImportantIsKeptAndRaisedFirst) {
  Scarce s({0, 0, 7});
  s.carries(1200);
  s.carries(600);
  EXPECT_EQ(s.service(), "llh");
  s.carries(100);
  EXPECT_EQ(s.service(), "--l");
  s.carries(200);
  EXPECT_EQ(s.service(), "l-l") << "admitted before any is upgraded";
  s.carries(550);
  EXPECT_EQ(s.service(), "lll") << "the important one would need 50 more";
  s.carries(600);
  EXPECT_EQ(s.service(), "llh");
}

TEST(AllocationTest, ServiceComesBeforeQualityAlsoFromTheStart) {
  Scarce s({7, 0, 0});
  s.carries(600);
  EXPECT_EQ(s.service(), "hll");
  s.decide();
  EXPECT_EQ(s.service(), "hll");
}

TEST(AllocationTest, NoChannelIsDegradedForOneThatWaits) {
  Scarce s({0, 9});
  s.carries(400);
  // Both at once: each is served, and the rest is too little for more.
  EXPECT_EQ(s.service(), "ll");
  Scarce t({0, 9});
  t.state().set_withdrawn(1, true);
  t.carries(400);
  EXPECT_EQ(t.service(), "h-");
  t.state().set_withdrawn(1, false);
  t.state().settle();
  EXPECT_EQ(t.service(), "h-") << "who was there keeps what he has";
}

TEST(AllocationTest, AReleaseServesWhoWaits) {
  Scarce s({0, 0});
  s.carries(150);
  EXPECT_EQ(s.service(), "l-");
  s.state().set_withdrawn(0, true);
  s.state().settle();
  EXPECT_EQ(s.service(), "-l");
}

TEST(AllocationTest, AChangeThatChangesNothingIsNotReported) {
  Scarce s({0, 0});
  s.carries(2000);
  EXPECT_TRUE(s.carries(2000).empty());
}

TEST(AllocationTest, WhatWasGrantedBeforeTheRestartIsServedFirst) {
  Scarce s({0, 0});
  s.carries(450);
  // Alone the second got its high quality before the first was admitted again.
  s.state().decide({{1, {0, {{"p1", 0, "air"}}}}});
  EXPECT_EQ(s.service(), "-h");
}

TEST(AllocationTest, WhatCannotBeKeptAfterARestartIsDegradedBeforeOneIsWithdrawn) {
  Scarce s({0, 0, 0});
  s.carries(550);
  // As before a reload by which the link is taken to carry less.
  s.state().decide({{0, {0, {{"p0", 0, "air"}}}}, {1, {0, {{"p1", 0, "air"}}}}});
  EXPECT_EQ(s.service(), "lll") << "the third has room then";
}

TEST(AllocationTest, AChannelThatMustGoDownComesBeforeOneThatWaits) {
  Scarce s({0, 0});
  s.carries(450);
  s.state().decide({{1, {0, {{"p1", 0, "air"}}}}});
  ASSERT_EQ(s.service(), "-h");
  s.carries(150);
  EXPECT_EQ(s.service(), "-l") << "its high quality does not fit even alone, its low one does";
}

/// A gateway that carries so many bytes/s and may lose so many events.
struct Way {
  Value bytes;
  Value lost;
};
/// What a channel accepts.
struct Wanted {
  Value lost;
  std::uint8_t importance = 0;
};

/// Two networks with gateways between them, and channels over them that prefer `kHigh` and are
/// content with `kLow`.
System several_ways(const std::vector<Way>& ways, const std::vector<Wanted>& channels) {
  System system;
  for (const char* name : {"near", "far"}) {
    Network& net = system.networks.emplace_back();
    net.name = name;
    net.kind = NetworkKind::other;
    net.provision.set(Attribute::omission, 0).set(Attribute::max_payload, 8);
    net.provision.set(Attribute::bandwidth, 10 * kHigh);
  }
  for (const Way& way : ways) {
    Gateway& g = system.gateways.emplace_back();
    g.name = "g" + std::to_string(system.gateways.size());
    g.provision.set(Attribute::omission, way.lost).set(Attribute::bandwidth, way.bytes);
    for (const std::size_t n : {0, 1}) g.ports.emplace_back().network = n;
  }
  for (const Wanted& wanted : channels) {
    add_channel(system, 0, wanted.importance);
    EventChannel& channel = system.channels.back();
    channel.attributes.set(Attribute::omission, wanted.lost);
    channel.lower[0].attributes.set(Attribute::omission, wanted.lost);
    for (AttributeSet* set :
         {&system.publishers.back().attributes, &system.subscribers.back().attributes})
      *set = channel.attributes;
    system.publishers.back().lower = system.subscribers.back().lower = channel.lower;
    system.publishers.back().mesh_node.reset();
    system.subscribers.back().mesh_node.reset();
    system.subscribers.back().place = network(1);
  }
  return system;
}

TEST(AllocationTest, WhatALessImportantChannelFreesByAnotherWayIsGivenToTheMoreImportant) {
  // Both fit the good gateway at their low rate. The second is upgraded over the lossy one, and
  // only then there is room for the high rate of the first.
  const System system = several_ways({{kHigh + kLow / 2, 0}, {kHigh, 5}}, {{0, 7}, {9}});
  EXPECT_EQ(service_of(State(system)), "hh");
  const Topology topology(system);
  const Members members(system);
  const World world(system);
  Ledger ledger = empty_ledger(system, world);
  std::vector<std::size_t> sets;
  decide_each({system, topology, members, world, {false, false}}, ledger,
              [&](std::size_t, const Decision& d) { sets.push_back(d.granted == 0 ? 9 : d.set); });
  EXPECT_EQ(sets, (std::vector<std::size_t>{0, 0}));
  State later(system);
  for (const bool available : {false, true}) {
    Condition condition;
    condition.available = available;
    later.set_condition(1, condition);
    later.settle();
  }
  EXPECT_EQ(service_of(later), "hh");
}

TEST(AllocationTest, WhatAChannelFreesThatTakesAnotherWayInTheSameQualityIsGivenAway) {
  // The first takes the lossy gateway, the second the good one, which the third needs.
  System system = several_ways({{kLow, 5}, {kLow, 0}}, {{9}, {9}, {0}});
  // Nobody can serve another subscriber of the second: it is looked at again with each relief.
  Network apart = system.networks[1];
  apart.name = "apart";
  system.networks.push_back(apart);
  system.subscribers.push_back(system.subscribers[1]);
  system.subscribers.back().place = network(2);
  State state(std::move(system));
  ASSERT_EQ(service_of(state), "ll-");
  state.set_withdrawn(0, true);
  state.settle();
  EXPECT_EQ(service_of(state), "-ll") << "the second goes over the lossy gateway now";
}

/// As when all of it is decided at once: what is granted does not depend on what was before.
TEST(AllocationTest, WhoComesBackIsServedInALowerSetOfTheWholeChannel) {
  System system = several_ways({{kHigh, 0}}, {{0}});
  Network third = system.networks[1];
  third.name = "third";
  system.networks.push_back(third);
  Gateway narrow = system.gateways[0];
  narrow.name = "narrow";
  narrow.provision.set(Attribute::bandwidth, kLow);
  narrow.ports[1].network = 2;
  system.gateways.push_back(narrow);
  system.subscribers.push_back(system.subscribers[0]);
  system.subscribers.back().place = network(2);
  Condition down;
  down.available = false;
  State state(system);
  EXPECT_EQ(service_of(state), "l") << "so that both receive it";
  state.set_condition(2, down);
  state.settle();
  EXPECT_EQ(service_of(state), "h");
  state.set_condition(2, {});
  state.settle();
  EXPECT_EQ(service_of(state), "l") << "the narrow gateway carries less, and both receive it";
  EXPECT_TRUE(state.decisions()[0].all_granted());
  state.decide();
  EXPECT_EQ(service_of(state), "l");
  EXPECT_TRUE(state.decisions()[0].all_granted());
}

/// Channels over one link between two nodes whose ends come at run time.
class Ages {
 public:
  /// `described`: of each channel, 'p' or 's' for the ends that the description has.
  explicit Ages(const std::vector<std::string>& described) {
    System system = mesh_of(2);
    system.networks[0].provision.set(Attribute::max_payload, 1400);
    for (std::size_t c = 0; c < described.size(); ++c) add_channel(system, 0);
    all_ = system;
    std::erase_if(system.publishers,
                  [&](const Publisher& p) { return !described[p.channel].contains('p'); });
    std::erase_if(system.subscribers,
                  [&](const Subscriber& s) { return !described[s.channel].contains('s'); });
    state_ = std::make_unique<State>(std::move(system));
  }

  void admit(AdmissionId id, std::size_t channel, const std::string& ends) {
    Admission a;
    a.id = id;
    a.channel = channel;
    if (ends.contains('p')) a.publisher = all_.publishers[channel];
    if (ends.contains('s')) a.subscriber = all_.subscribers[channel];
    state_->restore(a);
  }
  void release(AdmissionId id) { EXPECT_TRUE(state_->remove(id)); }

  /// Who is served where the link carries one of them.
  std::string served() {
    mesh::Graph graph;
    graph.nodes = 2;
    graph.links = {link(0, 2000)};
    state_->set_graph(0, graph);
    state_->decide();
    EXPECT_FALSE(service_of(*state_).contains('-')) << "there is room for all";
    graph.links = {link(0, 100)};
    state_->set_graph(0, graph);
    state_->settle();
    return service_of(*state_);
  }

 private:
  System all_;
  std::unique_ptr<State> state_;
};

TEST(AllocationTest, TheChannelThatWasAdmittedFirstIsKept) {
  Ages later({"", ""});
  later.admit(5, 0, "ps");
  later.admit(3, 1, "ps");
  EXPECT_EQ(later.served(), "-l");
  Ages earlier({"", ""});
  earlier.admit(2, 0, "ps");
  earlier.admit(3, 1, "ps");
  EXPECT_EQ(earlier.served(), "l-");
}

TEST(AllocationTest, AChannelIsAsOldAsTheFirstOfItsAdmissions) {
  for (const std::string first : {"p", "s"}) {
    Ages ages({"", ""});
    ages.admit(3, 0, "ps");
    ages.admit(2, 1, first);
    ages.admit(5, 1, first == "p" ? "s" : "p");
    EXPECT_EQ(ages.served(), "-l") << first;
    ages.release(2);
    ages.admit(6, 1, first);
    EXPECT_EQ(ages.served(), "l-") << "the others of the channel came later";
  }
}

TEST(AllocationTest, AChannelWithBothEndsInTheDescriptionIsOlderThanAnyAdmission) {
  Ages ages({"", "ps"});
  ages.admit(1, 0, "ps");
  EXPECT_EQ(ages.served(), "-l");
  ages.admit(7, 1, "s");
  EXPECT_EQ(ages.served(), "-l") << "whoever comes to it later";
  ages.admit(8, 1, "p");
  EXPECT_EQ(ages.served(), "-l");
}

TEST(AllocationTest, AChannelWithOneEndInTheDescriptionIsAsOldAsTheAdmissionOfTheOther) {
  for (const std::string described : {"p", "s"}) {
    Ages ages({"", described});
    ages.admit(1, 0, "ps");
    ages.admit(2, 1, described == "p" ? "s" : "p");
    EXPECT_EQ(ages.served(), "l-") << described;
    Ages older({"", described});
    older.admit(3, 0, "ps");
    older.admit(2, 1, described == "p" ? "s" : "p");
    EXPECT_EQ(older.served(), "-l") << described;
  }
}

/// Two links that reach each other only over a third, from b to c: k-hop domains, k = 1. Channels
/// of two sets, each over the link that is said.
class Islands {
 public:
  explicit Islands(const std::vector<std::uint32_t>& links_of_channels) {
    System system = mesh_of(4);
    system.networks[0].mesh->interference = mesh::Interference::k_hop;
    system.networks[0].mesh->hops = 1;
    for (const std::uint32_t number : links_of_channels) add_channel(system, 2 * number);
    state_ = std::make_unique<State>(std::move(system));
  }

  void carry(Value first, Value second, bool joined = false, Value busy = 0) {
    mesh::Graph graph;
    graph.nodes = 4;
    graph.links = {link(0, first), link(2, second)};
    for (mesh::Link& l : graph.links) l.busy = busy;
    if (joined) graph.unusable.push_back({1, 2, {}});
    state_->set_graph(0, graph);
    state_->settle();
  }
  [[nodiscard]] std::string service() const { return service_of(*state_); }
  void release(std::size_t channel, bool released) {
    state_->set_withdrawn(channel, released);
    state_->settle();
  }
  [[nodiscard]] const State& state() const { return *state_; }

 private:
  std::unique_ptr<State> state_;
};

TEST(AllocationTest, ALinkThatCarriesNothingJoinsWhatIsAroundItsEnds) {
  Islands two({0, 1});
  two.carry(400, 400);
  EXPECT_EQ(two.service(), "hh");
  two.carry(400, 400, true);
  EXPECT_EQ(two.state().world().meshes[0]->domains().count(), 1U);
  EXPECT_EQ(two.service(), "ll") << "one domain: 400 bytes/s for both together";
  two.carry(400, 400, true, 1);
  EXPECT_EQ(two.service(), "ll");
  two.carry(400, 400);
  EXPECT_EQ(two.service(), "hh");
}

TEST(AllocationTest, WhoIsInAnotherDomainKeepsWhatItHas) {
  Islands four({0, 0, 1, 1});
  four.carry(800, 500);
  EXPECT_EQ(four.service(), "hhhl");
  four.release(2, true);
  EXPECT_EQ(four.service(), "hh-h");
  four.release(2, false);
  EXPECT_EQ(four.service(), "hhlh") << "a channel that comes back takes from no other";
  four.carry(450, 500);
  EXPECT_EQ(four.service(), "lllh") << "the first link is none of their business";
}

}  // namespace
}  // namespace mlcca::core::testing
