// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/keys.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace mlcca::core::cluster {
namespace {

System odd_names() {
  System system;
  for (const char* name : {"bus", "drive/left %", "plant"}) {
    Network network;
    network.name = name;
    system.networks.push_back(network);
  }
  for (const char* name : {"g1", "g/2", "gw ä"}) {
    Gateway gateway;
    gateway.name = name;
    system.gateways.push_back(gateway);
  }
  const std::vector<std::vector<std::size_t>> ports = {{0, 1}, {0, 1, 2}, {1}};
  for (std::size_t g = 0; g < ports.size(); ++g)
    for (const std::size_t n : ports[g]) {
      Port port;
      port.network = n;
      system.gateways[g].ports.push_back(port);
    }
  return system;
}

TEST(ClusterKeys, NamesAreEncodedSoThatAKeyHasOneReading) {
  const Keys keys(odd_names(), "/mlcca/plant/");
  EXPECT_EQ(keys.member(1), "/mlcca/plant/m/g%2f2");
  EXPECT_EQ(keys.reservation(1, 2, 7), "/mlcca/plant/r/drive%2fleft%20%25/gw%20%c3%a4/7");
}

TEST(ClusterKeys, EveryKeyIsReadAsItWasWritten) {
  const Keys keys(odd_names(), "/mlcca/plant/");
  const std::string digest(64, 'a');
  using Kind = Key::Kind;
  EXPECT_EQ(keys.parse(keys.epoch()), Key{});
  EXPECT_EQ(keys.parse(keys.current()), (Key{.kind = Kind::current}));
  EXPECT_EQ(keys.parse(keys.next()), (Key{.kind = Kind::next}));
  EXPECT_EQ(keys.parse(keys.blob(digest, 3)), (Key{.kind = Kind::blob, .id = 3, .digest = digest}));
  for (std::size_t g = 0; g < 3; ++g) {
    EXPECT_EQ(keys.parse(keys.member(g)), (Key{.kind = Kind::member, .gateway = g}));
    EXPECT_EQ(keys.parse(keys.fence(g)), (Key{.kind = Kind::fence, .gateway = g}));
    EXPECT_EQ(keys.parse(keys.rollout_vote(g)), (Key{.kind = Kind::rollout_vote, .gateway = g}));
    EXPECT_EQ(keys.parse(keys.version(g)), (Key{.kind = Kind::version, .network = g}));
    EXPECT_EQ(keys.parse(keys.asked(g, 5)), (Key{.kind = Kind::asked, .gateway = g, .id = 5}));
    EXPECT_EQ(keys.parse(keys.reservation(2, g, 0)),
              (Key{.kind = Kind::reservation, .network = 2, .gateway = g}));
    EXPECT_EQ(keys.parse(keys.vote(g, 1, 18446744073709551615U)),
              (Key{.kind = Kind::vote, .gateway = g, .from = 1, .id = 18446744073709551615U}));
  }
}

TEST(ClusterKeys, WhatIsNoKeyIsNotRead) {
  const Keys keys(odd_names(), "p/");
  for (const char* key : {"",
                          "p/",
                          "q/e",
                          "p/e/",
                          "p/m",
                          "p/m/",
                          "p/m/nobody",
                          "p/m/g1/",
                          "p/m/g%2F2",
                          "p/m/g/2",
                          "p/x/g1/01",
                          "p/x/g1/-1",
                          "p/x/g1/18446744073709551616",
                          "p/x/g1",
                          "p/r/bus/g1",
                          "p/r/bus/g1/1/",
                          "p/r/sea/g1/1",
                          "p/a/g1/nobody/1",
                          "p/d/blob/aa/1",
                          "p/d/other",
                          "p/v/",
                          "p/z/g1/1",
                          "p/r/bus/g1/ 1"})
    EXPECT_FALSE(keys.parse(key)) << key;
}

TEST(ClusterKeys, ATakerThatIsNotKnownStillTakesOfItsNetwork) {
  const Keys keys(odd_names(), "p/");
  EXPECT_EQ(keys.network_of("p/r/bus/nobody/1"), 0U);
  EXPECT_EQ(keys.network_of("p/r/plant/g1/x/y"), 2U);
  EXPECT_FALSE(keys.network_of("p/r/sea/g1/1"));
  EXPECT_FALSE(keys.network_of("p/m/nobody"));
}

/// Names of gateways that are not described are shown to an operator, in a command.
TEST(ClusterKeys, WhatARemovedGatewayHasLeftHasPlainNames) {
  const Keys keys(odd_names(), "p/");
  const auto left = keys.parse_left("p/a/nobody/g1/1");
  ASSERT_TRUE(left);
  EXPECT_EQ(left->gateway, "nobody");
  EXPECT_FALSE(left->voter);
  EXPECT_EQ(keys.parse_left("p/a/g1/nobody/1")->voter, 0U);
  EXPECT_EQ(keys.parse_left("p/d/vote/nobody")->kind, Key::Kind::rollout_vote);
  EXPECT_EQ(keys.parse_left("p/x/g%2f3/7")->gateway, "g%2f3");
  for (const char* key : {"p/f/g1", "p/x/g1/7", "p/f/a;reboot", "p/f/$(reboot)", "p/r/b s/nobody/1",
                          "p/v/nobody", "p/x/nobody", "p/d/other/nobody"})
    EXPECT_FALSE(keys.parse_left(key)) << key;
}

TEST(ClusterKeys, TwoNetworksOfBothMakeGatewaysStandSideBySide) {
  const Keys keys(odd_names(), "");
  EXPECT_TRUE(keys.side_by_side(0, 1));
  EXPECT_TRUE(keys.side_by_side(1, 0));
  EXPECT_FALSE(keys.side_by_side(1, 2));
  EXPECT_FALSE(keys.side_by_side(1, 1));
}

}  // namespace
}  // namespace mlcca::core::cluster
