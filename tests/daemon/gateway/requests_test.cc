// SPDX-License-Identifier: BSD-2-Clause
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "core/admission/state.hpp"
#include "daemon/gateway/requests/asked.hpp"
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

}  // namespace
}  // namespace mlcca
