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
#include "core/cluster/records.hpp"
#include "tests/daemon/gateway/members_forged.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

constexpr std::uint64_t kHourNs = 3600 * kSecondNs;

class MembersHostile : public MembersForged {
 protected:
  void write_endless_lease() {
    beat_of_g1(std::numeric_limits<std::uint64_t>::max());
    run();
  }
  /// Asks g0 to admit a subscriber of c3 for g1.
  void write_request(std::uint64_t n) {
    request_of_g1(n, cc::Stage::prepared, subscriber_on_own1("c3", "s" + std::to_string(n)));
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

/// They are of no network, and what is known of each is not complete from then on.
TEST_F(MembersHostile, AboveTheLimitOfEntriesThatCannotBeReadNothingMoreIsGranted) {
  start_both();
  for (std::size_t n = 0; n <= cc::kMostStrange; n += 64) {
    std::vector<cc::Put> puts;
    for (std::size_t m = n; m < n + 64; ++m)
      puts.push_back({.key = key("x/g1/") + std::to_string(m + 1), .value = "nothing"});
    store.write(puts);
    run();
  }
  pass(kSecondNs);
  EXPECT_NE(asked(0, wanted("c3", "own0", "shared")), "granted");
  EXPECT_EQ(entries("r/"), 0U);
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
  for (const auto& [name, asked] : asked_by_g0()) {
    const std::int64_t create = store.entries.at(name).create;
    if (asked.for_gateway == "g1") others.push_back(create);
    if (asked.channel == "c5") user = create;
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
    const auto there = answer_to_g1(n);
    return there ? there->reason : "no vote";
  };
  EXPECT_EQ(vote(17), "16 admissions that g1 has asked for wait here, and may not be more");
  EXPECT_FALSE(vote(16).contains("may not be more")) << vote(16);
}

/// Each request of an entry is decided by itself.
TEST_F(MembersHostile, AnEntryHasABoundedNumberOfRequests) {
  start_both();
  at(1).end();
  beat_of_g1();
  run();
  const auto answer_to = [this](std::uint64_t n, std::size_t requests) {
    cluster::StoredRequest asked{.channel = "c2", .requests = {}};
    for (std::size_t i = 0; i < requests; ++i) {
      auto admit = subscriber_on_own1("c2", "s" + std::to_string(i));
      admit.to = "g0";
      auto& to = i % 2 == 0 ? asked.requests : asked.also;
      to.push_back({.id = (1000 * n) + i, .body = admit});
    }
    store.write({{.key = key("x/g1/") + std::to_string(n),
                  .value = codec.write(cc::RouteRequest{.stage = cc::Stage::prepared,
                                                        .admission = cluster::text_of(asked),
                                                        .gateways = {0}})}});
    run();
    const auto vote = answer_to_g1(n);
    if (!vote) return std::string("no vote");
    return vote->ok ? "yes" : vote->reason;
  };
  EXPECT_EQ(answer_to(5, cluster::StoredRequest::kMostRequests), "yes");
  EXPECT_EQ(answer_to(6, cluster::StoredRequest::kMostRequests + 1),
            "it has more than 256 requests");
}

/// Nobody agrees to what this gateway makes for g1, so each of these takes its 3 s.
TEST_F(MembersHostile, WhatWasLostIsReservedAgainWhateverAnotherGatewayAsksFor) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  at(1).end();
  store.write({{.key = key("f/g0"), .value = "g1"}});
  for (std::uint64_t n = 0; n < 300; ++n) {
    if (n % 10 == 0) beat_of_g1();
    if (n % 20 == 0) write_request(100 + n);
    pass(kStepNs);
  }
  EXPECT_TRUE(passes(0, 3));
}

}  // namespace
}  // namespace mlcca::test
