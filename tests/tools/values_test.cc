// SPDX-License-Identifier: BSD-2-Clause
// Values on the command line: exact, rounded to the safe side, and wrong ones explained.
#include "tools/values.hpp"

#include <gtest/gtest.h>

#include "mlcca/attribute.hpp"

namespace mlcca::tools {
namespace {

struct Good {
  const char* text;
  std::uint64_t value;
  Role role = Role::required;
};
void PrintTo(const Good& row, std::ostream* out) { *out << row.text; }

struct GoodValueTest : ::testing::TestWithParam<Good> {};

TEST_P(GoodValueTest, IsReadExactlyOrRoundedToTheSafeSide) {
  const auto attribute = parse_attribute(GetParam().text, GetParam().role);
  ASSERT_TRUE(attribute) << attribute.error().text;
  EXPECT_EQ(attribute->value, GetParam().value);
  EXPECT_FALSE(attribute->dynamic);
}

INSTANTIATE_TEST_SUITE_P(
    Units, GoodValueTest,
    ::testing::Values(Good{"Period=50ms", 50'000'000}, Good{"Period=50 ms", 50'000'000},
                      Good{" Period = 50ms ", 50'000'000}, Good{"Latency=5us", 5'000},
                      Good{"Latency=5µs", 5'000}, Good{"Latency=5μs", 5'000},
                      Good{"Latency=7ns", 7}, Good{"Deadline=1.5s", 1'500'000'000},
                      Good{"Jitter=2min", 120'000'000'000}, Good{"Period=24h", 86'400'000'000'000},
                      Good{"Bandwidth=400kB/s", 400'000}, Good{"Bandwidth=9B/s", 9},
                      Good{"Bandwidth=1.25MB/s", 1'250'000}, Good{"Bandwidth=2GB/s", 2'000'000'000},
                      Good{"Bandwidth=1KiB/s", 1'024}, Good{"Bandwidth=1MiB/s", 1'048'576},
                      Good{"Bandwidth=8bit/s", 1}, Good{"Bandwidth=500kbit/s", 62'500},
                      Good{"Bandwidth=10Mbit/s", 1'250'000}, Good{"Bandwidth=1Gbit/s", 125'000'000},
                      Good{"PacketLoss=0.5%", 5'000'000}, Good{"PacketLoss=100%", 1'000'000'000},
                      Good{"PacketLoss=100.000%", 1'000'000'000}, Good{"PacketLoss=3ppm", 3'000},
                      Good{"PacketLoss=7ppb", 7}, Good{"Omission=2", 2}, Good{"Omission=0", 0},
                      Good{"Omission=2 events", 2}, Good{"MaxPayload=8", 8},
                      Good{"MaxPayload=8 bytes", 8}, Good{"MaxPayload=8B", 8},
                      Good{"MaxPayload=1kB", 1'000}, Good{"MaxPayload=1.5KiB", 1'536}));

INSTANTIATE_TEST_SUITE_P(
    Rounding, GoodValueTest,
    ::testing::Values(
        Good{"Latency=1.9ns", 1}, Good{"Latency=0.9999999999us", 999}, Good{"Period=1.9ns", 1},
        Good{"Omission=2.9", 2}, Good{"PacketLoss=0.00000019%", 1}, Good{"PacketLoss=0.1ppb", 0},
        Good{"Bandwidth=1bit/s", 1}, Good{"Bandwidth=9bit/s", 2},
        Good{"Bandwidth=0.000000001B/s", 1}, Good{"MaxPayload=7.1", 8}, Good{"Jitter=1.9ns", 1},
        Good{"Jitter=1.1ns", 2, Role::offered}, Good{"Period=1.9ns", 1, Role::offered},
        Good{"Latency=1.9ns", 1, Role::offered}, Good{"MaxPayload=7.1", 8, Role::offered},
        Good{"Bandwidth=9bit/s", 2, Role::offered}));

INSTANTIATE_TEST_SUITE_P(Limits, GoodValueTest,
                         ::testing::Values(Good{"Omission=18446744073709551614", ~0ULL - 1},
                                           Good{"Period=1ns", 1}, Good{"Latency=0ns", 0},
                                           Good{"Latency=0.000000000000000001s", 0},
                                           Good{"Period=18446744073.709551614s", ~0ULL - 1}));

struct Bad {
  const char* text;
  const char* error;
};
void PrintTo(const Bad& row, std::ostream* out) { *out << row.text; }

struct BadValueTest : ::testing::TestWithParam<Bad> {};

TEST_P(BadValueTest, SaysWhatWouldBeRight) {
  const auto attribute = parse_attribute(GetParam().text, Role::required);
  ASSERT_FALSE(attribute) << attribute->value;
  EXPECT_EQ(attribute.error().text, GetParam().error);
}

INSTANTIATE_TEST_SUITE_P(
    Values, BadValueTest,
    ::testing::Values(
        Bad{"Period", "'Period': must be Name=Value, such as Period=50ms"},
        Bad{"", "'': must be Name=Value, such as Period=50ms"},
        Bad{"period=1s", "unknown attribute 'period': it is spelled Period"},
        Bad{"Colour=1",
            "unknown attribute 'Colour': must be one of Latency, Jitter, Deadline, Period, "
            "Bandwidth, PacketLoss, Omission, MaxPayload"},
        Bad{"Period=50", "Period=50: needs a unit: ns, us, ms, s, min or h"},
        Bad{"PacketLoss=0.5", "PacketLoss=0.5: needs a unit: %, ppm or ppb"},
        Bad{"Bandwidth=5",
            "Bandwidth=5: needs a unit: B/s, kB/s, MB/s, GB/s, KiB/s, MiB/s, bit/s, kbit/s, "
            "Mbit/s or Gbit/s"},
        Bad{"Period=50msec",
            "Period=50msec: 'msec' is not a unit of it: must be ns, us, ms, s, min or h"},
        Bad{"Omission=2ms", "Omission=2ms: 'ms' is not a unit of it: must be events"},
        Bad{"MaxPayload=8bit",
            "MaxPayload=8bit: 'bit' is not a unit of it: must be B, bytes, kB or KiB"},
        Bad{"Period=", "Period=: must be a number of 0 or more, such as 50 or 12.5"},
        Bad{"Period=ms", "Period=ms: must be a number of 0 or more, such as 50 or 12.5"},
        Bad{"Period=-5ms", "Period=-5ms: must be a number of 0 or more, such as 50 or 12.5"},
        Bad{"Period=0ms", "Period=0ms: must be more than 0 ns"},
        Bad{"Period=0.9ns", "Period=0.9ns: must be more than 0 ns"},
        Bad{"PacketLoss=100.0000001%", "PacketLoss=100.0000001%: must be at most 100%"},
        Bad{"Omission=18446744073709551615", "Omission=18446744073709551615: too large"},
        Bad{"Period=18446744073.709551615s", "Period=18446744073.709551615s: too large"},
        Bad{"Period=999999999999h", "Period=999999999999h: too large"}));

INSTANTIATE_TEST_SUITE_P(
    Numbers, BadValueTest,
    ::testing::Values(Bad{"Omission=18446744073709551616",
                          "Omission=18446744073709551616: must be digits, at most one point and 18 "
                          "decimals, and fit 64 bits without the point"},
                      Bad{"Period=1.2.3ms",
                          "Period=1.2.3ms: must be digits, at most one point and 18 decimals, and "
                          "fit 64 bits without the point"},
                      Bad{"Period=.5ms",
                          "Period=.5ms: must be digits, at most one point and 18 decimals, and fit "
                          "64 bits without the point"},
                      Bad{"Period=5.ms",
                          "Period=5.ms: must be digits, at most one point and 18 decimals, and fit "
                          "64 bits without the point"},
                      Bad{"Period=0.0000000000000000001s",
                          "Period=0.0000000000000000001s: must be digits, at most one point and 18 "
                          "decimals, and fit 64 bits without the point"}));

TEST(ValueTest, CarriesNameAndUnitOfTheAttributeTable) {
  for (const auto* text : {"Latency=1s", "Jitter=1s", "Deadline=1s", "Period=1s", "Bandwidth=1B/s",
                           "PacketLoss=1%", "Omission=1", "MaxPayload=1"}) {
    const auto attribute = parse_attribute(text, Role::required);
    ASSERT_TRUE(attribute) << attribute.error().text;
    const std::string_view name =
        std::string_view(text).substr(0, std::string_view(text).find('='));
    EXPECT_EQ(attribute->name, name);
    const auto* row = std::begin(kAttributeTable);
    while (name != row->name) ++row;
    EXPECT_EQ(attribute->unit, row->unit);
  }
}

TEST(ValueTest, IsPrintedAsPeopleSayIt) {
  EXPECT_EQ(print_value("Period", 50'000'000, "ns"), "50 ms");
  EXPECT_EQ(print_value("PacketLoss", 5'000'000, "1e-9"), "0.5 %");
  EXPECT_EQ(print_value("Bandwidth", 400'000, "bytes/s"), "400 kB/s");
  EXPECT_EQ(print_value("Omission", 2, "events"), "2");
  EXPECT_EQ(print_value("Latency", kUnbounded, "ns"), "unbounded");
}

TEST(ValueTest, OfAnUnknownAttributeIsPrintedWithItsUnit) {
  EXPECT_EQ(print_value("Temperature", 12, "K"), "12 K");
  EXPECT_EQ(print_value("Hops", 3, ""), "3");
  EXPECT_EQ(print_value("Hops", kUnbounded, ""), "unbounded");
}

TEST(ValueTest, OfAnAttributeOfTheDescriptionIsPrintedAsCheckPrintsIt) {
  EXPECT_EQ(print_value("Temperature", 3100, "1e-1 K"), "310 K");
  EXPECT_EQ(print_value("Temperature", 3105, "1e-1 K"), "310.5 K");
  EXPECT_EQ(print_value("Pressure", 12, "1e2 m^-1 kg s^-2"), "1200 m^-1 kg s^-2");
  EXPECT_EQ(print_value("Trust", 25, "1e-1"), "2.5");
  EXPECT_EQ(print_value("Trust", kUnbounded, "1e-1"), "unbounded");
  EXPECT_EQ(print_value("Odd", 3, "1e5000 K"), "3 1e5000 K") << "no magnitude that there is";
  EXPECT_EQ(print_value("Odd", 3, "1e-1K"), "3 1e-1K");
  EXPECT_EQ(print_value("Odd", 3, "1e"), "3 1e");
}

TEST(StatedTest, OfTheDescriptionGoesToTheDaemonAsItIsWritten) {
  const auto inside = [](const char* text) {
    const auto stated = parse_stated(text, Role::required);
    return stated ? stated->name + "|" + std::to_string(stated->value) + "|" + stated->unit
                  : stated.error().text;
  };
  EXPECT_EQ(inside("Trust=4"), "Trust|4|");
  EXPECT_EQ(inside("Trust=0"), "Trust|0|");
  EXPECT_EQ(inside("Temperature=310K"), "Temperature|310|K");
  EXPECT_EQ(inside("Temperature = 31.50 K"), "Temperature|315|1e-1 K");
  EXPECT_EQ(inside("Trust=2.5"), "Trust|25|1e-1");
  EXPECT_EQ(inside("Speed=3 m s^-1"), "Speed|3|m s^-1");
  EXPECT_EQ(inside("Period=50ms"), "Period|50000000|ns");
  EXPECT_EQ(inside("period=50ms"), "unknown attribute 'period': it is spelled Period");
  EXPECT_TRUE(std::string(inside("Trust=high")).starts_with("Trust=high: must be a number"));
  EXPECT_TRUE(std::string(inside("Trust")).contains("must be Name=Value"));
}

TEST(ValueTest, DurationMayBeForEver) {
  EXPECT_EQ(print_duration(10'000'000'000), "10 s");
  EXPECT_EQ(print_duration(0), "0 ns");
  EXPECT_EQ(print_duration(kUnbounded), "for ever");
}

TEST(ValueTest, BitrateHasTheLargestUnitThatIsExact) {
  EXPECT_EQ(print_bitrate(0), "unknown");
  EXPECT_EQ(print_bitrate(1'000'000), "1 Mbit/s");
  EXPECT_EQ(print_bitrate(500'000), "500 kbit/s");
  EXPECT_EQ(print_bitrate(83'333), "83333 bit/s");
}

TEST(ValueTest, CanIdentifierIsPrintedAsCandumpDoes) {
  EXPECT_EQ(print_can_id(0x7), "007");
  EXPECT_EQ(print_can_id(0x80000007), "00000007");
  EXPECT_EQ(print_can_id(0x98ffa533), "18ffa533");
  EXPECT_EQ(print_can_id(0x40000123), "123 RTR");
  EXPECT_EQ(print_can_id(0x20000004), "004 error");
}

}  // namespace
}  // namespace mlcca::tools
