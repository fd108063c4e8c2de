// SPDX-License-Identifier: BSD-2-Clause
// Where programs on the gateway send granted events, and where they receive them.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "control/codec.hpp"
#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

using control::AnnounceRequest;
using control::Endpoint;
using control::Role;
using control::Transfer;

constexpr core::Place kGateway{core::Place::Kind::gateway, 0};
constexpr core::Place kEthernet{core::Place::Kind::network, 2};
constexpr uid_t kUser = 1000;
constexpr const char* kKey = "0123456789abcdef";
const std::string kLocal = std::string("0a1b2") + kKey;

/// c0 of a program "p0" of user 1000 to both buses and to a program "here".
core::System with_programs() {
  core::System system = small_system();
  system.publishers[0].place = kGateway;
  system.publishers[0].uid = kUser;
  core::Subscriber here = system.subscribers[0];
  here.name = "here";
  here.place = kGateway;
  system.subscribers.push_back(here);
  return system;
}

class Endpoints : public ::testing::Test {
 protected:
  void start(core::System system) {
    system.gateways[0].relay = 990;
    bench_ = std::make_unique<Bench>(std::move(system));
    ASSERT_FALSE(bench_->start());
  }
  std::vector<Endpoint> endpoints(const AnnounceRequest& request, std::uint64_t session,
                                  uid_t user = kUser) {
    const serve::Answer answer = bench_->ask(request, {.pid = 7, .uid = user, .session = session});
    const auto* channels = std::get_if<control::Channels>(&answer.reply.body);
    return channels == nullptr ? std::vector<Endpoint>{} : channels->endpoints;
  }
  std::vector<Endpoint> of_publisher() { return endpoints({"c0", Role::publisher, "", {}}, 1); }
  std::string refusal(const AnnounceRequest& request, std::uint64_t session, uid_t user = kUser) {
    const serve::Answer answer = bench_->ask(request, {.pid = 7, .uid = user, .session = session});
    const auto* error = std::get_if<control::Error>(&answer.reply.body);
    return error == nullptr ? "" : error->message;
  }
  std::vector<Transfer> transfers(const control::TransfersRequest& request) {
    const serve::Answer answer = bench_->ask(request, outsider());
    if (!answer.slices) return std::get<control::Transfers>(answer.reply.body).transfers;
    std::vector<Transfer> all;
    for (bool more = true; more;) {
      const auto slice = answer.slices();
      for (const Transfer& one : std::get<control::Transfers>(slice->body).transfers)
        all.push_back(one);
      more = slice->more;
    }
    return all;
  }

  std::unique_ptr<Bench> bench_;
};

TEST_F(Endpoints, APublisherSendsWhereItIsGranted) {
  start(with_programs());
  const auto all = of_publisher();
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].network, "can1");
  EXPECT_EQ(all[0].interface, "can1");
  EXPECT_NE(all[0].ifindex, 0U);
  EXPECT_TRUE(all[0].can);
  EXPECT_EQ(all[0].id, 0x10U);
  EXPECT_TRUE(all[0].classic);
  EXPECT_EQ(all[0].frame_bytes, 8U);
  EXPECT_EQ(all[0].profile, "raw");
  EXPECT_FALSE(all[0].fragmented);
  EXPECT_TRUE(all[0].local.empty());
  bench_->ask(control::WithdrawRequest{"c0"});
  EXPECT_TRUE(of_publisher().empty());
}

TEST_F(Endpoints, ASubscriberReceivesWhereEventsComeFrom) {
  core::System system = small_system();
  system.subscribers[0].place = kGateway;
  start(std::move(system));
  const auto all = endpoints({"c0", Role::subscriber, "", {}}, 1, 4711);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].network, "can0");
  EXPECT_EQ(all[0].id, 0x10U);
  EXPECT_FALSE(all[0].user);
}

TEST_F(Endpoints, ProgramsOnTheGatewayReachEachOtherWithoutANetwork) {
  start(with_programs());
  const AnnounceRequest here{"c0", Role::subscriber, "", {}, kLocal};
  const auto from = endpoints(here, 2, 4711);
  ASSERT_EQ(from.size(), 1U);
  EXPECT_EQ(from[0].user, kUser) << "whose datagrams are the publisher's";
  EXPECT_EQ(from[0].frame_bytes, 8U) << "MaxPayload";
  EXPECT_EQ(from[0].publisher, "p0");
  EXPECT_EQ(from[0].period_ns, 50'000'000U);
  EXPECT_EQ(from[0].event_cost_ns, 49'975'000U) << "500 ppm faster: clocks differ";
  EXPECT_EQ(from[0].tolerance_ns, 49'975'000U) << "one event early";
  EXPECT_EQ(from[0].silence_ns, 0U) << "no subscriber states an Omission";
  ASSERT_EQ(bench_->events.back(), "local");
  const auto to = of_publisher();
  ASSERT_EQ(to.size(), 2U);
  EXPECT_EQ(to[0].local, kLocal);
  EXPECT_EQ(to[0].local_user, 4711U) << "who stated it";
  EXPECT_EQ(to[0].frame_bytes, 8U);
  EXPECT_EQ(to[1].interface, "can1");

  const std::size_t events = bench_->events.size();
  endpoints(here, 2, 4711);
  EXPECT_EQ(bench_->events.size(), events) << "nothing is different";
  bench_->clock.monotonic += LocalEnds::kReport;
  bench_->act();
  bench_->daemon().session_closed(2);
  EXPECT_EQ(bench_->events.size(), events + 1);
  EXPECT_EQ(of_publisher().size(), 1U);
}

/// Programs of one user cannot be distinguished there.
TEST_F(Endpoints, WhatProgramsSendIsSupervisedByTheirUsers) {
  core::System system = with_programs();
  for (core::Subscriber& s : system.subscribers) s.attributes.set(Attribute::omission, 2);
  core::Publisher other = system.publishers[0];
  other.name = "other";
  other.uid = kUser + 1;
  system.publishers.push_back(other);
  const AnnounceRequest here{"c0", Role::subscriber, "here", {}, kLocal};
  start(system);
  const auto apart = endpoints(here, 2, 4711);
  ASSERT_EQ(apart.size(), 2U);
  EXPECT_EQ(apart[0].user, kUser);
  EXPECT_EQ(apart[1].publisher, "other");
  for (const Endpoint& one : apart)
    EXPECT_EQ(one.silence_ns, 150'075'000U) << "(Omission + 1) * Period, 500 ppm slower";
  system.publishers[1].uid = kUser;
  start(system);
  const auto together = endpoints(here, 2, 4711);
  ASSERT_EQ(together.size(), 1U);
  EXPECT_EQ(together[0].publisher, "");
  EXPECT_EQ(together[0].event_cost_ns, 49'975'000U / 2);
  EXPECT_EQ(together[0].silence_ns, 150'075'000U);
}

TEST_F(Endpoints, AnAddressIsOneThatTheKernelGaveToASubscriberWithItsKey) {
  start(with_programs());
  const std::string digits = kLocal;
  for (const std::string& address :
       {std::string("0a1b2"), digits.substr(1), digits + "0", "0A1B2" + digits.substr(5),
        "0a1b2" + std::string("0123456789ABCDEF"), "/run/" + digits.substr(5),
        digits.substr(0, 20) + "\n", std::string(21, '\0'), std::string(4096, '0')}) {
    const std::string why = refusal({"c0", Role::subscriber, "", {}, address}, 2);
    EXPECT_NE(why, "") << address;
    EXPECT_EQ(why.find(address), std::string::npos) << "it may be nearly a key";
  }
  EXPECT_NE(refusal({"c0", Role::publisher, "", {}, kLocal}, 2), "");
  EXPECT_EQ(of_publisher().size(), 1U);
}

/// All that a request is answered, as it goes over the socket.
std::string answered(Bench& bench, decltype(control::Request::body) body, const serve::Peer& peer) {
  const serve::Answer answer = bench.ask(std::move(body), peer);
  std::string all = control::encode(answer.reply);
  for (bool more = static_cast<bool>(answer.slices); more;) {
    const auto slice = answer.slices();
    if (!slice) break;
    all += control::encode(control::Reply{.id = 1, .body = slice->body}) + slice->encoded;
    more = slice->more;
  }
  return all;
}

TEST_F(Endpoints, AKeyIsForGrantedPublishersAlone) {
  start(with_programs());
  const AnnounceRequest subscribe{"c0", Role::subscriber, "", {}, kLocal};
  const AnnounceRequest announce{"c0", Role::publisher, "", {}};
  const auto says_key = [this](decltype(control::Request::body) body, const serve::Peer& peer) {
    return answered(*bench_, std::move(body), peer).contains(kKey);
  };
  const serve::Peer owner{.pid = 7, .uid = 4711, .session = 2};
  const serve::Peer other{.pid = 8, .uid = 4712, .session = 3};
  const serve::Peer root{.pid = 8, .uid = 0, .session = 5};
  EXPECT_FALSE(says_key(subscribe, owner));
  EXPECT_TRUE(says_key(announce, {.pid = 9, .uid = kUser, .session = 4}));
  for (const serve::Peer& peer : {owner, other, root}) {
    EXPECT_FALSE(says_key(announce, peer)) << peer.uid << ": it is no publisher";
    EXPECT_FALSE(says_key(AnnounceRequest{"c0", Role::subscriber, "", {}}, peer));
    EXPECT_FALSE(says_key(control::StatusRequest{}, peer));
    EXPECT_FALSE(says_key(control::ChannelsRequest{}, peer));
    EXPECT_FALSE(says_key(control::ExplainRequest{"c0"}, peer));
    EXPECT_FALSE(says_key(control::RoutesRequest{}, peer));
    EXPECT_FALSE(says_key(control::TransfersRequest{}, peer));
    EXPECT_FALSE(says_key(control::ReservationsRequest{}, peer));
    EXPECT_FALSE(says_key(control::NetworksRequest{}, peer));
  }
  const auto is_told = [](const control::Event& event) {
    return control::encode(control::Reply{.id = 0, .body = event}).contains(kKey);
  };
  EXPECT_TRUE(std::ranges::none_of(bench_->published, is_told));
  bench_->ask(control::WithdrawRequest{"c0"});
  EXPECT_FALSE(says_key(announce, {.pid = 9, .uid = kUser, .session = 4})) << "nothing is granted";
}

TEST_F(Endpoints, OneChannelHasSoManySubscribersAndNoMore) {
  start(with_programs());
  for (std::size_t n = 0; n < LocalEnds::kMostOfChannel; ++n)
    bench_->ask(AnnounceRequest{"c0", Role::subscriber, "", {}, kLocal},
                {.pid = 7, .uid = 0, .may_change = true, .session = 2 + n});
  const std::size_t has_place = 2;
  EXPECT_EQ(refusal({"c0", Role::subscriber, "", {}, kLocal}, has_place, 0), "");
  const auto problem = [this](const std::string& local, std::uint64_t session) {
    const auto answer = bench_->ask(AnnounceRequest{"c0", Role::subscriber, "", {}, local},
                                    {.pid = 7, .uid = 0, .may_change = true, .session = session});
    return std::get<control::Channels>(answer.reply.body).local_problem;
  };
  EXPECT_EQ(problem(kLocal, 1000), "the 64 places of c0 for subscribers on this gateway are taken");
  EXPECT_EQ(problem(std::string("0a1b3") + kKey, 3), "") << "it has another one";
}

TEST_F(Endpoints, ATransferSaysWhereItComesFromAndGoesTo) {
  core::System system = small_system();
  system.publishers[0].place = kEthernet;
  system.publishers[0].station = *core::station_of("192.0.2.7");
  start(std::move(system));
  const auto all = transfers({"c0", {}});
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].channel, "c0");
  EXPECT_EQ(all[0].publisher, "p0");
  EXPECT_EQ(all[0].from.interface, "eth0");
  EXPECT_FALSE(all[0].from.can);
  EXPECT_EQ(all[0].from.address, "192.0.2.7");
  EXPECT_EQ(all[0].to.interface, "can1");
  EXPECT_EQ(all[0].to.id, 0x10U);
  EXPECT_EQ(all[0].event_bytes, 8U);
  EXPECT_EQ(all[0].period_ns, 50 * kMs);
  EXPECT_EQ(all[0].user, 990U);
  EXPECT_EQ(all[0].latency_ns, kMs) << "what forwarding may take here";
  EXPECT_EQ(transfers({"", {}}), all);
  EXPECT_EQ(transfers({"", 990}), all);
  EXPECT_TRUE(transfers({"", 1000}).empty());
  EXPECT_TRUE(transfers({"c1", {}}).empty());
  const auto routes = bench_->ask(control::RoutesRequest{}, outsider());
  EXPECT_EQ(std::get<control::Routes>(routes.reply.body).transfers, all);
  bench_->ask(control::WithdrawRequest{"c0"});
  EXPECT_TRUE(transfers({"", {}}).empty());
}

TEST_F(Endpoints, OnWpanAnEndpointSaysSoAndHoldsOneFrame) {
  core::System system = small_system();
  system.publishers[0].place = kEthernet;
  system.publishers[0].station = *core::station_of("0xbeef:0x0002");
  system.networks[kEthernet.index].kind = core::NetworkKind::ieee802154;
  start(std::move(system));
  const auto all = transfers({"c0", {}});
  ASSERT_EQ(all.size(), 1U);
  EXPECT_FALSE(all[0].from.can);
  EXPECT_TRUE(all[0].from.wpan);
  EXPECT_FALSE(all[0].from.fragmented);
  EXPECT_EQ(all[0].from.address, "0xbeef:0x0002");
  EXPECT_FALSE(all[0].to.wpan);
}

TEST_F(Endpoints, OfABroadcastNetworkAnEndpointSaysSo) {
  core::System system = small_system();
  system.publishers[0].place = kEthernet;
  for (const bool broadcast : {true, false}) {
    if (broadcast) system.networks[kEthernet.index].kind = core::NetworkKind::udp_broadcast;
    start(core::System(system));
    const auto all = transfers({"c0", {}});
    ASSERT_EQ(all.size(), 1U);
    EXPECT_FALSE(all[0].from.can);
    EXPECT_EQ(all[0].from.broadcast, broadcast);
    EXPECT_FALSE(all[0].to.broadcast);
    system.networks[kEthernet.index].kind = core::NetworkKind::udp_multicast;
  }
}

TEST_F(Endpoints, ADeliveryThatTheRelayDoesNotCarryIsInTrouble) {
  core::System system = small_system();
  system.publishers[0].place = kEthernet;
  start(std::move(system));
  const auto troubles = [this] {
    const auto answer = bench_->ask(control::ExplainRequest{"c0"});
    return std::get<control::Channels>(answer.reply.body).channels.at(0).problems;
  };
  const std::vector<std::string> missing{
      "mlcca-relay, which is to carry it, is not connected: start mlcca-relay.service"};
  EXPECT_EQ(troubles(), missing);
  bench_->ask(control::TransfersRequest{"", 990}, {.pid = 7, .uid = kUser, .session = 5});
  EXPECT_EQ(troubles(), missing) << "any user may ask";
  bench_->ask(control::TransfersRequest{"", 990}, {.pid = 7, .uid = 990, .session = 6});
  EXPECT_TRUE(troubles().empty());
  bench_->daemon().session_closed(6);
  EXPECT_EQ(troubles(), missing);
}

TEST_F(Endpoints, WhatTheRelayCarriesTooLateIsAnExceptionAndATrouble) {
  core::System system = small_system();
  system.publishers[0].place = kEthernet;
  system.gateways[0].provision.set(Attribute::latency, 2 * kMs);
  start(std::move(system));
  const serve::Peer relay{.pid = 7, .uid = 990, .session = 6};
  const Transfer carried = transfers({"", {}}).at(0);
  control::DelayRequest delay{.subject = carried.subject,
                              .publisher = carried.publisher,
                              .from = carried.from.network,
                              .to = carried.to.network,
                              .late = 4,
                              .longest_ns = 9'800'000};
  const auto ask = [&](const serve::Peer& peer) { return bench_->ask(delay, peer).reply.body; };
  const auto says = [](const auto& body) { return std::get<control::Done>(body).message; };
  EXPECT_EQ(std::get<control::Error>(ask(relay)).kind, control::ErrorKind::forbidden)
      << "it has not asked what it is to carry";
  bench_->ask(control::TransfersRequest{"", 990}, relay);
  EXPECT_EQ(std::get<control::Error>(ask({.pid = 7, .uid = kUser, .session = 6})).kind,
            control::ErrorKind::forbidden);
  EXPECT_NE(says(ask(relay)).find("4 events from"), std::string::npos);
  const auto troubles = [this] {
    const auto answer = bench_->ask(control::ExplainRequest{"c0"});
    return std::get<control::Channels>(answer.reply.body).channels.at(0).problems;
  };
  EXPECT_EQ(troubles(), std::vector<std::string>{
                            "the program that carries it to can1 took up to 9.8 ms, longer than "
                            "the gateway states, for 4 events"});
  EXPECT_EQ(says(ask(relay)), "too soon after the last report");
  delay.publisher = "another";
  EXPECT_EQ(says(ask(relay)), "nothing that is granted is late");
  delay.subject = 99;
  EXPECT_TRUE(std::holds_alternative<control::Error>(ask(relay)));
  bench_->clock.monotonic += 60 * 1'000 * kMs;
  EXPECT_TRUE(troubles().empty()) << "it counts for a minute";
}

TEST_F(Endpoints, OfWhatGoesFromProgramToProgramNoFrameIsCounted) {
  const auto crosses_none = [this](core::System system) {
    start(std::move(system));
    const auto answer = bench_->ask(control::ExplainRequest{"c0"});
    return std::get<control::Channels>(answer.reply.body).channels.at(0).crosses_no_gate;
  };
  EXPECT_FALSE(crosses_none(small_system()));
  core::System system = small_system();
  system.publishers[0].place = kGateway;
  system.publishers[0].uid = kUser;
  system.subscribers[0].place = kGateway;
  EXPECT_TRUE(crosses_none(std::move(system)));
}

TEST_F(Endpoints, WhatTheKernelCarriesIsNoTransfer) {
  start(small_system());
  ASSERT_TRUE(bench_->state().decisions()[0].verdicts.at(0).granted);
  EXPECT_TRUE(transfers({"", {}}).empty());
}

TEST_F(Endpoints, PublishersThatCannotBeDistinguishedAreOneTransfer) {
  core::System system = small_system();
  system.publishers[0].place = kEthernet;
  system.publishers.push_back(system.publishers[0]);
  system.publishers[1].name = "other";
  start(std::move(system));
  EXPECT_EQ(transfers({"", {}}).size(), 1U);
}

}  // namespace
}  // namespace mlcca::test
