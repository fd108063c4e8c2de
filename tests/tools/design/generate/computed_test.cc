// SPDX-License-Identifier: BSD-2-Clause
// What generated code says of numbers that were computed for a channel which is refused.
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/design/describe/program.hpp"
#include "tests/tools/design/generate/systems.hpp"

namespace mlcca::test {
namespace {

/// The generated header of the bus, or of another place.
std::string header_of(const std::string& system, const std::string& place = "bus") {
  const Folder folder;
  const auto out = folder.path("generated");
  const Ran ran = run({"generate", folder.write("system.xml", system), "--out", out});
  EXPECT_EQ(ran.status, 0) << ran.out << ran.error;
  return content_of(out + "/" + place + "_channels.hpp");
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

/// A stream over a link that has 584958 B/s for it, 580668 beside c.
std::string beside_c(const std::string& bandwidth) {
  return "<System name='m'><EventChannel name='c'><SubjectUID>0x1</SubjectUID><Attributes "
         "period='10ms' maxPayload='8' omission='2' deadline='50ms'/></EventChannel>"
         "<EventChannel name='big'><SubjectUID>0x2</SubjectUID><Attributes bandwidth='" +
         bandwidth +
         "'/></EventChannel><Network name='m'><Kind>mesh</Kind><Profile>famouso</Profile><Mesh>"
         "<PerHop latency='1ms' jitter='1ms' omission='1'/><Node name='n1' "
         "address='02:00:00:00:00:01' gateway='g'/><Node name='n2' address='02:00:00:00:00:02'/>"
         "<Link from='n1' to='n2' rate='6000000'/></Mesh></Network><Gateway name='g'><Provision "
         "latency='1ms' jitter='1ms' omission='0'/><Port network='m'><Interface name='bat0'/>"
         "</Port></Gateway><Publisher name='p' channel='c' gateway='g' user='nobody'/><Publisher "
         "name='pb' channel='big' gateway='g' user='nobody'/><Subscriber name='s' channel='c' "
         "network='m' mesh-node='n2'/><Subscriber name='sb' channel='big' network='m' "
         "mesh-node='n2'/></System>";
}

TEST(GenerateComputedTest, AStreamThatIsTooFastForAMeshIsHeldAgainstTheNumberOfCheck) {
  const Folder folder;
  const auto checked = run({"check", folder.write("m.xml", beside_c("900kB/s"))});
  EXPECT_TRUE(checked.out.contains("have time for 580.668 kB/s")) << checked.out;
  const auto header = header_of(beside_c("900kB/s"), "g");
  EXPECT_TRUE(header.contains("mlcca::Bandwidth<580668_bytes_per_s>")) << header;
  EXPECT_TRUE(header.contains("Bandwidth is what other channels leave.")) << header;
  EXPECT_FALSE(header.contains("584958")) << header;
}

TEST(GenerateComputedTest, WhatAMeshCarriesAloneIsNamedSo) {
  const auto header = header_of(beside_c("583kB/s"), "g");
  EXPECT_TRUE(header.contains("have time for 580.668 kB/s\")")) << header;
  EXPECT_TRUE(header.contains("Bandwidth is what they carry alone.\n")) << header;
  EXPECT_TRUE(header.contains("mlcca::Bandwidth<584958_bytes_per_s>")) << header;
}

}  // namespace
}  // namespace mlcca::test
