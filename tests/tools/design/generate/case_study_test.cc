// SPDX-License-Identifier: BSD-2-Clause
// The paper's case study at its three levels: what the compiler says of the code that is generated
// from each variant, and what a gateway decides at run time. What the design time says is in
// tests/description/twin.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>

#include "core/admission/state.hpp"
#include "description/read.hpp"
#include "tests/support/source_tree.hpp"
#include "tests/tools/design/describe/program.hpp"

namespace mlcca::test {
namespace {

namespace fs = std::filesystem;

std::string variant(const std::string& name) {
  return mlcca::testing::source_tree().string() + "examples/volksbot/" + name + ".xml";
}

/// Says what a compiler says of the header of a component.
Ran compiled(const Folder& folder, const std::string& generated, const std::string& program) {
  const auto source = folder.write("main.cc", program);
  return run_program({"g++", "-std=c++14", "-Wall", "-Wextra", "-Werror", "-fsyntax-only",
                      "-I" + mlcca::testing::source_tree().string() + "include", "-I" + generated,
                      source});
}

/// Of the switch, generated from that variant.
Ran switch_of(const std::string& name) {
  const Folder folder;
  const auto generated = folder.path("generated");
  const auto ran = run({"generate", variant(name), "--component", "switch", "--out", generated});
  EXPECT_EQ(ran.status, 0) << ran.out << ran.error;
  return compiled(folder, generated, "#include \"switch_channels.hpp\"\n");
}

TEST(CaseStudyTest, TheSwitchOnTheRobotsBusCompiles) {
  const auto ran = switch_of("robot");
  EXPECT_EQ(ran.status, 0);
  EXPECT_EQ(ran.out, "");
}

TEST(CaseStudyTest, TheSwitchBesideTheControlPcDoesNotCompile) {
  const auto said = switch_of("moved-switch");
  EXPECT_NE(said.status, 0);
  const auto& text = said.out;
  for (const char* part : {"ATTRIBUTES_MISMATCH", "Omission<5", "Omission<2"})
    EXPECT_TRUE(text.contains(part)) << part << " is not in:\n" << text;
}

// Figure 3 of the paper: a person puts the mesh in the place of the bus, by hand.
TEST(CaseStudyTest, TheCanLayerReplacedByTheMeshDoesNotCompile) {
  const Folder folder;
  const auto generated = folder.path("generated");
  ASSERT_EQ(run({"generate", variant("robot"), "--out", generated}).status, 0);
  const auto said = compiled(folder, generated,
                             "#include \"switch_channels.hpp\"\n"
                             "#include \"cameras_channels.hpp\"\n"
                             "using moved = mlcca::Check<volksbot::switch_::EmergencySwitchSpec::"
                             "attributes, volksbot::cameras::Awds::provision>;\n");
  EXPECT_NE(said.status, 0);
  const auto& text = said.out;
  for (const char* part : {"ATTRIBUTES_MISMATCH", "Omission<5", "Omission<2"})
    EXPECT_TRUE(text.contains(part)) << part << " is not in:\n" << text;
}

// The switch as it was compiled for the robot sees only its own bus: the compiler cannot know that
// another bus, behind the control PC, was put in its place. Generated again, the code knows the
// way.
TEST(CaseStudyTest, TheSecondBusIsNotSeenByCodeThatWasGeneratedForTheRobot) {
  const Folder folder;
  const auto generated = folder.path("generated");
  ASSERT_EQ(run({"generate", variant("robot"), "--out", generated}).status, 0);
  const auto second = folder.path("second");
  ASSERT_EQ(run({"generate", variant("second-bus"), "--out", second}).status, 0);
  const auto before = compiled(folder, generated, "#include \"switch_channels.hpp\"\n");
  EXPECT_EQ(before.status, 0) << before.out;
  const auto own_bus = compiled(folder, generated,
                                "#include \"switch_channels.hpp\"\n"
                                "using again = mlcca::Check<volksbot::switch_::"
                                "EmergencySwitchSpec::attributes, volksbot::switch_::RobotCan::"
                                "provision>;\n");
  EXPECT_EQ(own_bus.status, 0) << own_bus.out;
  EXPECT_NE(compiled(folder, second, "#include \"switch_channels.hpp\"\n").status, 0);
}

/// Whether every delivery of the channel is granted by a gateway that knows nothing but the
/// description.
bool granted(const std::string& name, const std::string& channel) {
  auto system = description::read(variant(name));
  if (!system) {
    ADD_FAILURE() << description::to_string(system.error().front());
    return false;
  }
  const core::State state(std::move(*system));
  const auto number = state.find_channel(channel);
  if (!number) {
    ADD_FAILURE() << name << " has no channel " << channel;
    return false;
  }
  const auto& verdicts = state.decisions()[*number].verdicts;
  EXPECT_FALSE(verdicts.empty());
  return std::ranges::all_of(verdicts, &core::Verdict::granted);
}

TEST(CaseStudyTest, AtRunTimeTheHeartBeatPassesOnTheRobotsBusAlone) {
  EXPECT_TRUE(granted("robot", "emergency-switch"));
  EXPECT_FALSE(granted("moved-switch", "emergency-switch"));
  EXPECT_FALSE(granted("second-bus", "emergency-switch"));
}

TEST(CaseStudyTest, AtRunTimeAVideoIsRefusedUntilTheMeshHasBeenMeasured) {
  for (const char* name : {"robot", "video-high", "video-low", "video-far", "video-on-can"})
    EXPECT_FALSE(granted(name, "video")) << name;
}

}  // namespace
}  // namespace mlcca::test
