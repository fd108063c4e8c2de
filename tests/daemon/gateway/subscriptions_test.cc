// SPDX-License-Identifier: BSD-2-Clause
// Subscriptions that come over a network: who may bring them, what they are, and what is passed on.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

constexpr uid_t kProgram = 991;
constexpr std::size_t kEthernet = 2;
constexpr core::Subject kPlainSubscriber = 0;

/// c0 is published on the first bus; its subscriber is on the second one.
class SubscriptionRequests : public ::testing::Test {
 protected:
  void SetUp() override {
    core::System system = small_system();
    system.gateways[0].relay = 990;
    lan_ = system.networks[kEthernet].name;
    subject_ = system.channels[0].subject;
    system.networks[kEthernet].subscriptions = {
        .accept = core::Subscribing::with_attributes, .most = 2, .origin = {}};
    for (core::Port& port : system.gateways[0].ports)
      if (port.network == kEthernet) port.control_uid = kProgram;
    bench_ = std::make_unique<Bench>(std::move(system));
    ASSERT_FALSE(bench_->start());
  }

  static serve::Peer program() { return {.pid = 9, .uid = kProgram, .session = 7}; }
  [[nodiscard]] control::SubscribeRequest wanted(const std::string& source = "192.0.2.7",
                                                 Value deadline_ms = 40) const {
    control::SubscribeRequest out;
    out.subject = subject_;
    out.network = lan_;
    out.source = source;
    out.required = {{.name = "Deadline", .value = deadline_ms * kMs, .unit = {}, .dynamic = false}};
    out.states_attributes = true;
    out.lease_ns = 60'000 * kMs;
    return out;
  }
  /// "granted", or why not.
  std::string subscribe(const control::SubscribeRequest& request,
                        const serve::Peer& peer = program()) {
    const auto body = bench_->ask(request, peer).reply.body;
    if (const auto* error = std::get_if<control::Error>(&body)) return error->message;
    if (const auto* done = std::get_if<control::Done>(&body)) return done->message;
    const auto& channels = std::get<control::Channels>(body).channels;
    if (channels.empty()) return "nothing";
    return channels.front().granted ? "granted" : channels.front().reason;
  }
  [[nodiscard]] std::size_t subscribers() const {
    return bench_->state().members().subscribers_of(0).size();
  }
  control::Subscriptions what_there_is() {
    const serve::Answer answer = bench_->ask(control::SubscriptionsRequest{}, program());
    control::Subscriptions all;
    for (bool more = true; more;) {
      const auto slice = answer.slices();
      const auto& some = std::get<control::Subscriptions>(slice->body);
      all.networks.insert(all.networks.end(), some.networks.begin(), some.networks.end());
      all.onward.insert(all.onward.end(), some.onward.begin(), some.onward.end());
      more = slice->more;
    }
    return all;
  }

  std::string lan_;
  core::Subject subject_ = kPlainSubscriber;
  std::unique_ptr<Bench> bench_;
};

TEST_F(SubscriptionRequests, APeerIsAdmittedLikeASubscriber) {
  EXPECT_EQ(subscribe(wanted()), "granted");
  ASSERT_EQ(subscribers(), 2U);
  const auto& members = bench_->state().members();
  const core::Subscriber& peer = members.subscriber(members.subscribers_of(0).back());
  EXPECT_EQ(peer.name, "peer-192.0.2.7");
  EXPECT_EQ(peer.attributes[Attribute::deadline], 40 * kMs);
  // Asked again it is the same one; with another requirement it takes its place.
  EXPECT_EQ(subscribe(wanted()), "granted");
  EXPECT_EQ(subscribers(), 2U);
  EXPECT_EQ(subscribe(wanted("192.0.2.7", 30)), "granted");
  EXPECT_EQ(subscribers(), 2U);
  EXPECT_EQ(members.subscriber(members.subscribers_of(0).back()).attributes[Attribute::deadline],
            30 * kMs);
}

TEST_F(SubscriptionRequests, TheEventNamesTheProgramThatBroughtIt) {
  bench_->published.clear();
  EXPECT_EQ(subscribe(wanted()), "granted");
  ASSERT_FALSE(bench_->published.empty());
  for (const control::Event& event : bench_->published) {
    ASSERT_TRUE(event.client) << event.message;
    EXPECT_EQ(event.client->uid, kProgram);
    EXPECT_EQ(event.client->pid, 9U);
  }
}

TEST_F(SubscriptionRequests, ItEndsWithItsLeaseOrWhenThePeerEndsIt) {
  EXPECT_EQ(subscribe(wanted()), "granted");
  bench_->clock.monotonic += 61'000 * kMs;
  bench_->round();
  EXPECT_EQ(subscribers(), 1U);
  EXPECT_EQ(subscribe(wanted()), "granted");
  control::SubscribeRequest end = wanted();
  end.end = true;
  EXPECT_TRUE(subscribe(end).starts_with("released admission"));
  EXPECT_EQ(subscribers(), 1U);
  EXPECT_EQ(subscribe(end), "there is no such subscription");
}

TEST_F(SubscriptionRequests, AnImpossibleRequirementIsRefusedWithTheHop) {
  control::SubscribeRequest request = wanted();
  request.required = {{.name = "Omission", .value = 2, .unit = {}, .dynamic = false}};
  EXPECT_EQ(subscribe(request), "Omission 2 required, can0 provides none");
  EXPECT_EQ(subscribers(), 1U);
}

TEST_F(SubscriptionRequests, OnlyTheProgramOfTheNetworkMaySubscribe) {
  for (const uid_t user : {uid_t{0}, uid_t{1000}, kProgram + 1})
    EXPECT_TRUE(subscribe(wanted(), {.pid = 9, .uid = user, .may_change = true, .session = 8})
                    .contains(" are for programs of user 991, the control-user of its Port"))
        << user;
  control::SubscribeRequest elsewhere = wanted();
  elsewhere.network = bench_->state().system().networks[0].name;
  EXPECT_TRUE(subscribe(elsewhere).contains("accepts no subscriptions"));
  elsewhere.network = "nowhere";
  EXPECT_TRUE(subscribe(elsewhere).contains("no port on a network 'nowhere'"));
  EXPECT_EQ(subscribers(), 1U);
}

TEST_F(SubscriptionRequests, WhoStatesNothingIsRefusedUnlessThePolicyAcceptsAll) {
  control::SubscribeRequest plain = wanted();
  plain.required.clear();
  plain.states_attributes = false;
  plain.lease_ns = 0;
  EXPECT_TRUE(subscribe(plain).contains("accepts no subscriptions without attributes"));
  bench_->system.networks[kEthernet].subscriptions.accept = core::Subscribing::all;
  bench_->ask(control::ReloadRequest{});
  bench_->reading().finish();
  bench_->act();
  EXPECT_EQ(subscribe(plain), "granted");
}

TEST_F(SubscriptionRequests, WhatTheDescriptionAcceptsNoMoreEndsWithTheReload) {
  const auto reload = [this](core::Subscribing accept) {
    bench_->system.networks[kEthernet].subscriptions.accept = accept;
    bench_->ask(control::ReloadRequest{});
    bench_->reading().finish();
    bench_->act();
  };
  control::SubscribeRequest plain = wanted("192.0.2.8");
  plain.required.clear();
  plain.states_attributes = false;
  plain.lease_ns = 0;
  reload(core::Subscribing::all);
  EXPECT_EQ(subscribe(plain), "granted");
  EXPECT_EQ(subscribe(wanted()), "granted");
  EXPECT_EQ(subscribers(), 3U);
  reload(core::Subscribing::with_attributes);
  EXPECT_EQ(subscribers(), 2U);
  reload(core::Subscribing::nobody);
  EXPECT_EQ(subscribers(), 1U);
}

TEST_F(SubscriptionRequests, ANetworkHasNoMoreThanItAllows) {
  EXPECT_EQ(subscribe(wanted("192.0.2.1")), "granted");
  EXPECT_EQ(subscribe(wanted("192.0.2.2")), "granted");
  EXPECT_TRUE(subscribe(wanted("192.0.2.3")).contains("its Subscriptions allow no more"));
  EXPECT_EQ(subscribe(wanted("192.0.2.2")), "granted");  // it is there
}

TEST_F(SubscriptionRequests, BadInputIsRefused) {
  control::SubscribeRequest request = wanted();
  for (const std::string& source : {std::string(), std::string("a b"), std::string(46, 'x')}) {
    request.source = source;
    EXPECT_TRUE(subscribe(request).contains("say the source")) << source;
  }
  request = wanted();
  request.required = {{.name = "Colour", .value = 1, .unit = {}, .dynamic = false}};
  EXPECT_TRUE(subscribe(request).contains("there is no attribute 'Colour'"));
  request = wanted();
  request.subject = 0xdead;
  EXPECT_TRUE(subscribe(request).contains("no event channel"));
}

TEST_F(SubscriptionRequests, TheProgramLearnsWhereSubscriptionsComeFrom) {
  const auto there = what_there_is();
  ASSERT_EQ(there.networks.size(), 1U);
  EXPECT_EQ(there.networks[0].network, lan_);
  EXPECT_EQ(there.networks[0].most, 2U);
  EXPECT_EQ(there.networks[0].user, kProgram);
  EXPECT_FALSE(there.networks[0].accepts_all);
  EXPECT_TRUE(there.networks[0].problem.empty());
  EXPECT_NE(there.networks[0].endpoint.ifindex, 0U);
  EXPECT_FALSE(there.networks[0].endpoint.can);
  EXPECT_TRUE(there.onward.empty());
}

/// Whoever renews what it has must not lose it by a question in vain.
TEST_F(SubscriptionRequests, WhatWasGrantedStaysWhereAStricterRequirementIsRefused) {
  EXPECT_EQ(subscribe(wanted()), "granted");
  const auto id = bench_->state().admissions().begin()->first;
  control::SubscribeRequest strict = wanted();
  strict.required = {{.name = "Omission", .value = 2, .unit = {}, .dynamic = false}};
  bench_->events.clear();
  EXPECT_EQ(subscribe(strict), "Omission 2 required, can0 provides none");
  ASSERT_EQ(subscribers(), 2U);
  EXPECT_TRUE(bench_->state().admissions().contains(id)) << "without an interruption";
  EXPECT_EQ(std::ranges::count(bench_->events, "released"), 0);
  const auto& members = bench_->state().members();
  EXPECT_EQ(members.subscriber(members.subscribers_of(0).back()).attributes[Attribute::deadline],
            40 * kMs);
  EXPECT_EQ(subscribe(wanted()), "granted");
  EXPECT_EQ(subscribe(wanted("192.0.2.7", 30)), "granted");
  EXPECT_FALSE(bench_->state().admissions().contains(id));
}

/// From the Ethernet to a bus: who subscribes on the bus is passed on to the Ethernet.
class OnwardRequests : public SubscriptionRequests {
 protected:
  void SetUp() override {
    core::System system = small_system();
    system.gateways[0].relay = 990;
    system.gateways[0].provision.set(Attribute::latency, 2 * kMs);
    lan_ = system.networks[kEthernet].name;
    subject_ = system.channels[0].subject;
    system.publishers[0].place = {core::Place::Kind::network, kEthernet};
    system.networks[kEthernet].subscriptions.accept = core::Subscribing::with_attributes;
    for (core::Port& port : system.gateways[0].ports)
      if (port.network == kEthernet) port.control_uid = kProgram;
    bench_ = std::make_unique<Bench>(std::move(system));
    ASSERT_FALSE(bench_->start());
  }
  [[nodiscard]] std::string says(const control::RefusalRequest& refusal, const serve::Peer& peer) {
    const auto body = bench_->ask(refusal, peer).reply.body;
    const auto* done = std::get_if<control::Done>(&body);
    return done != nullptr ? done->message : std::get<control::Error>(body).message;
  }
  void admit(Value latency) {
    control::Admit request;
    request.channel = "c0";
    request.to = bench_->state().system().networks[0].name;
    request.subscriber = "logger";
    request.required = {{.name = "Latency", .value = latency, .unit = "ns", .dynamic = false}};
    bench_->ask(request);
  }
};

TEST_F(OnwardRequests, WhatIsRequiredBehindTheGatewayIsPassedOn) {
  const auto described = what_there_is();
  ASSERT_EQ(described.onward.size(), 1U) << "its subscriber on the bus is described";
  EXPECT_TRUE(described.onward[0].begins_here);
  bench_->system.subscribers.clear();
  bench_->ask(control::ReloadRequest{});
  bench_->reading().finish();
  bench_->act();
  EXPECT_TRUE(what_there_is().onward.empty());
  admit(40 * kMs);
  const auto there = what_there_is();
  EXPECT_TRUE(there.onward[0].begins_here) << "it has not come over a network";
  ASSERT_EQ(there.onward.size(), 1U);
  EXPECT_EQ(there.onward[0].subject, subject_);
  EXPECT_EQ(there.onward[0].network, lan_);
  const auto& required = there.onward[0].required;
  const auto latency = std::ranges::find(required, "Latency", &control::Attribute::name);
  ASSERT_NE(latency, required.end());
  EXPECT_LT(latency->value, 38 * kMs);  // less the gateway and the bus
  EXPECT_GT(latency->value, 0U);
}

TEST_F(OnwardRequests, ARefusalFurtherOnIsAnEventOfTheChannel) {
  control::RefusalRequest refusal{
      .subject = subject_, .network = lan_, .source = "192.0.2.9", .reason = "far: no\nway"};
  bench_->ask(control::WithdrawRequest{.channel = "c0"});
  EXPECT_EQ(says(refusal, program()), "nothing of that is subscribed on the network now");
  bench_->ask(control::ReinstateRequest{.channel = "c0"});
  admit(40 * kMs);
  bench_->events.clear();
  EXPECT_TRUE(says(refusal, member()).contains(" are for programs of user 991"));
  EXPECT_TRUE(bench_->events.empty());
  EXPECT_EQ(says(refusal, program()), "reported");
  EXPECT_EQ(bench_->events, std::vector<std::string>{"refused"});
  // Programs that were told of the refusal are told that it is over.
  refusal.reason = "";
  EXPECT_EQ(says(refusal, program()), "reported");
  EXPECT_EQ(bench_->events, (std::vector<std::string>{"refused", "granted"}));
}

TEST_F(OnwardRequests, WhoMayNotSpeakOfSubscriptionsIsToldWhoMay) {
  const control::RefusalRequest refusal{
      .subject = subject_, .network = lan_, .source = "192.0.2.9", .reason = "no"};
  for (core::Port& port : bench_->system.gateways[0].ports) port.control_uid = 0;
  bench_->ask(control::ReloadRequest{});
  bench_->reading().finish();
  bench_->act();
  EXPECT_EQ(says(refusal, program()),
            "messages about subscriptions on " + lan_ +
                " are for programs of root, since its Port states no control-user, and this one "
                "is of user 991");
}

}  // namespace
}  // namespace mlcca::test
