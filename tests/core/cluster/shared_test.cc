// SPDX-License-Identifier: BSD-2-Clause
// A network that others were on is not a gateway's own by the next description.
#include "core/cluster/shared.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace mlcca::core::cluster {
namespace {

/// Each gateway has a port on each of the networks that are named for it.
System system_of(const std::vector<std::string>& networks,
                 const std::vector<std::vector<std::size_t>>& ports) {
  System system;
  for (const std::string& name : networks) {
    Network network;
    network.name = name;
    system.networks.push_back(std::move(network));
  }
  for (const auto& of : ports) {
    Gateway gateway;
    for (const std::size_t n : of) {
      Port port;
      port.network = n;
      port.identity.name = "eth" + std::to_string(n);
      gateway.ports.push_back(std::move(port));
    }
    system.gateways.push_back(std::move(gateway));
  }
  return system;
}

const System kBefore = system_of({"lan", "own"}, {{0, 1}, {0}});

TEST(ClusterShared, WhatStaysSharedOrGoesMay) {
  EXPECT_EQ(no_longer_shared(kBefore, 0, kBefore, 0), "");
  EXPECT_EQ(no_longer_shared(kBefore, 0, system_of({"own"}, {{}, {}}), 0), "") << "it is closed";
  EXPECT_EQ(no_longer_shared(kBefore, 0, system_of({"lan", "own"}, {{0, 1}, {0}, {0}}), 0), "");
  EXPECT_EQ(no_longer_shared(kBefore, 1, system_of({"lan", "own"}, {{0, 1}, {}}), 1), "")
      << "it is the one that has left";
}

TEST(ClusterShared, WhatOthersHaveLeftMayNot) {
  const std::string why =
      "others are on lan by the description in force, and would not be any more: roll out one "
      "without that network first, and then this one";
  EXPECT_EQ(no_longer_shared(kBefore, 0, system_of({"lan", "own"}, {{0, 1}, {}}), 0), why);
  EXPECT_EQ(no_longer_shared(kBefore, 0, system_of({"lan", "own"}, {{0, 1}}), 0), why);
  // By another name it is the same interface.
  EXPECT_EQ(no_longer_shared(kBefore, 0, system_of({"lan-2", "own"}, {{0, 1}}), 0), why);
}

TEST(ClusterShared, ANetworkThatWasOwnMayBeOwn) {
  EXPECT_EQ(no_longer_shared(system_of({"lan", "own"}, {{1}, {0}}), 0,
                             system_of({"lan", "own"}, {{1}, {}}), 0),
            "");
}

}  // namespace
}  // namespace mlcca::core::cluster
