// SPDX-License-Identifier: BSD-2-Clause
#include "tools/doctor/measured.hpp"

#include <gtest/gtest.h>

#include "tests/tools/doctor/devices.hpp"

namespace mlcca::doctor {
namespace {

using test::controller;
using test::fd_controller;
using test::virtual_bus;

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr core::can::WireLength kFrame{.slow = 143, .fast = 0};  // 286 us at 500 kbit/s

Single came_back(std::vector<std::uint64_t> after_us) {
  Single s{.sent_ns = kSecond, .length = kFrame, .echoes_ns = {}};
  for (const auto us : after_us) s.echoes_ns.push_back(kSecond + us * 1000);
  return s;
}

bool says(const Line& line, const std::string& part) {
  return line.text.find(part) != std::string::npos;
}

TEST(EchoTest, OnceAndNotBeforeTheFrameIsSent) {
  // 140 bits to the end of the frame: 280 us, 2 % less is tolerated.
  const std::vector good{came_back({275}), came_back({400})};
  EXPECT_EQ(judge_echo(controller(), good).outcome, Outcome::ok);
  const std::vector early{came_back({300}), came_back({274})};
  EXPECT_EQ(judge_echo(controller(), early).outcome, Outcome::failed);
  const std::vector twice{came_back({300, 301}), came_back({300})};
  EXPECT_TRUE(says(judge_echo(controller(), twice), "2 times"));
  EXPECT_EQ(judge_echo(controller(), twice).outcome, Outcome::failed);
}

TEST(EchoTest, NoneMeansThatNoNodeAcknowledges) {
  for (const auto& singles :
       {std::vector<Single>{}, std::vector{came_back({})}, {came_back({300}), came_back({})}}) {
    const auto line = judge_echo(controller(), singles);
    EXPECT_EQ(line.outcome, Outcome::failed);
    EXPECT_TRUE(says(line, "no node acknowledges"));
  }
}

TEST(EchoTest, AFrameThatIsNotTakenFails) {
  const std::vector refused{
      Single{.sent_ns = kSecond, .refused = true, .length = kFrame, .echoes_ns = {}}};
  EXPECT_EQ(judge_echo(controller(), refused).outcome, Outcome::failed);
  EXPECT_TRUE(says(judge_echo(controller(), refused), "no room"));
}

TEST(EchoTest, AnEchoOfTheKernelInTheDriversPlaceFails) {
  auto device = controller();
  device.controller.echoes = false;
  const std::vector good{came_back({300})};
  EXPECT_EQ(judge_echo(device, good).outcome, Outcome::failed);
}

TEST(EchoTest, OfAVirtualBusOnlyTheNumberIsSeen) {
  const std::vector at_once{came_back({0})};
  EXPECT_EQ(judge_echo(virtual_bus(), at_once).outcome, Outcome::not_tested);
  const std::vector none{came_back({})};
  EXPECT_EQ(judge_echo(virtual_bus(), none).outcome, Outcome::failed);
  const std::vector twice{came_back({0, 1})};
  EXPECT_EQ(judge_echo(virtual_bus(), twice).outcome, Outcome::failed);
}

/// 100 frames behind the first one, that took so much longer than their bits.
Passage passage(double off) {
  return {.sent = 101,
          .echoed = 101,
          .length = {.slow = 14'300, .fast = 0},
          .took_ns = static_cast<std::uint64_t>(28'600'000 * (1 + off))};
}

Seen passed(std::uint64_t ns, bool own) {
  Seen seen;
  seen.ns = ns;
  seen.own = own;
  seen.frame.id = 0x555;  // 11 bits, no payload
  return seen;
}

TEST(PassageTest, BeginsAndEndsWithAFrameOfOurs) {
  const auto each = core::can::wire_length(passed(0, true).frame).slow;
  PassageCount counted;
  counted.take_seen(passed(kSecond - 900, false));
  counted.take_seen(passed(kSecond, true));
  counted.take_seen(passed(kSecond + 100, false));
  EXPECT_EQ(counted.passage().took_ns, 0U);
  Seen error;
  error.error = 4;
  counted.take_seen(error);
  counted.take_seen(passed(kSecond + 200, true));
  counted.take_seen(passed(kSecond + 300, false));
  EXPECT_EQ(counted.passage().echoed, 2U);
  EXPECT_EQ(counted.passage().foreign, 1U);
  EXPECT_EQ(counted.passage().errors, 1U);
  EXPECT_EQ(counted.passage().took_ns, 200U);
  EXPECT_EQ(counted.passage().length.slow, 2 * each);
}

TEST(RateTest, IsOkWithinTheToleranceOnBothSides) {
  for (const double off : {-0.0199, 0.0, 0.0199})
    EXPECT_EQ(judge_rate(controller(), passage(off), false).outcome, Outcome::ok) << off;
  for (const double off : {-0.0201, 0.0201, 1.0, -0.5})
    EXPECT_EQ(judge_rate(controller(), passage(off), false).outcome, Outcome::failed) << off;
}

TEST(RateTest, IsTheOneThatTheFramesHad) {
  EXPECT_TRUE(says(judge_rate(controller(), passage(0), false), "500000 bit/s by 101 frames"));
  EXPECT_TRUE(says(judge_rate(controller(), passage(1), false), "250000 bit/s"));
}

TEST(RateTest, LostFramesFail) {
  auto lost = passage(0);
  lost.echoed = 99;
  EXPECT_TRUE(says(judge_rate(controller(), lost, false), "2 of 101 frames"));
  EXPECT_EQ(judge_rate(controller(), lost, false).outcome, Outcome::failed);
  EXPECT_TRUE(says(judge_rate(controller(), Passage{}, false), "no room for two frames"));
  auto at_once = passage(0);
  at_once.took_ns = 0;
  EXPECT_EQ(judge_rate(controller(), at_once, false).outcome, Outcome::failed);
}

TEST(RateTest, TheDataPhaseIsWhatTheSlowBitsLeave) {
  Passage p{.sent = 101, .echoed = 101, .length = {.slow = 5'400, .fast = 55'000}};
  p.took_ns = 10'800'000 + 27'500'000;
  const auto good = judge_rate(fd_controller(), p, true);
  EXPECT_EQ(good.outcome, Outcome::ok);
  EXPECT_TRUE(says(good, "2000000 bit/s"));
  p.took_ns = 10'800'000 + 55'000'000;
  const auto half = judge_rate(fd_controller(), p, true);
  EXPECT_EQ(half.outcome, Outcome::failed);
  EXPECT_TRUE(says(half, "1000000 bit/s"));
}

TEST(RateTest, NeedsAnEchoOfTheDriver) {
  EXPECT_FALSE(why_no_rate(controller(), false));
  EXPECT_FALSE(why_no_rate(fd_controller(), true));
  EXPECT_TRUE(why_no_rate(controller(), true)) << "no FD";
  EXPECT_TRUE(why_no_rate(virtual_bus(), false));
  auto device = controller();
  device.controller.echoes = false;
  EXPECT_TRUE(why_no_rate(device, false));
}

Filling filled(unsigned taken, unsigned left) {
  return {.taken = taken, .left = left, .echoed = taken, .refused = true};
}

TEST(DepthTest, IsWhatFitsBehindTheQueueAtTheSameTime) {
  const std::vector fillings{filled(12, 0), filled(14, 1), filled(13, 1)};
  const auto line = judge_depth(controller(), fillings, {});
  EXPECT_EQ(line.outcome, Outcome::ok);
  EXPECT_TRUE(says(line, "fifo-depth=\"3\" queue-length=\"10\"")) << line.text;
}

TEST(DepthTest, TheDescriptionMayNotSayLess) {
  const std::vector fillings{filled(13, 0)};
  EXPECT_EQ(judge_depth(controller(), fillings, 3).outcome, Outcome::ok);
  EXPECT_EQ(judge_depth(controller(), fillings, 4).outcome, Outcome::ok);
  EXPECT_EQ(judge_depth(controller(), fillings, 2).outcome, Outcome::failed);
}

TEST(DepthTest, ADescriptionHasLimits) {
  EXPECT_TRUE(says(judge_depth(controller(), std::vector{filled(10, 0)}, {}), "fifo-depth=\"1\""));
  EXPECT_EQ(judge_depth(controller(), std::vector{filled(74, 0)}, {}).outcome, Outcome::ok);
  EXPECT_EQ(judge_depth(controller(), std::vector{filled(75, 0)}, {}).outcome, Outcome::failed);
  EXPECT_EQ(judge_depth(controller(), std::vector{filled(9, 0)}, {}).outcome, Outcome::failed);
}

TEST(DepthTest, LostFramesFail) {
  auto lost = filled(13, 0);
  lost.echoed = 12;
  const auto line = judge_depth(controller(), std::vector{filled(13, 0), lost}, {});
  EXPECT_EQ(line.outcome, Outcome::failed);
  EXPECT_TRUE(says(line, "1 of 13"));
}

TEST(DepthTest, AQueueWithoutAnEndIsNotTested) {
  auto endless = filled(210, 200);
  endless.refused = false;
  EXPECT_EQ(judge_depth(controller(), std::vector{endless}, {}).outcome, Outcome::not_tested);
  EXPECT_FALSE(why_no_depth(controller()));
  EXPECT_TRUE(why_no_depth(virtual_bus()));
  auto unknown = controller();
  unknown.controller.queue_limit = 0;
  EXPECT_TRUE(why_no_depth(unknown));
}

TEST(BusOffTest, IsReportedInTwoWaysTogetherAndEnds) {
  const BusOff good{
      .frame_ns = kSecond, .link_ns = 2 * kSecond, .recovered_ns = 9 * kSecond, .seconds = 20};
  EXPECT_EQ(judge_bus_off(good).outcome, Outcome::ok);
  EXPECT_TRUE(says(judge_bus_off(good), "over 7 s later"));
  EXPECT_EQ(judge_bus_off(BusOff{}).outcome, Outcome::not_tested);
  for (auto member : {&BusOff::frame_ns, &BusOff::link_ns, &BusOff::recovered_ns}) {
    auto bad = good;
    bad.*member = {};
    EXPECT_EQ(judge_bus_off(bad).outcome, Outcome::failed);
  }
  auto apart = good;
  apart.link_ns = 3 * kSecond;
  EXPECT_EQ(judge_bus_off(apart).outcome, Outcome::ok);
  apart.link_ns = 3 * kSecond + 1;
  EXPECT_EQ(judge_bus_off(apart).outcome, Outcome::failed);
}

TEST(CountersTest, MayNotGrow) {
  const net::ErrorCounters low{.sending = 8, .receiving = 1};
  EXPECT_EQ(judge_counters(low, low).outcome, Outcome::ok);
  EXPECT_EQ(judge_counters(low, net::ErrorCounters{}).outcome, Outcome::ok);
  EXPECT_EQ(judge_counters(low, net::ErrorCounters{.sending = 9, .receiving = 1}).outcome,
            Outcome::failed);
  EXPECT_EQ(judge_counters(low, net::ErrorCounters{.sending = 8, .receiving = 2}).outcome,
            Outcome::failed);
  EXPECT_EQ(judge_counters({}, {}).outcome, Outcome::not_tested);
}

}  // namespace
}  // namespace mlcca::doctor
