// SPDX-License-Identifier: BSD-2-Clause
// Tests of requests at one gateway for publishers that another gateway has admitted.
#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <utility>
#include <variant>

#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

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
};

constexpr const char* kWhere =
    "the publisher of c3 at own0 (new) was admitted by gateway g0, and nobody behind this gateway "
    "receives it yet: ask at g0 for those who are to, with the options as here: 'mlccactl admit "
    "c3 --to own1'";

/// All gateways know described publishers.
TEST_F(MembersElsewhere, ASubscriberOfADescribedPublisherBehindAnotherGatewayIsGranted) {
  start_both();
  ASSERT_EQ(asked(1, subscriber("c2", "own1")), "granted");
  pass(kSecondNs);
  EXPECT_TRUE(passes(0, 2)) << "the other one carries it";
}

TEST_F(MembersElsewhere, ASubscriberOfAnAdmittedPublisherIsReferredToItsGateway) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  EXPECT_EQ(asked(1, subscriber("c3", "own1")), kWhere);
  EXPECT_EQ(queried(1, subscriber("c3", "own1")), kWhere);
  EXPECT_TRUE(at(1).state().admissions().empty());
  // The command in the refusal works.
  ASSERT_EQ(asked(0, subscriber("c3", "own1")), "granted");
  pass(kSecondNs);
  // From then on the other gateway knows the publisher, too.
  auto one_more = subscriber("c3", "own1");
  one_more.key = one_more.subscriber = "third";
  EXPECT_EQ(asked(1, one_more), "granted");
}

/// A request that names the place of the publisher does not mean another publisher there.
TEST_F(MembersElsewhere, TheSameWhereItIsSaidFromWhere) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  const std::string why = asked(1, subscriber("c3", "own1", "own0"));
  EXPECT_NE(why.find("'mlccactl admit c3 --from own0 --to own1'"), std::string::npos) << why;
  EXPECT_EQ(entries("x/g1/"), 0U);
}

TEST_F(MembersElsewhere, WithoutAPublisherAnywhereThereIsNothingToAdmit) {
  start_both();
  const std::string why = asked(1, subscriber("c3", "own1"));
  EXPECT_NE(why.find("no endpoint publishes c3"), std::string::npos) << why;
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  at(0).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "c3own0"});
  pass(3 * kSecondNs);
  const std::string then = asked(1, subscriber("c3", "own1"));
  EXPECT_NE(then.find("no endpoint publishes c3"), std::string::npos) << then;
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
  EXPECT_NE(why.find("no endpoint publishes c3"), std::string::npos) << why;
}

}  // namespace
}  // namespace mlcca::test
