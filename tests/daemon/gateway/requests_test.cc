// SPDX-License-Identifier: BSD-2-Clause
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "core/admission/state.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
#include "description/read.hpp"

namespace mlcca {
namespace {

core::State gateway_on_a_bus() {
  auto system = description::read_memory(
      R"(<System name="test">
        <EventChannel name="stop"><SubjectUID>0xa1</SubjectUID></EventChannel>
        <Network name="bus"><Kind>can</Kind><Profile>raw</Profile>
          <Binding channel="stop"><Identifier form="standard">0x123</Identifier></Binding></Network>
        <Gateway name="gate"><Port network="bus"><Interface name="can0"/></Port></Gateway>
        <Subscriber channel="stop" network="bus"/>
      </System>)",
      "test.xml");
  if (!system) throw std::runtime_error(to_string(system.error().front()));
  return core::State(std::move(*system));
}

control::ChannelRequest publisher_of_user(const std::string& user) {
  control::ChannelRequest request;
  request.channel = "stop";
  request.from = "gate";
  request.user = user;
  return request;
}

TEST(Understand, TakesTheLargestUserNumber) {
  const auto state = gateway_on_a_bus();
  const auto asked = understand(state, publisher_of_user("4294967294"), 1);
  ASSERT_TRUE(asked) << asked.error().text;
  EXPECT_EQ(asked->admission->publisher->uid, 4294967294U);
}

/// A look-up may take as long as a directory service likes.
TEST(Understand, LooksUpNoNamesOfUsers) {
  const auto state = gateway_on_a_bus();
  const auto asked = understand(state, publisher_of_user("root"), 1);
  ASSERT_FALSE(asked);
  EXPECT_NE(asked.error().text.find("by number"), std::string::npos) << asked.error().text;
}

/// In a slot 4294967295 stands for every user there is.
TEST(Understand, RefusesTheUserNumberThatStandsForAllUsers) {
  const auto state = gateway_on_a_bus();
  for (const char* user : {"4294967295", "4294967296", "99999999999999999999", "-1"}) {
    const auto asked = understand(state, publisher_of_user(user), 1);
    ASSERT_FALSE(asked) << user;
    EXPECT_NE(asked.error().text.find(user), std::string::npos) << asked.error().text;
  }
}

/// Two attributes are the description's own; the channel states one of them.
core::State with_own_attributes() {
  auto system = description::read_memory(
      R"(<System name="test">
        <UserAttribute name="Trust"><Better>larger</Better>
          <Composition>minimum</Composition></UserAttribute>
        <UserAttribute name="Temperature">
          <Dimension><SIUnit><Kelvins>1</Kelvins></SIUnit><Magnitude>-1</Magnitude></Dimension>
          <Better>smaller</Better><Composition>maximum</Composition></UserAttribute>
        <EventChannel name="stop"><SubjectUID>0xa1</SubjectUID>
          <Attributes><Attribute><Name>Trust</Name><Value>1</Value></Attribute></Attributes>
        </EventChannel>
        <Network name="bus"><Kind>can</Kind><Profile>raw</Profile>
          <Binding channel="stop"><Identifier form="standard">0x123</Identifier></Binding></Network>
        <Gateway name="gate"><Port network="bus"><Interface name="can0"/></Port></Gateway>
        <Subscriber channel="stop" network="bus"/>
      </System>)",
      "test.xml");
  if (!system) throw std::runtime_error(to_string(system.error().front()));
  return core::State(std::move(*system));
}

/// What a new subscriber requires of them; what is wrong, if it is an error.
std::string own_of_subscriber(std::vector<control::Attribute> required) {
  const auto state = with_own_attributes();
  control::ChannelRequest request;
  request.channel = "stop";
  request.to = "bus";
  request.required = std::move(required);
  const auto asked = understand(state, request, 1);
  if (!asked) return asked.error().text;
  std::string out;
  for (const core::UserValue& value : asked->admission->subscriber->user) {
    const auto& attribute = state.system().user_attributes[value.attribute];
    out += attribute.name + " " + core::format_user_value(attribute, value.value) + "; ";
  }
  return out;
}

TEST(OwnAttributes, AreRequiredOverThoseOfTheChannel) {
  EXPECT_EQ(own_of_subscriber({{"Omission", 1, "events", false}}), "Trust 1; ");
  EXPECT_EQ(own_of_subscriber({{"Trust", 4, "", false}}), "Trust 4; ");
  EXPECT_EQ(own_of_subscriber({{"Temperature", 3105, "1e-1 K", false}}),
            "Trust 1; Temperature 310.5 K; ");
  EXPECT_EQ(own_of_subscriber({{"Temperature", 310, "K", false}}), "Trust 1; Temperature 310 K; ");
}

TEST(OwnAttributes, AreRoundedTowardsTheHarderRequirement) {
  EXPECT_EQ(own_of_subscriber({{"Trust", 35, "1e-1", false}}), "Trust 4; ");
  EXPECT_EQ(own_of_subscriber({{"Temperature", 31059, "1e-2 K", false}}),
            "Trust 1; Temperature 310.5 K; ");
}

TEST(OwnAttributes, ThatAreNotDefinedAreRefusedWithThoseThatAre) {
  const std::string why = own_of_subscriber({{"Colour", 4, "", false}});
  EXPECT_TRUE(why.contains("no attribute 'Colour'")) << why;
  EXPECT_TRUE(why.contains("MaxPayload; the description defines: Trust, Temperature")) << why;
}

TEST(OwnAttributes, AreRefusedInAnotherUnit) {
  EXPECT_EQ(own_of_subscriber({{"Trust", 4, "K", false}}),
            "Trust is a number without a unit; here is K");
  EXPECT_EQ(own_of_subscriber({{"Temperature", 310, "", false}}),
            "Temperature is stated in K; here is no unit");
  EXPECT_EQ(own_of_subscriber({{"Temperature", kUnbounded, "K", false}}),
            "Temperature is too large");
}

TEST(OwnAttributes, OfAPublisherAreOfferedLikewise) {
  const auto state = with_own_attributes();
  auto request = publisher_of_user("1000");
  request.offered = {{"Trust", 2, "", false}};
  const auto asked = understand(state, request, 1);
  ASSERT_TRUE(asked) << asked.error().text;
  EXPECT_EQ(asked->admission->publisher->user,
            (core::UserValues{{.attribute = 0, .dynamic = false, .value = 2}}));
}

}  // namespace
}  // namespace mlcca
