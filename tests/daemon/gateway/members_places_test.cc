// SPDX-License-Identifier: BSD-2-Clause
// Tests of subscribers that another gateway has admitted, and for which there is no place here for
// a while.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/daemon/gateway/members_passing.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

constexpr const char* kFirst = "0x5600000000000001";
constexpr const char* kSecond = "0x5600000000000002";

/// Each network has one channel that is not described.
class MembersPlaces : public MembersPassing {
 protected:
  MembersPlaces() {
    for (std::size_t g = 0; g < 2; ++g)
      for (core::Network& n : at(g).system.networks)
        n.unlisted = {.allowed = true, .subject = kUnlistedSubjects, .bits = 8, .most = 1};
  }
  static control::Admit not_described(control::Admit request,
                                      std::vector<control::Identifier> identifiers) {
    request.unlisted = true;
    request.identifiers = std::move(identifiers);
    if (!request.publisher.empty())
      request.offered = {attribute_of("Period", 50 * kMs), attribute_of("MaxPayload", 8)};
    return request;
  }
  static control::Admit first_subscriber() {
    auto request = subscriber("own1");
    request.channel = kFirst;
    return not_described(request, {{"own0", 0x41}, {"shared", 0x42}, {"own1", 0x43}});
  }
  /// Time passes, and g0 agrees to what it is asked for.
  void agree_for(std::uint64_t time) {
    for (std::uint64_t gone = 0; gone < time; gone += kStepNs) {
      beat_of_g0();
      pass(kStepNs);
      vote("own1", {.ok = true, .hop = {}, .reason = {}});
    }
  }
};

TEST_F(MembersPlaces, WhatHasNoPlaceForAWhileGoesOnWaiting) {
  start_both();
  ASSERT_EQ(asked(0, not_described(wanted(kFirst, "own0", "shared"),
                                   {{"own0", 0x41}, {"shared", 0x42}, {"own1", 0x43}})),
            "granted");
  ASSERT_EQ(asked(1, first_subscriber()), "granted");
  at(0).end();
  beat_of_g0();
  refuse("own1");
  auto second = not_described(wanted(kSecond, "own1", "own1"), {{"own1", 0x44}});
  second.key = "second";
  ASSERT_EQ(asked(1, second), "granted") << "it has the place now";
  agree_for(30 * kSecondNs);
  const std::string why = asked(1, first_subscriber());
  EXPECT_NE(why.find("own1 has "), std::string::npos) << why;
  EXPECT_EQ(journalled(1), 2U);
  at(1).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "second"});
  agree_for(40 * kSecondNs);
  EXPECT_EQ(asked(1, first_subscriber()).find("left out"), std::string::npos)
      << asked(1, first_subscriber());
  EXPECT_EQ(at(1).state().admissions().size(), 1U);
}

/// The second one has been granted the place for which the first one waits.
class MembersPlacesTaken : public MembersPlaces {
 protected:
  static control::Admit second() {
    auto request = not_described(wanted(kSecond, "own1", "own1"), {{"own1", 0x44}});
    request.key = "second";
    return request;
  }
  void take_the_place() {
    start_both();
    ASSERT_EQ(asked(0, not_described(wanted(kFirst, "own0", "shared"),
                                     {{"own0", 0x41}, {"shared", 0x42}, {"own1", 0x43}})),
              "granted");
    ASSERT_EQ(asked(1, first_subscriber()), "granted");
    at(0).end();
    beat_of_g0();
    refuse("own1");
    ASSERT_EQ(asked(1, second()), "granted");
  }
  void expect_that_the_first_one_waits() {
    EXPECT_EQ(asked(1, second()), "granted");
    EXPECT_NE(asked(1, first_subscriber()), "granted");
    EXPECT_EQ(journalled(1), 2U);
    agree_for(30 * kSecondNs);
    EXPECT_EQ(asked(1, second()), "granted");
    at(1).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "second"});
    agree_for(60 * kSecondNs);
    EXPECT_EQ(asked(1, first_subscriber()).find("left out"), std::string::npos)
        << asked(1, first_subscriber());
    EXPECT_EQ(at(1).state().admissions().size(), 1U);
  }
};

TEST_F(MembersPlacesTaken, ByWhatIsGrantedStaysSoOverARestart) {
  take_the_place();
  at(1).end();
  beat_of_g0();
  start(1);
  for (int n = 0; n < 40; ++n) {
    beat_of_g0();
    pass(kStepNs);
  }
  expect_that_the_first_one_waits();
}

TEST_F(MembersPlacesTaken, ByWhatIsGrantedStaysSoOverAReload) {
  finish_reading = true;
  take_the_place();
  at(1).ask(control::ReloadRequest{});
  run();
  EXPECT_EQ(said(1, "reloaded: "), 1U);
  expect_that_the_first_one_waits();
}

/// Both were granted, and are after a restart: what g0 has agreed to is in the store.
TEST_F(MembersPlaces, WhatIsAgreedToIsThereAtOnceAfterARestart) {
  start_both();
  ASSERT_EQ(asked(0, not_described(wanted(kFirst, "own0", "shared"),
                                   {{"own0", 0x41}, {"shared", 0x42}, {"own1", 0x43}})),
            "granted");
  ASSERT_EQ(asked(1, first_subscriber()), "granted");
  at(1).end();
  start(1);
  EXPECT_EQ(at(1).state().admissions().size(), 1U);
  EXPECT_EQ(said(1, "admission 1 of"), 0U) << all_said(1);
}

/// By the description in force g0 has another name, and the next one may have g0 again.
TEST_F(MembersPassing, WhatAGatewayOfTheNextDescriptionMayAdmitGoesOnWaiting) {
  admit_both();
  at(0).end();
  at(1).end();
  at(1).system.gateways[0].name = "h0";
  at(1).digest = 5;
  at(1).handed_on = {{1, with_a_third_bus()}, {5, at(1).system}};
  at(1).texts.all = {{Sha256::Digest{1}, "1"}, {Sha256::Digest{5}, "5"}};
  const cluster::RecordCodec renamed(at(1).system, cc::Digest{5});
  store.write({{.key = "/mlcca/pair/d/current",
                .value = renamed.write(cc::Current{
                    .generation = 2, .digest = {5}, .former = {1}, .open = true, .waits = {}})},
               {.key = "/mlcca/pair/d/next",
                .value = renamed.write(cc::Next{.generation = 3,
                                                .digest = {6},
                                                .chunks = 1,
                                                .by = "h0",
                                                .without = {},
                                                .patience = 60 * kSecondNs})}});
  start(1);
  pass(10 * kSecondNs);
  ASSERT_TRUE(store.entries.contains("/mlcca/pair/d/next"));
  EXPECT_EQ(journalled(1), 1U);
  const std::string why = asked(1, subscriber("own1"));
  EXPECT_NE(why.find("another one is being rolled out"), std::string::npos) << why;
  store.write({}, {"/mlcca/pair/d/next"});
  pass(40 * kSecondNs);
  EXPECT_EQ(journalled(1), 0U) << "no description with it comes";
  EXPECT_EQ(said(1, "g0, where its publisher was, is no other gateway"), 1U);
}

}  // namespace
}  // namespace mlcca::test
