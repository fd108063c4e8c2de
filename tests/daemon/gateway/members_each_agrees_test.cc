// SPDX-License-Identifier: BSD-2-Clause
// Tests of one publisher whose subscribers are behind different gateways, or on different networks
// of one. What a gateway does not carry is not granted, and keeps nothing else closed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "tests/daemon/gateway/members_across.hpp"
#include "tests/daemon/gateway/members_passing.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

constexpr const char* kToPublisher = "/mlcca/pair/x/g0/";

/// g0 has a publisher with a subscriber on own1 and one on own2, both networks of g1.
class MembersEachAgrees : public MembersPassing {
 protected:
  void admit_both_subscribers() {
    start_both();
    ASSERT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
    ASSERT_EQ(asked(0, subscriber("own2")), "granted");
    ASSERT_TRUE(passes_on("own1"));
    ASSERT_TRUE(passes_on("own2"));
    ASSERT_EQ(entries("x/g0/"), 2U);
  }
  std::string shown() { return asked(0, subscriber("own2")); }
  /// g1 does not carry any more what g0 has asked it for on that network.
  void take_back(const std::string& network) {
    for (const auto& [name, entry] : store.entries) {
      if (!name.starts_with(kToPublisher)) continue;
      const auto asked = codec.asked(entry.value);
      const auto text = asked ? cluster::asked_in(asked->admission) : std::nullopt;
      if (!text || std::get<control::Admit>(text->requests.front().body).to != network) continue;
      store.write(
          {{.key = "/mlcca/pair/a/g1/g0/" + name.substr(name.rfind('/') + 1),
            .value = codec.write(cc::VoteOf{.asked = entry.create,
                                            .vote = {.ok = false, .hop = {}, .reason = kBusy}})}});
      break;
    }
    run();
  }
};

TEST_F(MembersEachAgrees, WhatTheOtherGatewayHasTakenBackIsNotGrantedBesideAnotherOne) {
  admit_both_subscribers();
  take_back("own2");
  EXPECT_NE(shown().find("waits for gateway g1"), std::string::npos) << shown();
  EXPECT_TRUE(passes_on("own1"));
  pass(60 * kSecondNs);
  EXPECT_TRUE(passes_on("own2")) << shown();
  EXPECT_EQ(shown(), "granted");
}

TEST_F(MembersEachAgrees, WhatTheOtherGatewayCannotCarryAfterItsRestartComesBack) {
  admit_both_subscribers();
  at(1).end();
  at(1).kernel.unplug("own2");
  start(1);
  pass(6 * kSecondNs);
  EXPECT_NE(shown(), "granted");
  EXPECT_TRUE(passes_on("own1"));
  at(1).kernel.plug("own2");
  at(1).daemon().links_changed();
  pass(100 * kSecondNs);
  EXPECT_TRUE(passes_on("own2")) << shown();
  EXPECT_EQ(shown(), "granted");
}

core::System three_gateways(bool side_by_side) {
  core::System system = two_gateways();
  core::Network bus = some_bus("own2");
  bus.bindings = system.networks.back().bindings;
  system.networks.push_back(bus);
  core::Gateway gateway = system.gateways[1];
  gateway.name = "g2";
  if (!side_by_side) {
    gateway.ports.back().network = system.networks.size() - 1;
    gateway.ports.back().identity.name = "own2";
  }
  system.gateways.push_back(gateway);
  return system;
}

/// g2 has own2, or is beside g1.
class MembersOfThree : public MembershipBench {
 protected:
  explicit MembersOfThree(bool side_by_side = false)
      : MembershipBench(three_gateways(side_by_side)),
        codec(three_gateways(side_by_side), cc::Digest{1}) {
    nodes.push_back(std::make_unique<Node>(store, 2, three_gateways(side_by_side)));
  }
  void start_all() {
    for (std::size_t g = 0; g < 3; ++g) start(g);
    pass(6 * kSecondNs);
  }
  void end(std::size_t g) {
    at(g).end();
    link(g).up = false;
  }
  void start_again(std::size_t g) {
    link(g).up = true;
    start(g);
  }
  bool passes_on(std::size_t g, const std::string& network) {
    const auto found = at(g).kernel.interfaces.find(network);
    if (found == at(g).kernel.interfaces.end() || !at(g).kernel.passes()) return false;
    return std::ranges::any_of(
        at(g).kernel.gates.at(found->second.ifindex).rules, [](const auto& one) {
          return one.first.subject == kThirdChannel + 1 &&
                 one.first.direction == core::Direction::egress && one.second.pass;
        });
  }
  static control::Admit subscriber(const std::string& to, const std::string& name = "on") {
    control::Admit request = subscriber_on_own1("c3", name + to);
    request.to = to;
    request.key = name + to;
    return request;
  }
  void admit_both_subscribers() {
    start_all();
    ASSERT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
    ASSERT_EQ(asked(0, subscriber("own2")), "granted");
    ASSERT_TRUE(passes_on(1, "own1"));
    ASSERT_TRUE(passes_on(2, "own2"));
  }
  /// It was silent for a while.
  void fence_g0() { store.write({{.key = "/mlcca/pair/f/g0", .value = "g1"}}); }
  /// As that gateway writes it each second, whatever its process does.
  void beat_of(std::size_t g, cc::Role role) {
    const auto& was = store.entries.at("/mlcca/pair/m/g" + std::to_string(g));
    auto beat = codec.beat(was.value).value_or(cc::Beat{});
    if (beat.incarnation == 0) beat.incarnation = was.create;
    ++beat.seq;
    beat.role = role;
    beat.applied = store.revision;
    store.write({{.key = "/mlcca/pair/m/g" + std::to_string(g), .value = codec.write(beat)}});
  }

  cluster::RecordCodec codec;
};

TEST_F(MembersOfThree, AGatewayThatIsOffDoesNotKeepWhatLeadsOverAnotherOne) {
  admit_both_subscribers();
  end(2);
  pass(30 * kSecondNs);
  EXPECT_TRUE(passes_on(1, "own1"));
  fence_g0();
  pass(30 * kSecondNs);
  EXPECT_TRUE(passes_on(1, "own1")) << asked(0, wanted("c3", "own0", "own1"));
  EXPECT_NE(asked(0, subscriber("own2")), "granted");
  start_again(2);
  pass(60 * kSecondNs);
  EXPECT_TRUE(passes_on(1, "own1"));
  EXPECT_TRUE(passes_on(2, "own2")) << asked(0, subscriber("own2"));
}

/// g2 is there, without the network.
TEST_F(MembersOfThree, AGatewayThatRefusesDoesNotKeepWhatLeadsOverAnotherOne) {
  admit_both_subscribers();
  end(2);
  at(2).kernel.unplug("own2");
  start_again(2);
  pass(4 * kSecondNs);
  fence_g0();
  pass(30 * kSecondNs);
  EXPECT_TRUE(passes_on(1, "own1")) << asked(0, wanted("c3", "own0", "own1"));
  EXPECT_NE(asked(0, subscriber("own2")), "granted");
}

TEST_F(MembersOfThree, AGatewayThatIsOffDoesNotKeepASubscriberBehindAnotherOne) {
  start_all();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "own2")), "granted");
  end(2);
  pass(30 * kSecondNs);
  EXPECT_EQ(asked(0, subscriber("own1")), "granted");
  EXPECT_TRUE(passes_on(1, "own1"));
  EXPECT_NE(asked(0, wanted("c3", "own0", "own2")), "granted");
}

TEST_F(MembersOfThree, WhatADeadGatewayCarriedIsNotGrantedAndComesBack) {
  admit_both_subscribers();
  end(2);
  pass(30 * kSecondNs);
  EXPECT_NE(asked(0, subscriber("own2")), "granted");
  start_again(2);
  pass(120 * kSecondNs);
  EXPECT_TRUE(passes_on(2, "own2")) << asked(0, subscriber("own2"));
}

TEST_F(MembersOfThree, OfTwoSubscribersEachHasTheGatewayOnItsWay) {
  admit_both_subscribers();
  std::size_t of_g1 = 0, of_g2 = 0;
  for (const auto& [name, entry] : store.entries) {
    const auto asked = name.starts_with(kToPublisher) ? codec.asked(entry.value) : std::nullopt;
    if (!asked) continue;
    ASSERT_EQ(asked->gateways.size(), 1U) << name;
    ++(asked->gateways.front() == 1 ? of_g1 : of_g2);
  }
  EXPECT_EQ(of_g1, 1U);
  EXPECT_EQ(of_g2, 1U);
}

class MembersBesideEachOther : public MembersOfThree {
 protected:
  MembersBesideEachOther() : MembersOfThree(true) {}
  void admit() {
    start_all();
    ASSERT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
    ASSERT_TRUE(passes_on(1, "own1"));
    ASSERT_FALSE(passes_on(2, "own1"));
  }
  /// g1 leaves to g2 what both could carry.
  void leave_to_g2() {
    at(1).end();
    for (int n = 0; n < 100; ++n) {
      if (n % 5 == 0) beat_of(1, cc::Role::standby);
      pass(kStepNs);
    }
  }
};

TEST_F(MembersBesideEachOther, WhatTheElectedGatewayDoesNotCarryIsNotGranted) {
  admit();
  leave_to_g2();
  EXPECT_TRUE(passes_on(2, "own1"));
  EXPECT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
}

/// g1 leaves it to g2 for a while, and then carries it again.
TEST_F(MembersBesideEachOther, OnlyOneCarriesItWhenBothHaveAgreed) {
  admit();
  leave_to_g2();
  ASSERT_TRUE(passes_on(2, "own1"));
  start(1);
  for (int n = 0; n < 1200; ++n) {
    pass(kStepNs);
    ASSERT_FALSE(passes_on(1, "own1") && passes_on(2, "own1")) << n;
  }
  EXPECT_TRUE(passes_on(1, "own1") || passes_on(2, "own1"));
  EXPECT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
}

/// The store does not answer, and g1 carries it all the same.
class MembersWithoutStore : public MembersAcross {};

TEST_F(MembersWithoutStore, TheOtherGatewayIsNotBlamedForTheStore) {
  start_both();
  ASSERT_EQ(asked(0, program_on("g1")), "granted");
  link(0).up = false;
  link(0).answers = false;
  pass(9 * kSecondNs + 700 * kMs);
  const std::string shown = asked(0, program_on("g1"));
  EXPECT_NE(shown.find("waits for the store"), std::string::npos) << shown;
}

/// A channel with many subscribers on g0 itself, and one behind g1.
TEST_F(MembersEachAgrees, AChannelWithManySubscribersHereIsReservedAgain) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
  for (std::size_t n = 0; n < cluster::StoredRequest::kMostRequests + 4; ++n) {
    control::Admit local = subscriber("g0");
    local.subscriber = local.key = "local" + std::to_string(n);
    ASSERT_EQ(asked(0, local), "granted") << n;
  }
  ASSERT_TRUE(passes_on("own1"));
  store.write({{.key = "/mlcca/pair/f/g0", .value = "g1"}});  // it was silent for a while
  pass(30 * kSecondNs);
  EXPECT_TRUE(passes_on("own1")) << asked(0, wanted("c3", "own0", "own1"));
}

/// All admissions of one place are one delivery, and so one entry. The first one brings the
/// publisher, too.
class MembersAtOnePlace : public MembersEachAgrees {
 protected:
  void admit(std::size_t admissions) {
    for (; there_ < admissions; ++there_) {
      control::Admit further = subscriber("own1");
      further.subscriber = further.key = "at-own1-" + std::to_string(there_);
      ASSERT_EQ(asked(0, further), "granted") << there_;
    }
    ASSERT_TRUE(passes_on("own1"));
  }
  /// Whether g0 has them again after it was taken for dead.
  bool are_reserved_again() {
    store.write({{.key = "/mlcca/pair/f/g0", .value = "g1"}});
    pass(12 * kSecondNs);
    return passes_on("own1");
  }

 private:
  std::size_t there_ = 1;
};

TEST_F(MembersAtOnePlace, AsManyAdmissionsAsAnEntryTakesAreReservedAgainAndOneMoreIsNot) {
  constexpr std::size_t most = cluster::StoredRequest::kMostRequests;
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
  admit(most);
  EXPECT_TRUE(are_reserved_again());
  admit(most + 1);
  EXPECT_FALSE(are_reserved_again());
  EXPECT_TRUE(std::ranges::any_of(at(0).published, [](const control::Event& event) {
    return event.message.find("too long for the store") != std::string::npos;
  }));
}

}  // namespace
}  // namespace mlcca::test
