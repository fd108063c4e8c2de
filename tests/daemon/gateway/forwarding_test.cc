// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/forwarding.hpp"

#include <gtest/gtest.h>
#include <linux/can.h>

#include <algorithm>
#include <utility>

#include "daemon/gateway/forwarder.hpp"

namespace mlcca {
namespace {

using net::CanRule;
using net::CanRuleThere;

constexpr int kFrom = 7;
constexpr int kTo = 8;
constexpr std::uint32_t kExact = core::kExtendedFlag | core::kRemoteFlag | CAN_EFF_MASK;

core::GateEntry entry(std::uint32_t id, bool classic = true, bool fd = false) {
  core::GateEntry e;
  e.id = id;
  e.mask = kExact;
  e.classic = classic;
  e.fd = fd;
  return e;
}

CanRule rule(std::uint32_t id, bool fd = false) {
  return {.from = kFrom, .to = kTo, .id = id, .mask = kExact, .fd = fd};
}

CanRuleThere foreign(CanRule rule) {
  CanRuleThere there;
  there.rule = rule;
  return there;
}

// --- which rules ---------------------------------------------------------------------------------

TEST(ForwardingTest, ARuleCarriesExactlyWhatWasGranted) {
  const auto rules = rules_of({entry(0x123), entry(0x123)}, kFrom, kTo);
  ASSERT_TRUE(rules) << rules.error();
  EXPECT_EQ(*rules, std::vector{rule(0x123)});
  EXPECT_FALSE(rules->front().translates());
}

TEST(ForwardingTest, ClassicAndFdFramesNeedARuleEach) {
  const auto rules = rules_of({entry(1, true, true), entry(1, true, true)}, kFrom, kTo);
  ASSERT_TRUE(rules);
  EXPECT_EQ(*rules, (std::vector{rule(1, false), rule(1, true)}));
}

TEST(ForwardingTest, OnlyFormsThatBothBusesHaveAreCarried) {
  const auto rules = rules_of({entry(1, true, true), entry(1, true, false)}, kFrom, kTo);
  ASSERT_TRUE(rules);
  EXPECT_EQ(*rules, std::vector{rule(1, false)});
  const auto none = rules_of({entry(1, true, false), entry(1, false, true)}, kFrom, kTo);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error(), "can-gw makes no FD frames of classic ones");
}

TEST(ForwardingTest, CanXlIsNotCarried) {
  core::Transit transit{entry(1, false), entry(1, false)};
  transit.in.xl = transit.out.xl = true;
  const auto none = rules_of(transit, kFrom, kTo);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error(), "can-gw carries no CAN XL frames");
}

TEST(ForwardingTest, AnotherIdentifierIsSetOnTheWay) {
  const std::uint32_t in = core::kExtendedFlag | 0x1f480064;
  const std::uint32_t out = core::kExtendedFlag | 0x1f480065;
  const auto rules = rules_of({entry(in), entry(out)}, kFrom, kTo);
  ASSERT_TRUE(rules);
  ASSERT_EQ(rules->size(), 1U);
  EXPECT_EQ(rules->front().id, in);
  EXPECT_EQ((in & rules->front().keep) | rules->front().set, out);
  EXPECT_EQ(change_of(foreign(rules->front())), "id to 1f480065");
}

TEST(ForwardingTest, TheFormOfTheIdentifierIsSetToo) {
  const auto rules = rules_of({entry(core::kExtendedFlag | 0x12345678), entry(0x123)}, kFrom, kTo);
  ASSERT_TRUE(rules);
  EXPECT_EQ(((core::kExtendedFlag | 0x12345678) & rules->front().keep) | rules->front().set,
            0x123U);
  EXPECT_EQ(change_of(foreign(rules->front())), "id to 123");
}

TEST(ForwardingTest, TheFragmentBitStaysAsItIs) {
  constexpr std::uint32_t fragment = 1U << 21;
  core::Transit transit{entry(core::kExtendedFlag | 0x1f000064),
                        entry(core::kExtendedFlag | 0x1f000065)};
  transit.in.mask &= ~fragment;
  transit.out.mask &= ~fragment;
  const auto rules = rules_of(transit, kFrom, kTo);
  ASSERT_TRUE(rules);
  const CanRule& r = rules->front();
  EXPECT_EQ(r.mask & fragment, 0U);
  for (const std::uint32_t bit : {0U, fragment})
    EXPECT_EQ(((transit.in.id | bit) & r.keep) | r.set, transit.out.id | bit);
}

core::Transit transported(std::uint32_t id, std::uint32_t open = 0) {
  core::GateEntry e = entry(core::kExtendedFlag | id);
  e.mask &= ~open;
  e.id &= e.mask;
  e.transport = true;
  e.max_length = 20;
  return {e, e};
}

TEST(ForwardingTest, MessagesAreCarriedWithTheFramesThatAnnounceThem) {
  const auto rules = rules_of(transported(0x18feca05), kFrom, kTo);
  ASSERT_TRUE(rules) << rules.error();
  ASSERT_EQ(rules->size(), 3U);
  EXPECT_EQ(rules->at(0).id, core::kExtendedFlag | 0x18feca05);
  EXPECT_EQ(rules->at(1).id, core::kExtendedFlag | 0x00ecff05);
  EXPECT_EQ(rules->at(2).id, core::kExtendedFlag | 0x00ebff05);
  for (const std::size_t carrier : {1U, 2U}) {
    EXPECT_EQ(rules->at(carrier).mask, kExact & ~0x1c000000U);
    EXPECT_FALSE(rules->at(carrier).fd);
  }
}

TEST(ForwardingTest, MessagesOfOneSourceShareTheRulesOfWhatCarriesThem) {
  const auto first = rules_of(transported(0x18feca05), kFrom, kTo);
  const auto second = rules_of(transported(0x0cfecb05, 0x1c000000), kFrom, kTo);
  const auto to_all = rules_of(transported(0x18120005, 0xff00), kFrom, kTo);
  ASSERT_TRUE(first && second && to_all);
  for (const std::size_t carrier : {1U, 2U}) {
    EXPECT_EQ(first->at(carrier), second->at(carrier));
    EXPECT_EQ(first->at(carrier), to_all->at(carrier));
  }
}

TEST(ForwardingTest, AMessageKeepsThePgnThatItNames) {
  core::Transit renamed = transported(0x18feca05);
  renamed.out.id = core::kExtendedFlag | 0x18fecb05;
  core::Transit in_one_frame = transported(0x18feca05);
  in_one_frame.out.transport = false;
  for (const auto& transit : {renamed, in_one_frame}) {
    const auto rules = rules_of(transit, kFrom, kTo);
    ASSERT_FALSE(rules);
    EXPECT_EQ(rules.error(),
              "can-gw carries frames as they are, and a message of the transport protocol names "
              "its PGN within them");
  }
}

TEST(ForwardingTest, EventsThatAreFragmentedOnOneBusOnlyCannotBeCarried) {
  core::Transit transit{entry(1), entry(1)};
  transit.in.mask &= ~(1U << 21);
  const auto rules = rules_of(transit, kFrom, kTo);
  ASSERT_FALSE(rules);
  EXPECT_NE(rules.error().find("in several fragments"), std::string::npos);
}

TEST(ForwardingTest, RemoteFramesThatOneBusRefusesStayBehind) {
  core::Transit transit{entry(1), entry(1)};
  transit.in.mask &= ~core::kRemoteFlag;
  const auto rules = rules_of(transit, kFrom, kTo);
  ASSERT_TRUE(rules);
  EXPECT_NE(rules->front().mask & core::kRemoteFlag, 0U);
}

// --- what leads to them --------------------------------------------------------------------------

TEST(ForwardingTest, TheDifferenceLeavesAloneWhatStays) {
  const Wanted wanted{{rule(1), 0}, {rule(2), 1}};
  const std::vector there{ours(rule(1), net::kFirstUid), ours(rule(3), net::kFirstUid + 1)};
  const auto changes = rule_changes_between(wanted, there);
  EXPECT_EQ(changes.remove, std::vector{there[1]});
  ASSERT_EQ(changes.add.size(), 1U);
  EXPECT_EQ(changes.add[0], ours(rule(2), net::kFirstUid + 2));
}

TEST(ForwardingTest, RulesOfOthersAreNeverRemoved) {
  const auto changes =
      rule_changes_between({}, {foreign(rule(1)), ours(rule(2), net::kLastUid + 1)});
  EXPECT_TRUE(changes.remove.empty());
}

TEST(ForwardingTest, ARuleThatIsThereTwiceIsOneTooMany) {
  const auto changes = rule_changes_between(
      {{rule(1), 0}}, {ours(rule(1), net::kFirstUid), ours(rule(1), net::kFirstUid + 9)});
  EXPECT_EQ(changes.remove.size(), 1U);
  EXPECT_TRUE(changes.add.empty());
}

struct Foreign {
  const char* what;
  CanRule rule;
  bool changes_more;
  std::size_t added, in_way;
};

class ForeignTest : public ::testing::TestWithParam<Foreign> {};

TEST_P(ForeignTest, WhatWasGrantedArrives) {
  CanRuleThere other = foreign(GetParam().rule);
  other.changes_more = GetParam().changes_more;
  const auto changes = rule_changes_between({{rule(0x100), 0}}, {other});
  EXPECT_EQ(changes.add.size(), GetParam().added) << GetParam().what;
  EXPECT_EQ(changes.in_way.size(), GetParam().in_way) << GetParam().what;
}

INSTANTIATE_TEST_SUITE_P(
    Rules, ForeignTest,
    ::testing::Values(
        Foreign{"everything", {.from = kFrom, .to = kTo}, false, 0, 0},
        Foreign{"all FD frames", {.from = kFrom, .to = kTo, .fd = true}, false, 1, 0},
        Foreign{"the other way", {.from = kTo, .to = kFrom}, false, 1, 0},
        Foreign{"this one", {.from = kFrom, .to = kTo, .id = 0x100, .mask = 0x7ff}, false, 0, 0},
        Foreign{"as cangw has it",
                {.from = kFrom, .to = kTo, .id = 0x100, .mask = 0xc00007ff},
                false,
                0,
                0},
        Foreign{"another one", {.from = kFrom, .to = kTo, .id = 0x101, .mask = 0x7ff}, false, 1, 0},
        Foreign{"all but this one",
                {.from = kFrom, .to = kTo, .id = 0x100 | CAN_INV_FILTER, .mask = 0x7ff},
                false,
                1,
                0},
        Foreign{"all but another one",
                {.from = kFrom, .to = kTo, .id = 0x101 | CAN_INV_FILTER, .mask = 0x7ff},
                false,
                0,
                0},
        Foreign{"with another identifier",
                {.from = kFrom, .to = kTo, .keep = ~0U, .set = 1},
                false,
                1,
                1},
        Foreign{"with other data", {.from = kFrom, .to = kTo}, true, 1, 1}));

TEST(ForwardingTest, ARuleOfAnotherProgramThatCarriesAPartIsInTheWay) {
  CanRule wide = rule(core::kExtendedFlag | 0x1f000064);
  wide.mask &= ~(1U << 21);
  const auto changes =
      rule_changes_between({{wide, 0}}, {foreign(rule(core::kExtendedFlag | 0x1f000064))});
  EXPECT_EQ(changes.add.size(), 1U) << "the other part would be lost";
  EXPECT_EQ(changes.in_way, std::vector{wide});
}

TEST(ForwardingTest, NumbersAreNeverUsedTwiceAndNeverRunOver) {
  Wanted wanted;
  for (std::uint32_t id = 0; id < 70'000; ++id) wanted.emplace(rule(core::kExtendedFlag | id), 0);
  const auto changes = rule_changes_between(wanted, {ours(rule(1), net::kFirstUid + 3)});
  EXPECT_EQ(changes.add.size(), net::kLastUid - net::kFirstUid);  // and the one that goes
  std::vector<std::uint32_t> uids;
  for (const auto& there : changes.add) {
    EXPECT_TRUE(there.is_ours());
    uids.push_back(there.uid);
  }
  std::ranges::sort(uids);
  EXPECT_EQ(std::ranges::adjacent_find(uids), uids.end());
  EXPECT_EQ(std::ranges::find(uids, net::kFirstUid + 3), uids.end());
}

// --- in time -------------------------------------------------------------------------------------

/// A can-gw whose rules a test reads, and that can fail.
struct FakeRules : net::CanRules {
  std::vector<CanRuleThere> rules;
  std::string broken;  ///< why everything but reading fails
  int reads = 0;

  Result<std::vector<CanRuleThere>> read() override {
    ++reads;
    return rules;
  }
  Result<void> add(const CanRuleThere& rule) override {
    if (!broken.empty()) return fail(broken);
    rules.push_back(rule);
    return {};
  }
  Result<void> remove(const CanRuleThere& rule) override {
    if (!broken.empty() || std::erase(rules, rule) == 0) return fail("no such rule");
    return {};
  }
};

class ForwarderTest : public ::testing::Test {
 protected:
  std::unique_ptr<FakeRules> made_ = std::make_unique<FakeRules>();
  FakeRules& kernel_ = *made_;
  std::vector<std::string> reported_;
  Forwarder forwarder_{std::move(made_),
                       [this](const std::string& line, bool) { reported_.push_back(line); }};
};

TEST_F(ForwarderTest, RulesComeWithTheGrantAndGoWithIt) {
  forwarder_.want(4, {rule(1)});
  forwarder_.act();
  ASSERT_EQ(kernel_.rules.size(), 1U);
  EXPECT_EQ(kernel_.rules[0].rule, rule(1));
  EXPECT_EQ(forwarder_.channel_of(rule(1)), 4U);
  forwarder_.want(4, {});
  forwarder_.act();
  EXPECT_TRUE(kernel_.rules.empty());
  EXPECT_TRUE(reported_.empty());
}

TEST_F(ForwarderTest, ARuleStaysAsLongAsAChannelNeedsIt) {
  forwarder_.want(1, {rule(1), rule(9)});
  forwarder_.want(2, {rule(2), rule(9), rule(9)});
  forwarder_.act();
  EXPECT_EQ(kernel_.rules.size(), 3U);
  EXPECT_EQ(forwarder_.channel_of(rule(9)), 1U);
  forwarder_.want(1, {});
  forwarder_.act();
  EXPECT_EQ(kernel_.rules.size(), 2U);
  EXPECT_EQ(forwarder_.channel_of(rule(9)), 2U);
  forwarder_.want(2, {rule(2)});
  forwarder_.act();
  EXPECT_EQ(kernel_.rules.size(), 1U);
  EXPECT_FALSE(forwarder_.channel_of(rule(9)));
}

TEST_F(ForwarderTest, WhatADeadDaemonLeftIsTakenOverOrTakenAway) {
  const auto kept = ours(rule(1), net::kFirstUid + 7);
  kernel_.rules = {kept, ours(rule(2), net::kFirstUid), foreign(rule(9))};
  forwarder_.want(0, {rule(1)});
  forwarder_.act();
  EXPECT_EQ(kernel_.rules, (std::vector{kept, foreign(rule(9))}));
}

TEST_F(ForwarderTest, AtTheEndOnlyThoseOfOthersAreLeft) {
  kernel_.rules = {foreign(rule(9))};
  forwarder_.want(0, {rule(1)});
  forwarder_.act();
  forwarder_.stop();
  EXPECT_EQ(kernel_.rules, std::vector{foreign(rule(9))});
}

TEST_F(ForwarderTest, RulesThatAnotherProgramRemovedAreAddedAgainAndReported) {
  forwarder_.want(0, {rule(1)});
  forwarder_.act();
  kernel_.rules.clear();
  forwarder_.poll();
  EXPECT_EQ(kernel_.rules.size(), 1U);
  ASSERT_EQ(reported_.size(), 1U);
  EXPECT_NE(reported_[0].find("removed 1 of our can-gw rules"), std::string::npos);
}

TEST_F(ForwarderTest, MakesWayForARuleOfAnotherProgramAndComesBackAfterIt) {
  forwarder_.want(0, {rule(1)});
  forwarder_.act();
  kernel_.rules.push_back(foreign({.from = kFrom, .to = kTo}));
  forwarder_.poll();
  EXPECT_EQ(kernel_.rules, (std::vector{foreign({.from = kFrom, .to = kTo})}));
  kernel_.rules.clear();
  forwarder_.poll();
  EXPECT_EQ(kernel_.rules.size(), 1U);
}

TEST_F(ForwarderTest, AFailureIsReportedOnceAndTriedAgain) {
  kernel_.broken = "can-gw: the kernel has no can-gw: modprobe can-gw";
  forwarder_.want(0, {rule(1), rule(2)});
  forwarder_.act();
  forwarder_.poll();
  ASSERT_EQ(reported_.size(), 1U);
  EXPECT_NE(reported_[0].find("modprobe can-gw"), std::string::npos);
  EXPECT_NE(forwarder_.problem().find("are not carried from bus to bus: " + kernel_.broken),
            std::string::npos);
  kernel_.broken.clear();
  forwarder_.poll();
  EXPECT_EQ(kernel_.rules.size(), 2U);
  EXPECT_TRUE(forwarder_.problem().empty());
  EXPECT_EQ(reported_.size(), 2U);
}

TEST_F(ForwarderTest, ARuleThatWentWithItsInterfaceIsNoProblem) {
  forwarder_.want(0, {rule(1)});
  forwarder_.act();
  kernel_.rules.clear();
  forwarder_.want(0, {});
  forwarder_.act();
  forwarder_.poll();
  EXPECT_TRUE(forwarder_.problem().empty());
}

TEST_F(ForwarderTest, WhoForwardsNothingReadsOnce) {
  forwarder_.act();
  for (int i = 0; i < 5; ++i) forwarder_.poll();
  EXPECT_EQ(kernel_.reads, 1);
}

TEST_F(ForwarderTest, ARuleInTheWayIsAProblemUntilItGoes) {
  CanRuleThere other = foreign({.from = kFrom, .to = kTo});
  other.changes_more = true;
  kernel_.rules = {other};
  forwarder_.want(0, {rule(1)});
  forwarder_.act();
  EXPECT_NE(forwarder_.problem().find("another program"), std::string::npos);
  EXPECT_EQ(forwarder_.in_way(), std::vector{rule(1)});
  kernel_.rules.clear();
  forwarder_.poll();
  EXPECT_TRUE(forwarder_.problem().empty());
}

}  // namespace
}  // namespace mlcca
