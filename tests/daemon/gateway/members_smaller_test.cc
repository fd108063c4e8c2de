// SPDX-License-Identifier: BSD-2-Clause
// Tests of reservations of which a part has ended: what nobody is granted any more is closed at the
// other gateway, too, and what is still granted continues.
#include <gtest/gtest.h>

#include <cstddef>
#include <set>
#include <string>
#include <utility>

#include "tests/daemon/gateway/members_passing.hpp"

namespace mlcca::test {
namespace {

/// g0 has publishers of c3, and subscribers of it on own1 and own2, both networks of g1.
class MembersSmaller : public MembersPassing {
 protected:
  void release(std::size_t g, const std::string& key) {
    const auto answer =
        at(g).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = key});
    ASSERT_FALSE(std::holds_alternative<control::Error>(answer.reply.body)) << key;
  }
  /// What a gateway grants of c3.
  std::set<std::pair<std::string, std::string>> deliveries(std::size_t g) {
    std::set<std::pair<std::string, std::string>> all;
    for (const auto& one : at(g).state().grants(kThirdChannel).deliveries)
      all.emplace(one.publisher, one.to);
    return all;
  }
};

TEST_F(MembersSmaller, ASubscriberWhosePublisherIsReleasedIsClosedAtTheOtherGateway) {
  admit_publisher();
  ASSERT_EQ(asked(0, subscriber("own1")), "granted");
  ASSERT_TRUE(passes_on("own1"));
  release(0, "c3own0");
  pass(4 * kSecondNs);
  EXPECT_FALSE(passes_on("own1"));
  EXPECT_EQ(at(0).state().admissions().size(), 1U) << "the subscriber stays admitted";
  for (const char* kind : {"r/", "x/", "a/"}) EXPECT_EQ(entries(kind), 0U) << kind;
  ASSERT_EQ(asked(0, wanted("c3", "own0", "shared")), "granted");
  pass(4 * kSecondNs);
  EXPECT_TRUE(passes_on("own1")) << "it is asked for again";
}

}  // namespace
}  // namespace mlcca::test
