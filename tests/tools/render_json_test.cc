// SPDX-License-Identifier: BSD-2-Clause
// Tests of the JSON of replies: fields have the names and units of the protocol.
#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/control/messages.hpp"
#include "tests/tools/json_of.hpp"
#include "tools/render.hpp"

namespace mlcca::tools {
namespace {

using Json = nlohmann::json;

struct JsonTest : ::testing::TestWithParam<test::NamedReply> {};

TEST_P(JsonTest, IsOneObjectOnOneLine) {
  const auto json = json_of(GetParam().reply);
  EXPECT_TRUE(json.is_object());
}

INSTANTIATE_TEST_SUITE_P(All, JsonTest, ::testing::ValuesIn(test::all_replies()),
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
  EXPECT_EQ(channel.at("margin"), Json::parse(R"({"where": "bridge", "attribute": "Omission",
      "unit": "events", "outcome": "unfit", "amount": 3, "words": "3 too many"})"));
  EXPECT_TRUE(channel.at("rows").at(3).at("provided").is_null());
  EXPECT_EQ(channel.at("rows").at(2).at("outcome"), "run-time");
}

TEST(JsonFieldsTest, ReportHowWatchedEventsComeAndNullOfOthers) {
  const auto json =
      json_of({1, control::Channels{{test::granted_channel(), test::refused_channel()}}});
  EXPECT_EQ(json.at("channels").at(0).at("watch"), Json::parse(R"({"period_ns": 50000000,
      "timeout_ns": 162075000, "missing_now": true, "events": 1001, "missing": 4,
      "since_last_ns": 200000000, "last_gap_ns": 49000000, "shortest_gap_ns": 44000000,
      "longest_gap_ns": 101000000, "jitter_ns": 6000000, "rate_millihertz": 19975, "shared": false,
      "silent_ns": 200000000,
      "gaps": [0, 0, 0, 0, 0, 0, 0, 499, 500, 0, 0, 0, 0, 0, 0, 1]})"));
  EXPECT_TRUE(json.at("channels").at(1).at("watch").is_null());
  EXPECT_EQ(json.at("channels").at(0).at("problems"),
            Json::parse(R"(["nothing has come for 200 ms: 4 events are missing"])"));
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

TEST(JsonFieldsTest, ReportWhatMediaGiveAndNullOfOtherMedia) {
  const auto json = json_of({1, control::Channels{{test::switched_channel()}}});
  const auto& channel = json.at("channels").at(0);
  EXPECT_EQ(channel.at("set"), 1);
  EXPECT_EQ(channel.at("sets"), 2);
  EXPECT_EQ(channel.at("importance"), 9);
  EXPECT_EQ(channel.at("media"), Json::parse(R"([
      {"network": "awds", "response_ns": null, "guaranteed_ns": null, "path_rate": 942857,
       "available": 600000, "limited_by": "all links", "path": ["laptop", "relay", "control"]},
      {"network": "robot-can", "response_ns": 310000, "guaranteed_ns": 5000000,
       "path_rate": null, "available": null, "limited_by": "", "path": []}])"));
}

TEST(JsonFieldsTest, ReportRoutesAndLinks) {
  const auto json = json_of({1, test::full_routes()});
  const auto& route = json.at("routes").at(1);
  EXPECT_EQ(route, Json::parse(R"({"from": "second-can", "to": "awds", "route": [], "granted": 0,
      "refused": 3, "media": [], "problem": "no gateway leads there"})"));
  EXPECT_EQ(json.at("links"), Json::parse(R"([
      {"network": "awds", "from": "laptop", "to": "relay", "rate": 24000000,
       "believed_rate": 22500000, "kind": "phy", "loss": 12500000, "busy": 43000,
       "age_ns": 1250000000, "stale": false, "state": "", "source": "nl80211 mesh0"},
      {"network": "awds", "from": "relay", "to": "02:00:00:00:00:03", "rate": null,
       "believed_rate": 0, "kind": "derived", "loss": null, "busy": null,
       "age_ns": 60000000000, "stale": true, "state": "stale", "source": "awds eth1"}])"));
  EXPECT_EQ(json.at("problems").size(), 2U);
  EXPECT_EQ(json.at("can_rules").at(0), Json::parse(R"({"from": "can1", "to": "can0",
      "id": 2672296036, "mask": 3758096383, "fd": true, "ours": true,
      "channel": "emergency-switch", "change": "id to 1f480065", "hops": 0,
      "handled": 7000000000, "dropped": 1, "deleted": 2})"));
}

TEST(JsonFieldsTest, ReportReservations) {
  const auto json = json_of({1, test::full_reservations()});
  EXPECT_EQ(json.at("resources").at(2), Json::parse(R"({"name": "uplink", "kind": "network",
      "unit": "bytes/s", "capacity": 300000, "reserved": 400000, "background": 0,
      "reservations": [{"channel": "video", "publisher": "camera", "amount": 400000,
        "admission": 8, "set": 1, "importance": 9, "lease_ns": 7500000000}]})"));
  EXPECT_TRUE(json.at("resources").at(3).at("capacity").is_null());
  EXPECT_TRUE(json.at("resources").at(0).at("reservations").at(0).at("lease_ns").is_null());
}

TEST(JsonFieldsTest, ReportWhatWouldBeAndWhatWas) {
  const auto what_if = json_of({1, test::full_what_if()});
  EXPECT_EQ(what_if.at("unchanged"), 12);
  EXPECT_EQ(what_if.at("outlooks").at(3), Json::parse(R"({"channel": "speech",
      "publisher": "camera", "to": "robot-can", "granted_now": true, "granted_then": false,
      "set_now": 1, "set_then": 0, "reason": "300 kB/s too much"})"));
  const auto history = json_of({1, test::full_history()});
  EXPECT_EQ(history.at("entries").at(0), Json::parse(R"({"unix_ns": 1700000100000000000,
      "kind": "degraded", "subject": "0x0000000000000010", "channel": "video", "from": "awds",
      "to": "robot-can", "network": "awds", "message": "set 2 of 2: laptop > relay is slower",
      "client": null})"));
  EXPECT_TRUE(history.at("entries").at(1).at("subject").is_null());
  EXPECT_EQ(json_of({0, test::full_event()}).at("admissions"), (Json{7, ~std::uint64_t{0}}));
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
