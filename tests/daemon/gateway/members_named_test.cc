// SPDX-License-Identifier: BSD-2-Clause
// Whom refusals, status and log of a gateway name: other gateways that hold what is asked for, that
// claim more than there is, and whose entries cannot be read.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <variant>
#include <vector>

#include "core/cluster/lease.hpp"
#include "daemon/cluster/record_codec.hpp"
#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

/// A bus of 125 kbit/s carries three of these, and not four.
control::Admit fast(const std::string& channel, std::size_t gateway) {
  auto request = wanted(channel, "own" + std::to_string(gateway), "shared");
  request.offered = {attribute_of("Period", 3'300'000)};
  return request;
}

class MembersNamed : public MembershipBench {
 protected:
  std::vector<std::string> problems(std::size_t g) {
    auto answer = at(g).ask(control::ClusterRequest{});
    const auto* found = std::get_if<control::Cluster>(&answer.reply.body);
    return found != nullptr ? found->health.reasons : std::vector<std::string>{"no answer"};
  }
  static bool any_has(const std::vector<std::string>& lines, const std::string& words) {
    return std::ranges::any_of(lines, [&](const auto& line) { return line.contains(words); });
  }
  std::size_t logged(std::size_t g, const std::string& words) {
    return static_cast<std::size_t>(std::ranges::count_if(at(g).published, [&](const auto& event) {
      return event.kind == "gateway" && event.message.contains(words);
    }));
  }
  std::string key(const std::string& kind) { return "/mlcca/pair/" + kind; }
};

TEST_F(MembersNamed, ARefusalForWhatOthersHoldNamesThem) {
  start_both();
  ASSERT_EQ(asked(1, fast("c2", 1)), "granted");
  ASSERT_EQ(asked(1, fast("c3", 1)), "granted");
  std::string text;
  for (const char* channel : {"c4", "c5"}) text = asked(0, fast(channel, 0));
  EXPECT_TRUE(text.contains("; reserved there by g1 (2 messages, ")) << text;
}

/// This gateway carries it as well, and is asked whether it agrees.
TEST_F(MembersNamed, WhatThisGatewayHasAgreedToIsOfTheOtherOne) {
  start_both();
  ASSERT_EQ(asked(1, wanted("c2", "own1", "own0")), "granted");
  for (const char* channel : {"c4", "c5"}) ASSERT_EQ(asked(1, fast(channel, 1)), "granted");
  auto faster = wanted("c3", "shared", "g0");
  faster.offered = {attribute_of("Period", 2'200'000)};
  const std::string text = asked(0, faster);
  EXPECT_TRUE(text.contains("; reserved there by g1 (3 messages, ")) << text;
}

/// g0 has admitted the publisher, and reserves on the shared bus for a subscriber of g1.
TEST_F(MembersNamed, WhatAGatewayHoldsForAnotherOneIsNamedSo) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c2", "own0", "own0")), "granted");
  control::Admit subscriber;
  subscriber.channel = "c2";
  subscriber.from = "own0";
  subscriber.to = "g1";
  subscriber.subscriber = subscriber.key = "also";
  ASSERT_EQ(asked(1, subscriber), "granted");
  for (const char* channel : {"c4", "c5"}) ASSERT_EQ(asked(1, fast(channel, 1)), "granted");
  auto faster = wanted("c3", "shared", "g1");
  faster.offered = {attribute_of("Period", 2'200'000)};
  const auto refusal = [&] { return asked(1, faster); };
  EXPECT_TRUE(refusal().contains("; reserved there by g0 (1 message, ")) << refusal();
  EXPECT_TRUE(refusal().contains(" of the time, for g1)")) << refusal();
  subscriber.channel = "c1";
  subscriber.to = "shared";
  subscriber.subscriber = subscriber.key = "own";
  ASSERT_EQ(asked(0, subscriber), "granted");
  EXPECT_TRUE(refusal().contains("; reserved there by g0 (2 messages, ")) << refusal();
  EXPECT_TRUE(refusal().contains(" of the time, in part for g1)")) << refusal();
}

TEST_F(MembersNamed, AnEntryThatCannotBeReadIsNamedUntilItsGatewayDeletesIt) {
  start_both();
  store.write({{.key = key("r/shared/g1/7"), .value = "not understood"}});
  run();
  const std::string named =
      key("r/shared/g1/7") + " of gateway g1 (it is damaged, or of another version)";
  EXPECT_TRUE(any_has(problems(0), named));
  const std::string text = asked(0, wanted("c2", "own0", "shared"));
  EXPECT_TRUE(text.contains("it is not known what other gateways hold of shared: " + named))
      << text;
  EXPECT_TRUE(text.contains("restart mlccad on g1")) << text;
  pass(2 * kSecondNs);
  EXPECT_EQ(logged(0, named), 1U);
  pass(20 * kSecondNs);
  EXPECT_EQ(logged(0, named), 1U) << "it has been said";
  at(1).end();
  start(1);
  pass(4 * kSecondNs);
  EXPECT_EQ(entries("r/"), 0U);
  EXPECT_FALSE(any_has(problems(0), "cannot be read"));
  EXPECT_EQ(asked(0, wanted("c2", "own0", "shared")), "granted");
}

TEST_F(MembersNamed, WhoClaimsMoreThanThereIsIsNamed) {
  start_both();
  const cluster::RecordCodec codec(two_gateways(), core::cluster::Digest{1});
  cc::Taken much{.channel = "c5", .publisher = "x", .part = {}, .through = {}};
  for (core::AdmissionId id = 1; id <= 6; ++id) {
    cc::BusPart& part = much.part.bus.emplace_back();
    part.message = {.priority = 0x10000000U + static_cast<std::uint32_t>(id),
                    .frames = 1,
                    .transmission = kMs,
                    .longest_frame = kMs,
                    .last_frame = kMs,
                    .period = 4 * kMs,
                    .deadline = 400 * kMs};
    part.source.admission = 100 + id;
  }
  store.write({{.key = key("r/shared/g1/77"), .value = codec.write(much)}});
  run();
  const std::string named =
      "other gateways have reserved more of shared than it has (150 % of its time): g1 (6 "
      "messages, "
      "150 % of the time)";
  EXPECT_TRUE(any_has(problems(0), named)) << problems(0).size();
  pass(2 * kSecondNs);
  EXPECT_EQ(logged(0, named), 1U);
  EXPECT_TRUE(granted(0, 0)) << "what is described goes on";
}

TEST_F(MembersNamed, ALeaseThatIsTooLongOpensNothingAndIsNamed) {
  start_both();
  ASSERT_EQ(asked(1, fast("c2", 1)), "granted");
  at(1).end();
  const cluster::RecordCodec codec(two_gateways(), core::cluster::Digest{1});
  cc::Beat beat;
  beat.digest = cc::Digest{1};
  beat.lease = 3 * cc::kMostLease;
  store.write({{.key = key("m/g1"), .value = codec.write(beat)}});
  run();
  EXPECT_TRUE(any_has(problems(0), "it states a lease of 3 h, and 1 h is the longest"));
  pass(60 * kSecondNs);
  EXPECT_EQ(entries("f/"), 0U) << "it may still send";
}

}  // namespace
}  // namespace mlcca::test
