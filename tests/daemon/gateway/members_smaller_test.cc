// SPDX-License-Identifier: BSD-2-Clause
// Tests of reservations of which a part has ended: what nobody is granted any more is closed at the
// other gateway, too, and what is still granted continues.
#include <gtest/gtest.h>

#include <cstddef>
#include <set>
#include <string>
#include <utility>

#include "tests/daemon/gateway/members_across.hpp"
#include "tests/daemon/gateway/members_passing.hpp"

namespace mlcca::test {
namespace {

/// g0 has publishers of c3, and subscribers of it on own1 and own2, both networks of g1.
class MembersSmaller : public MembersPassing {
 protected:
  void release(std::size_t g, const std::string& key) {
    const auto answer =
        at(g).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = key});
    ASSERT_FALSE(std::holds_alternative<control::Error>(answer.reply.body)) << key;
  }
  /// What a gateway grants of c3.
  std::set<std::pair<std::string, std::string>> deliveries(std::size_t g) {
    std::set<std::pair<std::string, std::string>> all;
    for (const auto& one : at(g).state().grants(kThirdChannel).deliveries)
      all.emplace(one.publisher, one.to);
    return all;
  }
};

TEST_F(MembersSmaller, ASubscriberWhosePublisherIsReleasedIsClosedAtTheOtherGateway) {
  admit_publisher();
  ASSERT_EQ(asked(0, subscriber("own1")), "granted");
  ASSERT_TRUE(passes_on("own1"));
  release(0, "c3own0");
  pass(4 * kSecondNs);
  EXPECT_FALSE(passes_on("own1"));
  EXPECT_EQ(at(0).state().admissions().size(), 1U) << "the subscriber stays admitted";
  for (const char* kind : {"r/", "x/", "a/"}) EXPECT_EQ(entries(kind), 0U) << kind;
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  pass(4 * kSecondNs);
  EXPECT_TRUE(passes_on("own1")) << "it is asked for again";
}

/// g0 was silent for a while, and has reserved both again with one entry.
class MembersTogether : public MembersSmaller {
 protected:
  void admit_together() {
    start_both();
    ASSERT_EQ(asked(0, wanted("c3", "own0", "own1")), "granted");
    ASSERT_EQ(asked(0, subscriber("own2")), "granted");
    store.write({{.key = "/mlcca/pair/f/g0", .value = "g1"}});
    pass(30 * kSecondNs);
    ASSERT_TRUE(passes_on("own1"));
    ASSERT_TRUE(passes_on("own2"));
    ASSERT_EQ(entries("x/g0/"), 1U);
  }
  /// What stays on own1 is not interrupted meanwhile.
  void pass_with_own1(std::uint64_t time) {
    for (std::uint64_t gone = 0; gone < time; gone += kStepNs) {
      pass(kStepNs);
      ASSERT_TRUE(passes_on("own1")) << gone;
      ASSERT_TRUE(granted(0, kThirdChannel)) << gone;
    }
  }
};

TEST_F(MembersTogether, AReleasedSubscriberIsClosedAtTheOtherGatewayAndTheOthersContinue) {
  admit_together();
  const auto before = store.entries;
  release(0, "own2");
  pass_with_own1(4 * kSecondNs);
  EXPECT_FALSE(passes_on("own2"));
  EXPECT_EQ(deliveries(1), deliveries(0));
  EXPECT_EQ(at(1).state().admissions().size(), 1U);
  EXPECT_EQ(entries("x/g0/"), 1U);
  EXPECT_EQ(entries("a/g1/"), 1U);
  for (const auto& [key, entry] : store.entries)
    EXPECT_FALSE(key.starts_with("/mlcca/pair/x/g0/") && before.contains(key))
        << "it has a number of its own: " << key;
  end_all();
}

TEST_F(MembersTogether, WhatIsReleasedMeanwhileIsClosedAsWell) {
  admit_together();
  release(0, "own2");
  at(0).act();  // it asks for a smaller one
  release(0, "c3own0");
  pass(6 * kSecondNs);
  EXPECT_FALSE(passes_on("own1"));
  EXPECT_FALSE(passes_on("own2"));
  for (const char* kind : {"r/", "x/", "a/"}) EXPECT_EQ(entries(kind), 0U) << kind;
  EXPECT_TRUE(at(1).state().admissions().empty());
}

/// The other gateway does not answer for a while, so it cannot agree to the smaller one.
TEST_F(MembersTogether, WhatCannotBeReplacedNowStaysAndIsReplacedLater) {
  admit_together();
  release(0, "own2");
  link(1).answers = false;
  pass_with_own1(2 * kSecondNs);
  link(1).answers = true;
  pass_with_own1(15 * kSecondNs);
  EXPECT_FALSE(passes_on("own2"));
  EXPECT_EQ(deliveries(1), deliveries(0));
  EXPECT_EQ(entries("x/g0/"), 1U);
}

TEST_F(MembersTogether, ItEndsAlsoIfTheGatewayIsStartedAgainMeanwhile) {
  admit_together();
  release(0, "own2");
  at(0).act();
  at(0).end();
  start(0);
  pass(10 * kSecondNs);
  EXPECT_TRUE(passes_on("own1"));
  EXPECT_FALSE(passes_on("own2"));
  EXPECT_EQ(deliveries(1), deliveries(0));
  EXPECT_EQ(entries("x/g0/"), 1U);
}

/// Two programs on g0 publish c2, and a program on g1 receives both.
class MembersTwoPublishers : public MembersAcross {
 protected:
  static constexpr std::size_t kChannel = 2;
  void admit_publishers() {
    start_both();
    for (const char* const name : {"one", "two"}) {
      control::Admit request = program_on("shared");
      request.channel = "c2";
      request.from = "g0";
      request.user = "1000";
      request.publisher = request.key = name;
      request.subscriber = std::string("with-") + name;
      ASSERT_EQ(asked(0, request), "granted") << name;
    }
  }
  void admit_subscriber(std::size_t at) {
    control::Admit request = program_on("g1");
    request.channel = "c2";
    ASSERT_EQ(asked(at, request), "granted");
    pass(kSecondNs);
  }
  /// The publishers whose events a gateway grants to programs on g1.
  std::set<std::string> publishers(std::size_t g) {
    std::set<std::string> all;
    for (const auto& one : at(g).state().grants(kChannel).deliveries)
      if (one.to == "g1") all.insert(one.publisher);
    return all;
  }
  void release_one_of_two() {
    for (std::size_t g = 0; g < 2; ++g)
      ASSERT_EQ(publishers(g), (std::set<std::string>{"one", "two"})) << g;
    at(0).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "one"});
    for (int n = 0; n < 40; ++n) {
      pass(kStepNs);
      for (std::size_t g = 0; g < 2; ++g) ASSERT_TRUE(publishers(g).contains("two")) << g << n;
    }
    for (std::size_t g = 0; g < 2; ++g)
      EXPECT_EQ(publishers(g), (std::set<std::string>{"two"})) << g;
  }
};

TEST_F(MembersTwoPublishers, AReleasedPublisherIsClosedAtTheOtherGatewayAndTheOtherOneContinues) {
  admit_publishers();
  admit_subscriber(0);
  release_one_of_two();
}

TEST_F(MembersTwoPublishers, TheSameHoldsForASubscriberThatIsAdmittedForTheOtherGateway) {
  admit_publishers();
  admit_subscriber(1);
  release_one_of_two();
  at(1).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "program"});
  at(0).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "two"});
  pass(4 * kSecondNs);
  for (const char* kind : {"r/", "x/", "a/"}) EXPECT_EQ(entries(kind), 0U) << kind;
}

}  // namespace
}  // namespace mlcca::test
