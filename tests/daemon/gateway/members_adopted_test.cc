// SPDX-License-Identifier: BSD-2-Clause
// Tests of what ends an admission that one gateway makes for another one, and what does not.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "tests/daemon/gateway/members_forged.hpp"

namespace mlcca::test {
namespace {

namespace cc = core::cluster;

class MembersAdopted : public MembersForged {
 protected:
  void vote_of_g1(const std::string& own, bool ok) {
    store.write({{.key = key("a/g1/g0/") + own.substr(own.rfind('/') + 1),
                  .value = codec.write(
                      cc::VoteOf{.asked = store.entries.at(own).create,
                                 .vote = {.ok = ok, .hop = {}, .reason = ok ? "" : "cable"}})}});
  }
  std::string why_not(std::uint64_t n) {
    const auto vote = answer_to_g1(n);
    return vote ? vote->reason : "no answer";
  }
  std::string entry_for_g1() {
    for (const auto& [name, asked] : asked_by_g0())
      if (asked.for_gateway == "g1") return name;
    return {};
  }
};

TEST_F(MembersAdopted, ARefusalIsToldAlsoIfTheOtherOneOpensAtThatTime) {
  start_both();
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  at(1).end();
  request_of_g1(5, cc::Stage::prepared, subscriber_on_own1("c3", "also"));
  run();
  const std::string made = entry_for_g1();
  ASSERT_NE(made, "");
  vote_of_g1(made, true);
  run();
  beat_of_g1();
  run();
  ASSERT_EQ(why_not(5), "");
  ASSERT_TRUE(answer_to_g1(5)->ok);
  vote_of_g1(made, false);
  request_of_g1(5, cc::Stage::granted, subscriber_on_own1("c3", "also"));
  run();
  for (int n = 0; n < 50; ++n) {
    if (n % 10 == 0) beat_of_g1();
    pass(kStepNs);
  }
  EXPECT_FALSE(store.entries.contains(made)) << "given back";
  EXPECT_EQ(why_not(5), "g1: cable");
}

TEST_F(MembersAdopted, AnotherGatewayBringsNoPublisher) {
  start_both();
  const auto before = at(0).state().members().publishers_of(3).size();
  const std::string why = asked(1, subscriber_on_own1("c3", "also", "own0"));
  EXPECT_NE(why.find("g0: no publisher of it is admitted here"), std::string::npos) << why;
  EXPECT_EQ(at(0).state().members().publishers_of(3).size(), before);
}

}  // namespace
}  // namespace mlcca::test
