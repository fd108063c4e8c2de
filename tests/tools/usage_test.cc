// SPDX-License-Identifier: BSD-2-Clause
// What mlccactl says of a command line that it cannot use.
#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <vector>

#include "tests/tools/run.hpp"

namespace mlcca {
namespace {

using test::run_mlccactl;

struct UsageRow {
  const char* name;
  std::vector<std::string> arguments;
  const char* error;  ///< part of it
};
void PrintTo(const UsageRow& row, std::ostream* out) { *out << row.name; }

struct MlccactlUsageTest : ::testing::TestWithParam<UsageRow> {};

TEST_P(MlccactlUsageTest, ExitsWith2AndSaysWhatIsWrong) {
  const auto outcome = run_mlccactl(GetParam().arguments, {"MLCCA_SOCKET=/nonexistent"});
  EXPECT_EQ(outcome.status, 2) << outcome.out << outcome.error;
  EXPECT_EQ(outcome.out, "");
  EXPECT_TRUE(outcome.error.starts_with("mlccactl: ")) << outcome.error;
  EXPECT_NE(outcome.error.find(GetParam().error), std::string::npos) << outcome.error;
}

INSTANTIATE_TEST_SUITE_P(
    Wrong, MlccactlUsageTest,
    ::testing::Values(
        UsageRow{"NoVerb", {}, "no verb: must be one of status, networks, channels, routes"},
        UsageRow{"UnknownVerb", {"foo"}, "unknown verb 'foo': must be one of status"},
        UsageRow{"UnknownOption", {"--foo", "status"}, "unexpected argument '--foo'"},
        UsageRow{"UnknownOptionOnly", {"--foo"}, "unexpected argument '--foo'"},
        UsageRow{"UnknownOptionOfVerb", {"status", "--foo"}, "unexpected argument '--foo'"},
        UsageRow{"TooManyArguments", {"query", "a", "b"}, "unexpected argument 'b'"},
        UsageRow{"TwoVerbs", {"status", "reload"}, "reload"},
        UsageRow{"NoChannel", {"query"}, "channel is required"},
        UsageRow{"NoChannelToExplain", {"explain"}, "channel is required"},
        UsageRow{"NoMode", {"mode"}, "mode is required"},
        UsageRow{"UnknownMode", {"mode", "off"}, "off not in {enforce,audit}"},
        UsageRow{"ReleaseOfNothing", {"release"}, "Exactly 1 option from [channel,--id"},
        UsageRow{"ReleaseOfBoth", {"release", "a", "--id", "1"}, "2 were given"},
        UsageRow{"AdmissionZero", {"release", "--id", "0"}, "not in range 1 to"},
        UsageRow{"RenewalOfNothing", {"renew"}, "Exactly 1 option from [--id,"},
        UsageRow{"RenewalOfBoth", {"renew", "--id", "1", "--key", "a"}, "2 were given"},
        UsageRow{"WhatIfNothing", {"what-if"}, "--link"},
        UsageRow{"WhatIfOneWayOnly", {"what-if", "--one-way"}, "--link"},
        UsageRow{"LinkWithoutRate", {"what-if", "--link", "a,b"}, "must be FROM,TO=RATE"},
        UsageRow{"LinkWithoutEnd", {"what-if", "--link", "a-b=0"}, "must be FROM,TO=RATE"},
        UsageRow{"LinkFromNowhere", {"what-if", "--link", ",b=0"}, "must be FROM,TO=RATE"},
        UsageRow{"LinkToNowhere", {"what-if", "--link", "a,=0"}, "must be FROM,TO=RATE"},
        UsageRow{"LinkOfNoNetwork", {"what-if", "--link", "/a,b=0"}, "must be FROM,TO=RATE"},
        UsageRow{
            "LinkWithoutUnit", {"what-if", "--link", "a,b=6"}, "needs a unit of k, M or G (bit/s)"},
        UsageRow{"LeaseWithoutUnit", {"admit", "a", "--lease", "30"}, "--lease '30': must be"},
        UsageRow{"LeaseZero", {"admit", "a", "--lease", "0s"}, "must be more than 0"},
        UsageRow{"LeaseOfAQuery", {"query", "a", "--lease", "1s"}, "unexpected argument"},
        UsageRow{"NoMoment", {"history", "--since", "soon"}, "--since 'soon': must be a moment"},
        UsageRow{"PastBackwards",
                 {"history", "--since", "@2", "--until", "@1"},
                 "--until '@1' is before --since '@2'"},
        UsageRow{"LimitZero", {"history", "--limit", "0"}, "not in range 1 to 10000"},
        UsageRow{"LimitLarge", {"history", "--limit", "10001"}, "not in range 1 to 10000"},
        UsageRow{"TwoPlaces", {"reservations", "a", "b"}, "unexpected argument 'b'"},
        UsageRow{"NodeTooLarge", {"query", "a", "--node", "254"}, "254 not in range 0 to 253"},
        UsageRow{"PriorityNegative", {"query", "a", "--priority", "-1"}, "--priority"},
        UsageRow{"NoUnit", {"query", "a", "--require", "Period=50"}, "needs a unit: ns, us, ms"},
        UsageRow{"MisspelledAttribute", {"admit", "a", "--offer", "period=1s"}, "spelled Period"},
        UsageRow{"OwnAttributeNoNumber", {"query", "a", "--require", "Trust=x"}, "be a number"},
        UsageRow{"AttributeTwice",
                 {"query", "a", "--require", "Omission=1", "--require", "Omission=2"},
                 "Omission is given twice"},
        UsageRow{"TimeoutZero", {"status", "--timeout", "0"}, "must be 0.001 to 86400 seconds"},
        UsageRow{"TimeoutLong", {"status", "--timeout", "86401"}, "must be 0.001 to 86400 seconds"},
        UsageRow{"TimeoutNan", {"status", "--timeout", "nan"}, "must be 0.001 to 86400 seconds"},
        UsageRow{"SocketMissing", {"status", "--socket"}, "--socket"}),
    [](const auto& row) { return row.param.name; });

TEST(MlccactlTest, NamesTheHelpOfTheVerb) {
  EXPECT_NE(run_mlccactl({"query"}).error.find("'mlccactl query --help' says more."),
            std::string::npos);
  EXPECT_NE(run_mlccactl({"check", "--format", "x", "a.xml"})
                .error.find("'mlccactl check --help' says more."),
            std::string::npos);
  EXPECT_NE(run_mlccactl({"foo"}).error.find("'mlccactl --help' says more."), std::string::npos);
}

}  // namespace
}  // namespace mlcca
