// SPDX-License-Identifier: BSD-2-Clause
// The examples are read without a problem and decided as their comments say; the generator of large
// descriptions writes valid ones.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "core/admission/state.hpp"
#include "core/model/text.hpp"
#include "description/read.hpp"

namespace mlcca::description {
namespace {

core::System system_of(Description read) {
  if (!read) {
    for (const auto& p : read.error()) ADD_FAILURE() << to_string(p);
    return {};
  }
  return std::move(*read);
}

/// The only verdict: one publisher towards one place.
core::Verdict verdict_of(const std::string& path) {
  const core::State state(system_of(read(path)));
  const auto& channels = state.decisions();
  if (channels.size() != 1 || channels[0].verdicts.size() != 1) {
    ADD_FAILURE() << path << " does not have exactly one verdict";
    return {};
  }
  return channels[0].verdicts[0];
}

TEST(Volksbot, IsRefusedBehindTheBridgeForItsOmissionAlone) {
  const auto v = verdict_of("examples/volksbot/system.xml");
  EXPECT_FALSE(v.granted);
  EXPECT_EQ(v.obstacle, core::Obstacle::none);
  EXPECT_EQ(v.route.size(), 3U);
  EXPECT_EQ(v.requirement[Attribute::omission], 2U);
  EXPECT_EQ(v.provision[Attribute::omission], 5U);
  int unfit = 0;
  for (const auto& row : v.rows) {
    if (row.comparison.outcome == Outcome::fit) continue;
    EXPECT_EQ(row.comparison.attribute, Attribute::omission);
    ++unfit;
  }
  EXPECT_EQ(unfit, 2) << "the bridge and end to end";
}

TEST(Volksbot, IsGrantedBehindTheRepairedBridge) {
  const auto v = verdict_of("examples/volksbot/repaired.xml");
  EXPECT_TRUE(v.granted);
  EXPECT_EQ(v.route.size(), 3U);
  EXPECT_EQ(v.provision[Attribute::omission], 1U);
  EXPECT_EQ(v.provision[Attribute::latency], 12000000U);
}

TEST(Volksbot, IsGrantedOnItsOwnBus) {
  const auto v = verdict_of("examples/volksbot/own-bus.xml");
  EXPECT_TRUE(v.granted);
  EXPECT_EQ(v.route.size(), 1U);
  EXPECT_EQ(v.provision[Attribute::omission], 0U);
}

std::string output_of(const std::string& command) {
  const std::unique_ptr<FILE, decltype([](FILE* f) { pclose(f); })> pipe(
      popen(command.c_str(), "r"));
  std::string out;
  std::array<char, 4096> block{};
  while (pipe != nullptr) {
    const auto got = std::fread(block.data(), 1, block.size(), pipe.get());
    if (got == 0) break;
    out.append(block.data(), got);
  }
  return out;
}

TEST(MakeSystem, WritesAValidDescriptionWhoseChannelsAreAllGranted) {
  const core::State state(
      system_of(read_memory(output_of("tests/bench/make-system 40"), "made.xml")));
  ASSERT_EQ(state.decisions().size(), 40U);
  for (const auto& decision : state.decisions()) {
    ASSERT_EQ(decision.verdicts.size(), 1U);
    EXPECT_TRUE(decision.all_granted())
        << reason(state.system(), state.members(), decision.verdicts[0]);
  }
}

TEST(Jitter, OfAChannelIsWhatSubscribersStandAndNotThePublishersOwn) {
  const std::string jitter =
      "<Attribute><Name>Jitter</Name><Dimension><SIUnit><Seconds>1</Seconds></SIUnit>"
      "<Magnitude>-3</Magnitude></Dimension><Value>5</Value></Attribute>";
  const auto system = read_memory(
      "<System name=\"s\"><EventChannel name=\"c\"><SubjectUID>0x1</SubjectUID><Attributes>" +
          jitter +
          "</Attributes></EventChannel><Network name=\"n\"><Kind>mesh</Kind></Network>"
          "<Publisher channel=\"c\" network=\"n\"/><Publisher channel=\"c\" "
          "network=\"n\"><Attributes>" +
          jitter + "</Attributes></Publisher><Subscriber channel=\"c\" network=\"n\"/></System>",
      "jitter.xml");
  ASSERT_TRUE(system) << to_string(system.error()[0]);
  EXPECT_FALSE(system->publishers[0].attributes.has(Attribute::jitter));
  EXPECT_TRUE(system->publishers[1].attributes.has(Attribute::jitter));
  EXPECT_TRUE(system->subscribers[0].attributes.has(Attribute::jitter));
}

}  // namespace
}  // namespace mlcca::description
