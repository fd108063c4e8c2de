// SPDX-License-Identifier: BSD-2-Clause
// mlccactl generate: what it writes, what it keeps, and what compilers say to it.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/source_tree.hpp"
#include "tests/tools/design/describe/program.hpp"
#include "tests/tools/design/generate/systems.hpp"

namespace mlcca::test {
namespace {

namespace fs = std::filesystem;
using Files = std::map<std::string, std::string>;

Files files_in(const std::string& folder) {
  Files out;
  for (const auto& entry : fs::directory_iterator(folder))
    out[entry.path().filename()] = content_of(entry.path());
  return out;
}

/// Generates from `system` into `folder`/out; returns that path.
std::string generated(const Folder& folder, const std::string& system,
                      std::vector<std::string> more = {}) {
  const auto file = folder.write("system.xml", system);
  std::vector<std::string> arguments = {"generate", file, "--out", folder.path("out")};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const auto ran = run(arguments);
  EXPECT_EQ(ran.status, 0) << ran.error;
  return folder.path("out");
}

std::vector<std::vector<std::string>> compilers() {
  return {{"g++"}, {"clang++-19"}, {"avr-g++"}, {"arm-none-eabi-g++"}};
}

/// What a compiler says to every callback file of `folder`.
std::string complaints(std::vector<std::string> compiler, const std::string& folder,
                       const std::vector<std::string>& more = {}) {
  compiler.insert(compiler.end(),
                  {"-std=c++14", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror",
                   "-fsyntax-only", "-I" + mlcca::testing::source_tree().string() + "include"});
  compiler.insert(compiler.end(), more.begin(), more.end());
  for (const auto& [name, text] : files_in(folder))
    if (name.ends_with(".cpp")) compiler.push_back(folder + "/" + name);
  const auto ran = run_program(compiler);
  return ran.status == 0 ? ran.out : "exit " + std::to_string(ran.status) + "\n" + ran.out;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from << " is not in\n" << text;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

TEST(GenerateTest, WritesAHeaderAndCallbacksForEachComponent) {
  const Folder folder;
  const auto files = files_in(generated(folder, robot()));
  std::vector<std::string> names;
  for (const auto& [name, text] : files) names.push_back(name);
  EXPECT_EQ(names,
            (std::vector<std::string>{
                "mlcca_generated.cmake", "mlcca_generated.mk", "motors_EmergencySwitchSpec.der",
                "motors_callbacks.cpp", "motors_channels.hpp", "second_can_EmergencySwitchSpec.der",
                "second_can_callbacks.cpp", "second_can_channels.hpp",
                "switch_EmergencySwitchSpec.der", "switch_callbacks.cpp", "switch_channels.hpp"}));
}

TEST(GenerateTest, TheSpecificationIsThatOfThePaper) {
  const Folder folder;
  const auto files = files_in(generated(folder, robot(), {"--component", "motors"}));
  const auto& header = files.at("motors_channels.hpp");
  for (
      const char* text :
      {"struct EmergencySwitchSpec {", "subject = 0xa4efeccc3210b497ULL;",
       "using attributes = mlcca::AttributeList<\n      mlcca::Period<50_ms>,\n"
       "      mlcca::Omission<2>,\n      mlcca::MaxPayload<8_bytes>>;",
       "static void notify(const uint8_t* event, size_t size);",
       "static void exception(ChannelException why);",
       "struct RobotCan {\n  using provision = mlcca::AttributeList<\n      mlcca::Latency<5_ms>,\n"
       "      mlcca::Period<10_ms>,\n      mlcca::Omission<0>,\n      mlcca::MaxPayload<8_bytes>>;",
       "mlcca::CheckTraffic<peer::EmergencySwitchSwitch::attributes, "
       "EmergencySwitchSpec::attributes>",
       "mlcca::Check<mlcca::Union<peer::EmergencySwitchSwitch::attributes, "
       "EmergencySwitchSpec::attributes>, RobotCan::provision>"})
    EXPECT_TRUE(header.contains(text)) << text << header;
  EXPECT_EQ(files.count("second_can_channels.hpp"), 0U);
  EXPECT_TRUE(files.at("motors_callbacks.cpp").contains("void EmergencySwitchSpec::notify("));
}

TEST(GenerateTest, ASporadicChannelSaysSo) {
  const Folder folder;
  std::string sporadic = robot();
  const std::string name = "<EventChannel ";
  sporadic.replace(sporadic.find(name), name.size(), name + "arrival=\"sporadic\" ");
  const std::string text = "  static constexpr bool sporadic = true;";
  EXPECT_TRUE(content_of(generated(folder, sporadic) + "/motors_channels.hpp").contains(text));
  const Folder other;
  EXPECT_FALSE(content_of(generated(other, robot()) + "/motors_channels.hpp").contains(text));
}

TEST(GenerateTest, APublisherHasNoNotification) {
  const Folder folder;
  const auto out = generated(folder, robot(), {"--component", "switch"});
  const auto header = content_of(out + "/switch_channels.hpp");
  EXPECT_TRUE(header.contains("exception(")) << header;
  EXPECT_FALSE(header.contains("notify("));
  // The lamp is behind the gateway.
  EXPECT_TRUE(
      header.contains("mlcca::RouteOf<mlcca::Network<RobotCan::provision>, "
                      "mlcca::Gateway<Bridge::provision>, "
                      "mlcca::Network<SecondCan::provision>>"))
      << header;
}

TEST(GenerateTest, CompilesWithoutAWarningEverywhere) {
  for (const auto& system : {robot(), nasty()}) {
    const Folder folder;
    const auto out = generated(folder, system);
    for (const auto& compiler : compilers()) EXPECT_EQ(complaints(compiler, out), "");
  }
}

TEST(GenerateTest, WhatDoesNotFitDoesNotCompile) {
  const Folder folder;
  const auto out = generated(folder, robot("5"), {"--component", "motors"});
  for (const auto& compiler : compilers()) {
    const auto said = complaints(compiler, out);
    EXPECT_TRUE(said.contains("ATTRIBUTES_MISMATCH")) << said;
    EXPECT_TRUE(said.contains("Omission<5")) << said;
    EXPECT_TRUE(said.contains("Omission<2")) << said;
  }
}

TEST(GenerateTest, TheExampleThatIsRefusedDoesNotCompileAndItsRepairDoes) {
  for (const auto& [example, fits] :
       {std::pair("system.xml", false), std::pair("own-bus.xml", true)}) {
    const Folder folder;
    const auto ran =
        run({"generate", mlcca::testing::source_tree().string() + "examples/volksbot/" + example,
             "--out", folder.path("out")});
    ASSERT_EQ(ran.status, 0) << ran.error;
    const auto said = complaints({"g++"}, folder.path("out"));
    EXPECT_EQ(said.empty(), fits) << said;
    EXPECT_EQ(said.contains("ATTRIBUTES_MISMATCH"), !fits) << said;
  }
}

TEST(GenerateTest, APreferredSetIsOnlyCheckedWhenAskedFor) {
  const Folder folder;
  // The first set asks for Omission 0, and that much the network no longer gives.
  const auto out =
      generated(folder, replaced(nasty(), "<Provision><Attribute><Name>Omission</Name><Value>0",
                                 "<Provision><Attribute><Name>Omission</Name><Value>1"));
  EXPECT_EQ(complaints({"g++"}, out), "");
  const auto said = complaints({"g++"}, out, {"-DMLCCA_CHECK_EVERY_SET"});
  EXPECT_TRUE(said.contains("ATTRIBUTES_MISMATCH")) << said;
}

TEST(GenerateTest, WhatABusGivesIsComputedAndSaysFromWhat) {
  const Folder folder;
  const auto out = generated(folder, on_a_bus());
  const auto header = content_of(out + "/bus_channels.hpp");
  for (const char* text :
       {"/// What network \"bus\" gives events of channel \"stop\".\n"
        "/// Computed: Latency, Jitter, Period, MaxPayload,\n"
        "/// from 500 kbit/s and the response times of all messages that are granted.\n"
        "struct BusForStop {\n  using provision = mlcca::AttributeList<\n"
        "      mlcca::Latency<320_us>,\n      mlcca::Jitter<320_us>,\n"
        "      mlcca::Period<50_ms>,\n      mlcca::MaxPayload<24608_bytes>>;",
        "BusForStop::provision>"})
    EXPECT_TRUE(header.contains(text)) << text << header;
  for (const auto& compiler : compilers()) EXPECT_EQ(complaints(compiler, out), "") << compiler[0];
}

// Without a Latency the Period would promise one of 50 ms.
TEST(GenerateTest, ALatencyWithoutBoundIsStatedBesideAPeriod) {
  const Folder folder;
  const auto out = generated(folder, unknown_mesh());
  const auto header = content_of(out + "/mesh_channels.hpp");
  EXPECT_TRUE(header.contains("Period<50_ms>")) << header;
  EXPECT_TRUE(header.contains("mlcca::Latency<static_cast<mlcca::Nanoseconds>(mlcca::kUnbounded)>"))
      << header;
}

TEST(GenerateTest, WhatOnlyTheCoreRefusesDoesNotCompile) {
  // Values of the two ends fit; the slow bus has not the time.
  const Folder folder;
  const auto said = complaints({"g++"}, generated(folder, on_a_bus("20000", one_more(true, true))));
  EXPECT_TRUE(said.contains("MLCCA031: with p, the frames of p (more) on bus")) << said;
}

TEST(GenerateTest, AnEndpointWithoutAnOtherSideIsDecidedAsCheckDoes) {
  const Folder sends;
  const Folder receives;
  const auto alone = [](bool publishes) {
    return on_a_bus("500000", one_more(publishes, !publishes));
  };
  EXPECT_EQ(complaints({"g++"}, generated(sends, alone(true))), "");
  const auto said = complaints({"g++"}, generated(receives, alone(false)));
  EXPECT_TRUE(said.contains("MLCCA010: ")) << said;
}

TEST(GenerateTest, UsersOfAnotherMachineNeedNotBeKnownHere) {
  const Folder folder;
  generated(folder, on_a_bus("500000",
                             "<Gateway name=\"g\"><Port network=\"bus\" "
                             "sender=\"nobody-of-this-machine\" "
                             "control-user=\"nobody-of-this-machine\"><Interface name=\"can0\"/>"
                             "</Port></Gateway><Publisher channel=\"stop\" gateway=\"g\" "
                             "node=\"0x30\" user=\"nobody-of-this-machine\"/>"));
}

TEST(GenerateTest, TheBytesInTheHeaderAreThoseOfTheFile) {
  for (const auto& system : {robot(), nasty()}) {
    const Folder folder;
    const auto out = generated(folder, system);
    std::size_t compared = 0;
    for (const auto& [name, text] : files_in(out)) {
      if (!name.ends_with("_channels.hpp")) continue;
      // Every line `constexpr auto kXDer = ` with the file that the comment before it names.
      std::string main = "#include \"" + name + "\"\n#include <stdio.h>\nint main() {\n";
      std::vector<std::string> blobs;
      const auto open = text.find("namespace ") + 10;
      const auto inner = text.find("namespace ", open) + 10;
      const auto scope = text.substr(open, text.find(' ', open) - open) +
                         "::" + text.substr(inner, text.find(' ', inner) - inner) + "::";
      for (auto at = text.find("as in the file "); at != std::string::npos;
           at = text.find("as in the file ", at + 1)) {
        const auto file = text.substr(at + 15, text.find(".\n", at) - at - 15);
        const auto from = text.find("constexpr auto ", at) + 15;
        const auto constant = scope + text.substr(from, text.find(' ', from) - from);
        main += "fwrite(" + constant + ".data(), 1, " + constant + ".size(), stdout);\n";
        blobs.push_back(content_of(out + "/" + file));
        EXPECT_FALSE(blobs.back().empty()) << file;
      }
      const auto source = folder.write("main.cpp", main + "}\n");
      const auto program = folder.path("main");
      const auto built = run_program({"g++", "-std=c++14",
                                      "-I" + mlcca::testing::source_tree().string() + "include",
                                      "-I" + out, source, "-o", program});
      ASSERT_EQ(built.status, 0) << built.out;
      std::string expected;
      for (const auto& blob : blobs) expected += blob;
      EXPECT_EQ(run_program({program}).out, expected) << name;
      compared += blobs.size();
    }
    EXPECT_GE(compared, 3U);
  }
}

TEST(GenerateTest, TheSameInputGivesTheSameBytesAnywhere) {
  const Folder one;
  const Folder two;
  EXPECT_EQ(files_in(generated(one, nasty())), files_in(generated(two, nasty())));
}

TEST(GenerateTest, WhatIsTheSameIsNotWrittenAgain) {
  const Folder folder;
  const auto out = generated(folder, robot());
  std::map<std::string, ino_t> before;
  for (const auto& entry : fs::directory_iterator(out)) {
    struct stat status{};
    ASSERT_EQ(::stat(entry.path().c_str(), &status), 0);
    before[entry.path()] = status.st_ino;
  }
  const auto ran = run({"generate", folder.path("system.xml"), "--out", out});
  EXPECT_TRUE(ran.out.contains("nothing to change")) << ran.out;
  for (const auto& [path, inode] : before) {
    struct stat status{};
    ASSERT_EQ(::stat(path.c_str(), &status), 0);
    EXPECT_EQ(status.st_ino, inode) << path;
  }
}

TEST(GenerateTest, UserCodeSurvives) {
  const Folder folder;
  const auto out = generated(folder, robot());
  const auto file = out + "/motors_callbacks.cpp";
  const auto written =
      replaced(replaced(content_of(file), "  static_cast<void>(why);\n", "  stop(why);\n"),
               "// BEGIN user code: helpers\n",
               "// BEGIN user code: helpers\nstatic void stop(ChannelException) {}\n");
  folder.write("out/motors_callbacks.cpp", written);
  generated(folder, robot());
  EXPECT_EQ(content_of(file), written);
  generated(folder, replaced(robot(), "heart-beats while", "another text while"));
  EXPECT_EQ(content_of(file), written);
}

TEST(GenerateTest, CodeOfARenamedChannelIsKeptAndComesBack) {
  const Folder folder;
  const auto out = generated(folder, robot());
  const auto file = out + "/motors_callbacks.cpp";
  const auto written = replaced(content_of(file), "  static_cast<void>(why);\n",
                                "  static_cast<void>(why);\n  // precious\n");
  folder.write("out/motors_callbacks.cpp", written);

  auto renamed = robot();
  for (auto at = renamed.find("emergency-switch"); at != std::string::npos;
       at = renamed.find("emergency-switch"))
    renamed.replace(at, 16, "stop");
  generated(folder, renamed);
  const auto kept = content_of(file);
  EXPECT_TRUE(kept.contains("void StopSpec::exception(")) << kept;
  EXPECT_TRUE(
      kept.contains("// BEGIN user code: EmergencySwitchSpec::exception\n#if 0\n"
                    "  static_cast<void>(why);\n  // precious\n#endif\n"))
      << kept;
  // An empty section is not kept.
  EXPECT_FALSE(kept.contains("EmergencySwitchSpec::notify")) << kept;
  EXPECT_EQ(complaints({"g++"}, out), "");
  generated(folder, renamed);
  EXPECT_EQ(content_of(file), kept);

  generated(folder, robot());
  EXPECT_EQ(content_of(file), written);
}

TEST(GenerateTest, ChangesOutsideOfUserCodeAreNotOverwritten) {
  const Folder folder;
  const auto out = generated(folder, robot());
  const auto file = out + "/motors_callbacks.cpp";
  const auto written =
      replaced(content_of(file), "namespace robot {", "int mine;\nnamespace robot {");
  folder.write("out/motors_callbacks.cpp", written);
  const auto arguments =
      std::vector<std::string>{"generate", folder.path("system.xml"), "--out", out};
  const auto ran = run(arguments);
  EXPECT_EQ(ran.status, 2);
  EXPECT_TRUE(ran.error.contains("outside of the user code")) << ran.error;
  EXPECT_EQ(content_of(file), written);
  auto forced = arguments;
  forced.emplace_back("--force");
  EXPECT_EQ(run(forced).status, 0);
  EXPECT_FALSE(content_of(file).contains("int mine;"));
}

TEST(GenerateTest, BrokenMarkersAreAnErrorWithTheirLine) {
  const Folder folder;
  const auto out = generated(folder, robot());
  const auto written =
      replaced(content_of(out + "/motors_callbacks.cpp"), "// END user code: helpers\n", "");
  folder.write("out/motors_callbacks.cpp", written);
  const auto ran = run({"generate", folder.path("system.xml"), "--out", out, "--force"});
  EXPECT_EQ(ran.status, 2);
  EXPECT_TRUE(ran.error.contains("user code begins inside of the one of line")) << ran.error;
  EXPECT_EQ(content_of(out + "/motors_callbacks.cpp"), written);
}

TEST(GenerateTest, FilesOfOthersAreNotOverwritten) {
  for (const char* name : {"motors_channels.hpp", "motors_callbacks.cpp", "mlcca_generated.mk",
                           "motors_EmergencySwitchSpec.der"}) {
    const Folder folder;
    fs::create_directory(folder.path("out"));
    folder.write(std::string("out/") + name, "another one's work\n");
    folder.write("system.xml", robot());
    const auto ran = run({"generate", folder.path("system.xml"), "--out", folder.path("out")});
    EXPECT_EQ(ran.status, 2) << name;
    EXPECT_TRUE(ran.error.contains("was not generated by this program")) << ran.error;
    EXPECT_EQ(files_in(folder.path("out")).size(), 1U) << name;
    EXPECT_EQ(
        run({"generate", folder.path("system.xml"), "--out", folder.path("out"), "--force"}).status,
        0);
    EXPECT_NE(content_of(folder.path("out/") + name), "another one's work\n");
  }
}

TEST(GenerateTest, NothingIsWrittenThroughASymbolicLink) {
  for (const char* name : {"motors_channels.hpp", "motors_callbacks.cpp", "mlcca_generated.mk",
                           "switch_EmergencySwitchSpec.der"})
    for (const bool leads_somewhere : {true, false}) {
      const Folder folder;
      fs::create_directory(folder.path("out"));
      const auto target = folder.path("target");
      if (leads_somewhere) folder.write("target", "another one's work\n");
      fs::create_symlink(target, folder.path("out/") + name);
      const auto system = folder.write("system.xml", robot());
      for (const bool force : {true, false}) {
        std::vector<std::string> arguments = {"generate", system, "--out", folder.path("out")};
        if (force) arguments.emplace_back("--force");
        const auto ran = run(arguments);
        EXPECT_EQ(ran.status, 2) << name << ran.out;
        EXPECT_TRUE(ran.error.contains(std::string(name) + ": is a symbolic link")) << ran.error;
        EXPECT_TRUE(ran.error.contains("nothing was written")) << ran.error;
        EXPECT_TRUE(fs::is_symlink(folder.path("out/") + name));
        EXPECT_EQ(std::distance(fs::directory_iterator(folder.path("out")), {}), 1) << name;
        EXPECT_EQ(fs::exists(target), leads_somewhere);
        if (leads_somewhere) {
          EXPECT_EQ(content_of(target), "another one's work\n");
        }
      }
    }
}

TEST(GenerateTest, ALinkToAFileOfTheGeneratorIsRefusedToo) {
  const Folder folder;
  const auto out = generated(folder, robot());
  const auto file = out + "/motors_channels.hpp";
  const auto text = content_of(file);
  fs::rename(file, folder.path("target"));
  fs::create_symlink(folder.path("target"), file);
  const auto ran = run({"generate", folder.path("system.xml"), "--out", out, "--force"});
  EXPECT_EQ(ran.status, 2) << ran.out;
  EXPECT_EQ(content_of(folder.path("target")), text);
}

TEST(GenerateTest, TheJitterOfTheSourceIsAddedToThatOfTheNetwork) {
  // 5 ms of the publisher and 3 ms of the network are 8 ms.
  for (const auto& [asked, fits] : {std::pair("6", false), std::pair("9", true)}) {
    const Folder folder;
    const auto out = generated(folder, jittery("5", "3", asked));
    for (const auto& compiler : compilers()) {
      const auto said = complaints(compiler, out);
      EXPECT_EQ(said.empty(), fits) << said;
      EXPECT_EQ(said.contains("ATTRIBUTES_MISMATCH"), !fits) << said;
      EXPECT_EQ(said.contains("8000000"), !fits) << said;
    }
  }
}

TEST(GenerateTest, TheNamesOfTheGeneratedCodeAreNotTaken) {
  for (const char* name :
       {"uint8_t",          "uint16_t", "uint32_t",  "uint64_t", "int8_t", "int16_t",   "int32_t",
        "int64_t",          "size_t",   "ptrdiff_t", "mlcca",    "peer",   "checks",    "std",
        "ChannelException", "literals", "der",       "Network",  "notify", "exception", "subject",
        "attributes",       "channel",  "provision", "why",      "event",  "size"}) {
    const Folder folder;
    const auto out = generated(folder, called(name));
    EXPECT_EQ(complaints({"g++"}, out), "") << name;
    EXPECT_EQ(complaints({"clang++-19"}, out), "") << name;
  }
}

TEST(GenerateTest, MoreUserDefinedAttributesThanAListHoldsAreRefused) {
  for (const bool of_network : {true, false}) {
    const Folder folder;
    const auto most = folder.write("most.xml", with_user_attributes(16, of_network));
    const auto more = folder.write("more.xml", with_user_attributes(17, of_network));
    const auto ran = run({"generate", more, "--out", folder.path("out")});
    EXPECT_EQ(ran.status, 2);
    EXPECT_TRUE(ran.error.contains("has 17 user-defined attributes")) << ran.error;
    EXPECT_TRUE(ran.error.contains("at most 16")) << ran.error;
    EXPECT_TRUE(files_in(folder.path("out")).empty());
    ASSERT_EQ(run({"generate", most, "--out", folder.path("out")}).status, 0);
    EXPECT_EQ(complaints({"g++"}, folder.path("out")), "");
  }
}

TEST(GenerateTest, WhatHasNoOwnerAnyMoreIsNamedAndStays) {
  const Folder folder;
  generated(folder, robot());
  folder.write("system.xml",
               replaced(robot(), "<Component name=\"motors\"", "<Component name=\"wheels\""));
  const auto ran = run({"generate", folder.path("system.xml"), "--out", folder.path("out")});
  EXPECT_TRUE(ran.out.contains("motors_callbacks.cpp: belongs to no component any more"))
      << ran.out;
  EXPECT_EQ(::access(folder.path("out/motors_callbacks.cpp").c_str(), F_OK), 0);
}

TEST(GenerateTest, WhatAHeaderCannotSayIsRefused) {
  const Folder folder;
  const auto file = folder.write("system.xml", robot("4294967296"));
  const auto ran = run({"generate", file, "--out", folder.path("out")});
  EXPECT_EQ(ran.status, 2);
  EXPECT_TRUE(ran.error.contains("can: Omission 4294967296: generated code holds at most"))
      << ran.error;
}

TEST(GenerateTest, UnknownComponentsAndBadDescriptionsAreRefused) {
  const Folder folder;
  const auto file = folder.write("system.xml", robot());
  const auto out = folder.path("out");
  const auto unknown = run({"generate", file, "--out", out, "--component", "wheels"});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_TRUE(unknown.error.contains("there are switch, motors, second-can")) << unknown.error;
  folder.write("system.xml", replaced(robot(), "0xa4ef", "a4ef"));
  const auto bad = run({"--json", "generate", file, "--out", out});
  EXPECT_EQ(bad.status, 2);
  EXPECT_TRUE(
      nlohmann::json::parse(bad.out).at("error").at("details").at(0).get<std::string>().contains(
          "system.xml:2: <SubjectUID>"))
      << bad.out;
  EXPECT_NE(::access(out.c_str(), F_OK), 0);
}

}  // namespace
}  // namespace mlcca::test
