// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/generate/names.hpp"

#include <gtest/gtest.h>

namespace mlcca::tools::design {
namespace {

TEST(NamesTest, TypesAreInCamelCase) {
  EXPECT_EQ(type_name("emergency-switch"), "EmergencySwitch");
  EXPECT_EQ(type_name("robotCan.2nd_bus"), "RobotCan2ndBus");
  EXPECT_EQ(type_name("CAN"), "Can");
  EXPECT_EQ(type_name("NULL"), "Null");
  EXPECT_EQ(type_name("0xA4EF"), "Subject_a4ef");
  EXPECT_EQ(type_name("0xa4ef@robot-can#2"), "Subject_a4efRobotCan2");
  EXPECT_EQ(type_name("switch@robot-can#2"), "SwitchRobotCan2");
}

TEST(NamesTest, SmallNamesAreNoKeywords) {
  EXPECT_EQ(small_name("Emergency-Switch"), "emergency_switch");
  EXPECT_EQ(small_name("switch"), "switch_");
  EXPECT_EQ(small_name("mlcca"), "mlcca_");
  EXPECT_EQ(small_name("uint8_t"), "uint8_t_");
  EXPECT_EQ(small_name("Size-T"), "size_t_");
  EXPECT_EQ(small_name("a--b__c-"), "a_b_c");
}

TEST(NamesTest, ANameIsGivenOnce) {
  Names names;
  EXPECT_EQ(names.take("Motor"), "Motor");
  EXPECT_EQ(names.take("motor"), "motor_2");
  EXPECT_EQ(names.take("Motor"), "Motor_3");
  EXPECT_EQ(names.take("Motor_2"), "Motor_2_2");
  EXPECT_EQ(names.take("switch_"), "switch_");
  EXPECT_EQ(names.take("switch_"), "switch_2");
}

TEST(NamesTest, CommentsStayComments) {
  EXPECT_EQ(comment_text("stop"), "\"stop\"");
  EXPECT_EQ(comment_text("a\nb\\"), "\"a b/\"");
  EXPECT_EQ(comment_text("what?\?/"), "\"what?./\"");
  EXPECT_EQ(comment_text("a\xe2\x80\xaez"), "\"a z\"");
  EXPECT_EQ(comment_text("\xc3\xa4"), "\"\xc3\xa4\"");
}

}  // namespace
}  // namespace mlcca::tools::design
