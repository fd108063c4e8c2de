// SPDX-License-Identifier: BSD-2-Clause
// What a gateway has left that the description does not have any more.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/core/cluster/members.hpp"

namespace mlcca::core::cluster::test {
namespace {

class RemovedGateway : public ClusterMember {
 protected:
  /// "gone" was on the bus by a former description, and did not give back what it had.
  RemovedGateway() {
    store.write({{.key = "m/gone", .value = codec.write(Beat{.lease = kTen})},
                 {.key = "r/bus/gone/1", .value = "5"},
                 {.key = "r/old/gone/1", .value = "5"},
                 {.key = "x/gone/1", .value = "?"},
                 {.key = "a/gone/A/1", .value = "?"},
                 {.key = "a/A/gone/1", .value = "?"},
                 {.key = "a/B/gone/1", .value = "?"},
                 {.key = "d/vote/gone", .value = "?"}});
  }
  std::vector<std::string> left() {
    std::vector<std::string> all;
    for (const auto& [key, entry] : store.entries)
      if (key.find("gone") != std::string::npos) all.push_back(key);
    return all;
  }
};

TEST_F(RemovedGateway, LeavesNothingWhereTheStoreLetsOthersDelete) {
  start(0);
  in_force(1);
  pass(30 * kSecond);
  EXPECT_TRUE(store.entries.contains("r/bus/gone/1")) << "nobody has fenced it";
  EXPECT_TRUE(store.entries.contains("m/gone"));
  EXPECT_FALSE(store.entries.contains("a/A/gone/1")) << "that is of A itself";
  store.write({{.key = "f/gone", .value = "A"}});
  pass(20 * kSecond);
  EXPECT_EQ(left(), std::vector<std::string>{"a/B/gone/1"}) << "B alone may";
  start(1);
  pass(2 * kSecond);
  EXPECT_EQ(left(), std::vector<std::string>{});
}

TEST_F(RemovedGateway, ThatMayStillSendKeepsWhatItHas) {
  start(0);
  in_force(1);
  store.write({{.key = "f/gone", .value = "A"}});
  pass(9 * kSecond);
  EXPECT_TRUE(store.entries.contains("r/bus/gone/1")) << "somebody hostile may have fenced it";
  EXPECT_TRUE(at(0).view().foreign(0).unreadable);
  store.write({{.key = "m/gone", .value = codec.write(Beat{.lease = kTen})}});
  const auto before = store.mod("m/gone");
  pass(60 * kSecond);
  EXPECT_EQ(store.mod("m/gone"), before) << "it is back";
  EXPECT_TRUE(store.entries.contains("f/gone"));
}

/// As the roles of the how-to have it.
TEST_F(RemovedGateway, LeavesWhatTheStoreForbidsAndThatBarsNothing) {
  store.forbidden = {"m/gone", "x/gone/", "a/gone/", "r/bus/gone/", "r/old/gone/", "d/vote/gone"};
  start(0);
  in_force(1);
  store.write({{.key = "f/gone", .value = "A"}, {.key = "r/old/A/1", .value = "5"}});
  store.write({{.key = "f/former", .value = "A"}});
  pass(30 * kSecond);
  EXPECT_EQ(left(),
            (std::vector<std::string>{"a/B/gone/1", "a/gone/A/1", "d/vote/gone", "f/gone", "m/gone",
                                      "r/bus/gone/1", "r/old/gone/1", "x/gone/1"}));
  EXPECT_FALSE(store.entries.contains("r/old/A/1"));
  EXPECT_FALSE(store.entries.contains("f/former")) << "nothing else is left of it";
  EXPECT_FALSE(at(0).view().foreign(0).unreadable);
  at(0).reserve(unit(1), now);
  run();
  EXPECT_EQ(nodes[0].take<Reserved>().size(), 1U);
  // An operator may.
  store.forbidden.clear();
  pass(70 * kSecond);
  EXPECT_EQ(left(), std::vector<std::string>{"a/B/gone/1"});
}

}  // namespace
}  // namespace mlcca::core::cluster::test
