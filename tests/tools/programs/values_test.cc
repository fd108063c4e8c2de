// SPDX-License-Identifier: BSD-2-Clause
// What the verbs of mlccactl say of values that they cannot use.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <ostream>
#include <string>
#include <vector>

#include "tests/support/source_tree.hpp"
#include "tests/tools/programs/run.hpp"

namespace mlcca {
namespace {

using test::End;

std::string in_tree(const std::string& path) { return (testing::source_tree() / path).string(); }

std::string content_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

const std::string kBus = in_tree("tests/corpus/import/bus.dbc");
const std::string kLog = in_tree("examples/learn/short.log");
const std::string kSystem = in_tree("examples/volksbot/system.xml");

End mlccactl(const std::vector<std::string>& arguments, const std::string& input = {}) {
  return test::run({.program = "mlccactl",
                    .arguments = arguments,
                    .environment = {"MLCCA_SOCKET=/nonexistent"},
                    .input = input});
}

struct ValueRow {
  const char* name;
  std::vector<std::string> arguments;
  const char* error;  ///< begin of it, behind "mlccactl: "
};
void PrintTo(const ValueRow& row, std::ostream* out) { *out << row.name; }

struct ValuesTest : ::testing::TestWithParam<ValueRow> {};

TEST_P(ValuesTest, AreRefusedAsWrongUseBeforeAnythingIsDone) {
  const End end = mlccactl(GetParam().arguments);
  EXPECT_EQ(end.status, 2) << end.out << end.error;
  EXPECT_EQ(end.out, "");
  EXPECT_TRUE(end.error.starts_with("mlccactl: " + std::string(GetParam().error))) << end.error;
}

// A variable of a shell that is not set gives an empty value.
INSTANTIATE_TEST_SUITE_P(
    Empty, ValuesTest,
    ::testing::Values(
        ValueRow{"Output", {"import", kBus, "--output", ""}, "--output: must not be empty\n"},
        ValueRow{
            "OutputOfCheck", {"check", kSystem, "--output", ""}, "--output: must not be empty"},
        ValueRow{"Merge", {"learn", kLog, "--merge", ""}, "--merge: must not be empty"},
        ValueRow{"For", {"learn", "lo", "--for", ""}, "--for: must not be empty"},
        ValueRow{"Bitrate", {"import", kBus, "--bitrate", ""}, "--bitrate: must not be empty"},
        ValueRow{"File", {"import", ""}, "file: must not be empty"},
        ValueRow{"Source", {"learn", kLog, ""}, "source: must not be empty"},
        ValueRow{"System", {"check", ""}, "file: must not be empty"},
        ValueRow{"New", {"new", "", "--network", "bus:can:can0"}, "file: must not be empty"},
        ValueRow{"Doctor", {"doctor", "--can", ""}, "--can: must not be empty"},
        ValueRow{"Verify", {"gate", "--verify", "--bpf-root", ""}, "--bpf-root: must not be empty"},
        ValueRow{"WhenClean",
                 {"mode", "enforce", "--when-clean", ""},
                 "--when-clean: must not be empty"},
        ValueRow{"From", {"query", "a", "--from", ""}, "--from: must not be empty"},
        ValueRow{"Key", {"release", "--key", ""}, "--key: must not be empty"},
        ValueRow{"Lease", {"admit", "a", "--lease", ""}, "--lease: must not be empty"},
        ValueRow{"Since", {"history", "--since", ""}, "--since: must not be empty"},
        ValueRow{"Place", {"reservations", ""}, "place: must not be empty"},
        ValueRow{"Socket", {"--socket", "", "status"}, "--socket: must not be empty"}),
    [](const auto& row) { return row.param.name; });

INSTANTIATE_TEST_SUITE_P(
    StandardInput, ValuesTest,
    ::testing::Values(
        ValueRow{"Check", {"check", "-"}, "file: standard input is not read here: name a file"},
        ValueRow{"Export",
                 {"export", "-", "--format", "dbc"},
                 "system: standard input is not read here: name a file"},
        ValueRow{"Format",
                 {"format", "--short", "-"},
                 "file: standard input is not read here: name a file"},
        ValueRow{"Generate", {"generate", "-"}, "system: standard input is not read here"},
        ValueRow{"Describe",
                 {"describe", "-", "--set", "Period=50ms"},
                 "file: standard input is not read here"},
        ValueRow{"AnalyseBus",
                 {"analyse-bus", "-", "--bitrate", "500k"},
                 "file: standard input is not read here"},
        ValueRow{"Rollout", {"rollout", "-"}, "system: standard input is not read here"},
        ValueRow{"Merge", {"learn", kLog, "--merge", "-"}, "--merge: standard input is not read"},
        ValueRow{"ImportTwice", {"import", "-", "-"}, "- is given twice"}),
    [](const auto& row) { return row.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Other, ValuesTest,
    ::testing::Values(
        ValueRow{"NoBitrate",
                 {"import", kBus, "--bitrate", "500x"},
                 "--bitrate '500x': must be a bit rate such as 500000, 500k or 0.5 Mbit/s\n"},
        ValueRow{"NoBitrateOfABus",
                 {"analyse-bus", kSystem, "--bitrate", "500x"},
                 "--bitrate: '500x': must be a bit rate such as 500000, 500k or 0.5 Mbit/s"},
        ValueRow{"NoBitrateOfAnInterface",
                 {"learn", kLog, "--bitrate", "can0=500x"},
                 "--bitrate can0=500x: '500x': must be a bit rate such as 500000, 500k"},
        ValueRow{"Bitrate",
                 {"import", kBus, "--bitrate", "2000000"},
                 "--bitrate '2000000': a CAN bus has at most 1 Mbit/s"},
        ValueRow{"BitrateInAnotherUnit",
                 {"import", kBus, "--bitrate", "500"},
                 "--bitrate '500': a CAN bus has at least 1 kbit/s; 500 kbit/s are 500000 or 500k"},
        ValueRow{"NoTime", {"learn", "lo", "--for", "0s"}, "--for '0s': must be 1ms to 366d\n"},
        ValueRow{"LongTime", {"learn", "lo", "--for", "367d"}, "--for '367d': must be 1ms to 366d"},
        ValueRow{"TimeWithoutUnit", {"learn", "lo", "--for", "5"}, "--for '5': must be whole"},
        ValueRow{"OtherInterface", {"learn", "lo"}, "lo: is neither a CAN nor an Ethernet"},
        ValueRow{"NoController", {"doctor", "--can", "lo"}, "lo: is no CAN interface"},
        ValueRow{"NoInterface",
                 {"doctor", "--can", "nonesuch"},
                 "nonesuch: there is no such interface"}),
    [](const auto& row) { return row.param.name; });

TEST(ImportTest, ReadsStandardInputAsAFile) {
  const End file = mlccactl({"import", kBus, "--network", "bus"});
  const End piped = mlccactl({"import", "-", "--network", "bus"}, content_of(kBus));
  ASSERT_EQ(piped.status, 0) << piped.error;
  auto expected = file.out;
  for (auto at = expected.find(kBus); at != std::string::npos; at = expected.find(kBus))
    expected.replace(at, kBus.size(), "standard input");
  EXPECT_EQ(piped.out, expected);
  EXPECT_TRUE(piped.error.contains("standard input: 3 messages of 4 nodes")) << piped.error;
  EXPECT_TRUE(mlccactl({"import", "-"}, content_of(kBus)).out.contains("<Network name=\"stdin\""));
}

TEST(ImportTest, SaysWhatIsWrongWithStandardInput) {
  const End end = mlccactl({"import", "-"}, "frob\n");
  EXPECT_EQ(end.status, 2);
  EXPECT_TRUE(end.error.starts_with("mlccactl: standard input: is in no format that is known"))
      << end.error;
}

TEST(BitRateTest, ANumberWithoutAUnitIsInBitPerSecond) {
  EXPECT_TRUE(mlccactl({"import", kBus, "--bitrate", "125000"}).out.contains("bitrate=\"125000\""));
  const End learned =
      mlccactl({"learn", kLog, "--bitrate", "can0=125000", "--data-bitrate", "can0=2000000"});
  EXPECT_EQ(learned.status, 0) << learned.error;
  EXPECT_TRUE(learned.out.contains("<Bus bitrate=\"125000\" data-bitrate=\"2000000\"/>"))
      << learned.out;
}

TEST(HelpTest, OfEachVerbNamesTheOptionsOfAllVerbs) {
  for (const char* verb : {"status", "query", "bandwidth", "check", "learn", "new"})
    EXPECT_TRUE(mlccactl({verb, "--help"}).out.contains("--no-color")) << verb;
  for (const char* verb : {"status", "check", "doctor"})
    EXPECT_TRUE(mlccactl({verb, "--help"}).out.contains("--json")) << verb;
  for (const char* verb : {"status", "query", "rollout"})
    EXPECT_TRUE(mlccactl({verb, "--help"}).out.contains("--socket PATH")) << verb;
}

}  // namespace
}  // namespace mlcca
