// SPDX-License-Identifier: BSD-2-Clause
// Gateways with whole daemons on benches that share a bus by a store: who is granted what, and what
// becomes of it when the store, a gateway or the disk fails.
#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/daemon/gateway/bench.hpp"
#include "tests/daemon/gateway/fake_store.hpp"

namespace mlcca::test {
namespace {

constexpr std::uint64_t kSecondNs = 1'000'000'000;
constexpr std::uint64_t kStepNs = 100'000'000;
constexpr std::uint64_t kLease = 10 * kSecondNs;
constexpr std::size_t kSharedBus = 0;

AttributeSet each(Value period, Value deadline = 400 * kMs) {
  return AttributeSet{}
      .set(Attribute::period, period)
      .set(Attribute::max_payload, 8)
      .set(Attribute::deadline, deadline);
}

core::Network some_bus(const std::string& name) {
  core::Network out;
  out.name = name;
  out.profile = core::Profile::raw;
  out.bus.bitrate = 125'000;
  out.provision.set(Attribute::max_payload, 8);
  return out;
}

/// "shared" is a bus of g0 and g1; "own0" and "own1" are of one each. c0 goes from own0 to shared,
/// c1 from own0 to programs on g0, as described; nobody uses the others.
core::System two_gateways() {
  core::System system;
  system.name = "pair";
  for (const char* name : {"shared", "own0", "own1"}) system.networks.push_back(some_bus(name));
  for (std::size_t g = 0; g < 2; ++g) {
    core::Gateway gateway;
    gateway.name = "g" + std::to_string(g);
    gateway.provision.set(Attribute::latency, kMs).set(Attribute::jitter, kMs);
    for (const std::size_t n : {kSharedBus, 1 + g}) {
      core::Port port;
      port.network = n;
      port.identity.name = system.networks[n].name;
      port.queue_length = 40;
      gateway.ports.push_back(port);
    }
    system.gateways.push_back(gateway);
  }
  for (std::size_t c = 0; c < 6; ++c) {
    core::EventChannel channel;
    channel.name = "c" + std::to_string(c);
    channel.subject = c + 1;
    channel.attributes = each(50 * kMs);
    system.channels.push_back(channel);
    for (core::Network& n : system.networks) {
      core::Binding binding;
      binding.channel = c;
      binding.id = static_cast<std::uint32_t>(0x10 + c);
      n.bindings.push_back(binding);
    }
  }
  for (std::size_t c = 0; c < 2; ++c) {
    core::Publisher p;
    p.name = "p" + std::to_string(c);
    p.channel = c;
    p.place = {core::Place::Kind::network, 1};
    p.attributes = each(50 * kMs);
    system.publishers.push_back(p);
    core::Subscriber s;
    s.name = "s" + std::to_string(c);
    s.channel = c;
    s.place = c == 0 ? core::Place{core::Place::Kind::network, kSharedBus}
                     : core::Place{core::Place::Kind::gateway, 0};
    s.attributes = each(50 * kMs);
    system.subscribers.push_back(s);
  }
  return system;
}

/// Somebody on the own bus of a gateway sends to somebody on another one.
control::Admit wanted(const std::string& channel, const std::string& from, const std::string& to) {
  control::Admit request;
  request.channel = channel;
  request.from = from;
  request.to = to;
  request.publisher = "new";
  request.subscriber = "late";
  request.key = channel + from;
  return request;
}

control::Attribute attribute_of(const std::string& name, std::uint64_t value) {
  control::Attribute out;
  out.name = name;
  out.value = value;
  return out;
}

class MembershipTest : public testing::Test {
 protected:
  struct Node {
    explicit Node(FakeStore& store, std::size_t self)
        : bench(two_gateways()), link(store, bench.clock) {
      bench.self = self;
      bench.cluster = &link;
      bench.lease_ns = kLease;
      bench.digest = 1;
    }
    Bench bench;
    FakeLink link;
    std::vector<std::uint64_t> ready;  ///< sessions
  };

  MembershipTest() {
    for (std::size_t g = 0; g < 2; ++g) nodes.push_back(std::make_unique<Node>(store, g));
  }

  void start(std::size_t g) {
    ASSERT_FALSE(at(g).start());
    at(g).daemon().on_slice(
        [this, g](std::uint64_t session) { nodes[g]->ready.push_back(session); });
  }
  void start_both() {
    start(0);
    start(1);
    pass(4 * kSecondNs);
  }
  Bench& at(std::size_t g) { return nodes[g]->bench; }
  FakeLink& link(std::size_t g) { return nodes[g]->link; }

  /// Until nothing is to be done now.
  void run() {
    for (bool more = true; more;) {
      more = false;
      for (auto& node : nodes) {
        if (!node->bench.runs()) continue;
        more = node->link.deliver() || more;
        const std::size_t sent = node->link.sent.size();
        node->bench.act();
        more = more || (node->link.answers && node->link.sent.size() != sent);
      }
    }
  }
  void pass(std::uint64_t time) {
    for (std::uint64_t gone = 0; gone < time; gone += kStepNs) {
      for (auto& node : nodes) {
        node->bench.clock.monotonic += kStepNs;
        node->bench.kernel.advance_to(node->bench.clock.monotonic);
        if (!node->bench.runs()) continue;
        node->bench.daemon().beat();
        if (gone % kSecondNs == 0) node->bench.round();
      }
      run();
    }
  }

  /// What it is answered in the end.
  std::string asked(std::size_t g, control::Admit request, const serve::Peer& peer = member()) {
    auto answer = at(g).ask(std::move(request), peer);
    run();
    return text_of(answer);
  }
  static std::string text_of(serve::Answer& answer) {
    auto body = answer.reply.body;
    if (answer.slices) {
      const auto slice = answer.slices();
      if (!slice) return "nothing yet";
      body = slice->body;
    }
    if (const auto* error = std::get_if<control::Error>(&body)) return error->message;
    const auto* channels = std::get_if<control::Channels>(&body);
    if (channels == nullptr || channels->channels.empty()) return "something else";
    const control::Channel& first = channels->channels.front();
    return first.granted ? "granted" : first.reason;
  }

  bool granted(std::size_t g, std::size_t channel) {
    return at(g).state().decisions()[channel].granted != 0;
  }
  /// Rules that pass frames of a channel out on the shared bus.
  bool passes(std::size_t g, std::size_t channel) {
    const auto* const found = at(g).kernel.interfaces.contains("shared")
                                  ? &at(g).kernel.interfaces.at("shared")
                                  : nullptr;
    if (found == nullptr || !at(g).kernel.passes()) return false;
    return std::ranges::any_of(at(g).kernel.gates.at(found->ifindex).rules, [&](const auto& one) {
      return one.first.subject == channel + 1 && one.second.pass;
    });
  }
  [[nodiscard]] std::size_t entries(const std::string& kind) const {
    std::size_t n = 0;
    for (const auto& [key, entry] : store.entries)
      if (key.starts_with("/mlcca/pair/" + kind)) ++n;
    return n;
  }

  FakeStore store;
  std::vector<std::unique_ptr<Node>> nodes;
};

TEST_F(MembershipTest, BeforeTheStoreIsKnownNothingSharedIsGrantedAndLocalIs) {
  link(0).up = false;
  start(0);
  run();
  EXPECT_FALSE(granted(0, 0));
  EXPECT_TRUE(granted(0, 1)) << "it stays on one gateway";
  EXPECT_NE(asked(0, wanted("c2", "own0", "shared")).find("the store does not answer"),
            std::string::npos);
  EXPECT_EQ(at(0).kernel.until, 0U);
}

TEST_F(MembershipTest, TheFirstDescriptionComesIntoForceWhenAllAreThere) {
  start(0);
  pass(5 * kSecondNs);
  EXPECT_FALSE(granted(0, 0)) << "g1 is not there";
  start(1);
  pass(40 * kSecondNs);
  EXPECT_TRUE(granted(0, 0));
  EXPECT_TRUE(passes(0, 0));
  EXPECT_EQ(entries("r/"), 0U) << "what is described needs no reservation";
}

TEST_F(MembershipTest, AnAdmissionIsAnsweredWhenTheStoreHasDecided) {
  start_both();
  link(0).answers = false;
  auto answer = at(0).ask(wanted("c2", "own0", "shared"));
  run();
  EXPECT_EQ(text_of(answer), "nothing yet");
  EXPECT_FALSE(passes(0, 2));
  EXPECT_EQ(asked(0, wanted("c3", "own0", "own0")), "granted") << "others go on";
  link(0).answers = true;
  run();
  EXPECT_EQ(text_of(answer), "granted");
  EXPECT_EQ(nodes[0]->ready, std::vector<std::uint64_t>{1});
  EXPECT_TRUE(passes(0, 2));
  EXPECT_EQ(entries("r/shared/g0/"), 1U);
  EXPECT_FALSE(at(1).state().world().foreign[kSharedBus].bus.empty());
  EXPECT_GT(at(0).kernel.until, at(0).clock.monotonic);
}

TEST_F(MembershipTest, WhatIsReleasedLeavesTheStoreASecondLater) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  at(0).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "c2own0"});
  run();
  EXPECT_FALSE(passes(0, 2));
  EXPECT_EQ(entries("r/"), 1U) << "frames may wait in a queue";
  EXPECT_EQ(at(0).kernel.until, 0U) << "nothing leased is open";
  pass(2 * kSecondNs);
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_EQ(entries("x/"), 0U);
}

TEST_F(MembershipTest, OfTwoThatDoNotFitTogetherOneIsRefused) {
  start_both();
  auto much = wanted("c2", "own0", "shared");
  auto more = wanted("c3", "own1", "shared");
  // Frames of 1.08 ms: all three of them take more than the bus has.
  auto before = wanted("c4", "own1", "shared");
  before.offered = much.offered = {attribute_of("Period", 3'300'000)};
  more.offered = {attribute_of("Period", 2'200'000)};
  ASSERT_EQ(asked(1, before), "granted");
  auto first = at(0).ask(much);
  auto second = at(1).ask(more);
  run();
  const std::string one = text_of(first);
  const std::string other = text_of(second);
  EXPECT_TRUE((one == "granted") != (other == "granted")) << one << " / " << other;
  EXPECT_NE((one + other).find("shared"), std::string::npos) << one << " / " << other;
  EXPECT_EQ(entries("r/"), 2U);
}

TEST_F(MembershipTest, WithoutTheStoreWhatIsLeasedClosesBeforeTheLeaseEnds) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  const std::uint64_t last = at(0).kernel.until;
  link(0).up = false;
  pass(5 * kSecondNs);
  EXPECT_TRUE(passes(0, 2)) << "it stays for as long as the lease lives";
  EXPECT_NE(asked(0, wanted("c3", "own0", "shared")), "granted");
  while (at(0).clock.monotonic < last) {
    pass(kStepNs);
    if (at(0).clock.monotonic >= last) break;
  }
  EXPECT_FALSE(passes(0, 2));
  EXPECT_TRUE(passes(0, 0)) << "it is described";
  EXPECT_EQ(at(0).kernel.lapses, 0U) << "closed by the daemon, in time";
  link(0).up = true;
  pass(5 * kSecondNs);
  EXPECT_TRUE(passes(0, 2)) << "nobody has fenced it";
}

TEST_F(MembershipTest, ADaemonThatStandsStillIsClosedByTheKernelAndItsShareIsGivenAway) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  // Only the other one goes on.
  std::unique_ptr<Node> stopped = std::move(nodes[0]);
  nodes.erase(nodes.begin());
  const std::uint64_t until = stopped->bench.kernel.until;
  for (int n = 0; n < 300; ++n) {
    stopped->bench.clock.monotonic += kStepNs;
    stopped->bench.kernel.advance_to(stopped->bench.clock.monotonic);
    pass(kStepNs);
    const bool counted = !nodes[0]->bench.state().world().foreign[kSharedBus].bus.empty();
    EXPECT_TRUE(counted || !stopped->bench.kernel.passes()) << n;
  }
  EXPECT_GE(stopped->bench.clock.monotonic, until);
  EXPECT_TRUE(nodes[0]->bench.state().world().foreign[kSharedBus].bus.empty());
  // It wakes up: fenced, and joins again.
  nodes.insert(nodes.begin(), std::move(stopped));
  at(0).daemon().beat();
  EXPECT_FALSE(passes(0, 2));
  pass(5 * kSecondNs);
  EXPECT_TRUE(passes(0, 0));
  EXPECT_TRUE(passes(0, 2)) << "it has asked again";
  EXPECT_FALSE(at(1).state().world().foreign[kSharedBus].bus.empty());
}

TEST_F(MembershipTest, AStopGivesBackWhatWasReserved) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  EXPECT_FALSE(at(0).daemon().begin_stop());
  run();
  EXPECT_FALSE(passes(0, 2));
  EXPECT_FALSE(passes(0, 0));
  pass(3 * kSecondNs);
  EXPECT_TRUE(at(0).daemon().may_stop());
  at(0).daemon().stop();
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_EQ(entries("x/"), 0U);
  EXPECT_FALSE(store.entries.contains("/mlcca/pair/m/g0"));
  // The next start asks again.
  start(0);
  pass(5 * kSecondNs);
  EXPECT_TRUE(passes(0, 2));
}

TEST_F(MembershipTest, ADaemonThatWasKilledTakesUpWhereItWas) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  at(0).end();
  start(0);
  EXPECT_TRUE(passes(0, 2)) << "with the start itself";
  run();
  EXPECT_EQ(entries("r/shared/g0/"), 1U);
  pass(15 * kSecondNs);
  EXPECT_TRUE(passes(0, 2));
  EXPECT_EQ(entries("r/shared/g0/"), 1U);
}

TEST_F(MembershipTest, WithoutTheStoreADaemonThatStartsOpensNothingShared) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  at(0).end();
  link(0).up = false;
  start(0);
  EXPECT_FALSE(passes(0, 2));
  EXPECT_FALSE(passes(0, 0));
  EXPECT_TRUE(granted(0, 1));
  link(0).up = true;
  pass(3 * kSecondNs);
  EXPECT_TRUE(passes(0, 0));
  EXPECT_TRUE(passes(0, 2));
}

TEST_F(MembershipTest, AClientThatHangsUpLeavesNothingBehind) {
  start_both();
  auto request = wanted("c2", "own0", "shared");
  request.hold = true;
  link(0).answers = false;
  auto answer = at(0).ask(request, member(7));
  run();
  at(0).daemon().session_closed(7);
  link(0).answers = true;
  pass(3 * kSecondNs);
  EXPECT_FALSE(granted(0, 2));
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_TRUE(at(0).state().admissions().empty());
}

TEST_F(MembershipTest, AHeldAdmissionIsOwnedByItsConnection) {
  start_both();
  auto request = wanted("c2", "own0", "shared");
  request.hold = true;
  auto answer = at(0).ask(request, member(7));
  run();
  const auto slice = answer.slices();
  ASSERT_TRUE(slice);
  EXPECT_NE(slice->owned, 0U);
}

TEST_F(MembershipTest, WhatTheDiskRefusesIsGivenBack) {
  start_both();
  link(0).answers = false;
  auto answer = at(0).ask(wanted("c2", "own0", "shared"));
  run();
  at(0).disk().trouble(store::test::Trouble::fail, 1, ENOSPC, 100);
  link(0).answers = true;
  run();
  EXPECT_NE(text_of(answer), "granted");
  at(0).disk().trouble(store::test::Trouble::fail, 1, 0, 0);
  pass(3 * kSecondNs);
  EXPECT_FALSE(granted(0, 2));
  EXPECT_EQ(entries("r/"), 0U);
}

TEST_F(MembershipTest, WithAnotherDescriptionNothingSharedIsGranted) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  at(0).digest = 2;
  at(0).daemon().reload();
  at(0).reading().finish();
  pass(3 * kSecondNs);
  EXPECT_FALSE(passes(0, 0));
  EXPECT_FALSE(passes(0, 2));
  EXPECT_TRUE(granted(0, 1));
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_NE(asked(0, wanted("c3", "own0", "shared")).find("another"), std::string::npos);
  at(0).digest = 1;
  at(0).daemon().reload();
  at(0).reading().finish();
  pass(5 * kSecondNs);
  EXPECT_TRUE(passes(0, 0));
  EXPECT_TRUE(passes(0, 2));
}

TEST_F(MembershipTest, AReloadOfTheSameDescriptionInterruptsNothing) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  at(0).daemon().reload();
  at(0).reading().finish();
  EXPECT_TRUE(passes(0, 0));
  EXPECT_TRUE(passes(0, 2));
  run();
  EXPECT_EQ(entries("r/shared/g0/"), 1U);
}

TEST_F(MembershipTest, AnAdmissionOverTwoGatewaysIsOneDecision) {
  start_both();
  EXPECT_EQ(asked(0, wanted("c2", "own0", "own1")), "granted");
  EXPECT_TRUE(granted(0, 2));
  EXPECT_TRUE(granted(1, 2)) << "it carries it on";
  EXPECT_EQ(at(1).state().admissions().size(), 1U);
  at(0).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "c2own0"});
  run();
  EXPECT_FALSE(granted(1, 2));
  pass(3 * kSecondNs);
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_EQ(entries("a/"), 0U);
}

TEST_F(MembershipTest, TheGatewayThatRefusesIsNamed) {
  start_both();
  auto local = wanted("c3", "own1", "own1");
  ASSERT_EQ(asked(1, wanted("c4", "shared", "own1")), "granted");
  at(1).kernel.unplug("own1");
  at(1).daemon().links_changed();
  run();
  const std::string why = asked(0, wanted("c2", "own0", "own1"));
  EXPECT_NE(why.find("g1: "), std::string::npos) << why;
  pass(3 * kSecondNs);
  EXPECT_FALSE(granted(0, 2));
  EXPECT_EQ(entries("r/shared/g0/"), 0U);
}

TEST_F(MembershipTest, ADaemonWithoutAClusterForgetsUntilWhenGatesMayBeOpen) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  ASSERT_NE(at(0).kernel.until, 0U);
  at(0).end();
  at(0).cluster = nullptr;
  start(0);
  EXPECT_EQ(at(0).kernel.until, 0U);
  EXPECT_TRUE(passes(0, 0));
}

}  // namespace
}  // namespace mlcca::test
