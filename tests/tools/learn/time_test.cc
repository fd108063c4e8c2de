// SPDX-License-Identifier: BSD-2-Clause
// Recordings whose time does not go on: files in any order, a clock that is set back, pauses.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/design/describe/program.hpp"
#include "tests/tools/learn/traffic.hpp"

namespace mlcca::test {
namespace {

using learn::test::kMs;
using learn::test::kSecond;
using Moved = std::function<std::uint64_t(std::uint64_t)>;

constexpr std::uint64_t kBegin = 1'700'000'000 * kSecond;

std::uint64_t unmoved(std::uint64_t ns) { return ns; }

/// Three channels, every 10 ms, 100 ms and 1 s; `moved` says which time stamp a frame has.
std::string bus(std::uint64_t from_s, std::uint64_t to_s, const Moved& moved = unmoved,
                std::uint64_t begin = kBegin) {
  std::string out;
  const auto put = [&](std::uint64_t ns, const char* id) {
    std::array<char, 64> line{};
    const std::uint64_t us = (begin + moved(ns)) / 1000;
    std::snprintf(line.data(), line.size(), "(%llu.%06llu) can0 %s#%08llX\n",
                  static_cast<unsigned long long>(us / 1'000'000),
                  static_cast<unsigned long long>(us % 1'000'000), id,
                  static_cast<unsigned long long>(ns / kMs));
    out += line.data();
  };
  for (std::uint64_t ms = from_s * 1000; ms < to_s * 1000; ms += 10) {
    // No event is on time to the microsecond.
    const std::uint64_t late = ms * 7919 % 300 * 1000;
    put(ms * kMs + late, "100");
    if (ms % 100 == 0) put(ms * kMs + kMs + late, "200");
    if (ms % 1000 == 0) put(ms * kMs + 2 * kMs + late, "300");
  }
  return out;
}

struct LearnTime : ::testing::Test {
  /// What is learned of recordings with these texts, in this order.
  Ran learned(const std::vector<std::string>& texts) {
    std::vector<std::string> arguments{"learn"};
    for (std::size_t i = 0; i < texts.size(); ++i)
      arguments.push_back(folder.write("part" + std::to_string(i + 1) + ".log", texts[i]));
    return run(arguments);
  }
  Folder folder;
};

/// Of a channel in the draft: "10ms", and whether it states an Omission as periodic ones do.
struct Stated {
  std::string period;
  std::string omission;
};
Stated stated(const Ran& ran, const std::string& channel) {
  const auto value = [&ran](std::size_t from, std::size_t to, const std::string& name) {
    const auto at = ran.out.find(name + "=\"", from);
    if (at == std::string::npos || at > to) return std::string();
    const auto begin = at + name.size() + 2;
    return ran.out.substr(begin, ran.out.find('"', begin) - begin);
  };
  const auto at = ran.out.find("<EventChannel name=\"" + channel + "\"");
  const auto end = ran.out.find("</EventChannel>", at);
  EXPECT_NE(at, std::string::npos) << channel << ran.out << ran.error;
  return {value(at, end, "period"), value(at, end, "omission")};
}

/// All three channels are periodic with their Periods, and nothing was lost.
void expect_as_sent(const Ran& ran, const std::string& slow = "1s") {
  EXPECT_EQ(ran.status, 0) << ran.error;
  const std::vector<std::pair<std::string, std::string>> all = {
      {"can0-100", "10ms"}, {"can0-200", "100ms"}, {"can0-300", slow}};
  for (const auto& [channel, period] : all) {
    EXPECT_EQ(stated(ran, channel).period, period) << channel << ran.error;
    EXPECT_EQ(stated(ran, channel).omission, "1") << channel << ran.error;
  }
}

// --- time that goes back -------------------------------------------------------------------------

TEST_F(LearnTime, PartsThatFollowEachOtherAreOneRecording) {
  const Ran ran = learned({bus(0, 30), bus(30, 60)});
  expect_as_sent(ran);
  EXPECT_EQ(ran.error, "");
  EXPECT_EQ(ran.out, learned({bus(0, 60)}).out);
}

TEST_F(LearnTime, PartsInTheWrongOrderGiveTheSameChannels) {
  const Ran ran = learned({bus(40, 80), bus(0, 40)});
  expect_as_sent(ran);
  EXPECT_TRUE(ran.error.contains("part2.log begins before ")) << ran.error;
}

TEST_F(LearnTime, AClockThatIsSetBackGivesNoRate) {
  for (const std::uint64_t by : {kSecond / 4, 2 * kSecond, 30 * kSecond}) {
    const Ran ran =
        learned({bus(0, 80, [by](std::uint64_t ns) { return ns < 40 * kSecond ? ns + by : ns; })});
    expect_as_sent(ran);
    EXPECT_TRUE(ran.error.contains("can0: time goes back by ")) << ran.error;
    EXPECT_TRUE(ran.error.contains("part1.log, to 1700000040.")) << ran.error;
  }
}

TEST_F(LearnTime, AFewMillisecondsBackGiveNoRateEither) {
  expect_as_sent(learned(
      {bus(0, 80, [](std::uint64_t ns) { return ns < 40 * kSecond ? ns + 60 * kMs : ns; })}));
}

TEST_F(LearnTime, APartThatIsAppendedOutOfOrderGivesNoRate) {
  const Ran ran = learned({bus(40, 80) + bus(0, 40) + bus(80, 120)});
  expect_as_sent(ran);
  EXPECT_TRUE(ran.error.contains("can0: time goes back by ")) << ran.error;
}

TEST_F(LearnTime, OfFewEventsTheStepIsNoGap) {
  const Ran ran =
      learned({bus(0, 20, [](std::uint64_t ns) { return ns < 10 * kSecond ? ns + kSecond : ns; })});
  EXPECT_EQ(stated(ran, "can0-300").period, "500ms") << "half the mean";
}

TEST_F(LearnTime, ARecordingCountsOnce) {
  const auto path = folder.write("part1.log", bus(0, 2));
  const Ran ran = run({"learn", path, folder.path("./part1.log")});
  EXPECT_EQ(ran.status, 2) << ran.out;
  EXPECT_TRUE(ran.error.contains("is given twice")) << ran.error;
}

TEST_F(LearnTime, RecordingsOfTheSameTimeAreNamedAndGiveNoRate) {
  const Ran ran = learned({bus(0, 60), bus(20, 60)});
  expect_as_sent(ran);
  EXPECT_TRUE(ran.error.contains("part2.log has frames of the same time as ")) << ran.error;
}

TEST_F(LearnTime, RecordingsThatCountFromTheirBeginningNeedNoNote) {
  const Ran ran = learned({bus(0, 60, unmoved, 0), bus(0, 60, unmoved, 0)});
  expect_as_sent(ran);
  EXPECT_EQ(ran.error, "");
}

// --- pauses --------------------------------------------------------------------------------------

TEST_F(LearnTime, APauseOfAWholeBusIsNoneOfItsChannels) {
  const Ran ran = learned(
      {bus(0, 80, [](std::uint64_t ns) { return ns < 40 * kSecond ? ns : ns + 2300 * kMs; })});
  expect_as_sent(ran);
  EXPECT_TRUE(ran.error.contains("can0: 1 pause in which nothing at all came, of 2.3"))
      << ran.error;
}

/// Forty identifiers, each every 10 ms, until a time and again 10 s later.
std::string begun_shortly_before(std::uint64_t pause_ms) {
  std::string out;
  const auto put = [&](std::uint64_t us) {
    for (unsigned id = 0; id < 40; ++id) {
      std::array<char, 64> line{};
      const std::uint64_t at = us + id * 230;
      std::snprintf(line.data(), line.size(), "(%llu.%06llu) can0 1%02X#0011223344556677\n",
                    static_cast<unsigned long long>(1'700'000'000 + at / 1'000'000),
                    static_cast<unsigned long long>(at % 1'000'000), id);
      out += line.data();
    }
  };
  for (std::uint64_t ms = 0; ms < 20'000; ms += 10) put((ms < pause_ms ? ms : ms + 10'000) * 1000);
  return out;
}

TEST_F(LearnTime, APauseSoonAfterTheBeginningIsOne) {
  const Ran ran = learned({begun_shortly_before(200)});
  EXPECT_TRUE(ran.error.contains("can0: 1 pause in which nothing at all came, of 10")) << ran.error;
  EXPECT_EQ(stated(ran, "can0-100").period, "10ms");
  EXPECT_EQ(stated(ran, "can0-127").omission, "1");
}

TEST_F(LearnTime, OfTooLittleTrafficNothingIsAPause) {
  EXPECT_EQ(learned({begun_shortly_before(50)}).error.find("pause in which nothing"),
            std::string::npos);
}

TEST_F(LearnTime, SeveralPausesAreCountedWithTheLongest) {
  const Ran ran = learned({bus(0, 90, [](std::uint64_t ns) {
    return ns + (ns < 30 * kSecond ? 0 : 5 * kSecond) + (ns < 60 * kSecond ? 0 : 7200 * kSecond);
  })});
  expect_as_sent(ran);
  EXPECT_TRUE(
      ran.error.contains("can0: 2 pauses in which nothing at all came, the longest of 7200 s"))
      << ran.error;
}

TEST_F(LearnTime, RecordingsADayApartHaveAPause) {
  const Ran ran = learned({bus(0, 20), bus(86'400, 86'420)});
  expect_as_sent(ran);
  EXPECT_TRUE(ran.error.contains("can0: 1 pause in which nothing at all came")) << ran.error;
}

TEST_F(LearnTime, APauseOfOneChannelIsItsOwn) {
  std::string text;
  std::string line;
  for (const char c : bus(0, 80)) {
    line += c;
    if (c != '\n') continue;
    const bool silent = line.contains(" 200#") && line > "(1700000040" && line < "(1700000043";
    if (!silent) text += line;
    line.clear();
  }
  const Ran ran = learned({text});
  EXPECT_EQ(stated(ran, "can0-200").period, "100ms");
  EXPECT_EQ(stated(ran, "can0-200").omission, "1") << "a pause is no loss";
  EXPECT_EQ(stated(ran, "can0-100").omission, "1");
  EXPECT_TRUE(ran.error.contains("can0: 0x200 paused while others went on")) << ran.error;
  const Ran json = run({"learn", folder.path("part1.log"), "--json"});
  EXPECT_TRUE(json.out.contains(R"("pauses":1,"longest_pause_ns":3)")) << json.out;
  EXPECT_TRUE(json.out.contains(R"("pauses":0,"longest_pause_ns":0)")) << json.out;
}

TEST_F(LearnTime, WhereEventsAreSeldomTheirGapsAreNoPauses) {
  std::string text;
  std::uint64_t at = 0;
  for (unsigned i = 0; i < 90; ++i) {
    if (i % 3 == 0) at += 1000 + i * 7919 % 4000;
    text += "(" + std::to_string(1'700'000'000 + at / 1000) + "." +
            std::to_string(1000 + at % 1000).substr(1) + ") can0 400#0102\n";
    at += 2;
  }
  const Ran ran = learned({text});
  EXPECT_EQ(ran.error, "");
  EXPECT_EQ(stated(ran, "can0-400").omission, "");
  EXPECT_EQ(stated(ran, "can0-400").period, "376.2ms")
      << "a third of the mean, which is a third of what is between three events";
}

}  // namespace
}  // namespace mlcca::test
