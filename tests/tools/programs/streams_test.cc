// SPDX-License-Identifier: BSD-2-Clause
// A message that cannot be written changes nothing, and an answer that cannot be written is an
// error: for every program.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/control/messages.hpp"
#include "tests/control/server.hpp"
#include "tests/support/source_tree.hpp"
#include "tests/tools/programs/run.hpp"

namespace mlcca {
namespace {

using test::End;
using test::run;
using test::Start;
using test::Stream;

constexpr int kWrongUse = 2;

/// A command. In its arguments $TREE is the source tree, $NEW a folder that is new for each run,
/// and $SOCKET a daemon that answers.
struct Row {
  const char* name;
  const char* program;
  std::vector<std::string> arguments;
  int status = 0;
  int unwritten = 3;    ///< status if standard output cannot be written
  bool prints = true;   ///< on standard output
  bool random = false;  ///< the output differs each time
};
void PrintTo(const Row& row, std::ostream* out) { *out << row.name; }

const std::vector<Row>& rows() {
  static const std::vector<Row> all{
      // what is wrong about the command line
      {"Mlccactl", "mlccactl", {"--frob"}, kWrongUse, 0, false},
      {"MlccactlVerb", "mlccactl", {"status", "--frob"}, kWrongUse, 0, false},
      {"MlccactlValue", "mlccactl", {"--timeout", "0", "status"}, kWrongUse, 0, false},
      {"Mlccad", "mlccad", {"--frob"}, kWrongUse, 0, false},
      {"Relay", "mlcca-relay", {"--frob"}, kWrongUse, 0, false},
      {"RelayWithoutValue", "mlcca-relay", {"--socket"}, kWrongUse, 0, false},
      {"Famouso", "mlcca-famouso", {"--frob"}, kWrongUse, 0, false},
      {"FamousoNothingToDo", "mlcca-famouso", {}, kWrongUse, 0, false},
      {"Cluster", "mlcca-cluster", {"--frob"}, kWrongUse, 0, false},
      {"Exporter", "mlcca-exporter", {"--frob"}, kWrongUse, 0, false},
      {"ExporterValue", "mlcca-exporter", {"--timeout", "0"}, kWrongUse, 0, false},
      {"Awds", "mlcca-awds", {"--frob"}, kWrongUse, 0, false},
      {"Sources", "mlcca-sources", {"--frob"}, kWrongUse, 0, false},
      {"Can", "mlcca-can", {"--frob"}, kWrongUse, 0, false},
      {"Design", "mlcca-design", {"--frob"}, kWrongUse, 0, false},
      {"DesignVerb", "mlccactl", {"check", "--frob"}, kWrongUse, 0, false},
      {"Doctor", "mlcca-doctor", {"--frob"}, kWrongUse, 0, false},
      {"DoctorVerb", "mlccactl", {"doctor", "--frob"}, kWrongUse, 0, false},
      {"Readback", "mlcca-readback", {"--frob"}, kWrongUse, 0, false},
      {"ReadbackVerb", "mlccactl", {"gate", "--verify", "--frob"}, kWrongUse, 0, false},
      // texts about the program
      {"MlccactlHelp", "mlccactl", {"--help"}},
      {"MlccactlVersion", "mlccactl", {"--version"}},
      {"StatusHelp", "mlccactl", {"status", "--help"}},
      {"LearnHelp", "mlccactl", {"learn", "--help"}},
      {"DoctorHelp", "mlccactl", {"doctor", "--help"}},
      {"VerifyHelp", "mlccactl", {"gate", "--verify", "--help"}},
      {"MlccadHelp", "mlccad", {"--help"}, 0, 1},
      {"MlccadVersion", "mlccad", {"--version"}, 0, 1},
      {"RelayHelp", "mlcca-relay", {"--help"}, 0, 1},
      {"FamousoHelp", "mlcca-famouso", {"--help"}, 0, 1},
      {"FamousoVersion", "mlcca-famouso", {"--version"}, 0, 1},
      {"ClusterHelp", "mlcca-cluster", {"--help"}, 0, 1},
      {"ExporterHelp", "mlcca-exporter", {"--help"}, 0, 1},
      // questions to the daemon
      {"Channels", "mlccactl", {"--socket", "$SOCKET", "channels"}},
      {"ChannelsJson", "mlccactl", {"--socket", "$SOCKET", "--json", "channels"}},
      {"Explained", "mlccactl", {"--socket", "$SOCKET", "explain", "emergency-switch"}, 1},
      {"NoDaemon", "mlccactl", {"--socket", "/nonexistent", "status"}, 3, 3, false},
      {"NoDaemonJson", "mlccactl", {"--socket", "/nonexistent", "--json", "status"}, 3},
      {"NoHealth", "mlccactl", {"--socket", "/nonexistent", "status", "--check"}, 3},
      {"NoReport", "mlccactl", {"--socket", "/nonexistent", "report", "--html"}, 3, 3, false},
      {"NoTop", "mlccactl", {"--socket", "/nonexistent", "top", "--batch"}, 3, 3, false},
      {"NoTopJson", "mlccactl", {"--socket", "/nonexistent", "--json", "top"}, 3},
      {"TopBySomething", "mlccactl", {"--json", "top", "--sort", "frob"}, kWrongUse},
      {"NobodyToAsk", "mlccactl", {"--socket", "$SOCKET", "withdraw", "a"}, kWrongUse, 3, false},
      {"Bandwidth", "mlccactl", {"bandwidth", "6Mbit/s", "12Mbit/s"}},
      {"LittleBandwidth", "mlccactl", {"bandwidth", "6Mbit/s", "--demand", "8Mbit/s"}, 1},
      {"Rollout", "mlccactl", {"--socket", "/nonexistent", "rollout", "--back"}, 3, 3, false},
      // descriptions
      {"Check", "mlccactl", {"check", "$TREE/examples/volksbot/repaired.xml"}},
      {"CheckFinds", "mlccactl", {"check", "$TREE/examples/volksbot/video-on-can.xml"}, 1},
      {"CheckNothing", "mlccactl", {"check", "/nonexistent"}, kWrongUse},
      {"CheckFolder", "mlccactl", {"check", "$NEW", "--output", "/nonexistent/a"}, 3, 3, false},
      {"CheckPage",
       "mlccactl",
       {"check", "$TREE/examples/volksbot/repaired.xml", "--format", "html", "--output", "$NEW/a"},
       0,
       0,
       false},
      {"Export",
       "mlccactl",
       {"export", "$TREE/examples/volksbot/repaired.xml", "--network", "robot-can", "--format",
        "dbc"}},
      {"ExportFile",
       "mlccactl",
       {"export", "$TREE/examples/volksbot/repaired.xml", "--network", "robot-can", "--format",
        "dbc", "--output", "$NEW/a"},
       0,
       0,
       false},
      {"Format", "mlccactl", {"format", "--paper", "$TREE/examples/rover/system.xml"}},
      {"Generate",
       "mlccactl",
       {"generate", "$TREE/examples/volksbot/system.xml", "--out", "$NEW/a"}},
      {"Import", "mlccactl", {"import", "$TREE/tests/corpus/import/bus.dbc"}},
      {"ImportJson", "mlccactl", {"--json", "import", "$TREE/tests/corpus/import/bus.dbc"}},
      {"ImportFile",
       "mlccactl",
       {"import", "$TREE/tests/corpus/import/bus.dbc", "--output", "$NEW/a"},
       0,
       0,
       false},
      {"ImportNothing", "mlccactl", {"import", "/nonexistent"}, kWrongUse, 3, false},
      {"ImportNothingJson", "mlccactl", {"--json", "import", "/nonexistent"}, kWrongUse},
      {"Learn", "mlccactl", {"learn", "$TREE/examples/learn/short.log"}},
      {"LearnFile", "mlccactl", {"learn", "$TREE/examples/learn/short.log", "--output", "$NEW/a"}},
      {"LearnMore",
       "mlccactl",
       {"learn", "$TREE/examples/learn/short.log", "--merge", "$TREE/examples/volksbot/system.xml",
        "--gateway", "laptop"},
       kWrongUse,
       3,
       false},
      {"New", "mlccactl", {"new", "-", "--network", "bus:can:can0"}, 0, 3, true, true},
      {"NewNothing", "mlccactl", {"new", "$NEW/a"}, kWrongUse, 3, false},
      {"Describe",
       "mlccactl",
       {"describe", "$TREE/examples/volksbot/system.xml", "--channel", "nonesuch", "--dry-run"},
       kWrongUse,
       3,
       false},
      {"AnalyseBus", "mlccactl", {"analyse-bus", "$TREE/examples/volksbot/repaired.xml"}},
      {"AnalyseNothing", "mlccactl", {"analyse-bus", "/nonexistent.xml"}, kWrongUse, 3, false},
      // programs of a machine
      {"DoctorOfNothing", "mlccactl", {"doctor", "--can", "nonesuch"}, kWrongUse, 3, false},
      {"VerifyNothing", "mlccactl", {"gate", "--verify", "--bpf-root", "$NEW"}, 3, 3, false},
      {"VerifyNothingJson", "mlccactl", {"--json", "gate", "--verify", "--bpf-root", "$NEW"}, 3},
      {"DaemonCheck",
       "mlccad",
       {"--check", "-d", "$TREE/examples/volksbot/system.xml", "-g", "bridge"},
       0,
       1},
      {"DaemonCheckNoGateway",
       "mlccad",
       {"--check", "-d", "$TREE/examples/volksbot/system.xml", "-g", "nonesuch"},
       kWrongUse,
       1,
       false},
      {"DaemonCheckNothing", "mlccad", {"--check", "-d", "/nonexistent"}, kWrongUse, 1, false},
      {"DaemonInterfaces",
       "mlccad",
       {"--close", "--check", "--named-in", "$TREE/systemd"},
       0,
       1,
       false},
      {"ClusterCheck", "mlcca-cluster", {"--check", "--settings", "/nonexistent"}, 2, 1, false},
      {"ExporterAlone", "mlcca-exporter", {}, 1, 1, false},
      {"AwdsAlone", "mlcca-awds", {"nonesuch"}, 1, 1, false},
      {"SourcesAlone", "mlcca-sources", {}, 1, 1, false},
      {"CanAlone", "mlcca-can", {}, 1, 1, false},
  };
  return all;
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

struct StreamsTest : ::testing::TestWithParam<Row> {
  StreamsTest()
      : server([](const control::Request&) {
          return test::Server::Answer{{{0, control::Channels{{test::refused_channel()}}}}};
        }) {}

  /// What the row's command does with such streams, with all files that it has made.
  End done(Stream out, Stream error, const std::vector<std::string>& environment = {}) {
    const test::TempDir directory;
    const auto folder = directory.path("new");
    std::filesystem::create_directory(folder);
    Start start{.program = GetParam().program,
                .arguments = GetParam().arguments,
                .environment = environment,
                .out = out,
                .error = error,
                .input = {}};
    for (std::string& word : start.arguments) {
      replace_all(word, "$TREE", testing::source_tree().string());
      replace_all(word, "$NEW", folder);
      replace_all(word, "$SOCKET", server.path());
    }
    End end = run(start);
    for (std::string* text : {&end.out, &end.error}) replace_all(*text, folder, "$NEW");
    made.clear();
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      if (!entry.is_regular_file()) continue;
      std::ifstream file(entry.path());
      made += entry.path().lexically_relative(folder).string() + ":\n" +
              std::string(std::istreambuf_iterator<char>(file), {});
    }
    std::filesystem::remove_all(folder);
    return end;
  }

  test::Server server;
  std::string made;  ///< the files that were made, with their content
};

const auto kNameOfRow = [](const auto& row) { return row.param.name; };

INSTANTIATE_TEST_SUITE_P(Programs, StreamsTest, ::testing::ValuesIn(rows()), kNameOfRow);

TEST_P(StreamsTest, AMessageThatCannotBeWrittenChangesNothing) {
  const End usual = done(Stream::file, Stream::file);
  const std::string made_usually = made;
  EXPECT_EQ(usual.status, GetParam().status) << usual.out << usual.error;
  EXPECT_EQ(!usual.out.empty(), GetParam().prints) << usual.out;
  for (const Stream error : {Stream::full, Stream::closed, Stream::gone}) {
    const End end = done(Stream::file, error);
    EXPECT_EQ(end.status, usual.status) << static_cast<int>(error);
    if (GetParam().random) continue;
    EXPECT_EQ(end.out, usual.out) << static_cast<int>(error);
    EXPECT_EQ(made, made_usually) << static_cast<int>(error);
  }
}

std::vector<Row> rows_that_print() {
  std::vector<Row> result;
  std::ranges::copy_if(rows(), std::back_inserter(result), &Row::prints);
  return result;
}

struct AnswersTest : StreamsTest {};

INSTANTIATE_TEST_SUITE_P(Programs, AnswersTest, ::testing::ValuesIn(rows_that_print()), kNameOfRow);

TEST_P(AnswersTest, ThatCannotBeWrittenAreAnError) {
  const End usual = done(Stream::file, Stream::file);
  for (const auto& [out, why] : {std::pair(Stream::full, "No space left on device"),
                                 std::pair(Stream::closed, "Bad file descriptor")}) {
    const End end = done(out, Stream::file);
    EXPECT_EQ(end.status, GetParam().unwritten) << end.error;
    const std::string name = std::string_view(GetParam().program).starts_with("mlccactl")
                                 ? "mlccactl"
                                 : GetParam().program;
    const auto line = name + ": standard output: " + why + "\n";
    if (GetParam().random || usual.error.empty())
      EXPECT_EQ(end.error.substr(std::min(end.error.find(line), end.error.size())), line);
    else
      EXPECT_EQ(end.error, usual.error + line);
  }
  EXPECT_EQ(done(Stream::full, Stream::full).status, GetParam().unwritten);
  EXPECT_EQ(done(Stream::closed, Stream::closed).status, GetParam().unwritten);
}

// Not for mlccactl, which is linked statically.
TEST(ClosingTest, AnAnswerThatIsLostWhenTheFileIsClosedIsAnError) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{
            "mlcca-design", "check",
            (testing::source_tree() / "examples/volksbot/system.xml").string()},
        std::vector<std::string>{"mlcca-doctor", "doctor", "--help"}}) {
    const End end =
        run({.program = words.front(),
             .arguments = {words.begin() + 1, words.end()},
             .environment = {"LD_PRELOAD=" + test::build_folder() + "/tests/failing_close.so"},
             .input = {}});
    EXPECT_EQ(end.status, 3) << words.front();
    EXPECT_EQ(end.error, "mlccactl: standard output: No space left on device\n");
    EXPECT_NE(end.out, "");
  }
}

/// The programs of the lists of all module.mk.
std::set<std::string> programs() {
  std::set<std::string> result;
  const std::regex line(R"(^PROGRAMS \+= \$O/(mlcc[\w-]*)$)");
  for (const auto& folder : std::filesystem::directory_iterator(testing::source_tree())) {
    std::ifstream file(folder.path() / "module.mk");
    std::smatch found;
    for (std::string text; std::getline(file, text);)
      if (std::regex_match(text, found, line)) result.insert(found[1]);
  }
  return result;
}

TEST(ProgramsTest, EachProgramIsTestedWithAWrongOption) {
  ASSERT_GT(programs().size(), 10U);
  for (const auto& program : programs())
    EXPECT_TRUE(std::ranges::any_of(rows(), [&](const Row& row) {
      return row.program == program && row.arguments == std::vector<std::string>{"--frob"} &&
             row.status == kWrongUse;
    })) << program;
}

}  // namespace
}  // namespace mlcca
