// SPDX-License-Identifier: BSD-2-Clause
#include "tools/doctor/device.hpp"

#include <gtest/gtest.h>
#include <linux/can/netlink.h>

#include "tests/tools/doctor/devices.hpp"
#include "tools/doctor/probe.hpp"

namespace mlcca::doctor {
namespace {

using test::controller;
using test::line;
using test::virtual_bus;

Outcome outcome(const Device& device, const std::string& check) {
  return line(judge(device), check).outcome;
}
std::string text(const Device& device, const std::string& check) {
  return line(judge(device), check).text;
}

TEST(DeviceTest, AGoodControllerIsOkInEverything) {
  for (const Line& l : judge(controller())) EXPECT_EQ(l.outcome, Outcome::ok) << l.check << l.text;
  EXPECT_EQ(text(controller(), "bit rate"), "500000 bit/s, sample point 87.5 %");
}

TEST(DeviceTest, NothingOfAVirtualBusFails) {
  EXPECT_FALSE(any_failed(judge(virtual_bus())));
  for (const char* check : {"modes", "state", "restart", "clock", "bit rate"})
    EXPECT_EQ(outcome(virtual_bus(), check), Outcome::not_tested) << check;
}

TEST(DeviceTest, AControllerWithoutABitRateFails) {
  auto device = controller();
  device.link.bitrate = 0;
  EXPECT_EQ(outcome(device, "bit rate"), Outcome::failed);
  EXPECT_TRUE(why_not_send(device, true));
}

TEST(DeviceTest, FdNeedsADataBitRate) {
  EXPECT_EQ(outcome(test::fd_controller(), "bit rate"), Outcome::ok);
  auto device = controller();
  device.controller.fd = true;
  EXPECT_EQ(outcome(device, "bit rate"), Outcome::failed);
}

struct ModeCase {
  std::uint32_t mode;
  Outcome outcome;
};
class ModeTest : public ::testing::TestWithParam<ModeCase> {};

TEST_P(ModeTest, WhatKeepsFramesFromTheBusFails) {
  auto device = controller();
  device.controller.modes = GetParam().mode;
  EXPECT_EQ(outcome(device, "modes"), GetParam().outcome);
}

INSTANTIATE_TEST_SUITE_P(All, ModeTest,
                         ::testing::Values(ModeCase{0, Outcome::ok},
                                           ModeCase{CAN_CTRLMODE_LOOPBACK, Outcome::failed},
                                           ModeCase{CAN_CTRLMODE_LISTENONLY, Outcome::failed},
                                           ModeCase{CAN_CTRLMODE_ONE_SHOT, Outcome::failed},
                                           ModeCase{CAN_CTRLMODE_PRESUME_ACK, Outcome::failed},
                                           ModeCase{CAN_CTRLMODE_FD_NON_ISO, Outcome::failed},
                                           ModeCase{CAN_CTRLMODE_FD, Outcome::ok},
                                           ModeCase{CAN_CTRLMODE_3_SAMPLES, Outcome::ok},
                                           ModeCase{CAN_CTRLMODE_BERR_REPORTING, Outcome::ok}));

TEST(DeviceTest, OnlyErrorActiveIsAGoodState) {
  for (const char* state : {"error-warning", "error-passive", "bus-off", "sleeping"}) {
    auto device = controller();
    device.link.can_state = state;
    EXPECT_EQ(outcome(device, "state"), Outcome::failed) << state;
  }
  auto device = controller();
  device.link.up = false;
  device.link.can_state = "stopped";
  EXPECT_EQ(outcome(device, "state"), Outcome::not_tested);
}

TEST(DeviceTest, ARestartByItselfIsAWarning) {
  auto device = controller();
  EXPECT_EQ(text(device, "restart").find("WARNING"), std::string::npos);
  device.controller.restart_ms = 100;
  EXPECT_NE(text(device, "restart").find("WARNING"), std::string::npos);
}

TEST(DeviceTest, FramesAreSentOnlyWhereTheyCanArrive) {
  EXPECT_FALSE(why_not_send(controller(), true));
  EXPECT_FALSE(why_not_send(virtual_bus(), true));
  EXPECT_TRUE(why_not_send(controller(), false));
  auto device = controller();
  device.link.up = false;
  EXPECT_TRUE(why_not_send(device, true));
  device = controller();
  device.link.can_state = "bus-off";
  EXPECT_TRUE(why_not_send(device, true));
  device = controller();
  device.controller.modes = CAN_CTRLMODE_LISTENONLY;
  EXPECT_TRUE(why_not_send(device, true));
}

TEST(DeviceTest, AGateIsInTheWayUnlessItDropsNothing) {
  auto device = controller();
  device.gate = Gate::enforcing;
  EXPECT_TRUE(why_not_send(device, true));
  EXPECT_EQ(outcome(device, "gate"), Outcome::not_tested);
  device.gate = Gate::audit;
  EXPECT_FALSE(why_not_send(device, true));
  EXPECT_EQ(outcome(device, "gate"), Outcome::ok);
  device.gate = Gate::unknown;
  EXPECT_EQ(outcome(device, "gate"), Outcome::not_tested);
}

TEST(IdentifierTest, HasElevenBitsUpTo7FFAndElse29) {
  EXPECT_FALSE(read_identifier("7FF")->extended);
  EXPECT_TRUE(read_identifier("800")->extended);
  EXPECT_EQ(read_identifier("0x1fffffff")->value, 0x1fffffffU);
  for (const char* wrong : {"20000000", "", "0x", "7FG", "-1", "123456789"})
    EXPECT_FALSE(read_identifier(wrong)) << wrong;
}

TEST(LineTest, TextAndJsonSayTheSame) {
  const std::vector<Line> lines = {{"echo", Outcome::ok, "10 of 10"},
                                   {"bus-off", Outcome::not_tested, "no \"short\""},
                                   {"bit rate", Outcome::failed, "none"}};
  EXPECT_EQ(to_text(lines),
            "echo      ok: 10 of 10\n"
            "bus-off   not tested: no \"short\"\n"
            "bit rate  FAILED: none\n"
            "1 ok, 1 failed, 1 not tested\n");
  EXPECT_EQ(to_json("can0", lines),
            R"({"interface":"can0","ok":1,"failed":1,"not_tested":1,"checks":[)"
            R"({"check":"echo","outcome":"ok","text":"10 of 10"},)"
            R"({"check":"bus-off","outcome":"not tested","text":"no \"short\""},)"
            R"({"check":"bit rate","outcome":"FAILED","text":"none"}]})"
            "\n");
  EXPECT_TRUE(any_failed(lines));
  EXPECT_FALSE(any_failed(std::span(lines).first(2)));
}

}  // namespace
}  // namespace mlcca::doctor
