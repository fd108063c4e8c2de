// SPDX-License-Identifier: BSD-2-Clause
// Tests of `mlccactl --json top`: each line has what has changed since the line before.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/control/messages.hpp"
#include "tests/control/server.hpp"
#include "tests/tools/run.hpp"
#include "tools/top/changes.hpp"

namespace mlcca::tools::top {
namespace {

using Json = nlohmann::json;

control::Channel delivery(const std::string& publisher, std::uint64_t passed) {
  control::Channel c;
  c.subject = 0x10;
  c.publisher = publisher;
  c.from = "second-can";
  c.to = "robot-can";
  c.passed = passed;
  c.watch = control::Watch{.period_ns = 50'000'000, .events = passed, .since_last_ns = 7};
  return c;
}

Sample sample(std::vector<control::Channel> channels, std::uint64_t came_in = 5) {
  Sample s;
  s.channels.channels = std::move(channels);
  control::Interface i;
  i.name = "can0";
  i.ingress.passed = came_in;
  i.ingress.reasons = {{.reason = "no-slot", .frames = 3}};
  s.status.interfaces = {i};
  return s;
}

TEST(TopChanges, TheFirstLineHasEverything) {
  Changes changes;
  const std::string text = changes.line(sample({delivery("a", 1), delivery("b", 2)}), 42);
  EXPECT_EQ(text.find('\n'), text.size() - 1);
  const auto line = Json::parse(text);
  EXPECT_EQ(line["taken_unix_ns"], 42);
  EXPECT_EQ(line["deliveries"].size(), 2U);
  EXPECT_EQ(line["deliveries"][1],
            Json::parse(R"({"subject": "0x0000000000000010", "publisher": "b",
      "admission": 0, "from": "second-can", "to": "robot-can"})"));
  ASSERT_EQ(line["counters"].size(), 2U);
  EXPECT_EQ(line["counters"][1]["delivery"], 1);
  EXPECT_EQ(line["counters"][1]["passed"], 2);
  EXPECT_EQ(line["counters"][1]["watch"]["events"], 2);
  EXPECT_EQ(line["counters"][1]["watch"]["last_gap_ns"], nullptr);
  EXPECT_EQ(line["interfaces"][0]["ingress"]["reasons"]["no-slot"], 3);
}

TEST(TopChanges, LaterLinesHaveWhatChanged) {
  Changes changes;
  static_cast<void>(changes.line(sample({delivery("a", 1), delivery("b", 2)}), 1));
  auto aged = delivery("a", 1);
  aged.watch->since_last_ns = 1'000'000'007;
  auto line = Json::parse(changes.line(sample({aged, delivery("b", 3)}), 2));
  EXPECT_FALSE(line.contains("deliveries"));
  ASSERT_EQ(line["counters"].size(), 1U) << "that time goes by is no change";
  EXPECT_EQ(line["counters"][0]["delivery"], 1);
  EXPECT_TRUE(line["interfaces"].empty());
  line = Json::parse(changes.line(sample({aged, delivery("b", 3)}, 6), 3));
  EXPECT_TRUE(line["counters"].empty());
  ASSERT_EQ(line["interfaces"].size(), 1U);
  EXPECT_EQ(line["interfaces"][0]["name"], "can0");
  EXPECT_EQ(line["interfaces"][0]["ingress"]["passed"], 6);
}

TEST(TopChanges, ASilenceThatBeginsIsAChangeAndItsAgeIsNone) {
  Changes changes;
  auto c = delivery("a", 1);
  auto line = Json::parse(changes.line(sample({c}), 1));
  EXPECT_EQ(line["counters"][0]["watch"]["silent_ns"], nullptr);
  c.watch->silent_ns = 2'000'000'000;
  line = Json::parse(changes.line(sample({c}), 2));
  ASSERT_EQ(line["counters"].size(), 1U);
  EXPECT_EQ(line["counters"][0]["watch"]["silent_ns"], 2'000'000'000U);
  c.watch->silent_ns = 3'000'000'000;
  EXPECT_TRUE(Json::parse(changes.line(sample({c}), 3))["counters"].empty());
}

TEST(TopChanges, OtherDeliveriesAreNamedWithAllCounters) {
  Changes changes;
  static_cast<void>(changes.line(sample({delivery("a", 1), delivery("b", 2)}), 1));
  const auto line = Json::parse(changes.line(sample({delivery("a", 1), delivery("c", 2)}), 2));
  EXPECT_EQ(line["deliveries"].size(), 2U);
  EXPECT_EQ(line["counters"].size(), 2U);
}

TEST(TopChanges, WhatNoGateCountsHasNoFrames) {
  Changes changes;
  auto c = delivery("a", 0);
  c.crosses_no_gate = true;
  EXPECT_EQ(Json::parse(changes.line(sample({c}), 1))["counters"][0]["passed"], nullptr);
}

// --- the program
// -----------------------------------------------------------------------------------

TEST(TopChanges, AreOneLineForEachPoll) {
  test::Server server(
      [passed = std::make_shared<std::uint64_t>(0)](const control::Request& request) {
        control::Reply reply{0, test::full_status()};
        if (std::holds_alternative<control::ChannelsRequest>(request.body)) {
          auto channel = test::granted_channel();
          channel.passed = *passed += 100;
          reply.body = control::Channels{{channel, test::refused_channel()}};
        }
        return test::Server::Answer{{reply}};
      });
  const auto outcome =
      test::run_mlccactl({"--socket", server.path(), "--json", "top", "-d", "0.1", "-n", "3"});
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  std::vector<Json> lines;
  for (std::size_t at = 0; at < outcome.out.size();) {
    const auto end = outcome.out.find('\n', at);
    lines.push_back(Json::parse(outcome.out.substr(at, end - at)));
    at = end + 1;
  }
  ASSERT_EQ(lines.size(), 3U) << outcome.out;
  EXPECT_EQ(lines[0]["counters"].size(), 2U);
  ASSERT_EQ(lines[2]["counters"].size(), 1U);
  EXPECT_EQ(lines[2]["counters"][0]["passed"], 300);
}

TEST(TopChanges, WithoutADaemonThereIsAnError) {
  const auto outcome = test::run_mlccactl({"--socket", "/nowhere/at/all", "--json", "top"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_TRUE(Json::parse(outcome.out).contains("error")) << outcome.out;
}

}  // namespace
}  // namespace mlcca::tools::top
