// SPDX-License-Identifier: BSD-2-Clause
// What generated code says of numbers that were computed for a channel which is refused.
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/design/describe/program.hpp"
#include "tests/tools/design/generate/systems.hpp"

namespace mlcca::test {
namespace {

/// The generated header of the bus.
std::string header_of(const std::string& system) {
  const Folder folder;
  const auto out = folder.path("generated");
  const Ran ran = run({"generate", folder.write("system.xml", system), "--out", out});
  EXPECT_EQ(ran.status, 0) << ran.out << ran.error;
  return content_of(out + "/bus_channels.hpp");
}

TEST(GenerateComputedTest, WhatADeadlineAllowsIsNotPresentedAsResponseTimes) {
  const auto header = header_of(on_a_bus("20000", one_more(true, true)));
  EXPECT_TRUE(header.contains(
      "from 20 kbit/s: the channel is refused there, and Latency and Jitter are what its deadline\n"
      "/// allows, not response times.\nstruct BusForMore"))
      << header;
}

/// What the bus gives is computed for each channel: nothing names what it states itself.
TEST(GenerateComputedTest, WhatStatesNothingAndIsNotNamedIsLeftOut) {
  const auto header = header_of(on_a_bus("500000", one_more(true, true)));
  EXPECT_FALSE(header.contains("AttributeList<>")) << header;
  EXPECT_FALSE(header.contains("struct Bus {")) << header;
  EXPECT_TRUE(header.contains("struct BusFor")) << header;
}

TEST(GenerateComputedTest, OfAChannelThatIsRefusedForSomethingElseTheyAreResponseTimes) {
  auto text = on_a_bus("500000", one_more(true, true));
  // The bus states no Omission, so none is promised.
  const auto at = text.find("<Attributes>");
  ASSERT_NE(at, std::string::npos);
  text.insert(at + 12, "<Attribute><Name>Omission</Name><Value>0</Value></Attribute>");
  const auto header = header_of(text);
  EXPECT_TRUE(
      header.contains("the response times of the messages that are granted: the channel\n"
                      "/// is refused, but not for these.\nstruct BusFor"))
      << header;
}

}  // namespace
}  // namespace mlcca::test
