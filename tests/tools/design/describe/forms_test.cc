// SPDX-License-Identifier: BSD-2-Clause
// In which form mlccactl describe writes an attribute: the short one, or that which the list has.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/tools/design/describe/program.hpp"

namespace mlcca::test {
namespace {

TEST(DescribeFormsTest, WritesUnitsAsPowersOfTenAndDigitsAsTheyWereTyped) {
  struct Case {
    const char* typed;
    const char* brief;
    std::string dimension;
    const char* value;
  };
  const std::string time = "<SIUnit><Seconds>1</Seconds></SIUnit>";
  const std::string rate = "<SIUnit><Seconds>-1</Seconds><Bytes>1</Bytes></SIUnit>";
  const std::vector<Case> cases = {
      {"Period=50ms", "period=\"50ms\"", time + "<Magnitude>-3</Magnitude>", "50"},
      {"Period=0.05s", "period=\"0.05s\"", time, "0.05"},
      {"Latency=012.50us", "latency=\"12.5us\"", time + "<Magnitude>-6</Magnitude>", "12.5"},
      {"Jitter=7 ns", "jitter=\"7ns\"", time + "<Magnitude>-9</Magnitude>", "7"},
      {"Deadline=1.5min", "deadline=\"90s\"", time, "90"},
      {"Deadline=2h", "deadline=\"7200s\"", time, "7200"},
      {"Bandwidth=400kB/s", "bandwidth=\"400kB/s\"", rate + "<Magnitude>3</Magnitude>", "400"},
      {"Bandwidth=1.5KiB/s", "bandwidth=\"1536B/s\"", rate, "1536"},
      {"Bandwidth=500kbit/s", "bandwidth=\"62500B/s\"", rate, "62500"},
      {"Bandwidth=3bit/s", "bandwidth=\"0.375B/s\"", rate + "<Magnitude>-3</Magnitude>", "375"},
      {"PacketLoss=0.5%", "packetLoss=\"0.5%\"", "<Magnitude>-2</Magnitude>", "0.5"},
      {"PacketLoss=3ppm", "packetLoss=\"3ppm\"", "<Magnitude>-6</Magnitude>", "3"},
      {"MaxPayload=64", "maxPayload=\"64\"", "<SIUnit><Bytes>1</Bytes></SIUnit>", "64"},
      {"MaxPayload=2KiB", "maxPayload=\"2048\"", "<SIUnit><Bytes>1</Bytes></SIUnit>", "2048"},
  };
  const std::string in_paper =
      "<EventChannel><SubjectUID>0x1</SubjectUID><Attributes><Attribute><Name>Omission</Name>"
      "<Value>2</Value></Attribute></Attributes></EventChannel>";
  for (const auto& [typed, brief, dimension, value] : cases) {
    const Folder folder;
    const auto file = folder.path("c.xml");
    ASSERT_EQ(run({"describe", file, "--set", typed}).status, 0) << typed;
    EXPECT_TRUE(content_of(file).contains(fmt::format("<Attributes {}/>", brief)))
        << typed << content_of(file);
    // A list keeps the form that it has.
    const auto old = folder.write("old.xml", in_paper);
    ASSERT_EQ(run({"describe", old, "--set", typed}).status, 0) << typed;
    EXPECT_TRUE(content_of(old).contains("<Dimension>" + dimension + "</Dimension><Value>" + value +
                                         "</Value>"))
        << typed << content_of(old);
  }
}

TEST(DescribeFormsTest, EditsTheShortForm) {
  const Folder folder;
  const auto file =
      folder.write("c.xml",
                   "<EventChannel>\n  <SubjectUID>0x1</SubjectUID>\n"
                   "  <Attributes omission='2'\n              period=\"50ms\"/> <!-- agreed -->\n"
                   "</EventChannel>\n");
  ASSERT_EQ(run({"describe", file, "--set", "Period=40ms", "--set", "Omission=2", "--set",
                 "MaxPayload=8"})
                .status,
            0);
  EXPECT_EQ(content_of(file),
            "<EventChannel>\n  <SubjectUID>0x1</SubjectUID>\n"
            "  <Attributes omission='2'\n              period=\"40ms\" maxPayload=\"8\"/> "
            "<!-- agreed -->\n</EventChannel>\n");
  const auto ran = run({"describe", file, "--unset", "Omission", "--unset", "MaxPayload"});
  EXPECT_TRUE(ran.out.contains("Omission: removed, was 2")) << ran.out << ran.error;
  EXPECT_TRUE(content_of(file).contains("  <Attributes\n              period=\"40ms\"/>"))
      << content_of(file);
  EXPECT_EQ(run({"describe", file, "--unset", "Omission"}).status, 2);
}

}  // namespace
}  // namespace mlcca::test
