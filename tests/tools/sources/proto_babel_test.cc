// SPDX-License-Identifier: BSD-2-Clause
// What is read from the lines of babeld's local interface, as babeld 1.12.1 wrote them.
#include <gtest/gtest.h>

#include <sstream>

#include "tests/tools/sources/proto_loop.hpp"
#include "tools/sources/babel.hpp"

namespace mlcca::net::babel {
namespace {

const char* const kDump =
    "add interface mesh0 up true ipv6 fe80::ff:fe00:1 ipv4 10.1.1.10\n"
    "add neighbour 556e6227fcd0 address fe80::ff:fe00:2 if mesh0 reach ffff ureach 0000 rxcost 256 "
    "txcost 256 rtt 0.302 rttcost 0 cost 256\n"
    "add xroute 10.9.1.1/32-0.0.0.0/0 prefix 10.9.1.1/32 from 0.0.0.0/0 metric 0\n"
    "add route 556e62281050 prefix 10.9.3.1/32 from 0.0.0.0/0 installed yes "
    "id 94:60:77:7a:c1:5c:1c:c2 metric 512 refmetric 256 via fe80::ff:fe00:2 if mesh0\n";

State state_after(const std::string& lines, core::mesh::DescribedNodes described = {}) {
  State state(std::move(described));
  std::istringstream in(lines);
  for (std::string line; std::getline(in, line);) state.take(line);
  return state;
}

TEST(Babel, RepliesEndInOneOfThreeWords) {
  State state({});
  EXPECT_EQ(state.take("BABEL 1.0"), Line::other);
  EXPECT_EQ(state.take("version babeld-1.12.1"), Line::other);
  EXPECT_EQ(state.take("host vm"), Line::other);
  EXPECT_EQ(state.take("my-id 94:3f:0a:a6:00:6e:96:ce"), Line::other);
  EXPECT_EQ(state.take("ok"), Line::ok);
  EXPECT_EQ(state.take("ok\r"), Line::ok);
  EXPECT_EQ(state.take("no read-only"), Line::refused);
  EXPECT_EQ(state.take("bad"), Line::refused);
  EXPECT_EQ(state.take("add interface mesh0 up false"), Line::fact);
}

TEST(Babel, ANeighbourIsALinkInBothDirections) {
  const auto snapshot = state_after(kDump).snapshot();
  ASSERT_EQ(snapshot.links.size(), 2U);
  const auto* there = test::find(snapshot, "fe80::ff:fe00:1", "fe80::ff:fe00:2");
  const auto* back = test::find(snapshot, "fe80::ff:fe00:2", "fe80::ff:fe00:1");
  ASSERT_TRUE(there != nullptr && back != nullptr);
  EXPECT_EQ(there->rate, 0U);
  EXPECT_EQ(there->loss, 0U);
  EXPECT_EQ(there->weight, 256U);
  EXPECT_EQ(back->loss, 0U);
  EXPECT_EQ(back->weight, 256U);
}

TEST(Babel, WhatTheNeighbourCountsIsTheLossOfTheWayThere) {
  const auto snapshot =
      state_after(std::string(kDump) +
                  "change neighbour 556e6227fcd0 address fe80::ff:fe00:2 if mesh0 reach fff0 "
                  "ureach 0000 rxcost 512 txcost 1024 cost 2048\n")
          .snapshot();
  EXPECT_EQ(test::find(snapshot, "fe80::ff:fe00:1", "fe80::ff:fe00:2")->loss, 750'000'000U);
  EXPECT_EQ(test::find(snapshot, "fe80::ff:fe00:2", "fe80::ff:fe00:1")->loss, 500'000'000U);
  EXPECT_EQ(test::find(snapshot, "fe80::ff:fe00:2", "fe80::ff:fe00:1")->weight, 2048U);
}

TEST(Babel, LossIsRoundedUp) {
  EXPECT_EQ(loss_of(256), 0U);
  EXPECT_EQ(loss_of(257), 3'891'051U);  // 1/257 = 0.00389105058…
  EXPECT_EQ(loss_of(65535), 1'000'000'000U);
  EXPECT_EQ(loss_of(70000), 1'000'000'000U);
  EXPECT_FALSE(loss_of(96));  // a wire is not counted
}

TEST(Babel, AnInstalledRouteToAHostIsANextHop) {
  const auto snapshot = state_after(kDump).snapshot();
  ASSERT_EQ(snapshot.next_hops.size(), 1U);
  EXPECT_EQ(snapshot.next_hops[0].from, "fe80::ff:fe00:1");
  EXPECT_EQ(snapshot.next_hops[0].to, "10.9.3.1");
  EXPECT_EQ(snapshot.next_hops[0].via, "fe80::ff:fe00:2");
}

TEST(Babel, RoutesThatAreNotUsedAndNetworksAreNoNextHops) {
  const auto snapshot =
      state_after(std::string(kDump) +
                  "change route 556e62281050 prefix 10.9.3.1/32 from 0.0.0.0/0 installed no id "
                  "94:60:77:7a:c1:5c:1c:c2 metric 512 refmetric 256 via fe80::ff:fe00:2 if mesh0\n"
                  "add route 1 prefix 10.8.0.0/16 from 0.0.0.0/0 installed yes id "
                  "94:60:77:7a:c1:5c:1c:c2 metric 512 refmetric 256 via fe80::ff:fe00:2 if mesh0\n")
          .snapshot();
  EXPECT_TRUE(snapshot.next_hops.empty());
}

TEST(Babel, WhatIsFlushedIsGone) {
  auto state = state_after(kDump);
  state.take(
      "flush route 556e62281050 prefix 10.9.3.1/32 from 0.0.0.0/0 installed yes id "
      "94:60:77:7a:c1:5c:1c:c2 metric 512 refmetric 256 via fe80::ff:fe00:2 if mesh0");
  EXPECT_TRUE(state.snapshot().next_hops.empty());
  EXPECT_EQ(state.snapshot().links.size(), 2U);
  state.take("flush neighbour 556e6227fcd0 address fe80::ff:fe00:2 if mesh0 reach 0000");
  EXPECT_TRUE(state.snapshot().links.empty());
}

TEST(Babel, AnInterfaceThatIsDownHasNoLinks) {
  auto state = state_after(kDump);
  state.take("change interface mesh0 up false");
  EXPECT_TRUE(state.snapshot().links.empty());
  EXPECT_TRUE(state.snapshot().next_hops.empty());
}

TEST(Babel, NodesMayBeDescribedByTheirHostRoutes) {
  // The neighbour announces its own address: nothing is added to the cost of reaching it.
  const auto snapshot =
      state_after(
          std::string(kDump) +
              "add route 2 prefix 10.9.2.1/32 from 0.0.0.0/0 installed yes id "
              "94:60:77:7a:c1:5c:1c:c3 metric 256 refmetric 0 via fe80::ff:fe00:2 if mesh0\n",
          {"10.9.1.1", "10.9.2.1", "10.9.3.1"})
          .snapshot();
  EXPECT_NE(test::find(snapshot, "10.9.1.1", "10.9.2.1"), nullptr);
  EXPECT_NE(test::find(snapshot, "10.9.2.1", "10.9.1.1"), nullptr);
  ASSERT_EQ(snapshot.next_hops.size(), 2U);
  for (const auto& hop : snapshot.next_hops) {
    EXPECT_EQ(hop.from, "10.9.1.1");
    EXPECT_EQ(hop.via, "10.9.2.1");
  }
}

TEST(Babel, HostsAndNetworksAreDistinguished) {
  EXPECT_EQ(host_of("10.9.3.1/32"), "10.9.3.1");
  EXPECT_EQ(host_of("fd00::1/128"), "fd00::1");
  EXPECT_FALSE(host_of("fd00::/32"));
  EXPECT_FALSE(host_of("10.9.0.0/16"));
  EXPECT_FALSE(host_of("10.9.3.1"));
}

TEST(Babel, LinesThatEndEarlyAreSurvived) {
  State state({});
  const std::string dump(kDump);
  for (std::size_t size = 0; size < dump.size(); ++size) state.take(dump.substr(0, size));
  for (const char* line : {"", " ", "add", "add neighbour", "add neighbour 1 rxcost", "flush",
                           "change neighbour 1 address x if mesh0 rxcost -5 txcost 99999999999"})
    state.take(line);
  for (const auto& sample : state.snapshot().links) EXPECT_EQ(sample.rate, 0U);
}

}  // namespace
}  // namespace mlcca::net::babel
