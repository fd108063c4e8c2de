// SPDX-License-Identifier: BSD-2-Clause
// What a person sees, and what a program sees, of the same replies.
#include "tools/render.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/control/messages.hpp"
#include "tools/json.hpp"

namespace mlcca::tools {
namespace {

using control::Reply;
using Json = nlohmann::json;

struct RenderTest : testing::Test {
  RenderTest() {
    ::setenv("TZ", "UTC", 1);  // NOLINT(concurrency-mt-unsafe)
    ::tzset();
  }
};

Json json_of(const Reply& reply) {
  const auto text = to_json(reply);
  EXPECT_EQ(text.find('\n'), text.size() - 1) << "one line";
  return Json::parse(text, nullptr, false);
}

TEST_F(RenderTest, ExplainsARefusalAttributeByAttribute) {
  EXPECT_EQ(
      explain({{test::refused_channel()}}, Color::no, true),
      R"(refused  emergency-switch (0xa4efeccc3210b497) from second-can to robot-can: Omission 2 required, bridge provides 5 (3 too many)
  WHERE       ATTRIBUTE   REQUIRED       PROVIDED  OUTCOME              MARGIN
  second-can  Period         50 ms        12.5 ms  fit                  37.5 ms to spare
  bridge      Omission           2              5  unfit                3 too many
  robot-can   PacketLoss     0.5 %  at best 0.1 %  decided at run time  0.4 % to spare
  end to end  Bandwidth   400 kB/s        nothing  unfit                not provided
  route        second-can > bridge > robot-can
  publisher    switch
  subscribers  motor-left, motor-right
  frames       12 passed, 345 dropped
)");
}

TEST_F(RenderTest, NamesTheAdmissionThatCanBeReleased) {
  const auto text = explain({{test::granted_channel()}}, Color::no, false);
  EXPECT_TRUE(text.starts_with(
      "granted  emergency-switch (0xa4efeccc3210b497) from robot-can to robot-can: "));
  EXPECT_NE(text.find("  admission    7 (mlccactl release --id 7 takes it back)\n"),
            std::string::npos);
  EXPECT_EQ(text.find("passed"), std::string::npos);
}

TEST_F(RenderTest, StartsEachDeliveryWithItsVerdict) {
  const auto text =
      explain({{test::refused_channel(), test::granted_channel()}}, Color::yes, false);
  EXPECT_TRUE(text.starts_with("\x1b[1;31mrefused\x1b[0m  "));
  EXPECT_NE(text.find("\n\n\x1b[32mgranted\x1b[0m  "), std::string::npos);
}

TEST_F(RenderTest, AnswersAQuestionAboutNothing) {
  EXPECT_TRUE(explain({}, Color::no, false).starts_with("refused  nothing to deliver"));
}

TEST_F(RenderTest, ListsDeliveries) {
  EXPECT_EQ(
      render(control::Channels{{test::refused_channel(), test::granted_channel()}}, Color::no),
      R"(CHANNEL           SUBJECT             FROM        TO         VERDICT  PASSED  DROPPED  ADMISSION  REASON
emergency-switch  0xa4efeccc3210b497  second-can  robot-can  refused      12      345             Omission 2 required, bridge provides 5 (3 too many)
emergency-switch  0xa4efeccc3210b497  robot-can   robot-can  granted      12        0          7  Period 50 ms required, the route provides 12.5 ms (37.5 ms to spare)
)");
}

TEST_F(RenderTest, ShowsTheGatewayAsItIs) {
  EXPECT_EQ(render(test::full_status(), Color::no),
            R"(gateway      bridge of robot
mlccad       0.1.0, since 2023-11-14 22:13:20
description  /etc/mlcca/system.xml, read 2023-11-14 22:15:00
gate         open: verdicts are in force
mode         enforce
channels     3 granted, 1 refused
grace        10 s, lapsed 2 times
problem      can1 is missing
last reload  system.xml:7: <Period>: not a number

INTERFACE  NETWORK     PROFILE  LINK    CAN STATE        BITRATE  GATE  SLOTS  IN PASSED  IN DROPPED  OUT PASSED  OUT DROPPED  MANAGED  IDENTITY
can0       robot-can   famouso  up      ERROR-ACTIVE  500 kbit/s  held      4       1001          22        2002           33  yes      name can0
can1       second-can           absent                                      0          0           0           0            0
can0: queue is full
can1: no such interface

frames by reason
  INTERFACE  DIRECTION  REASON   FRAMES
  can0       in         unknown      21
  can0       in         length        1
  can0       out        source        3

unknown frames, last seen first
  INTERFACE  DIRECTION  IDENTIFIER  FORMAT   LENGTH  FRAMES
  can0       in         18ffa533    classic       8      19
  can0       out        123         FD           64       2
)");
}

TEST_F(RenderTest, SaysAuditModeFirstAndLoudly) {
  auto status = test::full_status();
  status.mode = "audit";
  EXPECT_TRUE(
      render(status, Color::yes)
          .starts_with("\x1b[1;31mAUDIT MODE: nothing is dropped, unfit data passes\x1b[0m\n"));
}

TEST_F(RenderTest, SaysThatAClosedGateDeniesEverything) {
  auto status = test::full_status();
  status.open = false;
  EXPECT_NE(render(status, Color::no).find("gate         CLOSED: everything is denied\n"),
            std::string::npos);
}

TEST_F(RenderTest, SaysThatAnInterfaceIsNotHeld) {
  auto status = test::full_status();
  status.interfaces[0].gated = false;
  EXPECT_NE(render(status, Color::no).find("NOT HELD"), std::string::npos);
}

TEST_F(RenderTest, ShowsWhatNetworksProvideAndWhatIsReserved) {
  EXPECT_EQ(
      render(test::full_networks(), Color::no),
      R"(NETWORK    KIND  PROFILE  STATE       RESERVED  CAPACITY  GATEWAYS               PROVISION
robot-can  can   famouso  usable       160 B/s   40 kB/s  bridge, second-bridge  Latency 5 ms, Omission at best 5
mesh       mesh  none     not usable     0 B/s   unknown
mesh: wlan0 is down
)");
}

TEST_F(RenderTest, PrintsAnEventOnOneLine) {
  EXPECT_EQ(
      render(test::full_event(), Color::no),
      "2023-11-14 22:13:20.123  refused    emergency-switch (0xa4efeccc3210b497) on robot-can: "
      "Omission 2 required, bridge provides 5\n");
  auto event = test::full_event();
  event.kind = "mode";
  event.subject = 0;
  event.network.clear();
  event.message = "audit\nmode";
  EXPECT_EQ(render(event, Color::no), "2023-11-14 22:13:20.123  mode       audit?mode\n");
}

TEST_F(RenderTest, PrintsEveryDetailOfAnError) {
  EXPECT_EQ(render(control::Error{control::ErrorKind::unreadable, "2 errors", {"a:1: x", "a:2: y"}},
                   Color::no),
            "mlccactl: 2 errors\n  a:1: x\n  a:2: y\n");
}

struct JsonTest : testing::TestWithParam<test::NamedReply> {};

TEST_P(JsonTest, IsOneObjectOnOneLine) {
  const auto json = json_of(GetParam().reply);
  EXPECT_TRUE(json.is_object());
}

INSTANTIATE_TEST_SUITE_P(All, JsonTest, testing::ValuesIn(test::all_replies()),
                         [](const auto& row) { return row.param.name; });

TEST(JsonFieldsTest, CarryTheNamesAndUnitsOfTheProtocol) {
  const auto json = json_of({1, control::Channels{{test::refused_channel()}}});
  const auto& channel = json.at("channels").at(0);
  EXPECT_EQ(channel.at("subject"), "0xa4efeccc3210b497");
  EXPECT_EQ(channel.at("granted"), false);
  EXPECT_EQ(channel.at("route"), (Json{"second-can", "bridge", "robot-can"}));
  EXPECT_EQ(channel.at("rows").at(1), Json::parse(R"({"where": "bridge", "attribute": "Omission",
      "unit": "events", "required": 2, "provided": 5, "dynamic": false, "outcome": "unfit",
      "margin": "3 too many"})"));
  EXPECT_TRUE(channel.at("rows").at(3).at("provided").is_null());
  EXPECT_EQ(channel.at("rows").at(2).at("outcome"), "run-time");
}

TEST(JsonFieldsTest, SayUnboundedWhereNumbersWouldLie) {
  auto status = test::full_status();
  status.grace_ns = ~std::uint64_t{0};
  EXPECT_EQ(json_of({1, status}).at("grace_ns"), "unbounded");
  status.grace_ns = (std::uint64_t{1} << 53U) - 1;
  EXPECT_EQ(json_of({1, status}).at("grace_ns"), (std::uint64_t{1} << 53U) - 1);
}

TEST(JsonFieldsTest, AreNullWhereNothingIsKnown) {
  const auto json = json_of({1, test::full_networks()});
  EXPECT_EQ(json.at("networks").at(0).at("capacity"), 40'000);
  EXPECT_TRUE(json.at("networks").at(1).at("capacity").is_null());
}

TEST(JsonFieldsTest, SurviveTextThatIsNotUtf8) {
  EXPECT_EQ(json_of({1, control::Done{"\xff"}}).at("message"), "\ufffd");
}

TEST(JsonFieldsTest, NameTheKindOfAnError) {
  const auto json =
      json_of({1, control::Error{control::ErrorKind::unreadable, "bad", {"a.xml:1: x"}}});
  EXPECT_EQ(json, Json::parse(R"({"error": {"kind": "unreadable", "message": "bad",
                                            "details": ["a.xml:1: x"]}})"));
}

}  // namespace
}  // namespace mlcca::tools
