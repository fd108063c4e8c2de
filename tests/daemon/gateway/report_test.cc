// SPDX-License-Identifier: BSD-2-Clause
// Tests that programs can read every property of a delivery and of a network from a field, without
// parsing a line.
#include "daemon/gateway/report.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "core/admission/state.hpp"
#include "core/model/text.hpp"
#include "description/read.hpp"

namespace mlcca {
namespace {

/// A heart-beat from one bus to another, over a gateway with the stated Omission.
core::State heart_beat_state(const std::string& omission, const std::string& bus,
                             const std::string& latency = "5ms",
                             const std::string& arrival = "periodic") {
  auto system = description::read_memory(
      R"(<System name="test">
        <EventChannel name="beat" arrival=")" +
          arrival + R"("><SubjectUID>0xa1</SubjectUID>
          <Attributes period="50ms" maxPayload="8" omission="2"/></EventChannel>
        <Network name="from"><Kind>other</Kind>
          <Provision latency="1ms" period="1ms" omission="0" maxPayload="8"/></Network>
        <Network name="to"><Kind>other</Kind>
          <Provision latency=")" +
          latency + R"(" period="1ms" omission="0" maxPayload="8"/></Network>)" + bus +
          R"(<Gateway name="gate"><Provision latency="1ms" omission=")" + omission + R"("/>
          <Port network="from"><Interface name="eth0"/></Port>
          <Port network="to"><Interface name="eth1"/></Port></Gateway>
        <Publisher channel="beat" network="from"/><Subscriber channel="beat" network="to"/>
      </System>)",
      "test.xml");
  if (!system) throw std::runtime_error(to_string(system.error().front()));
  return core::State(std::move(*system));
}

control::Channel first_delivery(const core::State& state) {
  return channel_report(state, state.decisions()[0].verdicts.front(), {});
}

TEST(ChannelReport, TheMarginOfARefusalIsThatOfTheRowThatRefuses) {
  const control::Channel c = first_delivery(heart_beat_state("5", ""));
  ASSERT_FALSE(c.granted) << c.reason;
  ASSERT_TRUE(c.margin);
  EXPECT_EQ(c.margin->where, "gate");
  EXPECT_EQ(c.margin->attribute, "Omission");
  EXPECT_EQ(c.margin->unit, "events");
  EXPECT_EQ(c.margin->outcome, control::Outcome::unfit);
  EXPECT_TRUE(c.margin->amount_known);
  EXPECT_EQ(c.margin->amount, 3U);
  EXPECT_EQ(c.margin->words, "3 too many");
}

TEST(ChannelReport, SaysWhetherItsEventsAreSporadic) {
  for (const char* omission : {"2", "5"}) {
    EXPECT_FALSE(first_delivery(heart_beat_state(omission, "")).sporadic);
    EXPECT_TRUE(first_delivery(heart_beat_state(omission, "", "5ms", "sporadic")).sporadic);
  }
}

TEST(ChannelReport, TheMarginOfAGrantIsTheSmallestThatItsReasonStates) {
  const control::Channel c = first_delivery(heart_beat_state("2", "", "40ms"));
  ASSERT_TRUE(c.granted) << c.reason;
  ASSERT_TRUE(c.margin);
  EXPECT_EQ(c.margin->outcome, control::Outcome::fit);
  EXPECT_NE(c.reason.find('(' + c.margin->words + ')'), std::string::npos) << c.reason;
  EXPECT_EQ(c.reason.rfind(c.margin->attribute + ' ', 0), 0U) << c.reason;
}

TEST(ChannelReport, WhatNoComparisonHasDecidedHasNoMargin) {
  const core::State state = heart_beat_state("2", "");
  core::Verdict v = state.decisions()[0].verdicts.front();
  v.granted = false;
  v.obstacle = core::Obstacle::withdrawn;
  EXPECT_FALSE(channel_report(state, v, {}).margin);
}

TEST(NetworkReport, HasTheBitRatesThatAreDescribed) {
  const core::State state =
      heart_beat_state("2", R"(<Network name="fast"><Kind>can</Kind><Profile>raw</Profile>
        <Bus bitrate="500000" data-bitrate="2000000"/></Network>
        <Network name="bare"><Kind>can</Kind><Profile>raw</Profile></Network>)");
  EXPECT_EQ(network_report(state, 2).described_bitrate, 500'000U);
  EXPECT_EQ(network_report(state, 2).described_data_bitrate, 2'000'000U);
  EXPECT_EQ(network_report(state, 3).described_bitrate, 0U);
  EXPECT_EQ(network_report(state, 0).described_bitrate, 0U);
}

}  // namespace
}  // namespace mlcca
