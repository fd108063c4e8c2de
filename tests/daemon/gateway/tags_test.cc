// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's tags as the daemon knows them: who claims one, and who may have it.
#include "daemon/gateway/tags.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "bpf/gate.h"
#include "core/admission/state.hpp"
#include "core/gates/control_traffic.hpp"
#include "tests/core/robot.hpp"

namespace mlcca {
namespace {

using core::testing::kBridge;
using core::testing::kEmergency;
using core::testing::kSecondCan;
using core::testing::robot;

constexpr core::Subject kDistance = 0x44697374616e6365;
constexpr core::Subject kVelocity = 0x56656c6f63697479;
constexpr core::Subject kUnlisted = 0x5600000000000001;
constexpr std::uint16_t kTag = 0x3ffe;
constexpr std::uint16_t kNext = 0x3ffd;

/// The switch has tag kTag on the second bus; those of distance and velocity are dealt.
core::System machine(bool switch_is_dealt = false) {
  core::System system = robot(0);
  for (const core::Subject subject : {kDistance, kVelocity}) {
    core::EventChannel channel = system.channels[0];
    channel.subject = subject;
    channel.name = subject == kDistance ? "distance" : "velocity";
    system.channels.push_back(channel);
    core::Binding b = system.networks[kSecondCan].bindings.at(0);
    b.channel = system.channels.size() - 1;
    b.dynamic = true;
    b.id = 0;
    system.networks[kSecondCan].bindings.push_back(b);
  }
  core::Binding& stated = system.networks[kSecondCan].bindings[0];
  stated.dynamic = switch_is_dealt;
  stated.id = switch_is_dealt ? 0 : kTag;
  return system;
}

class TagClaims : public ::testing::Test {
 protected:
  TagClaims() { describe(machine()); }
  void describe(const core::System& system) {
    tags_.describe(system, kBridge);
    tags_.hold_apart();
  }
  Tag& of(core::Subject subject) { return *tags_.find(kSecondCan, subject); }
  /// The broker deals it, and the gate has received that.
  void deal(core::Subject subject, std::uint16_t tag) {
    of(subject).dealt = tag != of(subject).etag ? tag : std::uint16_t{0};
    tags_.hold_apart();
    give();
  }
  /// What is due is given, as the gateway does.
  void give() {
    for (Tag& tag : tags_.all()) {
      if (!tag.dynamic || tag.due() == tag.etag) continue;
      tag.etag = tag.due();
      if (tag.etag != 0) tag.dealt = 0;
    }
  }
  [[nodiscard]] std::size_t refused() const { return tags_.contradicted(kSecondCan).size(); }

  Tags tags_;
};

TEST_F(TagClaims, ATagWithoutAnotherClaimIsGiven) {
  deal(kDistance, kNext);
  EXPECT_EQ(of(kDistance).etag, kNext);
  EXPECT_EQ(refused(), 0U);
}

/// The description says 0x3ffe is the switch's, the broker says it is distance's: neither has it.
TEST_F(TagClaims, ATagThatIsStatedForAnotherIsGivenToNone) {
  deal(kDistance, kTag);
  EXPECT_EQ(of(kDistance).etag, 0);
  EXPECT_EQ(of(kDistance).problem(),
            "the broker has dealt it tag 0x3ffe on second-can, which is that of emergency-switch");
  EXPECT_EQ(of(kEmergency).problem(),
            "the broker has dealt its tag 0x3ffe on second-can to 0x44697374616e6365 (Distance)");
  EXPECT_EQ(refused(), 2U);
  deal(kDistance, kNext);
  EXPECT_EQ(of(kDistance).etag, kNext);
  EXPECT_EQ(refused(), 0U) << "the other one is not claimed any more";
}

TEST_F(TagClaims, OfTwoThatAreDealtOneTagTheLaterOneWaitsForTheOthersNext) {
  deal(kDistance, kNext);
  of(kDistance).contradiction = "the broker has dealt its tag to another";
  deal(kVelocity, kNext);
  EXPECT_EQ(of(kDistance).etag, kNext) << "closed, and not forgotten";
  EXPECT_EQ(of(kVelocity).etag, 0);
  EXPECT_EQ(refused(), 2U);
  of(kDistance).contradiction.clear();
  deal(kDistance, 0x3ffc);
  EXPECT_EQ(of(kDistance).etag, 0x3ffc);
  EXPECT_EQ(of(kVelocity).etag, kNext);
  EXPECT_EQ(refused(), 0U);
}

TEST_F(TagClaims, TwoThatAreDealtEachOthersTagsExchangeThem) {
  deal(kDistance, kNext);
  deal(kVelocity, 0x3ffc);
  of(kDistance).dealt = 0x3ffc;
  of(kVelocity).dealt = kNext;
  tags_.hold_apart();
  give();
  EXPECT_EQ(of(kDistance).etag, 0x3ffc);
  EXPECT_EQ(of(kVelocity).etag, kNext);
  EXPECT_EQ(refused(), 0U);
}

TEST_F(TagClaims, TwoThatAreDealtAtOnceGetNothing) {
  of(kDistance).dealt = of(kVelocity).dealt = kNext;
  tags_.hold_apart();
  give();
  EXPECT_EQ(of(kDistance).etag, 0);
  EXPECT_EQ(of(kVelocity).etag, 0);
  EXPECT_EQ(refused(), 2U);
}

TEST_F(TagClaims, SubscriptionsClaimTheirTagToo) {
  deal(core::kSubscribeSubject, 0x3fff);
  EXPECT_EQ(of(core::kSubscribeSubject).etag, 0x3fff);
  deal(kDistance, 0x3fff);
  EXPECT_EQ(of(kDistance).etag, 0);
  EXPECT_EQ(of(kDistance).problem(),
            "the broker has dealt it tag 0x3fff on second-can, which is that of SUBSCRIB");
  deal(core::kSubscribeSubject, kTag);
  EXPECT_EQ(of(core::kSubscribeSubject).etag, 0) << "that is the switch's";
  EXPECT_EQ(of(kDistance).etag, 0x3fff);
}

/// Of what is learned a reload knows; what it states then goes against it.
TEST_F(TagClaims, AReloadThatStatesATagThatWasDealtToAnotherOpensNeither) {
  describe(machine(true));
  deal(kDistance, kTag);
  EXPECT_EQ(of(kDistance).etag, kTag);
  describe(machine());
  give();
  EXPECT_EQ(of(kDistance).etag, 0);
  EXPECT_EQ(of(kDistance).dealt, kTag);
  EXPECT_EQ(refused(), 2U);
  describe(machine());
  EXPECT_EQ(refused(), 2U) << "and stays so over the next one";
}

TEST_F(TagClaims, WhatIsAdmittedWithoutBeingDescribedIsHeldAgainstTheBrokerAndTheOthers) {
  core::System system = machine();
  system.networks[kSecondCan].unlisted.allowed = true;
  core::State state(system);
  ASSERT_TRUE(
      state.list({.subject = kUnlisted, .networks = {}, .bindings = {{kSecondCan, kNext}}}));
  describe(state.system());
  const auto stated = tags_.stated(kSecondCan);
  const auto own = std::ranges::find(stated, kUnlisted, &gates::StatedBinding::subject);
  ASSERT_NE(own, stated.end());
  EXPECT_EQ(own->etag, kNext);
  deal(kDistance, kNext);
  EXPECT_EQ(of(kDistance).etag, 0);
  EXPECT_EQ(refused(), 2U);
  // No subject was admitted: the next query finds it gone.
  EXPECT_TRUE(state.unlist_unused());
  EXPECT_FALSE(state.unlist_unused());
  describe(state.system());
  give();
  EXPECT_EQ(of(kDistance).etag, kNext);
  EXPECT_EQ(refused(), 0U);
}

TEST_F(TagClaims, ATagThatWasLearnedIsForNoOtherSubject) {
  core::System system = machine();
  system.networks[kSecondCan].unlisted.allowed = true;
  core::State state(system);
  state.set_tag(kSecondCan, 1, kNext);
  const auto listed =
      state.list({.subject = kUnlisted, .networks = {}, .bindings = {{kSecondCan, kNext}}});
  ASSERT_FALSE(listed);
  EXPECT_EQ(listed.error().text,
            "identifier 0x3ffd on second-can is channel distance's: choose another");
}

/// The gate that has received the broker's replies is gone, with its interface or by a reboot.
TEST_F(TagClaims, WhatWasClosedStaysClosedForADaemonThatFindsNoGate) {
  of(kEmergency).contradiction = "the broker has dealt its tag to another";
  store::Contents kept;
  for (const store::Contradicted& entry : tags_.to_keep()) kept.apply(entry);
  ASSERT_EQ(kept.contradicted.size(), 1U);

  tags_ = Tags();
  describe(machine());
  EXPECT_EQ(refused(), 0U);
  const auto closed = tags_.recall(kept);
  ASSERT_EQ(closed.size(), 1U);
  EXPECT_EQ(closed[0]->subject, kEmergency);
  EXPECT_EQ(of(kEmergency).problem(), "the broker has dealt its tag to another");
  EXPECT_EQ(refused(), 1U);
  const auto stated = tags_.stated(kSecondCan);
  EXPECT_TRUE(std::ranges::find(stated, kEmergency, &gates::StatedBinding::subject)->contradicted);
}

/// Whom the tag was dealt to is not known then: that it was dealt to some subject is.
TEST_F(TagClaims, ATagThatIsStatedForAnotherStaysClosedForADaemonThatFindsNoGate) {
  deal(kDistance, kTag);
  store::Contents kept;
  for (const store::Contradicted& entry : tags_.to_keep()) kept.apply(entry);
  tags_ = Tags();
  describe(machine());
  tags_.recall(kept);
  EXPECT_EQ(of(kEmergency).problem(),
            "the broker has dealt its tag 0x3ffe on second-can to 0x44697374616e6365 (Distance)");
}

TEST_F(TagClaims, WhatWasKeptCountsForTheSameTagAndWhereNoGateKnowsBetter) {
  store::Contents kept;
  kept.apply(store::Contradicted{"second-can", kEmergency, kNext, "dealt to another"});
  kept.apply(store::Contradicted{"another-can", kEmergency, kTag, "dealt to another"});
  kept.apply(store::Contradicted{"second-can", kDistance, 0, "dealt to another"});
  EXPECT_TRUE(tags_.recall(kept).empty());
  kept.apply(store::Contradicted{"second-can", kEmergency, kTag, "dealt to another"});
  of(kEmergency).is_confirmed = true;
  EXPECT_TRUE(tags_.recall(kept).empty());
  describe(machine());
  EXPECT_EQ(tags_.recall(kept).size(), 1U);
}

/// A gate of a new interface has received nothing itself.
TEST_F(TagClaims, WhatIsKnownIsGivenToAGateThatHasNotReceivedIt) {
  deal(kDistance, kNext);
  deal(kVelocity, kTag);
  of(kEmergency).contradiction = "the broker has dealt its tag to another";
  for (const gates::StatedBinding& b : tags_.stated(kSecondCan)) {
    EXPECT_EQ(b.contradicted, b.subject == kEmergency);
    EXPECT_EQ(b.dealt, b.subject == kDistance ? kNext : b.subject == kVelocity ? kTag : 0);
    EXPECT_EQ(b.etag, b.subject == kDistance ? kNext : b.subject == kEmergency ? kTag : 0);
  }
}

TEST_F(TagClaims, WhatNoGateHasRoomForIsRefused) {
  core::System system = machine();
  auto& bindings = system.networks[kSecondCan].bindings;
  core::Binding b = bindings[0];
  while (bindings.size() < GATE_BINDINGS) {
    system.channels.push_back(system.channels[0]);
    system.channels.back().subject = 0x100 + bindings.size();
    b.channel = system.channels.size() - 1;
    b.id = static_cast<std::uint32_t>(0x64 + bindings.size());
    bindings.push_back(b);
  }
  describe(system);
  const auto stated = tags_.stated(kSecondCan);
  EXPECT_EQ(stated.size(), static_cast<std::size_t>(GATE_BINDINGS));
  const auto refused = tags_.contradicted(kSecondCan);
  ASSERT_EQ(refused.size(), 1U) << "SUBSCRIB has one, too";
  EXPECT_EQ(refused[0].how, "no gate holds more than 4096 tags of second-can against the broker");
  const core::Subject subject = system.channels[refused[0].channel].subject;
  EXPECT_EQ(std::ranges::find(stated, subject, &gates::StatedBinding::subject), stated.end());
}

}  // namespace
}  // namespace mlcca
