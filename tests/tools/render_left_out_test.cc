// SPDX-License-Identifier: BSD-2-Clause
// What a delivery, or a reply about many of them, does not list, and what is not shown at all.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tests/control/messages.hpp"
#include "tools/json.hpp"
#include "tools/render.hpp"

namespace mlcca::tools {
namespace {

TEST(RenderLeftOutTest, SaysHowManyComparisonsAndDeliveriesAreLeftOut) {
  auto channel = test::granted_channel();
  channel.rows_left_out = 12;
  EXPECT_NE(explain({{channel}}, Color::no, false).find("\n  and 12 more comparisons\n"),
            std::string::npos);
  EXPECT_TRUE(explain({{channel}, 99}, Color::no, false)
                  .ends_with("\n\nand 99 more deliveries, all granted\n"));
  channel.granted = false;
  EXPECT_NE(explain({{channel}}, Color::no, false)
                .find("\n  and 12 more comparisons; those that do not fit go first\n"),
            std::string::npos);
  EXPECT_TRUE(explain({{channel}, 1}, Color::no, false)
                  .ends_with("\n\nand 1 more delivery; what is refused is listed first\n"));
}

TEST(RenderLeftOutTest, JsonHasTheNumbers) {
  auto channel = test::granted_channel();
  channel.rows_left_out = 12;
  const std::string text = to_json(control::Reply{1, control::Channels{{channel}, 99}});
  EXPECT_NE(text.find("\"rows_left_out\":12"), std::string::npos) << text;
  EXPECT_NE(text.find("\"left_out\":99"), std::string::npos) << text;
}

TEST(RenderLeftOutTest, AdmissionsThatCarryNothingAreNamedWhereChannelsAreListed) {
  const control::LeftOutAdmission admission{7, "camera", "there is no network lan"};
  const std::string line = "left out  admission 7 of camera: there is no network lan\n";
  control::Channels channels;
  channels.admissions_left_out = {admission};
  EXPECT_TRUE(render(channels, Color::no)
                  .starts_with("no channel has a publisher and a subscriber\n\n" + line));
  EXPECT_TRUE(explain(channels, Color::no, true).starts_with(line));
  channels.channels = {test::granted_channel()};
  EXPECT_TRUE(render(channels, Color::no).contains("\n\n" + line));
  EXPECT_TRUE(explain(channels, Color::no, true).contains("\n\n" + line));
  EXPECT_TRUE(to_json({1, channels})
                  .contains(R"("admissions_left_out":[{"admission":7,"channel":"camera",)"
                            R"("reason":"there is no network lan"}])"));
}

/// Output is kept in logs, and a key is for granted publishers alone.
TEST(RenderLeftOutTest, JsonHasNoKeyOfAReceiver) {
  control::Channels channels;
  channels.endpoints.emplace_back().local = "0a1b20123456789abcdef";
  const std::string text = to_json(control::Reply{1, std::move(channels)});
  EXPECT_NE(text.find(R"("local":"0a1b2")"), std::string::npos) << text;
}

TEST(RenderLeftOutTest, WhatNobodyCountsIsNotZero) {
  auto channel = test::granted_channel();
  channel.crosses_no_gate = true;
  const auto table = render(control::Channels{{channel}}, Color::no);
  EXPECT_TRUE(table.contains("  -        0  ")) << table;
  const auto text = explain({{channel}}, Color::no, true);
  EXPECT_TRUE(text.contains("not counted: they cross no gate of this gateway")) << text;
  const std::string json = to_json({0, control::Channels{{channel}}});
  EXPECT_TRUE(json.contains("\"passed\":null")) << json;
  EXPECT_TRUE(json.contains("\"crosses_no_gate\":true")) << json;
  channel.crosses_no_gate = false;
  EXPECT_TRUE(to_json({0, control::Channels{{channel}}}).contains("\"passed\":12"));
}

TEST(RenderLeftOutTest, SaysThatSilenceOfASporadicChannelMeansNothing) {
  auto channel = test::granted_channel();
  EXPECT_FALSE(explain({{channel}}, Color::no, true).contains("arrival"));
  EXPECT_TRUE(to_json({0, control::Channels{{channel}}}).contains("\"sporadic\":false"));
  channel.sporadic = true;
  const auto text = explain({{channel}}, Color::no, false);
  EXPECT_TRUE(text.contains(
      "  arrival      sporadic: events come when something happens, and silence means nothing\n"))
      << text;
  EXPECT_TRUE(to_json({0, control::Channels{{channel}}}).contains("\"sporadic\":true"));
}

TEST(RenderLeftOutTest, AWithdrawalNamesWhatALongAnswerLeavesOut) {
  control::Channels channels{{test::refused_channel(), test::granted_channel()}};
  channels.left_out = 3;
  const auto some = what_stops(channels, "a", Color::no);
  EXPECT_TRUE(some.starts_with("a, once it is withdrawn: 4 deliveries stop; ")) << some;
  EXPECT_TRUE(some.ends_with("  and 3 more that are not listed\n")) << some;
  channels.channels.pop_back();
  EXPECT_TRUE(
      what_stops(channels, "a", Color::no)
          .starts_with(
              "a, once it is withdrawn: up to 3 deliveries stop, none of which is listed; "))
      << "what is refused is listed first";
}

}  // namespace
}  // namespace mlcca::tools
