// SPDX-License-Identifier: BSD-2-Clause
// Which networks may accept subscriptions, from whom and how many.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "description/read.hpp"

namespace mlcca::description {
namespace {

std::string network(const std::string& kind, const std::string& profile,
                    const std::string& attributes) {
  return fmt::format(
      "<System name=\"t\"><Network "
      "name=\"n\"><Kind>{}</Kind>{}<Subscriptions{}/></Network></System>",
      kind, profile.empty() ? "" : "<Profile>" + profile + "</Profile>", attributes);
}

core::SubscriptionPolicy policy_of(const std::string& attributes) {
  const auto system = read_memory(network("can", "famouso", attributes), "t.xml");
  return system ? system->networks.at(0).subscriptions : core::SubscriptionPolicy{};
}

std::vector<std::string> problems_of(const std::string& text) {
  std::vector<std::string> out;
  if (const auto system = read_memory(text, "t.xml"); !system)
    for (const auto& p : system.error()) out.push_back(to_string(p));
  return out;
}

TEST(SubscriptionPolicyTest, AcceptsThoseWithAttributesUnlessItSaysAll) {
  EXPECT_EQ(policy_of("").accept, core::Subscribing::with_attributes);
  EXPECT_EQ(policy_of("").most, 64U);
  EXPECT_EQ(policy_of(" accept=\"attributes\"").accept, core::Subscribing::with_attributes);
  EXPECT_EQ(policy_of(" accept=\"all\" most=\"3\"").accept, core::Subscribing::all);
  EXPECT_EQ(policy_of(" accept=\"all\" most=\"3\"").most, 3U);
  const auto without = read_memory(
      "<System name=\"t\"><Network name=\"n\"><Kind>can</Kind><Profile>famouso</Profile></Network>"
      "</System>",
      "t.xml");
  ASSERT_TRUE(without);
  EXPECT_EQ(without->networks.at(0).subscriptions.accept, core::Subscribing::nobody);
}

TEST(SubscriptionPolicyTest, HasLimits) {
  EXPECT_EQ(policy_of(" most=\"1\"").most, 1U);
  EXPECT_EQ(policy_of(" most=\"1024\"").most, 1024U);
  for (const char* wrong : {" most=\"0\"", " most=\"1025\"", " most=\"\"", " accept=\"none\"",
                            " accept=\"\"", " allow=\"all\""})
    EXPECT_EQ(problems_of(network("can", "famouso", wrong)).size(), 1U) << wrong;
}

TEST(SubscriptionPolicyTest, IsForNetworksOfFamouso) {
  EXPECT_TRUE(problems_of(network("udp-multicast", "famouso", "")).empty());
  EXPECT_TRUE(problems_of(network("mesh", "famouso", "")).empty());
  EXPECT_TRUE(problems_of(network("ieee802154", "famouso", "")).empty());
  const std::vector<std::string> wrong{
      "t.xml:1: <Subscriptions>: n is not of profile famouso on CAN, Ethernet, IEEE 802.15.4 or a "
      "mesh, whose nodes subscribe: remove it"};
  EXPECT_EQ(problems_of(network("can", "raw", "")), wrong);
  EXPECT_EQ(problems_of(network("udp-multicast", "", "")), wrong);
  EXPECT_EQ(problems_of(network("ieee802154", "", "")), wrong);
}

}  // namespace
}  // namespace mlcca::description
