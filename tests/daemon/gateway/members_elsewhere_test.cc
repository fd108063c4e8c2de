// SPDX-License-Identifier: BSD-2-Clause
// Tests of subscribers at one gateway of publishers that another gateway has admitted.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>

#include "daemon/gateway/report.hpp"
#include "tests/daemon/gateway/members_across.hpp"

namespace mlcca::test {
namespace {

constexpr std::size_t kC3 = 3;
constexpr const char* kNobody =
    "no endpoint publishes c3: there is nothing to admit. A publisher that another gateway has "
    "admitted on its own networks alone is not in the store: say where it is (--from)";

class MembersElsewhere : public MembershipBench {
 protected:
  MembersElsewhere() : MembershipBench(with_a_described_publisher()) {}

  static control::Admit subscriber(const std::string& channel, const std::string& to,
                                   const std::string& from = {}) {
    control::Admit request;
    request.channel = channel;
    request.from = from;
    request.to = to;
    request.subscriber = "also";
    request.key = "also-" + to;
    return request;
  }
  std::string queried(std::size_t g, const control::Admit& request) {
    control::Query query;
    static_cast<control::ChannelRequest&>(query) = request;
    const auto body = at(g).ask(std::move(query)).reply.body;
    const auto* error = std::get_if<control::Error>(&body);
    return error == nullptr ? "something else" : error->message;
  }
  void release(std::size_t g, const std::string& key) {
    const auto body =
        at(g).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = key}).reply.body;
    EXPECT_EQ(std::get_if<control::Error>(&body), nullptr);
    run();
  }
  /// Events of c3 pass at g1 from the shared bus to its own one.
  bool passes_on() {
    const auto found = at(1).kernel.interfaces.find("own1");
    if (found == at(1).kernel.interfaces.end() || !at(1).kernel.passes()) return false;
    return std::ranges::any_of(
        at(1).kernel.gates.at(found->second.ifindex).rules, [](const auto& one) {
          return one.first.subject == kC3 + 1 && one.first.direction == core::Direction::egress &&
                 one.second.pass;
        });
  }
  /// Both gateways count c3 once on the bus that they share, beside the described c0.
  void expect_once() {
    for (std::size_t g = 0; g < 2; ++g)
      EXPECT_EQ(at(g).state().ledger().schedule(kSharedBus)->messages().size(), 2U) << g;
    EXPECT_EQ(at(0).state().ledger().reserved(kSharedBus),
              at(1).state().ledger().reserved(kSharedBus));
  }
  void expect_nothing_left() {
    for (const char* kind : {"r/", "x/", "a/"}) EXPECT_EQ(entries(kind), 0U) << kind;
    for (std::size_t g = 0; g < 2; ++g)
      EXPECT_TRUE(!at(g).runs() || at(g).state().admissions().empty()) << g;
  }
  /// Why the admission of that gateway ended, as its log says.
  std::string said(std::size_t g) {
    for (const auto& event : at(g).published)
      if (event.message.find("also-") != std::string::npos ||
          event.message.find("is not admitted any more") != std::string::npos ||
          event.message.find("is not there") != std::string::npos)
        return event.message;
    return {};
  }
  /// The publisher on own0 is admitted at g0, and a subscriber of it on own1 at g1.
  void both_admitted() {
    start_both();
    ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
    ASSERT_EQ(asked(1, subscriber("c3", "own1")), "granted");
    ASSERT_TRUE(passes_on());
  }
};

/// All gateways know described publishers.
TEST_F(MembersElsewhere, ASubscriberOfADescribedPublisherBehindAnotherGatewayIsGranted) {
  start_both();
  ASSERT_EQ(asked(1, subscriber("c2", "own1")), "granted");
  pass(kSecondNs);
  EXPECT_TRUE(passes(0, 2)) << "the other one carries it";
}

TEST_F(MembersElsewhere, ASubscriberOfAnAdmittedPublisherIsAdmittedByBothGatewaysInOneDecision) {
  both_admitted();
  EXPECT_EQ(entries("x/g1/"), 1U) << "what was asked of the other one";
  EXPECT_EQ(entries("x/g0/"), 2U) << "the publisher, and the subscriber in the name of the other";
  EXPECT_EQ(entries("a/"), 2U);
  EXPECT_EQ(entries("r/shared/g1/"), 0U);
  EXPECT_TRUE(passes(0, kC3));
  expect_once();
  // A further one behind that gateway depends on the same publisher.
  auto one_more = subscriber("c3", "own1");
  one_more.key = one_more.subscriber = "third";
  EXPECT_EQ(asked(1, one_more), "granted");
  EXPECT_EQ(entries("x/g1/"), 2U);
  expect_once();
  pass(5 * kSecondNs);
  EXPECT_TRUE(passes_on());
}

TEST_F(MembersElsewhere, TheSameWhereItIsSaidFromWhere) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  EXPECT_EQ(asked(1, subscriber("c3", "own1", "own0")), "granted");
  EXPECT_TRUE(passes_on());
  expect_once();
}

TEST_F(MembersElsewhere, ANamelessSubscriberAndARepeatedRequest) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  auto request = subscriber("c3", "own1");
  request.subscriber.clear();
  EXPECT_EQ(asked(1, request), "granted");
  EXPECT_EQ(asked(1, request), "granted") << "the same one";
  EXPECT_EQ(entries("x/g1/"), 1U);
}

/// Nothing is open before all gateways have agreed, and the answer comes after that.
TEST_F(MembersElsewhere, NothingOpensBeforeTheOtherGatewayHasAgreed) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  link(0).answers = false;
  auto answer = at(1).ask(subscriber("c3", "own1"));
  run();
  EXPECT_EQ(text_of(answer), "nothing yet");
  EXPECT_FALSE(passes_on());
  EXPECT_TRUE(at(1).state().admissions().empty());
  link(0).answers = true;
  run();
  EXPECT_EQ(text_of(answer), "granted");
  EXPECT_TRUE(passes_on());
}

/// A gateway that only knows of the publisher from the store grants it to none of its subscribers,
/// even on networks of its own: settle() has no such publisher.
TEST_F(MembersElsewhere, APublisherOfAnotherGatewayIsGrantedToNobodyHereWithoutAVote) {
  for (std::size_t g = 0; g < 2; ++g) {
    core::Subscriber s = at(g).system.subscribers.front();
    s.name = "described";
    s.channel = kC3;
    s.place = {core::Place::Kind::network, 2};
    // It can receive nothing in time from another gateway.
    s.attributes = each(50 * kMs, 3 * kMs);
    at(g).system.subscribers.push_back(s);
  }
  start_both();
  ASSERT_NE(asked(0, wanted("c3", "own0", "shared")), "granted") << "somebody could not receive it";
  EXPECT_NE(asked(1, subscriber("c3", "own1")), "granted");
  pass(3 * kSecondNs);
  EXPECT_FALSE(passes_on());
  EXPECT_FALSE(granted(1, kC3));
  expect_nothing_left();
}
TEST_F(MembersElsewhere, SubscribersOfAnotherPublisherGetNothingOfItWithoutAVote) {
  start_both();
  ASSERT_EQ(asked(1, wanted("c3", "own1", "own1")), "granted");
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  const auto before = at(1).state().decisions()[kC3].verdicts.size();
  pass(5 * kSecondNs);
  EXPECT_EQ(at(1).state().decisions()[kC3].verdicts.size(), before);
  EXPECT_EQ(entries("a/"), 0U);
  EXPECT_EQ(at(1).state().members().publishers_of(kC3).size(), 1U);
}

TEST_F(MembersElsewhere, TheGatewayThatRefusesIsNamedAndNothingChanges) {
  start_both();
  for (const char* channel : {"c4", "c5"}) {
    auto much = wanted(channel, "own1", "own1");
    much.offered = {attribute_of("Period", 2'200'000)};
    ASSERT_EQ(asked(1, much), "granted");
  }
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  const std::string why = asked(1, subscriber("c3", "own1"));
  EXPECT_NE(why.find("g0: g1: "), std::string::npos) << why;
  EXPECT_NE(why.find("own1"), std::string::npos) << why;
  EXPECT_FALSE(passes_on());
  pass(4 * kSecondNs);
  EXPECT_EQ(entries("x/"), 1U) << "the publisher";
  EXPECT_EQ(entries("a/"), 0U);
  EXPECT_EQ(entries("r/"), 1U);
  EXPECT_EQ(at(0).state().admissions().size(), 1U);
}

TEST_F(MembersElsewhere, WhatIsReleasedHereIsGivenBackByTheOtherGateway) {
  both_admitted();
  release(1, "also-own1");
  EXPECT_FALSE(passes_on());
  pass(4 * kSecondNs);
  EXPECT_EQ(entries("x/"), 1U) << "the publisher has its first subscriber";
  EXPECT_EQ(entries("r/"), 1U);
  EXPECT_EQ(entries("a/"), 0U);
  EXPECT_TRUE(passes(0, kC3));
  release(0, "c3own0");
  pass(4 * kSecondNs);
  expect_nothing_left();
}

TEST_F(MembersElsewhere, ItEndsWithThePublisher) {
  both_admitted();
  at(1).published.clear();
  release(0, "c3own0");
  for (int n = 0; n < 40; ++n) {
    EXPECT_TRUE(!passes_on() || entries("r/shared/") != 0) << "given away while it is open: " << n;
    pass(kStepNs);
  }
  EXPECT_FALSE(passes_on());
  expect_nothing_left();
  EXPECT_NE(said(1).find("g0: the publisher that it is for is not admitted any more"),
            std::string::npos)
      << said(1);
}

TEST_F(MembersElsewhere, ItIsClosedBeforeWhatTheGatewayOfThePublisherHasIsGivenAway) {
  both_admitted();
  at(1).published.clear();
  at(0).end();
  link(0).up = false;
  for (int n = 0; n < 180; ++n) {
    EXPECT_TRUE(!passes_on() || entries("r/shared/") != 0) << "given away while it is open: " << n;
    pass(kStepNs);
  }
  EXPECT_FALSE(passes_on());
  EXPECT_TRUE(at(1).state().admissions().empty());
  EXPECT_EQ(entries("x/g1/"), 0U);
  EXPECT_NE(said(1).find("g0 is not there"), std::string::npos) << said(1);
}

TEST_F(MembersElsewhere, ItIsClosedWhileThatGatewayIsDrained) {
  both_admitted();
  at(0).ask(control::DrainRequest{});
  pass(5 * kSecondNs);
  EXPECT_FALSE(passes_on());
  EXPECT_TRUE(at(1).state().admissions().empty());
  EXPECT_EQ(entries("x/g1/"), 0U);
  at(0).ask(control::JoinRequest{});
  pass(15 * kSecondNs);
  EXPECT_TRUE(passes_on());
}

TEST_F(MembersElsewhere, ItGoesOnOverARestartOfEitherGateway) {
  both_admitted();
  for (const std::size_t g : {std::size_t{1}, std::size_t{0}, std::size_t{1}}) {
    at(g).end();
    start(g);
    for (int n = 0; n < 40; ++n) {
      pass(kStepNs);
      EXPECT_TRUE(passes_on()) << g << ' ' << n;
    }
    EXPECT_EQ(entries("x/g1/"), 1U);
    EXPECT_EQ(entries("x/g0/"), 2U);
    expect_once();
  }
  release(1, "also-own1");
  release(0, "c3own0");
  pass(4 * kSecondNs);
  expect_nothing_left();
}

/// The gateway of the subscriber was away: the subscriber is admitted again when it is back.
TEST_F(MembersElsewhere, AGatewayThatWasAwayAsksAgain) {
  both_admitted();
  link(1).up = false;
  pass(20 * kSecondNs);
  EXPECT_FALSE(passes_on());
  link(1).up = true;
  pass(15 * kSecondNs);
  EXPECT_TRUE(passes_on());
  EXPECT_EQ(asked(1, subscriber("c3", "own1")), "granted") << "the same one";
  expect_once();
}
TEST_F(MembersElsewhere, WhatIsNotThereAnyMoreWhenItAsksAgainEnds) {
  both_admitted();
  at(1).end();
  release(0, "c3own0");
  pass(20 * kSecondNs);
  start(1);
  pass(20 * kSecondNs);
  EXPECT_FALSE(passes_on());
  expect_nothing_left();
}

TEST_F(MembersElsewhere, WithoutAPublisherAnywhereThereIsNothingToAdmit) {
  start_both();
  EXPECT_EQ(asked(1, subscriber("c3", "own1")), kNobody);
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  release(0, "c3own0");
  pass(3 * kSecondNs);
  EXPECT_EQ(asked(1, subscriber("c3", "own1")), kNobody);
}

/// Only its gateway knows it, and that is found by the description.
TEST_F(MembersElsewhere, APublisherOnNetworksOfOneGatewayIsFoundByItsPlace) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "own0")), "granted");
  ASSERT_EQ(entries("x/"), 0U) << "it is not in the store";
  EXPECT_EQ(asked(1, subscriber("c3", "own1")), kNobody);
  ASSERT_EQ(asked(1, subscriber("c3", "own1", "own0")), "granted");
  EXPECT_TRUE(passes_on());
  EXPECT_EQ(entries("r/shared/g0/"), 1U);
  expect_once();
  release(0, "c3own0");
  pass(4 * kSecondNs);
  expect_nothing_left();
}

TEST_F(MembersElsewhere, WhatWouldBeGrantedIsAskedAtItsGateway) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  EXPECT_EQ(queried(1, subscriber("c3", "own1")),
            "the publisher of c3 is admitted by gateway g0, which decides with this one: ask at g0 "
            "what would be granted, with the options as here: 'mlccactl query c3 --to own1'");
}

/// Nothing more is to be reserved for it, and the other gateway must open its gates all the same.
TEST_F(MembersAcross, EveryGatewayOnTheWayAgreesEvenIfNothingIsToBeReserved) {
  start_both();
  ASSERT_TRUE(granted(0, 0)) << verdict_line(at(0).state(),
                                             at(0).state().decisions().front().verdicts.front());
  ASSERT_EQ(asked(0, program_on("g1")), "granted");
  EXPECT_EQ(at(1).state().admissions().size(), 1U) << "the other one knows of it";
  EXPECT_EQ(entries("a/g1/g0/"), 1U);
  EXPECT_EQ(entries("r/"), 0U) << "the description promises what it needs";
  at(0).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "program"});
  pass(4 * kSecondNs);
  EXPECT_TRUE(at(1).state().admissions().empty());
  EXPECT_EQ(entries("x/"), 0U);
}
TEST_F(MembersAcross, AGatewayThatWasAwayAsksTheOthersAgain) {
  start_both();
  ASSERT_EQ(asked(0, program_on("g1")), "granted");
  link(0).up = false;
  pass(20 * kSecondNs);
  EXPECT_TRUE(at(1).state().admissions().empty());
  link(0).up = true;
  pass(15 * kSecondNs);
  EXPECT_EQ(at(1).state().admissions().size(), 1U);
  EXPECT_EQ(entries("x/g0/"), 1U);
}

/// A program takes up the end that its own gateway has admitted; the other gateway's admission has
/// put the same subscriber there.
TEST_F(MembersAcross, AProgramTakesUpTheOneSubscriber) {
  start_both();
  auto publisher = program_on("shared");
  publisher.from = "g0";
  publisher.channel = "c2";
  publisher.user = "1000";
  publisher.publisher = "new";
  publisher.key = "publisher";
  ASSERT_EQ(asked(0, publisher), "granted");
  auto program = program_on("g1");
  program.channel = "c2";
  ASSERT_EQ(asked(1, program), "granted");
  ASSERT_EQ(at(1).state().members().subscribers_of(2).size(), 3U) << "one came with the publisher";
  control::AnnounceRequest announced;
  announced.channel = "c2";
  announced.role = control::Role::subscriber;
  const auto body = at(1).ask(announced).reply.body;
  const auto* const error = std::get_if<control::Error>(&body);
  EXPECT_EQ(error, nullptr) << error->message;
}
TEST_F(MembersAcross, NothingIsGrantedThereWithoutTheOtherGateway) {
  start_both();
  at(1).end();
  link(1).up = false;
  pass(20 * kSecondNs);
  const std::string why = asked(0, program_on("g1"));
  EXPECT_NE(why.find("g1"), std::string::npos) << why;
  EXPECT_TRUE(at(0).state().admissions().empty());
}

/// Entries that other gateways wrote are untrusted text.
TEST_F(MembersElsewhere, WhatTheOtherOneHasWrittenIsNotBelieved) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  for (auto& [key, entry] : store.entries)
    if (key.starts_with("/mlcca/pair/x/g0/")) {
      store.write({{.key = key, .value = "nonsense"}});
      break;
    }
  run();
  const std::string why = asked(1, subscriber("c3", "own1"));
  EXPECT_EQ(why, kNobody);
}

}  // namespace
}  // namespace mlcca::test
