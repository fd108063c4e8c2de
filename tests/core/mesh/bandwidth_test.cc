// SPDX-License-Identifier: BSD-2-Clause
// mlccactl bandwidth as a user runs it, without a daemon.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/tools/run.hpp"

namespace mlcca {
namespace {

using Json = nlohmann::json;
using Arguments = std::vector<std::string>;

constexpr int kRefused = 1;
constexpr int kUsage = 2;

test::Outcome run(Arguments arguments) {
  arguments.insert(arguments.begin(), "bandwidth");
  return test::run_mlccactl(arguments);
}

/// The first line; everything else of a run that succeeds.
std::string first_line(const Arguments& arguments) {
  const auto outcome = run(arguments);
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_EQ(outcome.error, "");
  return outcome.out.substr(0, outcome.out.find('\n'));
}

Json json(Arguments arguments, int status = 0) {
  arguments.emplace_back("--json");
  const auto outcome = run(arguments);
  EXPECT_EQ(outcome.status, status) << outcome.error;
  return Json::parse(outcome.out, nullptr, false);
}

double available(const Arguments& arguments) {
  return json(arguments).at("available_bit_s").get<double>() / 1e6;
}

TEST(BandwidthTest, PrintsTheRateOfThePaperAndNothingElse) {
  const auto outcome = run({"24Mbit/s", "11Mbit/s"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.out, "7.542857 Mbit/s\n");
  EXPECT_EQ(outcome.error, "");
}

TEST(BandwidthTest, KnowsEveryUnit) {
  for (const char* rate : {"24Mbit/s", "24M", "24000k", "24000kbit/s", "0.024Gbit/s", "0.024G",
                           "24000000bit/s", "3MB/s", "3MByte/s", "3000kB/s", "3000KByte/s",
                           "3000kByte/s", "3000000B/s", "3000000Byte/s", "0.003GB/s", "24 Mbit/s"})
    EXPECT_EQ(first_line({rate}), "24.000000 Mbit/s") << rate;
  EXPECT_EQ(first_line({"500kbit/s"}), "0.500000 Mbit/s");
  EXPECT_EQ(first_line({"1.5Gbit/s"}), "1500.000000 Mbit/s");
  EXPECT_EQ(first_line({"1KiB/s"}), "0.008192 Mbit/s");
  EXPECT_EQ(first_line({"1MiB/s"}), "8.388608 Mbit/s");
  EXPECT_EQ(first_line({"1.9bit/s"}), "0.000001 Mbit/s") << "rounded down";
}

TEST(BandwidthTest, TheFirstLineStaysWhateverElseIsAsked) {
  EXPECT_EQ(first_line({"24M", "11M", "--limit", "0.5", "--packet", "100", "--loss", "0.1"}),
            "7.542857 Mbit/s");
}

TEST(BandwidthTest, LimitAndBackgroundLeaveTheRest) {
  EXPECT_NEAR(available({"24M", "11M"}), 6.034, 5e-4) << "0.8 by default";
  EXPECT_NEAR(available({"24M", "11M", "--limit", "1"}), 7.542857, 1e-4);
  EXPECT_NEAR(available({"24M", "11M", "--limit", "100%"}), 7.542857, 1e-4);
  // 0.7 / (1/24 + 1/11) = 0.7 * 264/35
  EXPECT_NEAR(available({"24M", "11M", "--background", "0.1"}), 5.28, 1e-4);
  EXPECT_NEAR(available({"24M", "11M", "--background", "0.9"}), 0, 1e-9);
}

TEST(BandwidthTest, LossOfALinkOrOfAll) {
  // 0.8 / (1/24 / 0.5 + 1/11)
  const double half_lost = 0.8 / (2.0 / 24 + 1.0 / 11);
  EXPECT_NEAR(available({"24M:0.5", "11M"}), half_lost, 1e-4);
  EXPECT_NEAR(available({"24M:50%", "11M"}), half_lost, 1e-4);
  EXPECT_NEAR(available({"24M", "11M:0", "--loss", "0.5"}), half_lost, 1e-4);
  EXPECT_NEAR(available({"24M:1"}), 0, 1e-9);
}

TEST(BandwidthTest, OverheadCountsForEachPacket) {
  // 1500 bytes: 169.5 + 8 * 1536 / 24 = 681.5 us, a frame exchange of 802.11 at 24 Mbit/s
  const Arguments wlan{"24M", "--limit",       "1",    "--packet", "1500", "--header",
                       "36",  "--overhead-us", "169.5"};
  EXPECT_NEAR(available(wlan), 12000 / 681.5, 1e-4);
}

TEST(BandwidthTest, LinksFarApartDoNotShare) {
  const Arguments chain{"24M", "11M", "24M", "24M", "--limit", "1"};
  const auto with = [&](const std::string& domain) {
    Arguments arguments = chain;
    arguments.insert(arguments.end(), {"--domain", domain});
    return available(arguments);
  };
  EXPECT_NEAR(with("single-domain"), 4.632, 5e-4);
  EXPECT_NEAR(with("1-hop"), 4.632, 5e-4);
  EXPECT_NEAR(with("0-hop"), 5.739, 5e-4);
}

TEST(BandwidthTest, ADemandFitsOrNot) {
  const auto video = run({"24Mbit/s", "11Mbit/s", "--demand", "400KByte/s"});
  EXPECT_EQ(video.status, 0) << video.error;
  EXPECT_NE(video.out.find("3.200000 Mbit/s takes 42.43 %: fits"), std::string::npos) << video.out;
  const auto second = run({"24M", "11M", "--demand", "400KByte/s", "--background", "0.4242"});
  EXPECT_EQ(second.status, kRefused);
  EXPECT_NE(second.out.find("does not fit"), std::string::npos) << second.out;
  const auto low = run({"24M", "11M", "--demand", "100KByte/s", "--background", "0.4242"});
  EXPECT_EQ(low.status, 0);
}

TEST(BandwidthTest, ExactlyWhatIsAvailableFits) {
  const auto most = json({"24M", "11M"}).at("available_bit_s").get<std::uint64_t>();
  EXPECT_EQ(run({"24M", "11M", "--demand", std::to_string(most) + "bit/s"}).status, 0);
  EXPECT_EQ(run({"24M", "11M", "--demand", std::to_string(most + 1) + "bit/s"}).status, kRefused);
}

TEST(BandwidthTest, JsonHasBothNumbers) {
  const Json answer =
      json({"24M", "11M:0.25", "--domain", "2-hop", "--demand", "80Mbit/s"}, kRefused);
  EXPECT_EQ(answer.at("path_rate_bit_s"), 7'542'857);
  EXPECT_NEAR(answer.at("available_bit_s").get<double>(), 0.8e6 / (1.0 / 24 + 4.0 / 33), 100);
  EXPECT_EQ(answer.at("limited_by"), "around 1 > 2");
  EXPECT_DOUBLE_EQ(answer.at("links").at(1).at("loss").get<double>(), 0.25);
  EXPECT_EQ(answer.at("links").at(0).at("rate_bit_s"), 24'000'000);
  EXPECT_EQ(answer.at("demand").at("rate_bit_s"), 80'000'000);
  EXPECT_NEAR(answer.at("demand").at("medium_time").get<double>(), 80 * (1.0 / 24 + 4.0 / 33),
              1e-6);
  EXPECT_EQ(answer.at("demand").at("fits"), false);
  EXPECT_TRUE(json({"24M"}).at("demand").is_null());
}

TEST(BandwidthTest, WhatCannotBeUsedIsExplained) {
  struct Wrong {
    Arguments arguments;
    const char* explanation;
  };
  const std::vector<Wrong> wrongs = {
      {{"24"}, "'24': needs a unit"},
      {{"24furlongs"}, "needs a unit of k, M or G (bit/s), bit/s, kbit/s"},
      {{"fast"}, "must begin with a number"},
      {{"-5M"}, "-5M"},
      {{"0Mbit/s"}, "must be 1 bit/s or more"},
      {{"99999999999Gbit/s"}, "too large"},
      {{"24M", "11M:2"}, "loss of '11M:2': '2': must be at most 1 or 100%"},
      {{"24M", "--loss", "1s"}, "--loss '1s': must be a share"},
      {{"24M", "--limit", "1.1"}, "--limit '1.1': must be at most 1"},
      {{"24M", "--background", "x"}, "--background 'x': must begin with a number"},
      {{"24M", "--domain", "17-hop"}, "must be single-domain, or 0-hop to 16-hop"},
      {{"24M", "--domain", "two-hop"}, "must be single-domain, or 0-hop to 16-hop"},
      {{"24M", "--overhead-us", "1ms"}, "--overhead-us '1ms': must be a number of microseconds"},
      {{"24M", "--demand", "5"}, "--demand '5': needs a unit"},
      {{"24M", "--packet", "0"}, "--packet"},
      {{"24M", "--packet", "65536"}, "--packet"},
      {Arguments(33, "24M"), "33 rates: must be at most 32"},
      {{}, "rate"},
  };
  for (const auto& wrong : wrongs) {
    const auto outcome = run(wrong.arguments);
    EXPECT_EQ(outcome.status, kUsage) << wrong.explanation;
    EXPECT_EQ(outcome.out, "") << wrong.explanation;
    EXPECT_NE(outcome.error.find(wrong.explanation), std::string::npos) << outcome.error;
  }
}

TEST(BandwidthTest, TakesAsManyLinksAsARouteMayHave) {
  EXPECT_EQ(first_line(Arguments(32, "32M")), "1.000000 Mbit/s");
}

}  // namespace
}  // namespace mlcca
