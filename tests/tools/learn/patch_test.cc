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
  Patching() { read(kSystem); }
  void read(const std::string& text) {
    auto read = description::read(folder.write("plant.xml", text), description::Users::any);
    ASSERT_TRUE(read);
    system = std::move(*read);
  }
  /// The Period of the channel, the Jitter of its publisher, which states no list, and a Binding.
  static void propose(LearnPatch& patch) {
    patch.state({LearnPatch::Element::channel, 0, "period"}, 10'000'000);
    patch.state({LearnPatch::Element::publisher, 0, "jitter"}, 1'000'000);
    patch.insert_in_network(0, "    <!-- here -->\n");
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
  system.networks[0].origin.line = 999;
  for (int i = 0; i < 2; ++i) {
    const auto files = patch.files();
    ASSERT_FALSE(files);
    EXPECT_TRUE(files.error().text.contains("no <Network> begins in line 999"))
        << files.error().text;
  }
}

// --- several elements on one line ----------------------------------------------------------------

/// Two of each kind, all on one line.
constexpr const char* kOneLine =
    "<System name=\"plant\"> "
    "<EventChannel name=\"a\"><SubjectUID>0x11</SubjectUID><Attributes period=\"20ms\" "
    "maxPayload=\"8\"/></EventChannel> "
    "<EventChannel name=\"b\"><SubjectUID>0x12</SubjectUID><Attributes period=\"30ms\" "
    "maxPayload=\"4\"/></EventChannel> "
    "<Network name=\"one\"><Kind>can</Kind><Profile>raw</Profile><Bus bitrate=\"500000\"/>"
    "<Provision period=\"20ms\" omission=\"0\" packetLoss=\"0\"/>"
    "<Binding channel=\"a\"><Identifier form=\"standard\">0x123</Identifier></Binding></Network> "
    "<Network name=\"two\"><Kind>can</Kind><Profile>raw</Profile><Bus bitrate=\"500000\"/>"
    "<Provision period=\"20ms\" omission=\"0\" packetLoss=\"0\"/>"
    "<Binding channel=\"b\"><Identifier form=\"standard\">0x124</Identifier></Binding></Network> "
    "<Publisher channel=\"a\" network=\"one\"/><Publisher channel=\"b\" network=\"two\"/></System>";

TEST_F(Patching, OfSeveralElementsOnALineItChangesTheOneThatIsMeant) {
  ASSERT_NO_FATAL_FAILURE(read(kOneLine));
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string channel = i == 0 ? "a" : "b";
    const std::string network = i == 0 ? "one" : "two";
    LearnPatch patch(system);
    patch.state({LearnPatch::Element::channel, i, "period"}, 7'000'000);
    patch.state({LearnPatch::Element::publisher, i, "jitter"}, 1'000'000);
    patch.state({LearnPatch::Element::network, i, "period"}, 5'000'000);
    patch.insert_in_network(i, "<!-- here -->");
    const auto files = patch.files();
    ASSERT_TRUE(files) << files.error().text;
    ASSERT_EQ(files->size(), 1U);
    const std::string& text = files->front().second;
    auto changed = description::read(folder.write("changed.xml", text), description::Users::any);
    ASSERT_TRUE(changed) << text;
    for (std::size_t k = 0; k < 2; ++k) {
      const auto period = [k](const core::System& of) {
        return of.channels[k].attributes[Attribute::period];
      };
      const auto jitter = [k](const core::System& of) {
        return of.publishers[k].attributes[Attribute::jitter];
      };
      const auto provided = [k](const core::System& of) {
        return of.networks[k].provision[Attribute::period];
      };
      EXPECT_EQ(period(*changed), k == i ? 7'000'000U : period(system)) << text;
      EXPECT_EQ(jitter(*changed), k == i ? 1'000'000U : jitter(system)) << text;
      EXPECT_EQ(provided(*changed), k == i ? 5'000'000U : provided(system)) << text;
    }
    const auto note = text.find("<!-- here -->");
    EXPECT_EQ(text.rfind("<Network name=\"", note), text.find("<Network name=\"" + network))
        << text;
    EXPECT_TRUE(patch.notes().empty());
  }
}

TEST_F(Patching, TwoElementsOnALineHaveValuesOfTheirOwn) {
  ASSERT_NO_FATAL_FAILURE(read(kOneLine));
  LearnPatch patch(system);
  patch.state({LearnPatch::Element::channel, 0, "period"}, 7'000'000);
  patch.state({LearnPatch::Element::channel, 1, "period"}, 9'000'000);
  const auto files = patch.files();
  ASSERT_TRUE(files && files->size() == 1U);
  const std::string& text = files->front().second;
  EXPECT_TRUE(text.contains("<SubjectUID>0x11</SubjectUID><Attributes period=\"7ms\"")) << text;
  EXPECT_TRUE(text.contains("<SubjectUID>0x12</SubjectUID><Attributes period=\"9ms\"")) << text;
}

TEST_F(Patching, WhatCannotBeToldApartIsLeftAsItIsAndSaid) {
  ASSERT_NO_FATAL_FAILURE(read(kOneLine));
  system.publishers.push_back(system.publishers[0]);  // more of them than elements on that line
  std::swap(system.channels[0].name, system.channels[1].name);
  LearnPatch patch(system);
  patch.state({LearnPatch::Element::publisher, 0, "jitter"}, 1'000'000);
  patch.state({LearnPatch::Element::publisher, 0, "period"}, 1'000'000);
  patch.state({LearnPatch::Element::channel, 0, "period"}, 1'000'000);
  const auto files = patch.files();
  ASSERT_TRUE(files) << files.error().text;
  EXPECT_TRUE(files->empty());
  ASSERT_EQ(patch.notes().size(), 2U);
  EXPECT_TRUE(
      patch.notes()[0].contains(":1: several <EventChannel> begin in this line, and which "
                                "one b is cannot be told"))
      << patch.notes()[0];
  EXPECT_TRUE(patch.notes()[1].contains("<Publisher>")) << patch.notes()[1];
}

TEST_F(Patching, PartsThatHaveOneElementGetTheValueThatAllNeed) {
  system.publishers.push_back(system.publishers[0]);
  LearnPatch patch(system);
  patch.state({LearnPatch::Element::publisher, 0, "period"}, 9'000'000);
  patch.state({LearnPatch::Element::publisher, 1, "period"}, 7'000'000);
  const auto files = patch.files();
  ASSERT_TRUE(files && files->size() == 1U);
  EXPECT_TRUE(files->front().second.contains("<Attributes period=\"7ms\"/>\n"))
      << files->front().second;
}

}  // namespace
}  // namespace mlcca::tools::design
