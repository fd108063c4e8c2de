// SPDX-License-Identifier: BSD-2-Clause
// Tests of complete daemons on benches that share a bus by a store: which requests are granted, and
// what happens to them when the store, a gateway or the disk fails.
#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

class MembershipTest : public MembershipBench {
 protected:
  std::string phase(std::size_t g) {
    const auto body = at(g).ask(control::ClusterRequest{}).reply.body;
    const auto* const cluster = std::get_if<control::Cluster>(&body);
    return cluster == nullptr ? "no answer" : cluster->phase;
  }
  /// A backup is restored, and others write to it: soon its revision is as late as before.
  void go_back() {
    const FakeStore backup = store;
    pass(10 * kSecondNs);
    const std::int64_t newest = store.revision;
    for (auto& node : nodes) node->link.up = false;
    run();
    store = backup;
    for (auto& node : nodes) node->link.up = true;
    for (auto& node : nodes) node->link.deliver();
    while (store.revision < newest + 100)
      store.write({{.key = "/mlcca/pair/v/shared", .value = ""}});
  }
};

TEST_F(MembershipTest, BeforeTheStoreIsKnownNothingSharedIsGrantedAndLocalIs) {
  link(0).up = false;
  start(0);
  run();
  EXPECT_FALSE(granted(0, 0));
  EXPECT_TRUE(granted(0, 1)) << "it stays on one gateway";
  EXPECT_NE(asked(0, wanted("c2", "own0", "shared")).find("the store does not answer"),
            std::string::npos);
  EXPECT_EQ(at(0).kernel.until, 0U);
}

TEST_F(MembershipTest, TheFirstDescriptionComesIntoForceWhenAllAreThere) {
  start(0);
  pass(5 * kSecondNs);
  EXPECT_FALSE(granted(0, 0)) << "g1 is not there";
  start(1);
  pass(40 * kSecondNs);
  EXPECT_TRUE(granted(0, 0));
  EXPECT_TRUE(passes(0, 0));
  EXPECT_EQ(entries("r/"), 0U) << "what is described needs no reservation";
}

TEST_F(MembershipTest, AnAdmissionIsAnsweredWhenTheStoreHasDecided) {
  start_both();
  link(0).answers = false;
  auto answer = at(0).ask(wanted("c2", "own0", "shared"));
  run();
  EXPECT_EQ(text_of(answer), "nothing yet");
  EXPECT_FALSE(passes(0, 2));
  EXPECT_EQ(asked(0, wanted("c3", "own0", "own0")), "granted") << "others go on";
  link(0).answers = true;
  run();
  EXPECT_EQ(text_of(answer), "granted");
  EXPECT_EQ(nodes[0]->ready, std::vector<std::uint64_t>{1});
  EXPECT_TRUE(passes(0, 2));
  EXPECT_EQ(entries("r/shared/g0/"), 1U);
  EXPECT_FALSE(at(1).state().world().foreign[kSharedBus].bus.empty());
  EXPECT_GT(at(0).kernel.until, at(0).clock.monotonic);
}

TEST_F(MembershipTest, WhatIsReleasedLeavesTheStoreASecondLater) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  at(0).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "c2own0"});
  run();
  EXPECT_FALSE(passes(0, 2));
  EXPECT_EQ(entries("r/"), 1U) << "frames may wait in a queue";
  EXPECT_EQ(at(0).kernel.until, 0U) << "nothing leased is open";
  pass(2 * kSecondNs);
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_EQ(entries("x/"), 0U);
}

TEST_F(MembershipTest, OfTwoThatDoNotFitTogetherOneIsRefused) {
  start_both();
  auto much = wanted("c2", "own0", "shared");
  auto more = wanted("c3", "own1", "shared");
  // With frames of 1.08 ms the three together need more than the bus has.
  auto before = wanted("c4", "own1", "shared");
  before.offered = much.offered = {attribute_of("Period", 3'300'000)};
  more.offered = {attribute_of("Period", 2'200'000)};
  ASSERT_EQ(asked(1, before), "granted");
  auto first = at(0).ask(much);
  auto second = at(1).ask(more);
  run();
  pass(kStepNs);  // the gateway that came second waits for a moment
  const std::string one = text_of(first);
  const std::string other = text_of(second);
  EXPECT_TRUE((one == "granted") != (other == "granted")) << one << " / " << other;
  EXPECT_NE((one + other).find("shared"), std::string::npos) << one << " / " << other;
  EXPECT_EQ(entries("r/"), 2U);
}

TEST_F(MembershipTest, WithoutTheStoreWhatIsLeasedClosesBeforeTheLeaseEnds) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  const std::uint64_t last = at(0).kernel.until;
  link(0).up = false;
  pass(5 * kSecondNs);
  EXPECT_TRUE(passes(0, 2)) << "it stays for as long as the lease lives";
  EXPECT_NE(asked(0, wanted("c3", "own0", "shared")), "granted");
  while (at(0).clock.monotonic < last) {
    pass(kStepNs);
    if (at(0).clock.monotonic >= last) break;
  }
  EXPECT_FALSE(passes(0, 2));
  EXPECT_TRUE(passes(0, 0)) << "it is described";
  EXPECT_EQ(at(0).kernel.lapses, 0U) << "closed by the daemon, in time";
  link(0).up = true;
  pass(5 * kSecondNs);
  EXPECT_TRUE(passes(0, 2)) << "nobody has fenced it";
}

TEST_F(MembershipTest, ADaemonThatStandsStillIsClosedByTheKernelAndItsShareIsGivenAway) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  // Only the other gateway continues.
  std::unique_ptr<Node> stopped = std::move(nodes[0]);
  nodes.erase(nodes.begin());
  const std::uint64_t until = stopped->bench.kernel.until;
  for (int n = 0; n < 300; ++n) {
    stopped->bench.clock.monotonic += kStepNs;
    stopped->bench.kernel.advance_to(stopped->bench.clock.monotonic);
    pass(kStepNs);
    const bool counted = !nodes[0]->bench.state().world().foreign[kSharedBus].bus.empty();
    EXPECT_TRUE(counted || !stopped->bench.kernel.passes()) << n;
  }
  EXPECT_GE(stopped->bench.clock.monotonic, until);
  EXPECT_TRUE(nodes[0]->bench.state().world().foreign[kSharedBus].bus.empty());
  // The stopped gateway continues: it is fenced, and joins again.
  nodes.insert(nodes.begin(), std::move(stopped));
  at(0).daemon().beat();
  EXPECT_EQ(at(0).events.back(), "lapsed");
  const auto status = at(0).ask(control::StatusRequest{});
  EXPECT_NE(
      std::get<control::Status>(status.reply.body)
          .health.reasons.at(0)
          .find("because the lease of this gateway ended before the store had confirmed a beat"),
      std::string::npos);
  EXPECT_FALSE(passes(0, 2));
  pass(5 * kSecondNs);
  EXPECT_TRUE(passes(0, 0));
  EXPECT_TRUE(passes(0, 2)) << "it has asked again";
  EXPECT_FALSE(at(1).state().world().foreign[kSharedBus].bus.empty());
}

TEST_F(MembershipTest, AStopGivesBackWhatWasReserved) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  EXPECT_FALSE(at(0).daemon().begin_stop());
  run();
  EXPECT_FALSE(passes(0, 2));
  EXPECT_FALSE(passes(0, 0));
  pass(3 * kSecondNs);
  EXPECT_TRUE(at(0).daemon().may_stop());
  at(0).daemon().stop();
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_EQ(entries("x/"), 0U);
  EXPECT_FALSE(store.entries.contains("/mlcca/pair/m/g0"));
  // The next start makes the request again.
  start(0);
  pass(5 * kSecondNs);
  EXPECT_TRUE(passes(0, 2));
}

TEST_F(MembershipTest, ADaemonThatWasKilledTakesUpWhereItWas) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  at(0).end();
  start(0);
  EXPECT_TRUE(passes(0, 2)) << "with the start itself";
  run();
  EXPECT_EQ(entries("r/shared/g0/"), 1U);
  pass(15 * kSecondNs);
  EXPECT_TRUE(passes(0, 2));
  EXPECT_EQ(entries("r/shared/g0/"), 1U);
}

/// Each member of the store that is tried fails for a reason of its own.
TEST_F(MembershipTest, TheLossOfTheStoreIsReportedOnceAndSoIsItsReturn) {
  start_both();
  at(0).published.clear();
  const auto reports = [&](const std::string& words) {
    return std::ranges::count_if(at(0).published, [&](const control::Event& event) {
      return event.message.find(words) != std::string::npos;
    });
  };
  link(0).up = false;
  for (int n = 0; n < 30; ++n) {
    link(0).problem = "https://10.0.0." + std::to_string(n) + ": refused";
    pass(kSecondNs / 2);
  }
  EXPECT_EQ(reports("the store does not answer: https://10.0.0.0: refused"), 1);
  EXPECT_EQ(reports("the store does not answer"), 1);
  link(0).up = true;
  pass(5 * kSecondNs);
  EXPECT_EQ(reports("this gateway takes part"), 1);
  // It comes and goes.
  for (int n = 0; n < 40; ++n) {
    link(0).up = n % 2 == 1;
    pass(kStepNs);
  }
  EXPECT_LE(reports("the store does not answer"), 2);
}

/// Nothing in the store shows it any more when the daemon starts again.
TEST_F(MembershipTest, AStoreThatHasGoneBackStaysSoOverARestartAndADrain) {
  start_both();
  go_back();
  run();
  ASSERT_EQ(phase(0), "gone-back");

  at(0).end();
  start(0);
  pass(15 * kSecondNs);
  EXPECT_EQ(phase(0), "gone-back");
  EXPECT_FALSE(passes(0, 0));
  static_cast<void>(at(1).ask(control::DrainRequest{}));
  pass(10 * kSecondNs);
  static_cast<void>(at(1).ask(control::JoinRequest{}));
  pass(15 * kSecondNs);
  EXPECT_EQ(phase(1), "gone-back");

  store.write({{.key = "/mlcca/pair/e", .value = std::string(16, 'n')}});
  pass(30 * kSecondNs);
  for (std::size_t g = 0; g < 2; ++g) EXPECT_EQ(phase(g), "in") << g;
  EXPECT_TRUE(passes(0, 0));
}

TEST_F(MembershipTest, ThatTheStoreHasGoneBackIsOnDiskBeforeTheKernelHasClosed) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  go_back();
  at(0).kernel.calls.refuse(1, 1000);
  run();
  ASSERT_EQ(phase(0), "gone-back");
  at(0).end();
  at(0).kernel.calls.relent();
  start(0);
  pass(15 * kSecondNs);
  EXPECT_EQ(phase(0), "gone-back");
  EXPECT_FALSE(passes(0, 2));
}

TEST_F(MembershipTest, WithoutTheStoreADaemonThatStartsOpensNothingShared) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  at(0).end();
  link(0).up = false;
  start(0);
  EXPECT_FALSE(passes(0, 2));
  EXPECT_FALSE(passes(0, 0));
  EXPECT_TRUE(granted(0, 1));
  link(0).up = true;
  pass(3 * kSecondNs);
  EXPECT_TRUE(passes(0, 0));
  EXPECT_TRUE(passes(0, 2));
}

TEST_F(MembershipTest, AClientThatHangsUpLeavesNothingBehind) {
  start_both();
  auto request = wanted("c2", "own0", "shared");
  request.hold = true;
  link(0).answers = false;
  auto answer = at(0).ask(request, member(7));
  run();
  at(0).daemon().session_closed(7);
  link(0).answers = true;
  pass(3 * kSecondNs);
  EXPECT_FALSE(granted(0, 2));
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_TRUE(at(0).state().admissions().empty());
}

TEST_F(MembershipTest, AHeldAdmissionIsOwnedByItsConnection) {
  start_both();
  auto request = wanted("c2", "own0", "shared");
  request.hold = true;
  auto answer = at(0).ask(request, member(7));
  run();
  const auto slice = answer.slices();
  ASSERT_TRUE(slice);
  EXPECT_NE(slice->owned, 0U);
}

TEST_F(MembershipTest, WhatTheDiskRefusesIsGivenBack) {
  start_both();
  link(0).answers = false;
  auto answer = at(0).ask(wanted("c2", "own0", "shared"));
  run();
  at(0).disk().trouble(store::test::Trouble::fail, 1, ENOSPC, 100);
  link(0).answers = true;
  run();
  EXPECT_NE(text_of(answer), "granted");
  at(0).disk().trouble(store::test::Trouble::fail, 1, 0, 0);
  pass(3 * kSecondNs);
  EXPECT_FALSE(granted(0, 2));
  EXPECT_EQ(entries("r/"), 0U);
}

TEST_F(MembershipTest, WithAnotherDescriptionNothingSharedIsGranted) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  at(0).digest = 2;
  at(0).daemon().reload();
  at(0).reading().finish();
  pass(3 * kSecondNs);
  EXPECT_FALSE(passes(0, 0));
  EXPECT_FALSE(passes(0, 2));
  EXPECT_TRUE(granted(0, 1));
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_NE(asked(0, wanted("c3", "own0", "shared")).find("another"), std::string::npos);
  at(0).digest = 1;
  at(0).daemon().reload();
  at(0).reading().finish();
  pass(5 * kSecondNs);
  EXPECT_TRUE(passes(0, 0));
  EXPECT_TRUE(passes(0, 2));
}

TEST_F(MembershipTest, AReloadOfTheSameDescriptionInterruptsNothing) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  at(0).daemon().reload();
  at(0).reading().finish();
  EXPECT_TRUE(passes(0, 0));
  EXPECT_TRUE(passes(0, 2));
  run();
  EXPECT_EQ(entries("r/shared/g0/"), 1U);
}

TEST_F(MembershipTest, WhoIsDecidedAtAReloadIsToldWhatHappenedAndWhatToDo) {
  start_both();
  link(0).answers = false;
  auto answer = at(0).ask(wanted("c2", "own0", "shared"));
  run();
  at(0).digest = 2;
  at(0).daemon().reload();
  at(0).reading().finish();
  run();
  EXPECT_EQ(
      text_of(answer),
      "nothing was changed: this gateway has loaded a description meanwhile, by a reload or a "
      "rollout: ask again");
}

TEST_F(MembershipTest, WhoIsDecidedAtADrainIsToldSo) {
  start_both();
  link(0).answers = false;
  auto answer = at(0).ask(wanted("c2", "own0", "shared"));
  run();
  at(0).ask(control::DrainRequest{});
  run();
  EXPECT_EQ(text_of(answer), "nothing was changed: this gateway is being drained");
}

TEST_F(MembershipTest, AnAdmissionOverTwoGatewaysIsOneDecision) {
  start_both();
  EXPECT_EQ(asked(0, wanted("c2", "own0", "own1")), "granted");
  EXPECT_TRUE(granted(0, 2));
  EXPECT_TRUE(granted(1, 2)) << "it carries it on";
  EXPECT_EQ(at(1).state().admissions().size(), 1U);
  at(0).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "c2own0"});
  run();
  EXPECT_FALSE(granted(1, 2));
  pass(3 * kSecondNs);
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_EQ(entries("a/"), 0U);
}

TEST_F(MembershipTest, TheGatewayThatRefusesIsNamed) {
  start_both();
  auto local = wanted("c3", "own1", "own1");
  ASSERT_EQ(asked(1, wanted("c4", "shared", "own1")), "granted");
  at(1).kernel.unplug("own1");
  at(1).daemon().links_changed();
  run();
  const std::string why = asked(0, wanted("c2", "own0", "own1"));
  EXPECT_NE(why.find("g1: "), std::string::npos) << why;
  pass(3 * kSecondNs);
  EXPECT_FALSE(granted(0, 2));
  EXPECT_EQ(entries("r/shared/g0/"), 0U);
}

TEST_F(MembershipTest, ADaemonWithoutAClusterForgetsUntilWhenGatesMayBeOpen) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  ASSERT_NE(at(0).kernel.until, 0U);
  at(0).end();
  at(0).cluster = nullptr;
  start(0);
  EXPECT_EQ(at(0).kernel.until, 0U);
  EXPECT_TRUE(passes(0, 0));
}

}  // namespace
}  // namespace mlcca::test
