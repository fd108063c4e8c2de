// SPDX-License-Identifier: BSD-2-Clause
// Tests of subscribers that another gateway admits for this one, where they are asked for again
// beside other work of this gateway.
#include <gtest/gtest.h>

#include <cstddef>
#include <set>
#include <string>

#include "tests/daemon/gateway/members_passing.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

class MembersPassingAgain : public MembersPassing {
 protected:
  /// The admissions that g1 has asked g0 for, by the store.
  std::set<core::AdmissionId> asked_for_now() {
    std::set<core::AdmissionId> all;
    for (const auto& [name, entry] : store.entries) {
      if (!name.starts_with("/mlcca/pair/x/g1/")) continue;
      const auto text = codec.asked(entry.value);
      const auto of = text ? cluster::asked_in(text->admission) : std::nullopt;
      if (of && of->on_behalf) all.insert(of->requests.front().id);
    }
    return all;
  }
};

/// The operator takes g1 out and in again. What g0 has admitted for it is asked for again, as after
/// a start.
TEST_F(MembersPassingAgain, ItContinuesAfterADrainAndAJoin) {
  admit_both();
  at(1).ask(control::DrainRequest{});
  pass(3 * kSecondNs);
  EXPECT_FALSE(passes_on("own1"));
  EXPECT_NE(asked(1, subscriber("own1")).find("left out: this gateway is drained"),
            std::string::npos);
  at(1).ask(control::JoinRequest{});
  pass(15 * kSecondNs);
  EXPECT_EQ(journalled(1), 1U);
  EXPECT_EQ(asked(1, subscriber("own1")), "granted");
  EXPECT_TRUE(passes_on("own1"));
  end_all();
}

/// A reload that the kernel refuses changes nothing: what waits goes on waiting.
TEST_F(MembersPassingAgain, ItContinuesAfterAReloadThatIsTakenBackWhileItWaits) {
  admit_both();
  ASSERT_EQ(asked(1, subscriber("own2")), "granted");
  refuse("own1");
  ASSERT_FALSE(passes_on("own1"));
  std::size_t taken_back = 0;
  for (std::size_t n = 1; n <= 40; ++n) {
    const auto described = at(1).daemon().scene().description;
    at(1).digest = 2;
    at(1).kernel.calls.refuse(n);
    at(1).daemon().reload();
    at(1).reading().finish();
    at(1).kernel.calls.relent();
    at(1).digest = 1;
    if (at(1).daemon().scene().digest == Sha256::Digest{2}) {
      at(1).daemon().reload();  // nothing was refused
      at(1).reading().finish();
    } else if (at(1).daemon().scene().description == described + 2) {
      ++taken_back;
    }
    run();
    const std::string again = asked(1, subscriber("own1"));
    EXPECT_TRUE(again == "granted" || again.find("waits for gateway g0") != std::string::npos)
        << again;
  }
  EXPECT_GT(taken_back, 0U);
  pass(40 * kSecondNs);
  EXPECT_TRUE(passes_on("own1"));
  EXPECT_EQ(asked(1, subscriber("own1")), "granted");
  end_all();
}

/// What g1 reserves itself for the channel says nothing of what g0 has agreed to.
TEST_F(MembersPassingAgain, AReservationOfItsOwnDoesNotStandForTheAgreement) {
  admit_both();
  ASSERT_EQ(asked(1, subscriber("own2")), "granted");
  auto own = wanted("c3", "own2", "shared");
  ASSERT_EQ(asked(1, own), "granted");
  // After it has joined again, it reserves for the channel as the channel is now.
  store.write({{.key = "/mlcca/pair/f/g1", .value = "g0"}});
  pass(10 * kSecondNs);
  ASSERT_TRUE(passes(1, kThirdChannel));
  ASSERT_TRUE(passes_on("own1"));
  ASSERT_TRUE(passes_on("own2"));
  refuse("own1");
  EXPECT_FALSE(passes_on("own1"));
}

/// g0 is there and answers nothing. Each admission is asked for in its turn, and what this gateway
/// wishes itself has turns as well.
TEST_F(MembersPassingAgain, WhatWaitsDoesNotKeepOthersFromTheirTurns) {
  admit_publisher();
  constexpr std::size_t many = 16;
  for (std::size_t n = 0; n < many; ++n) {
    auto one = subscriber("own1");
    one.subscriber = one.key = "s" + std::to_string(n);
    ASSERT_EQ(asked(1, one), "granted") << n;
  }
  ASSERT_EQ(asked(1, wanted("c4", "own1", "shared")), "granted");
  at(0).end();
  store.write({{.key = "/mlcca/pair/f/g1", .value = "g0"}});
  std::set<core::AdmissionId> seen;
  bool own_again = false;
  for (int n = 0; n < 1800; ++n) {
    if (n % 10 == 0) beat_of_g0();
    pass(kStepNs);
    own_again = own_again || passes(1, 4);
    seen.merge(asked_for_now());
    if (n == 300) {
      EXPECT_TRUE(own_again) << "after half a minute";
    }
  }
  EXPECT_TRUE(own_again);
  EXPECT_EQ(seen.size(), many) << "each is asked for within three minutes";
}

/// Another description is loaded while g0 is asked. The admission goes on waiting.
TEST_F(MembersPassingAgain, WhatIsAskedForAtAReloadGoesOnWaiting) {
  admit_both();
  at(0).end();
  beat_of_g0();
  refuse("own1");
  ASSERT_FALSE(passes_on("own1"));
  bool is_asked = false;
  for (int n = 0; n < 200 && !is_asked; ++n) {
    if (n % 10 == 0) beat_of_g0();
    pass(kStepNs);
    is_asked = n > 20 && !asked_for_now().empty();
  }
  ASSERT_TRUE(is_asked);
  at(1).digest = 2;
  at(1).daemon().reload();
  at(1).reading().finish();
  run();
  ASSERT_NE(said(1, "reloaded: "), 0U);
  const std::string again = asked(1, subscriber("own1"));
  EXPECT_NE(again.find("waits for gateway g0"), std::string::npos) << again;
}

/// g0 leaves to others what they could carry, because a relay or a bus of it is away. It is there
/// all the same, and decides.
TEST_F(MembersPassingAgain, AGatewayThatLeavesForwardingToOthersIsAskedToo) {
  admit_both();
  at(0).end();
  beat_of_g0(cc::Role::standby);
  refuse("own1");
  ASSERT_FALSE(passes_on("own1"));
  bool is_asked = false;
  for (int n = 0; n < 400 && !is_asked; ++n) {
    if (n % 10 == 0) beat_of_g0(cc::Role::standby);
    pass(kStepNs);
    is_asked = n > 20 && !asked_for_now().empty();
  }
  EXPECT_TRUE(is_asked);
}

}  // namespace
}  // namespace mlcca::test
