// SPDX-License-Identifier: BSD-2-Clause
// What an operator sees of a cluster, and does with the part that a gateway takes in it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <variant>
#include <vector>

#include "daemon/cluster/record_codec.hpp"
#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

class MembersOperated : public MembershipBench {
 protected:
  template <class Answer>
  Answer said(std::size_t g, decltype(control::Request::body) body) {
    auto answer = at(g).ask(std::move(body));
    const auto* found = std::get_if<Answer>(&answer.reply.body);
    EXPECT_NE(found, nullptr) << error_in(answer);
    return found != nullptr ? *found : Answer{};
  }
  control::Cluster cluster(std::size_t g) {
    return said<control::Cluster>(g, control::ClusterRequest{});
  }
  control::ClusterMember member_of(std::size_t g, std::size_t whom) {
    auto all = said<control::ClusterMembers>(g, control::ClusterRequest{.part = "members"});
    return whom < all.members.size() ? all.members[whom] : control::ClusterMember{};
  }
  std::vector<control::ClusterReservation> reserved(std::size_t g, const std::string& network = {},
                                                    const std::string& gateway = {}) {
    return said<control::ClusterReservations>(g, control::ClusterRequest{.part = "reservations",
                                                                         .network = network,
                                                                         .gateway = gateway})
        .reservations;
  }
  static std::string error_in(const serve::Answer& answer) {
    const auto* error = std::get_if<control::Error>(&answer.reply.body);
    return error != nullptr ? error->message : "no error";
  }
  std::string refusal(std::size_t g, decltype(control::Request::body) body,
                      const serve::Peer& peer = member()) {
    return error_in(at(g).ask(std::move(body), peer));
  }
  std::string done(std::size_t g, decltype(control::Request::body) body) {
    return said<control::Done>(g, std::move(body)).message;
  }
  bool is_reason(std::size_t g, const std::string& words) {
    const auto health = said<control::Status>(g, control::StatusRequest{}).health;
    return std::ranges::any_of(health.reasons,
                               [&](const auto& reason) { return reason.contains(words); });
  }
};

TEST_F(MembersOperated, AMemberSaysHowItStands) {
  start_both();
  const auto all = cluster(0);
  EXPECT_EQ(all.gateway, "g0");
  EXPECT_EQ(all.system, "pair");
  EXPECT_EQ(all.phase, "in");
  EXPECT_EQ(all.why, "");
  EXPECT_EQ(all.shared, "open");
  EXPECT_EQ(all.networks, std::vector<std::string>{"shared"});
  EXPECT_EQ(all.health.state, control::HealthState::healthy);
  EXPECT_NE(all.incarnation, 0U);
  EXPECT_EQ(all.lease_ns, kLease);
  EXPECT_GT(all.lasts_ns, 0U);
  EXPECT_LE(all.lasts_ns, kLease);
  EXPECT_EQ(all.generation, 1U);
  EXPECT_EQ(all.digest, all.own_digest);
  EXPECT_EQ(all.digest.size(), 64U);
  EXPECT_TRUE(all.in_force);
  EXPECT_TRUE(all.store_up);
  EXPECT_GE(all.store_for_ns, 4 * kSecondNs);
  EXPECT_EQ(all.gateways, 2U);
  EXPECT_EQ(all.present, 2U);
}

TEST_F(MembersOperated, BeforeAllAreThereNoDescriptionIsInForce) {
  start(0);
  pass(4 * kSecondNs);
  const auto all = cluster(0);
  EXPECT_EQ(all.phase, "description-pending");
  EXPECT_EQ(all.shared, "closed");
  EXPECT_EQ(all.generation, 0U);
  EXPECT_FALSE(member_of(0, 0).other);
  EXPECT_EQ(member_of(0, 1).state, "absent");
  EXPECT_EQ(member_of(0, 1).lasts_ns, 0U);
}

TEST_F(MembersOperated, MembersAndReservationsAreThoseOfAll) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  ASSERT_EQ(asked(1, wanted("c3", "own1", "shared")), "granted");
  const auto own = member_of(0, 0);
  EXPECT_TRUE(own.own);
  EXPECT_EQ(own.state, "active");
  EXPECT_FALSE(own.other);
  EXPECT_EQ(own.lease_ns, kLease);
  EXPECT_EQ(own.carries, (std::vector<std::string>{"c0", "c2"}));
  ASSERT_EQ(own.shares.size(), 1U);
  EXPECT_EQ(own.shares[0].network, "shared");
  EXPECT_EQ(own.shares[0].reservations, 1U);
  const auto other = member_of(0, 1);
  EXPECT_FALSE(other.own);
  EXPECT_EQ(other.state, "active");
  EXPECT_EQ(other.shares.size(), 1U);
  EXPECT_GT(other.lasts_ns, 0U);
  pass(kSecondNs);
  EXPECT_LE(member_of(0, 1).beat_age_ns, kLease / 4);

  const auto all = reserved(0);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].gateway, "g0");
  EXPECT_EQ(all[0].network, "shared");
  EXPECT_EQ(all[0].channel, "c2");
  EXPECT_EQ(all[0].state, "granted");
  EXPECT_EQ(all[0].messages, 1U);
  EXPECT_GT(all[0].bytes_per_second, 0U);
  ASSERT_EQ(reserved(0, {}, "g1").size(), 1U);
  EXPECT_EQ(reserved(0, {}, "g1")[0].channel, "c3");
  EXPECT_EQ(reserved(1).size(), 2U);
  EXPECT_TRUE(reserved(0, "own0").empty());
  const auto wrong = [](const std::string& network, const std::string& gateway) {
    return control::ClusterRequest{.part = "reservations", .network = network, .gateway = gateway};
  };
  EXPECT_EQ(refusal(0, wrong("nowhere", "")), "there is no network 'nowhere'");
  EXPECT_EQ(refusal(0, wrong("", "g9")), "there is no gateway 'g9'");
  EXPECT_NE(refusal(0, control::ClusterRequest{.part = "leaders"}), "no error");
}

TEST_F(MembersOperated, WhatARemovedGatewayHasLeftIsNamedWithWhatDeletesIt) {
  const std::string prefix = "/mlcca/pair/";
  const cluster::RecordCodec codec(two_gateways(), Sha256::Digest{1});
  store.write({{.key = prefix + "m/g7", .value = codec.write(core::cluster::Beat{.lease = kLease})},
               {.key = prefix + "r/shared/g7/4", .value = "?"},
               {.key = prefix + "r/shared/g7/5", .value = "?"},
               {.key = prefix + "r/g7/g7/5", .value = "?"},
               {.key = prefix + "x/g7/4", .value = "?"}});
  store.forbidden = {prefix + "m/g7", prefix + "r/shared/g7/", prefix + "r/g7/g7/",
                     prefix + "x/g7/"};
  start_both();
  auto left = member_of(0, 2);
  EXPECT_EQ(left.name, "g7");
  EXPECT_EQ(left.state, "removed");
  EXPECT_EQ(left.entries, 5U);
  EXPECT_EQ(left.removal, "") << "it may still send";
  EXPECT_NE(asked(0, wanted("c3", "own0", "shared")), "granted");
  store.write({{.key = prefix + "f/g7", .value = "g0"}});
  pass(15 * kSecondNs);
  left = member_of(0, 2);
  EXPECT_EQ(left.entries, 6U);
  EXPECT_EQ(left.removal,
            "etcdctl del --prefix /mlcca/pair/r/g7/g7/ && "
            "etcdctl del --prefix /mlcca/pair/r/shared/g7/ && "
            "etcdctl del --prefix /mlcca/pair/x/g7/ && "
            "etcdctl del /mlcca/pair/m/g7 && etcdctl del /mlcca/pair/f/g7");
  EXPECT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  store.forbidden.clear();
  pass(130 * kSecondNs);
  EXPECT_EQ(member_of(0, 2).name, "");
}

TEST_F(MembersOperated, WhatOthersMustAgreeToIsPending) {
  start_both();
  link(1).answers = false;
  auto answer = at(0).ask(wanted("c2", "own0", "own1"));
  run();
  ASSERT_EQ(reserved(0).size(), 1U);
  EXPECT_EQ(reserved(0)[0].state, "pending");
  EXPECT_EQ(reserved(0)[0].through, std::vector<std::string>{"g1"});
  link(1).answers = true;
  run();
  EXPECT_EQ(text_of(answer), "granted");
  EXPECT_EQ(reserved(1)[0].state, "granted");
  at(0).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = "c2own0"});
  run();
  EXPECT_EQ(reserved(0)[0].state, "ending");
}

TEST_F(MembersOperated, WithoutTheStoreItSaysForHowLongAndWhatCloses) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  EXPECT_FALSE(is_reason(0, "cluster"));
  link(0).up = false;
  pass(2 * kSecondNs);
  auto all = cluster(0);
  EXPECT_FALSE(all.store_up);
  EXPECT_GE(all.store_for_ns, kSecondNs);
  EXPECT_EQ(all.store_problem, "it is gone");
  EXPECT_EQ(all.shared, "open");
  EXPECT_EQ(all.health.state, control::HealthState::degraded);
  EXPECT_TRUE(is_reason(0, "cluster pair: nothing new is granted on networks of several gateways"));
  pass(kLease);
  all = cluster(0);
  EXPECT_EQ(all.phase, "silent");
  EXPECT_EQ(all.shared, "described");
  EXPECT_EQ(all.lasts_ns, 0U);
  EXPECT_TRUE(is_reason(0, "what is reserved on networks of several gateways is closed"));
  EXPECT_EQ(member_of(0, 1).state, "silent") << "as far as this one knows";
  pass(2 * kSecondNs);
  EXPECT_EQ(member_of(1, 0).state, "fenced");
  EXPECT_EQ(member_of(1, 1).state, "active");
}

TEST_F(MembersOperated, AnotherDescriptionClosesWhatIsShared) {
  start_both();
  at(0).digest = 2;
  at(0).daemon().reload();
  at(0).reading().finish();
  pass(3 * kSecondNs);
  const auto all = cluster(0);
  EXPECT_EQ(all.phase, "other-description");
  EXPECT_EQ(all.shared, "closed");
  EXPECT_EQ(all.health.state, control::HealthState::closed);
  EXPECT_NE(all.digest, all.own_digest);
  EXPECT_TRUE(member_of(1, 0).other);
  EXPECT_FALSE(member_of(1, 1).other);
}

TEST_F(MembersOperated, WhatCannotBeReadIsAReason) {
  start_both();
  store.write({{.key = "/mlcca/pair/r/shared/g1/7", .value = "not understood"}});
  run();
  EXPECT_EQ(cluster(0).unreadable, 1U);
  EXPECT_TRUE(is_reason(0, "what the store has of shared cannot be read"));
  ASSERT_EQ(reserved(0).size(), 1U);
  EXPECT_EQ(reserved(0)[0].state, "unreadable");
}

TEST_F(MembersOperated, ADrainedGatewayGivesBackWhatItHasAndStaysOut) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  EXPECT_TRUE(done(0, control::DrainRequest{"g0"}).starts_with("drained: networks that g0 shares"));
  const auto event = std::ranges::find_if(
      at(0).published, [](const auto& e) { return e.message.starts_with("drained: "); });
  ASSERT_NE(event, at(0).published.end());
  EXPECT_EQ(event->kind, "gateway");
  EXPECT_TRUE(event->client.has_value());
  EXPECT_FALSE(passes(0, 0)) << "at once";
  EXPECT_FALSE(passes(0, 2));
  EXPECT_TRUE(granted(0, 1)) << "it stays on one gateway";
  run();
  EXPECT_EQ(cluster(0).phase, "draining");
  EXPECT_EQ(member_of(1, 0).state, "draining");
  pass(3 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "drained");
  EXPECT_EQ(cluster(0).shared, "closed");
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_FALSE(store.entries.contains("/mlcca/pair/m/g0"));
  EXPECT_EQ(member_of(1, 0).state, "absent");
  EXPECT_EQ(member_of(1, 0).lasts_ns, 0U) << "it has said so";
  EXPECT_EQ(cluster(1).present, 1U);
  EXPECT_TRUE(is_reason(0, "this gateway is drained: 'mlccactl cluster join' ends that"));
  EXPECT_NE(asked(0, wanted("c3", "own0", "shared")).find("is drained"), std::string::npos);
  EXPECT_EQ(done(0, control::DrainRequest{}), "g0 is drained already");
  EXPECT_EQ(asked(1, wanted("c4", "own1", "shared")), "granted") << "others go on";
}

TEST_F(MembersOperated, ADrainLastsOverRestartsAndReloadsUntilItJoins) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  done(0, control::DrainRequest{});
  // Killed before it has given anything back.
  at(0).end();
  start(0);
  EXPECT_FALSE(passes(0, 0));
  pass(5 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "drained");
  EXPECT_EQ(entries("r/"), 0U) << "what the former daemon had";
  EXPECT_EQ(entries("x/"), 0U);
  EXPECT_FALSE(store.entries.contains("/mlcca/pair/m/g0"));
  at(0).daemon().reload();
  at(0).reading().finish();
  pass(3 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "drained");
  EXPECT_FALSE(passes(0, 0));
  EXPECT_FALSE(at(0).daemon().begin_stop() && !at(0).daemon().may_stop());
  at(0).daemon().stop();
  at(0).end();
  start(0);
  pass(3 * kSecondNs);
  EXPECT_EQ(done(0, control::JoinRequest{"g0"}), "joins: g0 takes part in the cluster pair again");
  pass(5 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "in");
  EXPECT_TRUE(passes(0, 0));
  EXPECT_TRUE(passes(0, 2)) << "it has asked again";
  EXPECT_EQ(entries("r/shared/g0/"), 1U);
  EXPECT_EQ(done(0, control::JoinRequest{}), "g0 is not drained: nothing was changed");
  EXPECT_FALSE(is_reason(0, "cluster"));
}

/// As the machine is switched off: what has a network no more cannot give anything back.
TEST_F(MembersOperated, ADrainUntilARestartIsOverAfterIt) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  EXPECT_TRUE(done(0, control::DrainRequest{{}, true}).ends_with("until mlccad is started again"));
  pass(3 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "drained");
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_FALSE(store.entries.contains("/mlcca/pair/m/g0"));
  EXPECT_TRUE(is_reason(0, "this gateway is drained until mlccad is started again"));
  EXPECT_EQ(done(0, control::DrainRequest{{}, true}), "g0 is drained already");
  at(0).daemon().reload();
  at(0).reading().finish();
  pass(3 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "drained") << "over a reload it stays";
  at(0).end();
  start(0);
  pass(5 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "in");
  EXPECT_TRUE(passes(0, 2)) << "it has asked again";
  // An operator who drains it means more.
  done(0, control::DrainRequest{{}, true});
  EXPECT_TRUE(done(0, control::DrainRequest{}).ends_with("until 'mlccactl cluster join'"));
  pass(3 * kSecondNs);
  at(0).end();
  start(0);
  pass(5 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "drained");
  EXPECT_EQ(done(0, control::DrainRequest{{}, true}), "g0 is drained already");
}

TEST_F(MembersOperated, ADrainThatIsTakenBackAtOnceLosesNothing) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  done(0, control::DrainRequest{});
  done(0, control::JoinRequest{});
  run();
  pass(5 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "in");
  EXPECT_TRUE(passes(0, 0));
  EXPECT_TRUE(passes(0, 2));
  EXPECT_EQ(entries("r/shared/g0/"), 1U);
}

TEST_F(MembersOperated, WithoutTheStoreADrainClosesAtOnceAndEndsLater) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
  link(0).up = false;
  run();
  done(0, control::DrainRequest{});
  EXPECT_FALSE(passes(0, 0));
  EXPECT_FALSE(passes(0, 2));
  pass(2 * kLease);
  EXPECT_EQ(cluster(0).phase, "draining");
  EXPECT_TRUE(is_reason(0, "being drained, and the store does not answer"));
  EXPECT_TRUE(at(0).daemon().may_stop()) << "a stop does not wait for it";
  link(0).up = true;
  pass(5 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "drained");
  EXPECT_EQ(entries("r/"), 0U);
}

TEST_F(MembersOperated, WhatGoesOverADrainedGatewayEnds) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "own1")), "granted");
  ASSERT_EQ(at(1).state().admissions().size(), 1U);
  done(1, control::DrainRequest{});
  pass(3 * kSecondNs);
  EXPECT_FALSE(granted(0, 2));
  EXPECT_TRUE(at(1).state().admissions().empty());
  EXPECT_EQ(entries("r/"), 0U);
  done(1, control::JoinRequest{});
  pass(10 * kSecondNs);
  EXPECT_TRUE(granted(0, 2)) << "it is asked for again";
  EXPECT_EQ(at(1).state().admissions().size(), 1U);
}

TEST_F(MembersOperated, OnlyTheGatewayItselfIsDrainedAndOnlyByWhoMay) {
  start_both();
  EXPECT_EQ(refusal(0, control::DrainRequest{"g1"}),
            "this is g0, and each gateway alone writes what it takes part in: run 'mlccactl "
            "cluster drain' on g1");
  EXPECT_NE(refusal(0, control::JoinRequest{"g1"}), "no error");
  EXPECT_NE(refusal(0, control::DrainRequest{}, outsider()).find("only root and members"),
            std::string::npos);
  EXPECT_EQ(error_in(at(0).ask(control::ClusterRequest{}, outsider())), "no error");
  pass(kSecondNs);
  EXPECT_EQ(cluster(0).phase, "in");
  EXPECT_EQ(cluster(1).phase, "in");
}

TEST_F(MembersOperated, WhatTheDiskRefusesIsNoDrain) {
  start_both();
  at(0).disk().trouble(store::test::Trouble::fail, 1, ENOSPC, 100);
  EXPECT_NE(refusal(0, control::DrainRequest{}), "no error");
  at(0).disk().trouble(store::test::Trouble::fail, 1, 0, 0);
  pass(2 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "in");
  EXPECT_TRUE(passes(0, 0));
}

TEST_F(MembersOperated, AGatewayInNoClusterSaysSo) {
  at(0).cluster = nullptr;
  start(0);
  const auto all = cluster(0);
  EXPECT_EQ(all.gateway, "g0");
  EXPECT_EQ(all.system, "");
  EXPECT_EQ(all.health.state, control::HealthState::healthy);
  EXPECT_TRUE(reserved(0).empty());
  EXPECT_EQ(refusal(0, control::DrainRequest{}),
            "g0 takes part in no cluster: /etc/mlcca/cluster.conf is not there");
}

}  // namespace
}  // namespace mlcca::test
