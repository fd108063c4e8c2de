// SPDX-License-Identifier: BSD-2-Clause
// Tests of what ends an admission that one gateway makes for another one, and what does not.
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "core/cluster/types.hpp"
#include "daemon/cluster/codec.hpp"
#include "tests/daemon/gateway/membership_bench.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

/// A subscriber on own1 of a publisher that g0 has admitted.
control::Admit one_more_on_own1(const std::string& channel, const std::string& from = {}) {
  control::Admit request;
  request.channel = channel;
  request.from = from;
  request.to = "own1";
  request.subscriber = "also";
  request.key = "also-own1";
  return request;
}

class MembersAdopted : public MembershipBench {
 protected:
  MembersAdopted() : MembershipBench(with_a_described_publisher()) {}

  static std::string key(const std::string& kind) { return "/mlcca/pair/" + kind; }
  void both_admitted() {
    start_both();
    ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
    ASSERT_EQ(asked(1, one_more_on_own1("c3")), "granted");
    ASSERT_TRUE(is_granted_twice());
  }
  /// Its own subscriber on the shared bus, and the one of the other gateway.
  bool is_granted_twice() { return at(0).state().decisions()[3].granted == 2; }

  // The test writes what g1 would, which does not run.

  void beat_of_g1() {
    const auto& was = store.entries.at(key("m/g1"));
    auto beat = codec.beat(was.value).value_or(cc::Beat{});
    if (beat.incarnation == 0) beat.incarnation = was.create;
    beat.digest = cc::Digest{1};
    beat.lease = kLease;
    beat.applied = store.revision;
    beat.generation = 1;
    store.write({{.key = key("m/g1"), .value = codec.write(beat)}});
  }
  void request_of_g1(std::uint64_t n, cc::Stage stage, const control::Admit& admit) {
    const cluster::Asked asked{.channel = admit.channel,
                               .requests = {{.id = 7000 + n, .body = admit}},
                               .also = {},
                               .on_behalf = true};
    store.write({{.key = key("x/g1/") + std::to_string(n),
                  .value = codec.write(cc::Asked{
                      .stage = stage, .admission = cluster::text_of(asked), .gateways = {0}})}});
  }
  void vote_of_g1(const std::string& own, bool ok) {
    store.write({{.key = key("a/g1/g0/") + own.substr(own.rfind('/') + 1),
                  .value = codec.write(
                      cc::VoteOf{.asked = store.entries.at(own).create,
                                 .vote = {.ok = ok, .hop = {}, .reason = ok ? "" : "cable"}})}});
  }
  cc::Vote answer_to_g1(std::uint64_t n) {
    const auto there = store.entries.find(key("a/g0/g1/") + std::to_string(n));
    const auto vote = there == store.entries.end() ? std::nullopt : codec.vote(there->second.value);
    return vote ? vote->vote : cc::Vote{.ok = false, .hop = {}, .reason = "no answer"};
  }
  std::string entry_for_g1() {
    for (const auto& [k, entry] : store.entries) {
      if (!k.starts_with(key("x/g0/"))) continue;
      const auto asked = codec.asked(entry.value);
      const auto text = asked ? cluster::asked_in(asked->admission) : std::nullopt;
      if (text && text->for_gateway == "g1") return k;
    }
    return {};
  }

  cluster::Codec codec{with_a_described_publisher(), cc::Digest{1}};
};

TEST_F(MembersAdopted, ARefusalIsToldAlsoIfTheOtherOneOpensAtThatTime) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  at(1).end();
  request_of_g1(5, cc::Stage::prepared, one_more_on_own1("c3"));
  run();
  const std::string made = entry_for_g1();
  ASSERT_NE(made, "");
  vote_of_g1(made, true);
  run();
  beat_of_g1();
  run();
  ASSERT_TRUE(answer_to_g1(5).ok) << answer_to_g1(5).reason;
  vote_of_g1(made, false);
  request_of_g1(5, cc::Stage::granted, one_more_on_own1("c3"));
  run();
  for (int n = 0; n < 50; ++n) {
    if (n % 10 == 0) beat_of_g1();
    pass(kStepNs);
  }
  EXPECT_FALSE(store.entries.contains(made)) << "given back";
  EXPECT_EQ(answer_to_g1(5).reason, "g1: cable");
}

TEST_F(MembersAdopted, AnotherGatewayBringsNoPublisher) {
  start_both();
  const auto before = at(0).state().members().publishers_of(3).size();
  const std::string why = asked(1, one_more_on_own1("c3", "own0"));
  EXPECT_NE(why.find("g0: no publisher of it is admitted here"), std::string::npos) << why;
  EXPECT_EQ(at(0).state().members().publishers_of(3).size(), before);
}

}  // namespace
}  // namespace mlcca::test
