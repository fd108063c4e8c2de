// SPDX-License-Identifier: BSD-2-Clause
// Gateways that announce themselves: in which interval, and that somebody receives it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "description/read.hpp"

namespace mlcca::description {
namespace {

std::string side_by_side(const std::string& first, const std::string& second,
                         const std::string& of_network) {
  const auto gateway = [](const char* name, const std::string& presence) {
    return fmt::format(
        "<Gateway name=\"{}\"{}><Port network=\"n\" control-user=\"991\"><Interface "
        "name=\"eth0\"/></Port></Gateway>",
        name, presence.empty() ? "" : fmt::format(" presence=\"{}\"", presence));
  };
  return fmt::format(
      "<System name=\"t\"><Network name=\"n\"><Kind>udp-multicast</Kind>"
      "<Profile>famouso</Profile>{}</Network>{}{}</System>",
      of_network, gateway("a", first), gateway("b", second));
}

const std::string kSome = "<Subscriptions accept=\"gateways\"/>";

std::vector<std::string> errors_of(const std::string& text) {
  std::vector<std::string> out;
  if (const auto system = read_memory(text, "t.xml"); !system)
    for (const auto& p : system.error()) out.push_back(to_string(p));
  return out;
}

Value presence_of(const std::string& stated) {
  const auto system = read_memory(side_by_side(stated, "1", kSome), "t.xml");
  return system ? system->gateways.at(0).presence : 0;
}

TEST(PresenceOfGatewaysTest, IsATimeInItsRange) {
  EXPECT_EQ(presence_of("0.5"), 500'000'000U);
  EXPECT_EQ(presence_of("0.1"), 100'000'000U);
  EXPECT_EQ(presence_of("10"), 10'000'000'000U);
  for (const char* bad : {"0.099", "10.1", "0", "-1", "often"}) {
    const auto errors = errors_of(side_by_side(bad, "1", kSome));
    ASSERT_FALSE(errors.empty()) << bad;
    EXPECT_NE(errors.front().find("t.xml:1: <Gateway>: attribute presence"), std::string::npos)
        << errors.front();
  }
}

TEST(PresenceOfGatewaysTest, NeedsSomebodyWhoReceivesIt) {
  EXPECT_TRUE(errors_of(side_by_side("0.5", "1", kSome)).empty());
  EXPECT_TRUE(errors_of(side_by_side("", "", kSome)).empty());
  EXPECT_EQ(errors_of(side_by_side("0.5", "", kSome)),
            std::vector<std::string>{
                "t.xml:1: <Gateway>: nobody receives the presence of a: another Gateway needs a "
                "presence, and a network of both needs Subscriptions"});
  EXPECT_EQ(errors_of(side_by_side("0.5", "1", "")).size(), 2U);
}

/// Two gateways on a bus. `of_ports`: attributes of theirs.
std::string on_a_bus(const std::string& presence, const std::string& of_ports) {
  const auto gateway = [&](const char* name, const char* node) {
    return fmt::format(
        "<Gateway name=\"{}\" presence=\"{}\">\n<Port network=\"n\"{}{}><Interface "
        "name=\"can0\"/></Port></Gateway>",
        name, presence, of_ports.contains("node") ? "" : node, of_ports);
  };
  return "<System name=\"t\"><Network name=\"n\"><Kind>can</Kind><Profile>famouso</Profile>"
         "<Bus bitrate=\"500000\"/><Subscriptions accept=\"gateways\"/></Network>" +
         gateway("main", " node=\"0x10\"") + gateway("back-up", " node=\"0x11\"") + "</System>";
}

TEST(PresenceOfGatewaysTest, NeedsWhoMaySendIt) {
  EXPECT_TRUE(errors_of(on_a_bus("0.5", " control-user=\"991\"")).empty());
  const auto errors = errors_of(on_a_bus("0.5", ""));
  ASSERT_EQ(errors.size(), 2U);
  EXPECT_EQ(errors[0],
            "t.xml:2: <Port>: main announces itself on n by a program of the control-user: state "
            "control-user=\"mlcca-famouso\"");
}

TEST(PresenceOfGatewaysTest, NeedsASenderOnABus) {
  std::string text = on_a_bus("0.5", " control-user=\"991\"");
  for (const std::string node : {" node=\"0x10\"", " node=\"0x11\""})
    text.erase(text.find(node), node.size());
  const auto errors = errors_of(text);
  ASSERT_EQ(errors.size(), 2U);
  EXPECT_EQ(errors[0],
            "t.xml:2: <Port>: main announces itself on n, where every frame has a sender: state a "
            "node");
}

TEST(PresenceOfGatewaysTest, NeedsRoomInTheControlTrafficOfABus) {
  // 33 octets with both names are 5 frames; 2 gateways ten times a second send 100.
  const auto errors = errors_of(on_a_bus("0.1", " control-user=\"991\" control-rate=\"99\""));
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0],
            "t.xml:2: <Port>: gateways announce themselves on n with up to 100 frames of subscribe "
            "in a second, and 99 may pass: state a longer presence or a greater control-rate");
  EXPECT_TRUE(errors_of(on_a_bus("0.1", " control-user=\"991\"")).empty());
}

}  // namespace
}  // namespace mlcca::description
