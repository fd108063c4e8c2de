// SPDX-License-Identifier: BSD-2-Clause
// What a gateway does to another one by what it writes into the store: a lease without an end, and
// more requests than are decided.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "core/cluster/lease.hpp"
#include "daemon/cluster/codec.hpp"
#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

constexpr std::uint64_t kHourNs = 3600 * kSecondNs;

control::Admit subscriber_of(const std::string& channel, const std::string& name) {
  control::Admit request;
  request.channel = channel;
  request.to = "own1";
  request.subscriber = name;
  request.key = "also-" + name;
  return request;
}

/// The tests write for g1 what another program than mlccad could write.
class MembersHostile : public MembershipBench {
 protected:
  MembersHostile() : MembershipBench(with_a_described_publisher()) {}

  static std::string key(const std::string& kind) { return "/mlcca/pair/" + kind; }
  void write_beat(std::uint64_t lease) {
    const auto& was = store.entries.at(key("m/g1"));
    auto beat = codec.beat(was.value).value_or(cc::Beat{});
    if (beat.incarnation == 0) beat.incarnation = was.create;
    beat.digest = cc::Digest{1};
    beat.lease = lease;
    beat.applied = store.revision;
    beat.generation = 1;
    store.write({{.key = key("m/g1"), .value = codec.write(beat)}});
  }
  void write_endless_lease() {
    write_beat(std::numeric_limits<std::uint64_t>::max());
    run();
  }
  /// Asks g0 to admit a subscriber of c3 for g1.
  void write_request(std::uint64_t n) {
    const cluster::Asked asked{
        .channel = "c3",
        .requests = {{.id = 7000 + n, .body = subscriber_of("c3", "s" + std::to_string(n))}},
        .also = {},
        .on_behalf = true};
    store.write({{.key = key("x/g1/") + std::to_string(n),
                  .value = codec.write(cc::Asked{.stage = cc::Stage::prepared,
                                                 .admission = cluster::text_of(asked),
                                                 .gateways = {0}})}});
  }
  /// In long steps, as nothing happens but what time does.
  void wait(std::uint64_t time) {
    for (std::uint64_t gone = 0; gone < time; gone += 20 * kSecondNs) {
      for (auto& node : nodes) node->bench.clock.monotonic += 20 * kSecondNs;
      pass(kStepNs);
    }
  }
  std::string state_of_g1() {
    auto answer =
        at(0).ask(control::ClusterRequest{.part = "members", .network = {}, .gateway = {}});
    const auto* found = std::get_if<control::ClusterMembers>(&answer.reply.body);
    if (found == nullptr) return "no answer";
    for (const auto& one : found->members)
      if (one.name == "g1") return one.state;
    return {};
  }

  cluster::Codec codec{with_a_described_publisher(), cc::Digest{1}};
};

/// To start it with a lease that it may have is what status says about such an entry.
TEST_F(MembersHostile, WhoHadALeaseWithoutAnEndAndRestartsIsFencedWhenItDies) {
  start_both();
  ASSERT_EQ(asked(1, wanted("c2", "own1", "shared")), "granted");
  at(1).end();
  write_endless_lease();
  start(1);
  pass(5 * kSecondNs);
  at(1).end();
  link(1).up = false;
  wait(kHourNs - (60 * kSecondNs));
  EXPECT_EQ(entries("f/"), 0U) << "the process before it may still send";
  wait(120 * kSecondNs);
  EXPECT_EQ(entries("f/"), 1U);
}

TEST_F(MembersHostile, WhoHadALeaseWithoutAnEndIsAbsentAnHourAfterItsEntryWasDeleted) {
  start_both();
  at(1).end();
  link(1).up = false;
  write_endless_lease();
  wait(2 * kHourNs);
  EXPECT_EQ(state_of_g1(), "silent") << "its entry is still there";
  store.write({}, {key("m/g1")});
  wait(kHourNs - (60 * kSecondNs));
  EXPECT_EQ(state_of_g1(), "silent");
  wait(120 * kSecondNs);
  EXPECT_EQ(state_of_g1(), "absent");
}

TEST_F(MembersHostile, AnEpochAfterALeaseWithoutAnEndIsUsedAnHourAfterItsBeginning) {
  start_both();
  at(1).end();
  write_endless_lease();
  store.write({{.key = key("e"), .value = std::string(16, 'x')}});
  run();
  wait(kHourNs + (60 * kSecondNs));
  const std::string waits = asked(0, wanted("c3", "own0", "shared"));
  EXPECT_TRUE(waits.contains("leases from before have not ended yet, and g1 states one of"))
      << waits;
  start(1);
  pass(4 * kSecondNs);
  EXPECT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
}

TEST_F(MembersHostile, AUserIsDecidedBetweenTheRequestsOfAnotherGateway) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  at(1).end();
  link(0).answers = false;
  auto first = at(0).ask(wanted("c4", "own0", "shared"));
  auto second = at(0).ask(wanted("c5", "own0", "shared"));
  run();
  for (std::uint64_t n = 1; n <= 8; ++n) write_request(n);
  run();
  link(0).answers = true;
  run();
  std::int64_t user = 0;
  std::vector<std::int64_t> others;
  for (const auto& [name, entry] : store.entries) {
    if (!name.starts_with(key("x/g0/"))) continue;
    const auto asked = codec.asked(entry.value);
    const auto text = asked ? cluster::asked_in(asked->admission) : std::nullopt;
    if (text && text->for_gateway == "g1") others.push_back(entry.create);
    if (text && text->channel == "c5") user = entry.create;
  }
  ASSERT_NE(user, 0);
  EXPECT_LE(std::ranges::count_if(others, [user](std::int64_t at) { return at < user; }), 1);
}

TEST_F(MembersHostile, WhoAsksForTooMuchIsToldSo) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  at(1).end();
  link(0).answers = false;
  for (std::uint64_t n = 1; n <= 17; ++n) write_request(n);
  run();
  link(0).answers = true;
  run();
  const auto vote = [&](std::uint64_t n) {
    const auto found = store.entries.find(key("a/g0/g1/") + std::to_string(n));
    const auto there =
        found == store.entries.end() ? std::nullopt : codec.vote(found->second.value);
    return there ? there->vote.reason : "no vote";
  };
  EXPECT_EQ(vote(17), "16 admissions that g1 has asked for wait here, and may not be more");
  EXPECT_FALSE(vote(16).contains("may not be more")) << vote(16);
}

/// Nobody agrees to what this gateway makes for g1, so each of these takes its 3 s.
TEST_F(MembersHostile, WhatWasLostIsReservedAgainWhateverAnotherGatewayAsksFor) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  at(1).end();
  store.write({{.key = key("f/g0"), .value = "g1"}});
  for (std::uint64_t n = 0; n < 300; ++n) {
    if (n % 10 == 0) write_beat(kLease);
    if (n % 20 == 0) write_request(100 + n);
    pass(kStepNs);
  }
  EXPECT_TRUE(passes(0, 3));
}

}  // namespace
}  // namespace mlcca::test
