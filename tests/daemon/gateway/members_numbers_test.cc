// SPDX-License-Identifier: BSD-2-Clause
// A gateway that has lost its journal gives numbers of admissions that the store still has to
// others.
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/daemon/gateway/members_forged.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

constexpr std::uint64_t kNumber = 7001;

/// g1 does not run. It asks g0 to carry and to admit what these tests write.
class MembersNumbers : public MembersForged {
 protected:
  void start_and_leave_g1() {
    start_both();
    at(1).end();
    beat_of_g1();
    run();
  }
  void ask_g0(std::uint64_t n, cc::Stage stage, const control::Admit& admit,
              bool on_behalf = false) {
    const cluster::StoredRequest asked{.channel = admit.channel,
                                       .requests = {{.id = kNumber, .body = admit}},
                                       .also = {},
                                       .on_behalf = on_behalf};
    store.write({{.key = key("x/g1/") + std::to_string(n),
                  .value = codec.write(cc::RouteRequest{
                      .stage = stage, .admission = cluster::text_of(asked), .gateways = {0}})}});
    beat_of_g1();
    run();
  }
  void grant(std::uint64_t n, const control::Admit& admit) {
    ask_g0(n, cc::Stage::prepared, admit);
    ask_g0(n, cc::Stage::granted, admit);
  }
  std::string answer(std::uint64_t n) {
    const auto vote = answer_to_g1(n);
    if (!vote) return "no answer";
    return vote->ok ? "yes" : vote->reason;
  }
  /// The entry of what g0 admits for g1.
  std::string made_for_g1() {
    for (const auto& [name, asked] : asked_by_g0())
      if (asked.for_gateway == "g1") return name;
    return {};
  }
  /// g0 has a publisher, and is asked to admit a subscriber of it for g1. The entry of that.
  std::string admit_for_g1() {
    start_both();
    EXPECT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
    at(1).end();
    beat_of_g1();
    run();
    ask_g0(5, cc::Stage::prepared, subscriber_on_own1("c3", "also"), true);
    return made_for_g1();
  }
  bool carries(const std::string& channel) {
    const auto there = at(0).state().find_channel(channel);
    return there && granted(0, *there);
  }
};

TEST_F(MembersNumbers, AnotherRequestWithTheNumberOfAFormerOneIsJudgedAndCarried) {
  start_and_leave_g1();
  grant(1, wanted("c3", "own0", "g0"));
  ASSERT_EQ(answer(1), "yes");
  ASSERT_TRUE(carries("c3"));
  grant(2, wanted("c4", "own0", "g0"));
  EXPECT_EQ(answer(2), "yes");
  EXPECT_TRUE(carries("c4"));
  EXPECT_FALSE(carries("c3")) << "the former one has ended";
  EXPECT_EQ(answer(1), "its number is that of another admission since");
}

TEST_F(MembersNumbers, AnotherRequestWithTheNumberOfAFormerOneIsRefusedWhereItDoesNotFit) {
  start_and_leave_g1();
  grant(1, wanted("c3", "own0", "g0"));
  auto much = wanted("c4", "own0", "g0");
  much.offered = {attribute_of("Period", 1'000)};
  ask_g0(2, cc::Stage::prepared, much);
  EXPECT_NE(answer(2), "yes");
  EXPECT_NE(answer(2), "no answer");
}

TEST_F(MembersNumbers, TheFormerOneDoesNotTakeItsNumberBack) {
  start_and_leave_g1();
  grant(1, wanted("c3", "own0", "g0"));
  grant(2, wanted("c4", "own0", "g0"));
  grant(1, wanted("c3", "own0", "g0"));
  EXPECT_TRUE(carries("c4"));
  EXPECT_FALSE(carries("c3"));
}

TEST_F(MembersNumbers, WhatIsTheSameRequestIsCarriedUntilTheLastOneEnds) {
  start_and_leave_g1();
  grant(1, wanted("c3", "own0", "g0"));
  auto again = wanted("c3", "own0", "g0");
  again.key = "another";
  again.lease_ns = kSecondNs;
  grant(2, again);
  EXPECT_EQ(answer(2), "yes");
  store.write({}, {key("x/g1/1")});
  run();
  EXPECT_TRUE(carries("c3"));
  EXPECT_EQ(answer(2), "yes");
  store.write({}, {key("x/g1/2")});
  run();
  EXPECT_FALSE(carries("c3"));
}

TEST_F(MembersNumbers, WhatWasAdmittedForTheFormerOneIsGivenBack) {
  const std::string made = admit_for_g1();
  ASSERT_NE(made, "");
  ask_g0(6, cc::Stage::prepared, wanted("c4", "own0", "g0"));
  EXPECT_EQ(answer(6), "yes");
  EXPECT_EQ(answer(5), "its number is that of another admission since");
  for (int n = 0; n < 30; ++n) {
    if (n % 10 == 0) beat_of_g1();
    pass(kStepNs);
  }
  EXPECT_FALSE(store.entries.contains(made));
}

/// One entry is for g0 to admit, the other one says that g1 has admitted it.
TEST_F(MembersNumbers, ARequestThatIsAdmittedForAnotherGatewayIsNotCarriedBeside) {
  const std::string made = admit_for_g1();
  ASSERT_NE(made, "");
  ask_g0(6, cc::Stage::prepared, subscriber_on_own1("c3", "also"));
  EXPECT_EQ(answer(6), "it was asked for before");
  store.write({{.key = key("a/g1/g0/") + made.substr(made.rfind('/') + 1),
                .value = codec.write(cc::VoteOf{.asked = store.entries.at(made).create,
                                                .vote = {.ok = true, .hop = {}, .reason = {}}})}});
  run();
  beat_of_g1();
  run();
  EXPECT_EQ(answer(5), "yes");
}

/// The store still has what it has reserved before. With the same number it would count as one.
TEST_F(MembersNumbers, ANumberThatTheStoreHasIsNotGivenAgain) {
  start_both();
  ASSERT_EQ(asked(1, wanted("c4", "own1", "shared")), "granted");
  const auto numbers = [this] {
    std::vector<std::uint64_t> all;
    for (const auto& [name, entry] : store.entries) {
      const auto asked = name.starts_with(key("x/g1/")) ? codec.asked(entry.value) : std::nullopt;
      const auto text = asked ? cluster::asked_in(asked->admission) : std::nullopt;
      if (text)
        for (const control::Request& request : text->requests) all.push_back(request.id);
    }
    return all;
  };
  const auto before = numbers();
  ASSERT_EQ(before.size(), 1U);
  at(1).lose_disk();
  start(1);
  for (int n = 0; n < 5 && asked(1, wanted("c5", "own1", "shared")) != "granted"; ++n)
    pass(kStepNs);
  const auto after = numbers();
  ASSERT_EQ(after.size(), 2U) << "the former one leaves the store a second later";
  EXPECT_NE(after.front(), after.back());
}

/// The store cannot be reached, and an admission on a network of this gateway alone gets a number
/// that the store has. When the store is back, nothing is reserved for that admission beside the
/// former one.
TEST_F(MembersNumbers, WhatHasANumberThatTheStoreHasWaitsUntilTheFormerOneHasLeft) {
  start_both();
  ASSERT_EQ(asked(1, wanted("c4", "own1", "shared")), "granted");
  ASSERT_EQ(entries("r/shared/g1/"), 1U);
  at(1).lose_disk();
  link(1).up = false;
  start(1);
  ASSERT_EQ(asked(1, wanted("c5", "own1", "own1")), "granted");
  link(1).up = true;
  run();
  auto further = wanted("c5", "own1", "shared");
  further.publisher.clear();
  further.key = "further";
  auto answer = at(1).ask(further);
  run();
  std::string text = text_of(answer);
  bool met = false;
  for (int n = 0; n < 60 && text != "granted"; ++n) {
    met = met || entries("r/shared/g1/") > 1;
    pass(kStepNs);
    if (text == "nothing yet") text = text_of(answer);
    if (text == "nothing yet" || text == "granted") continue;
    answer = at(1).ask(further);
    run();
    text = text_of(answer);
  }
  EXPECT_EQ(text, "granted");
  EXPECT_FALSE(met);
  EXPECT_EQ(entries("r/shared/g1/"), 1U);
}

/// g0 would have to close the former one first, and does nothing.
TEST_F(MembersNumbers, WhatWaitsForAFormerNumberIsToldSo) {
  start_both();
  ASSERT_EQ(asked(1, wanted("c4", "own1", "own0")), "granted");
  at(1).lose_disk();
  link(1).up = false;
  start(1);
  ASSERT_EQ(asked(1, wanted("c5", "own1", "own1")), "granted");
  nodes[0]->hangs = true;
  link(1).up = true;
  run();
  auto answer = at(1).ask(wanted("c3", "own1", "shared"));
  run();
  ASSERT_EQ(text_of(answer), "nothing yet");
  pass(6 * kSecondNs);
  const std::string text = text_of(answer);
  EXPECT_NE(text.find("admissions of this gateway from before its journal was lost"),
            std::string::npos)
      << text;
}

/// The store shows an admission of this gateway with the number that one has which waits.
TEST_F(MembersNumbers, WhatWaitsWithANumberThatTheStoreHasIsNotReservedBesideTheFormerOne) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c4", "own0", "shared")), "granted");
  const auto before = asked_by_g0();
  ASSERT_EQ(before.size(), 1U);
  const std::uint64_t number = before.begin()->second.requests.front().id + 2;
  link(0).answers = false;
  auto first = at(0).ask(wanted("c3", "own0", "shared"));
  run();
  auto second = at(0).ask(wanted("c5", "own0", "shared"));
  run();
  nodes[1]->hangs = true;
  const cluster::StoredRequest former{
      .channel = "c2", .requests = {{.id = number, .body = wanted("c2", "own0", "own1")}}};
  store.write(
      {{.key = key("x/g0/") + "77",
        .value = codec.write(cc::RouteRequest{
            .stage = cc::Stage::granted, .admission = cluster::text_of(former), .gateways = {1}})},
       {.key = key("f/g0"), .value = "g1"}});
  link(0).answers = true;
  for (int n = 0; n < 40; ++n) {
    pass(kStepNs);
    for (const auto& [name, asked] : asked_by_g0())
      ASSERT_NE(asked.channel, "c5") << name << ' ' << n;
  }
  EXPECT_EQ(text_of(second), "nothing yet");
}

}  // namespace
}  // namespace mlcca::test
