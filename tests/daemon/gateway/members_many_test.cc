// SPDX-License-Identifier: BSD-2-Clause
// Tests of gateways that ask others for a lot.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "tests/daemon/gateway/members_forged.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

core::System with_a_third_gateway() {
  core::System system = with_a_described_publisher();
  system.gateways.push_back(system.gateways[1]);
  system.gateways.back().name = "g2";
  return system;
}

/// g0 runs, and g1 and g2 write what they ask for.
class MembersMany : public MembershipBench {
 protected:
  static constexpr std::uint64_t kFirst = 100;
  MembersMany() : MembershipBench(with_a_third_gateway()) {
    nodes.push_back(std::make_unique<Node>(store, 2, with_a_third_gateway()));
  }
  void begin() {
    for (std::size_t g = 0; g < 3; ++g) start(g);
    pass(6 * kSecondNs);
    for (std::size_t g = 1; g < 3; ++g) at(g).end();
  }
  void beat_of(const std::string& gateway) {
    const auto& was = store.entries.at("/mlcca/pair/m/" + gateway);
    auto beat = codec.beat(was.value).value_or(cc::Beat{});
    if (beat.incarnation == 0) beat.incarnation = was.create;
    beat.applied = store.revision;
    store.write({{.key = "/mlcca/pair/m/" + gateway, .value = codec.write(beat)}});
  }
  void ask_g0(const std::string& gateway, std::uint64_t number, std::size_t requests = 1,
              cc::Stage stage = cc::Stage::prepared) {
    cluster::StoredRequest asked{.channel = "c2", .requests = {}};
    for (std::size_t i = 0; i < requests; ++i) {
      control::Admit admit;
      admit.channel = "c2";
      admit.to = "g0";
      admit.subscriber = std::to_string(i);
      asked.requests.push_back({.id = (1000 * number) + i, .body = admit});
    }
    store.write({{.key = "/mlcca/pair/x/" + gateway + "/" + std::to_string(number),
                  .value = codec.write(cc::RouteRequest{
                      .stage = stage, .admission = cluster::text_of(asked), .gateways = {0}})}});
  }
  void ask_g0_for_many(const std::string& gateway, std::uint64_t entries, std::size_t requests,
                       cc::Stage stage = cc::Stage::prepared) {
    for (std::uint64_t n = 0; n < entries; ++n) ask_g0(gateway, kFirst + n, requests, stage);
  }
  static std::string votes_on(const std::string& gateway) { return "a/g0/" + gateway + "/"; }
  [[nodiscard]] std::size_t objections_to(const std::string& gateway,
                                          const std::string& reason) const {
    return static_cast<std::size_t>(std::ranges::count_if(store.entries, [&](const auto& one) {
      if (!one.first.starts_with("/mlcca/pair/" + votes_on(gateway))) return false;
      const auto vote = codec.vote(one.second.value);
      return vote && !vote->vote.ok && vote->vote.reason.find(reason) != std::string::npos;
    }));
  }
  /// What g0 has written until then.
  [[nodiscard]] std::size_t votes_before(std::int64_t revision, const std::string& gateway) const {
    return static_cast<std::size_t>(std::ranges::count_if(store.entries, [&](const auto& one) {
      return one.first.starts_with("/mlcca/pair/" + votes_on(gateway)) &&
             one.second.create < revision;
    }));
  }
  [[nodiscard]] cc::Beat beat_of_g0() const {
    return codec.beat(store.entries.at("/mlcca/pair/m/g0").value).value_or(cc::Beat{});
  }
  cluster::RecordCodec codec{with_a_third_gateway(), cc::Digest{1}};
};

TEST_F(MembersMany, TakeTurns) {
  begin();
  ask_g0_for_many("g1", 300, 1);
  ask_g0("g2", kFirst);
  run();
  EXPECT_EQ(entries(votes_on("g1")), 300U);
  const auto vote = store.entries.find("/mlcca/pair/a/g0/g2/100");
  ASSERT_NE(vote, store.entries.end());
  EXPECT_LT(votes_before(vote->second.create, "g1"), 10U);
}

/// Its beats go on, and the others see at once what it has closed.
TEST_F(MembersMany, AreDecidedInManyTurns) {
  begin();
  ask_g0_for_many("g1", 100, 256);
  link(0).deliver();
  for (std::size_t turn = 1; turn <= 3; ++turn) {
    const std::int64_t revision = store.revision;
    at(0).act();
    link(0).deliver();
    EXPECT_LE(entries(votes_on("g1")), turn);
    EXPECT_GT(store.revision, revision) << "it has sent something, and so a beat";
  }
  EXPECT_GE(beat_of_g0().applied, store.entries.at("/mlcca/pair/x/g1/199").mod)
      << "votes that are not due yet are nothing to wait for";
  run();
}

TEST_F(MembersMany, AreOpenBeforeTheOthersAreToldSo) {
  begin();
  ask_g0_for_many("g1", 20, 256);
  run();
  ASSERT_EQ(entries(votes_on("g1")), 20U);
  beat_of("g1");
  ask_g0_for_many("g1", 20, 256, cc::Stage::granted);
  const std::int64_t granted = store.revision;
  while (link(0).deliver()) {
  }
  at(0).act();
  while (link(0).deliver()) {
  }
  EXPECT_LT(at(0).state().admissions().size(), 20U * 256U);
  EXPECT_LT(beat_of_g0().applied, granted);
  for (int turn = 0; turn < 20; ++turn) at(0).act();
  run();
  EXPECT_EQ(at(0).state().admissions().size(), 20U * 256U);
  EXPECT_GE(beat_of_g0().applied, granted);
}

TEST_F(MembersMany, AreRefusedBeyondWhatOneGatewayMayHaveHere) {
  begin();
  constexpr std::size_t most = Adopting::kMostOfGateway / cluster::StoredRequest::kMostRequests;
  ask_g0_for_many("g1", most + 2, cluster::StoredRequest::kMostRequests);
  ask_g0("g2", kFirst);
  run();
  EXPECT_EQ(entries(votes_on("g1")), most + 2);
  EXPECT_EQ(objections_to("g1", "g1 would have more than 16384 requests here"), 2U);
  EXPECT_EQ(objections_to("g2", "more than"), 0U);
  // What has ended counts no more.
  store.write({}, {"/mlcca/pair/x/g1/100"});
  ask_g0("g1", kFirst + 500);
  run();
  EXPECT_EQ(objections_to("g1", "more than"), 2U);
}

}  // namespace
}  // namespace mlcca::test
