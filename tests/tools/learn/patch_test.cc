// SPDX-License-Identifier: BSD-2-Clause
// The changes that `learn --merge` proposes to the files of a description: all of them or none.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "description/read.hpp"
#include "tests/tools/design/describe/program.hpp"
#include "tools/design/learn_patch.hpp"

namespace mlcca::tools::design {
namespace {

constexpr const char* kSystem = R"(<System name="plant">
  <EventChannel name="a">
    <SubjectUID>0x11</SubjectUID>
    <Attributes period="20ms" maxPayload="8"/>
  </EventChannel>
  <Network name="bus">
    <Kind>can</Kind>
    <Profile>raw</Profile>
    <Bus bitrate="500000"/>
    <Provision omission="0" packetLoss="0"/>
    <Binding channel="a"><Identifier form="standard">0x123</Identifier></Binding>
  </Network>
  <Publisher name="sender" channel="a" network="bus"/>
</System>
)";

struct Patching : ::testing::Test {
  Patching() {
    auto read = description::read(folder.write("plant.xml", kSystem), description::Users::any);
    EXPECT_TRUE(read);
    if (read) system = std::move(*read);
  }
  /// The Period of the channel, the Jitter of its publisher, which states no list, and a Binding.
  void propose(LearnPatch& patch) const {
    patch.state({system.channels[0].origin, LearnPatch::Element::channel, "period"}, 10'000'000);
    patch.state({system.publishers[0].origin, LearnPatch::Element::publisher, "jitter"}, 1'000'000);
    patch.insert_in_network(system.networks[0].origin, "    <!-- here -->\n");
  }
  test::Folder folder;
  core::System system;
};

TEST_F(Patching, ChangesWhatWasProposed) {
  LearnPatch patch(system);
  propose(patch);
  const auto files = patch.files();
  ASSERT_TRUE(files) << files.error().text;
  ASSERT_EQ(files->size(), 1U);
  const std::string& text = files->front().second;
  EXPECT_TRUE(text.contains("<Attributes period=\"10ms\" maxPayload=\"8\"/>")) << text;
  EXPECT_TRUE(text.contains("<Attributes jitter=\"1ms\"/>")) << text;
  EXPECT_TRUE(text.contains("    <!-- here -->\n  </Network>")) << text;
}

TEST_F(Patching, AskedAgainItHasTheSameChanges) {
  LearnPatch patch(system);
  propose(patch);
  const auto first = patch.files();
  const auto second = patch.files();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(*first, *second);
}

TEST_F(Patching, WithOneThatCannotBeMadeNoneIsMade) {
  LearnPatch patch(system);
  propose(patch);
  core::Origin nowhere = system.networks[0].origin;
  nowhere.line = 999;
  patch.insert_in_network(nowhere, "    <!-- there -->\n");
  for (int i = 0; i < 2; ++i) {
    const auto files = patch.files();
    ASSERT_FALSE(files);
    EXPECT_TRUE(files.error().text.contains("no <Network> begins in line 999"))
        << files.error().text;
  }
}

}  // namespace
}  // namespace mlcca::tools::design
