// SPDX-License-Identifier: BSD-2-Clause
// Moments and spans on the command line; the numbers are those of date(1).
#include "tools/times.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>

namespace mlcca::tools {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
/// 2026-11-21 14:30:15.5 in Berlin, 13:30:15.5 UTC.
constexpr std::uint64_t kNow = 1'795'267'815 * kSecond + kSecond / 2;

/// Times are those of Berlin, without a database of zones.
struct TimesTest : ::testing::Test {
  TimesTest() { in("CET-1CEST,M3.5.0,M10.5.0/3"); }
  static void in(const char* zone) {
    ::setenv("TZ", zone, 1);  // NOLINT(concurrency-mt-unsafe)
    ::tzset();
  }
};

std::uint64_t moment(std::string_view text, std::uint64_t now = kNow) {
  const auto read = parse_moment(text, now);
  EXPECT_TRUE(read) << read.error().text;
  return read.value_or(0);
}

TEST_F(TimesTest, ReadsDatesAndTimesOfTheLocalZone) {
  EXPECT_EQ(moment("2026-11-21 14:00:00"), 1'795'266'000 * kSecond);
  EXPECT_EQ(moment("2026-11-21 14:00"), 1'795'266'000 * kSecond);
  EXPECT_EQ(moment("2026-11-21  14:00:07"), 1'795'266'007 * kSecond);
  EXPECT_EQ(moment("2026-11-21"), 1'795'215'600 * kSecond);
  EXPECT_EQ(moment("2026-07-01 00:00"), 1'782'856'800 * kSecond) << "summer: two hours";
  EXPECT_EQ(moment("2024-02-29"), 1'709'161'200 * kSecond);
  in("UTC");
  EXPECT_EQ(moment("2026-11-21 14:00:00"), 1'795'269'600 * kSecond);
}

TEST_F(TimesTest, ReadsWhatIsRelativeToNow) {
  EXPECT_EQ(moment("now"), kNow);
  EXPECT_EQ(moment("-1h"), kNow - 3600 * kSecond);
  EXPECT_EQ(moment("-1h30min"), kNow - 5400 * kSecond);
  EXPECT_EQ(moment("10 min ago"), kNow - 600 * kSecond);
  EXPECT_EQ(moment("2 days ago"), kNow - 172'800 * kSecond);
  EXPECT_EQ(moment("today"), 1'795'215'600 * kSecond);
  EXPECT_EQ(moment("yesterday"), 1'795'129'200 * kSecond);
  EXPECT_EQ(moment("14:00"), 1'795'266'000 * kSecond);
  EXPECT_EQ(moment("14:00:09"), 1'795'266'009 * kSecond);
  EXPECT_EQ(moment("@1700000000"), 1'700'000'000 * kSecond);
}

/// Clocks went back at 3:00 on 2026-10-25: that day has 25 hours.
TEST_F(TimesTest, YesterdayIsADayOfTheCalendar) {
  const std::uint64_t monday_0_30 = 1'792'971'000 * kSecond;
  EXPECT_EQ(moment("today", monday_0_30), 1'792'969'200 * kSecond);
  EXPECT_EQ(moment("yesterday", monday_0_30), 1'792'879'200 * kSecond);
}

TEST_F(TimesTest, RefusesWhatIsNoMoment) {
  for (const auto* text : {"",
                           "tomorrow",
                           "2026-02-29",
                           "2026-11-21 24:00",
                           "2026-11-21 14",
                           "2026-11-21x",
                           "2026-13-01",
                           "2026-00-01",
                           "1969-12-31",
                           "14:60",
                           "14:00:60",
                           "14:",
                           ":14",
                           "-",
                           "-5",
                           "-1x",
                           "1h",
                           "ago",
                           " ago",
                           "-2026 years",
                           "-100000w",
                           "@",
                           "@-1",
                           "@1x",
                           "@99999999999999999999",
                           "2026-03-29 02:30",
                           "9999-01-01",
                           "2026--1-01",
                           "-1h-30min"}) {
    const auto read = parse_moment(text, kNow);
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().text.find("such as '2026-11-21 14:00:00'"), std::string::npos);
  }
}

TEST(SpanTest, AddsUpNumbersWithUnits) {
  EXPECT_EQ(*parse_span("30s"), 30 * kSecond);
  EXPECT_EQ(*parse_span("1500 ms"), kSecond + kSecond / 2);
  EXPECT_EQ(*parse_span("1h 30min"), 5400 * kSecond);
  EXPECT_EQ(*parse_span("1d12h"), 129'600 * kSecond);
  EXPECT_EQ(*parse_span("2 weeks"), 1'209'600 * kSecond);
  EXPECT_EQ(*parse_span("0s"), 0U);
  for (const auto* text : {"", "30", "s", "1.5s", "-1s", "1 fortnight", "1s!", "1 s x"})
    EXPECT_FALSE(parse_span(text)) << text;
  EXPECT_EQ(parse_span("99999999999999d").error().text, "'99999999999999d': too long");
}

TEST_F(TimesTest, PrintsMomentsWithMilliseconds) {
  EXPECT_EQ(print_moment(kNow), "2026-11-21 14:30:15.500");
}

}  // namespace
}  // namespace mlcca::tools
