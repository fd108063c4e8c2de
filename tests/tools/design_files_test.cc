// SPDX-License-Identifier: BSD-2-Clause
// One rule for the files of all verbs that need no daemon: what is there is not overwritten, "-" is
// standard output, and exit status 2 is about what is read, 3 about what is written.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/description/folder.hpp"
#include "tests/tools/run.hpp"

namespace mlcca {
namespace {

using test::Outcome;
using Words = std::vector<std::string>;

const std::string kSystem = "examples/rover/system.xml";

std::string content_of(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

Outcome run(Words words, const Words& more = {}) {
  words.insert(words.end(), more.begin(), more.end());
  return test::run_mlccactl(std::move(words), {"MLCCA_SOCKET=/nonexistent"});
}

class DesignFiles : public description::WithFolder {
 protected:
  std::string dbc() {
    return file("bus.dbc", "BU_: A B\nBO_ 100 M: 8 A\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" B\n");
  }
  /// The verbs with --output. Those of `forced` make what can be made again.
  [[nodiscard]] static std::vector<Words> forced() {
    return {{"check", kSystem},
            {"format", "--short", kSystem},
            {"export", kSystem, "--format", "wireshark"}};
  }
  std::vector<Words> drafting() {
    return {{"learn", "examples/learn/short.log"}, {"import", dbc()}};
  }
  std::vector<Words> all() {
    auto out = forced();
    for (auto& one : drafting()) out.push_back(one);
    return out;
  }
};

TEST_F(DesignFiles, WhatIsThereIsNotOverwritten) {
  const auto there = file("there", "mine");
  for (const Words& verb : all()) {
    const auto ran = run(verb, {"--output", there});
    EXPECT_EQ(ran.status, 3) << verb[0];
    EXPECT_EQ(ran.out, "") << verb[0];
    EXPECT_TRUE(
        ran.error.contains(there + " exists, and nothing is overwritten: name another file"))
        << ran.error;
    EXPECT_EQ(content_of(there), "mine") << verb[0];
  }
}

TEST_F(DesignFiles, ForceReplacesWhatCanBeMadeAgain) {
  for (const Words& verb : forced()) {
    const auto there = file("there", "mine");
    EXPECT_TRUE(run(verb, {"--output", there}).error.contains(", or state --force\n")) << verb[0];
    const auto ran = run(verb, {"--output", there, "--force"});
    EXPECT_EQ(ran.status, 0) << verb[0] << ran.error;
    EXPECT_NE(content_of(there), "mine") << verb[0];
    EXPECT_EQ(run(verb, {"--output", path("new-" + verb[0]), "--force"}).status, 0);
    const auto alone = run(verb, {"--force"});
    EXPECT_EQ(alone.status, 2) << verb[0];
    EXPECT_TRUE(alone.error.contains("--force requires --output")) << alone.error;
  }
  for (const Words& verb : drafting()) EXPECT_EQ(run(verb, {"--force"}).status, 2) << verb[0];
}

TEST_F(DesignFiles, ADashIsStandardOutput) {
  for (const Words& verb : all()) {
    const auto plain = run(verb);
    for (const char* name : {"-", "/dev/stdout"}) {
      const auto dash = run(verb, {"--output", name});
      EXPECT_EQ(dash.status, plain.status) << verb[0];
      EXPECT_EQ(dash.out, plain.out) << verb[0];
      EXPECT_EQ(dash.error, plain.error) << verb[0];
    }
    EXPECT_FALSE(std::filesystem::exists("-")) << verb[0];
  }
}

TEST_F(DesignFiles, ADeviceIsWrittenTo) {
  for (const Words& verb : all()) {
    EXPECT_EQ(run(verb, {"--output", "/dev/null"}).status, 0) << verb[0];
    EXPECT_EQ(run(verb, {"--output", "/dev/full"}).status, 3) << verb[0];
  }
}

TEST_F(DesignFiles, WhatCannotBeReadIs2) {
  const std::vector<Words> readers = {{"analyse-bus", "--bitrate", "500k"},
                                      {"check"},
                                      {"export", "--format", "wireshark"},
                                      {"format", "--short"},
                                      {"generate"},
                                      {"import"},
                                      {"learn"}};
  for (const Words& verb : readers)
    for (const std::string& name : {path("none/there"), path("")}) {
      const auto ran = run(verb, {name});
      EXPECT_EQ(ran.status, 2) << verb[0] << " " << name << ": " << ran.error;
    }
}

TEST_F(DesignFiles, WhatDescribeCannotReadIs2AndWhatItCannotCreateIs3) {
  EXPECT_EQ(run({"describe", "--name", "x", "--set", "Period=50ms"}, {path("")}).status, 2);
  EXPECT_EQ(run({"describe", "--name", "x", "--set", "Period=50ms"}, {path("none/there")}).status,
            3);
}

TEST_F(DesignFiles, WhatCannotBeWrittenIs3) {
  auto writers = all();
  for (Words& verb : writers) verb.emplace_back("--output");
  writers.push_back({"new", "--network", "bus:can:can0"});
  for (const Words& verb : writers)
    for (const std::string& name : {path("none/there"), path("")})
      EXPECT_EQ(run(verb, {name}).status, 3) << verb[0] << " " << name;
}

TEST_F(DesignFiles, TheHelpOfEachVerbSaysItsExitStatuses) {
  for (const std::string verb : {"analyse-bus", "check", "describe", "export", "format", "generate",
                                 "import", "learn", "new", "rollout"}) {
    const auto help = run({verb, "--help"}).out;
    const auto at = help.find("Exit status: 0 ");
    ASSERT_NE(at, std::string::npos) << verb;
    const bool has_1 =
        verb != "export" && verb != "format" && verb != "generate" && verb != "import";
    EXPECT_EQ(help.find(", 1 ", at) != std::string::npos, has_1) << help;
    EXPECT_FALSE(help.contains("1 findings")) << help;
  }
  EXPECT_TRUE(run({"learn", "--help"}).out.contains("1 with --merge: there are differences"));
}

// --- options without effect ----------------------------------------------------------------------

TEST_F(DesignFiles, OptionsWithoutEffectAreRefused) {
  const auto xml = file("qos.xml",
                        "<dds><profiles><publisher profile_name=\"p\"><topic><name>t</name>"
                        "</topic></publisher></profiles></dds>");
  const auto eds = file("node.eds",
                        "[FileInfo]\nFileName=node.eds\n[DeviceInfo]\nProductName=n\n"
                        "[1017]\nParameterName=h\nDataType=6\nDefaultValue=100\n");
  const struct {
    Words words;
    const char* why;
  } rows[] = {
      {{"export", kSystem, "--format", "wireshark", "--network", "x"},
       "--network: only dbc is of one network; wireshark has all"},
      {{"export", kSystem, "--format", "wireshark", "--gateway", "x"},
       "--gateway: only can-gw and em_canid are of one gateway"},
      {{"export", kSystem, "--format", "dbc", "--gateway", "x"},
       "--gateway: only can-gw and em_canid are of one gateway"},
      {{"export", kSystem, "--format", "can-gw", "--network", "x"},
       "--network: only dbc is of one network; can-gw has those of its gateway"},
      {{"export", kSystem, "--format", "em_canid", "--network", "x"},
       "--network: only dbc is of one network; em_canid has those of its gateway"},
      {{"import", dbc(), "--node", "5"}, "--node: only eds and cyphal files have a node"},
      {{"import", xml, "--node", "5"}, "--node: only eds and cyphal files have a node"},
      {{"import", xml, "--profile", "j1939"}, "--profile: only dbc files have one to choose"},
      {{"import", eds, "--node", "5", "--profile", "raw"},
       "--profile: only dbc files have one to choose"},
      {{"import", xml, "--bitrate", "500k"}, "--bitrate: only dbc, eds and cyphal files"},
      {{"import", xml, "--data-bitrate", "2M"}, "--data-bitrate: only dbc and cyphal files"},
      {{"import", eds, "--node", "5", "--data-bitrate", "2M"},
       "--data-bitrate: only dbc and cyphal files"},
      {{"report", "--html", "--json"}, "the report is a page of HTML, without --json"},
      {{"check", kSystem, "--json", "--format", "html"}, "--json goes without --format html"},
      {{"check", kSystem, "--json", "--format", "text"}, "--json goes without --format text"},
      {{"learn", "examples/learn/short.log", "--merge", kSystem, "--name", "x"},
       "--name goes without --merge"},
  };
  for (const auto& [words, why] : rows) {
    const auto ran = run(words);
    EXPECT_EQ(ran.status, 2) << why;
    EXPECT_TRUE((ran.error + ran.out).contains(why)) << why << ": " << ran.error << ran.out;
  }
  EXPECT_EQ(run({"check", kSystem, "--json", "--format", "json"}).status, 0);
  EXPECT_EQ(
      run({"import", dbc(), xml, "--bitrate", "250k", "--network", "a", "--network", "b"}).status,
      0)
      << "one of the files has a bit rate";
}

}  // namespace
}  // namespace mlcca
