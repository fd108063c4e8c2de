// SPDX-License-Identifier: BSD-2-Clause
// What becomes of mlccad's answers on the page that Prometheus reads.
#include "tools/exporter/metrics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/control/messages.hpp"
#include "tests/control/server.hpp"
#include "tools/exporter/exposition.hpp"
#include "tools/exporter/scrapes.hpp"

namespace mlcca {
namespace {

using exporter::Answers;
using exporter::kind_of;
using exporter::Most;

bool has(const std::string& page, const std::string& line) {
  return ('\n' + page).find('\n' + line + '\n') != std::string::npos;
}

std::size_t series(const std::string& page, const std::string& metric) {
  std::size_t count = 0;
  const std::string at_front = '\n' + metric + '{';
  for (auto at = page.find(at_front); at != std::string::npos; at = page.find(at_front, at + 1))
    ++count;
  return count;
}

control::Channel delivery(const std::string& name, bool granted) {
  control::Channel c;
  c.name = name;
  c.publisher = "p";
  c.from = "a";
  c.to = "b";
  c.granted = granted;
  return c;
}

Answers answers_with(std::vector<control::Channel> channels) {
  Answers answers;
  answers.live.status.emplace();
  answers.live.channels.emplace();
  answers.live.channels->channels = std::move(channels);
  return answers;
}

std::string page_of(const Answers& answers, const Most& most = {}) {
  return exporter::page(answers, most, {}, 0.25);
}

/// Counters of one slot are in two series then: who adds them up can see that.
TEST(ExporterPage, SaysWhoseCountersAreThoseOfSeveralPublishers) {
  auto a = delivery("c", true);
  a.counts_shared = true;
  a.passed = 40;
  auto b = a;
  b.publisher = "q";
  const auto page = page_of(answers_with({a, b, delivery("alone", true)}));
  const auto of = [](const std::string& channel, const std::string& publisher) {
    return "mlcca_delivery_shared{channel=\"" + channel + "\",publisher=\"" + publisher +
           "\",from=\"a\",to=\"b\"} ";
  };
  EXPECT_TRUE(has(page, of("c", "p") + "1")) << page;
  EXPECT_TRUE(has(page, of("c", "q") + "1"));
  EXPECT_TRUE(has(page, of("alone", "p") + "0"));
}

TEST(ExporterPage, KnowsNothingWithoutADaemon) {
  Answers answers;
  answers.reports.networks.emplace();
  answers.reports.networks->networks.push_back({.name = "robot"});
  const auto page = page_of(answers);
  EXPECT_TRUE(has(page, "mlcca_up 0"));
  EXPECT_TRUE(has(page, "mlcca_health 3"));
  EXPECT_EQ(page.find("mlcca_health_reason"), std::string::npos);
  EXPECT_EQ(page.find("robot"), std::string::npos);
}

TEST(ExporterPage, NumbersTheHealthAsTheExitStatusOfStatusCheck) {
  Answers answers;
  answers.live.status.emplace();
  auto& health = answers.live.status->health;
  using control::HealthState;
  const auto with = [&](HealthState state) {
    health.state = state;
    return page_of(answers);
  };
  EXPECT_TRUE(has(with(HealthState::healthy), "mlcca_health 0"));
  EXPECT_TRUE(has(with(HealthState::degraded), "mlcca_health 1"));
  EXPECT_TRUE(has(with(HealthState::closed), "mlcca_health 2"));
  EXPECT_TRUE(has(with(HealthState::unknown), "mlcca_health 3"));
  health.reasons = {"18 frames on lan in the last 42 s", "19 frames on lan in the last 44 s"};
  health.left_out = 3;
  const auto page = page_of(answers);
  EXPECT_TRUE(has(page, "mlcca_health_reasons 5"));
  EXPECT_EQ(series(page, "mlcca_health_reason"), 1U);
  EXPECT_TRUE(has(page, "mlcca_health_reason{reason=\"N frames on lan in the last N s\"} 1"));
  EXPECT_TRUE(has(page, "mlcca_exporter_left_out{kind=\"reasons\"} 3"));
}

TEST(ExporterPage, ReplacesNumbersButNotNames) {
  EXPECT_EQ(kind_of("can0 (robot-2): 3 of 12.5 ms"), "can0 (robot-2): N of N ms");
  EXPECT_EQ(kind_of("from 10.0.0.7, 02:00:5e:10:00:01, 0x4e6f"), "from N, N, N");
  EXPECT_EQ(kind_of("fe80::1: can0-100 of 0xb1ue, bed-1.2.3, ab:cd"),
            "N: can0-100 of 0xb1ue, bed-1.2.3, ab:cd");
  EXPECT_EQ(kind_of("Omission 2 required, bridge provides 5 (3 too many)"),
            "Omission N required, bridge provides N (N too many)");
  EXPECT_EQ(kind_of("1"), "N");
  EXPECT_EQ(kind_of("for 5: 6."), "for N: N.");
  EXPECT_EQ(kind_of(""), "");
}

/// Any station can send them, and each would be a series for ever.
TEST(ExporterPage, HasTheSameSeriesWhateverUnknownSendersChoose) {
  Answers answers;
  answers.live.status.emplace();
  auto& reasons = answers.live.status->health.reasons;
  const auto with = [&](const std::string& latest) {
    reasons = {
        "a from lan (p) to g: 3 frames on lan in the last 4 s named no known subject, the "
        "latest " +
            latest + ": does the publisher send by another name?",
        "lan: frames of " + latest};
    return page_of(answers);
  };
  const auto page = with("0x4e6f626f64790000 from 192.0.2.7 (02:00:5e:10:00:01)");
  EXPECT_EQ(page, with("0xa4efeccc3210b497 from 198.51.100.77 (02:00:5e:10:aa:ff)"));
  EXPECT_TRUE(has(page,
                  "mlcca_health_reason{reason=\"a from lan (p) to g: N frames on lan in the "
                  "last N s named no known subject\"} 1"))
      << page;
}

TEST(ExporterPage, GivesTheReasonOtherToFramesOfWhichNoneIsStated) {
  Answers answers;
  answers.live.status.emplace();
  auto& i = answers.live.status->interfaces.emplace_back();
  i.name = "can0";
  i.network = "robot";
  i.ingress.dropped = 7;
  i.ingress.reasons = {{"no-slot", 5}};
  const auto page = page_of(answers);
  const std::string of =
      R"(mlcca_interface_frames_dropped_total{interface="can0",network="robot",)";
  EXPECT_TRUE(has(page, of + R"(direction="in",reason="no-slot"} 5)"));
  EXPECT_TRUE(has(page, of + R"(direction="in",reason="other"} 2)"));
}

TEST(ExporterPage, CountsWhatPassedAsNoDrop) {
  Answers answers;
  answers.live.status.emplace();
  auto& i = answers.live.status->interfaces.emplace_back();
  i.name = "eth0";
  i.network = "lan";
  i.ingress.passed = 40;
  i.ingress.dropped = 3;
  i.ingress.reasons = {{"passed", 40, true}, {"no event traffic", 12, true}, {"malformed", 3}};
  const auto page = page_of(answers);
  const auto of = [](const std::string& metric, const std::string& rest) {
    return "mlcca_interface_frames_" + metric +
           R"(_total{interface="eth0",network="lan",direction="in",)" + rest;
  };
  EXPECT_TRUE(has(page, of("passed", R"(kind="admitted"} 40)")));
  EXPECT_TRUE(has(page, of("passed", R"(kind="no event traffic"} 12)")));
  EXPECT_TRUE(has(page, of("dropped", R"(reason="malformed"} 3)")));
  EXPECT_TRUE(has(page, of("dropped", R"(reason="other"} 0)")));
  EXPECT_EQ(page.find(R"(reason="passed")"), std::string::npos);
  EXPECT_EQ(page.find(R"(reason="no event traffic")"), std::string::npos);
}

TEST(ExporterPage, ShowsRefusedDeliveriesFirstAndCountsWhatItLeavesOut) {
  auto troubled = delivery("troubled", true);
  troubled.problems = {"nothing has come"};
  const auto page = page_of(answers_with({delivery("well", true), delivery("better", true),
                                          troubled, delivery("refused", false)}),
                            {.deliveries = 2});
  EXPECT_EQ(series(page, "mlcca_delivery_granted"), 2U);
  EXPECT_TRUE(
      has(page, R"(mlcca_delivery_granted{channel="refused",publisher="p",from="a",to="b"} 0)"));
  EXPECT_TRUE(
      has(page, R"(mlcca_delivery_problems{channel="troubled",publisher="p",from="a",to="b"} 1)"));
  EXPECT_TRUE(has(page, R"(mlcca_exporter_left_out{kind="deliveries"} 2)"));
}

/// Two values of one series would make Prometheus refuse the whole page.
TEST(ExporterPage, JoinsAdmissionsThatDifferInTheirNumberAlone) {
  auto first = delivery("stop", true);
  first.passed = 3;
  auto second = delivery("stop", false);
  second.admission = 7;
  second.passed = 4;
  const auto page = page_of(answers_with({first, second}));
  const std::string labels = R"({channel="stop",publisher="p",from="a",to="b"} )";
  EXPECT_EQ(series(page, "mlcca_delivery_granted"), 1U);
  EXPECT_TRUE(has(page, "mlcca_delivery_granted" + labels + "0"));
  EXPECT_TRUE(has(page, "mlcca_delivery_frames_passed_total" + labels + "7"));
}

/// Nobody counts frames that no gate sees.
TEST(ExporterPage, CountsNoFramesOfWhatCrossesNoGateHere) {
  auto elsewhere = delivery("elsewhere", true);
  elsewhere.crosses_no_gate = true;
  const auto page = page_of(answers_with({elsewhere, delivery("here", true)}));
  EXPECT_EQ(series(page, "mlcca_delivery_frames_passed_total"), 1U);
  EXPECT_TRUE(
      has(page,
          R"(mlcca_delivery_frames_passed_total{channel="here",publisher="p",from="a",to="b"} 0)"));
}

TEST(ExporterPage, EscapesWhatStandsInLabels) {
  exporter::Family family("m", "gauge", "help");
  family.add(exporter::Labels{{"name", "a\"b\\c\nd"}}, std::uint64_t{1});
  EXPECT_EQ(family.text(), "# HELP m help\n# TYPE m gauge\nm{name=\"a\\\"b\\\\c\\nd\"} 1\n");
  EXPECT_EQ(exporter::Family("empty", "gauge", "help").text(), "");
}

TEST(ExporterPage, SaysHowTheGatewayStandsInItsCluster) {
  Answers answers;
  answers.live.status.emplace();
  answers.live.cluster = test::full_cluster();
  answers.reports.members = test::full_cluster_members();
  const auto page = page_of(answers);
  EXPECT_TRUE(has(page, "mlcca_cluster_phase{phase=\"other-description\"} 1")) << page;
  EXPECT_TRUE(has(page, "mlcca_cluster_shared{state=\"closed\"} 1"));
  EXPECT_TRUE(has(page, "mlcca_cluster_lasts_seconds 8.25"));
  EXPECT_TRUE(has(page, "mlcca_cluster_store_up 1"));
  EXPECT_TRUE(has(page, "mlcca_cluster_description_same 0"));
  EXPECT_TRUE(has(page, R"(mlcca_cluster_member{gateway="gw2",state="silent"} 1)"));
  EXPECT_TRUE(has(page, R"(mlcca_cluster_member{gateway="gw9",state="removed"} 1)"));
  EXPECT_TRUE(has(page, R"(mlcca_cluster_member_beat_age_seconds{gateway="gw2"} 75)"));
  EXPECT_TRUE(has(page, R"(mlcca_cluster_reservations{gateway="gw1",network="mesh"} 1)"));
  EXPECT_TRUE(
      has(page, R"(mlcca_cluster_reserved_bytes_per_second{gateway="gw1",network="mesh"} 400000)"));
  EXPECT_EQ(series(page, "mlcca_cluster_member_beat_age_seconds"), 2U) << "gw3 has none";
  EXPECT_EQ(series(page_of(answers, {.others = 1}), "mlcca_cluster_member"), 1U);
  EXPECT_TRUE(has(page_of(answers, {.others = 1}), "mlcca_exporter_left_out{kind=\"gateways\"} 3"));
}

TEST(ExporterPage, SaysNothingOfAClusterThatTheGatewayIsNotIn) {
  Answers answers;
  answers.live.status.emplace();
  answers.live.cluster.emplace();
  answers.reports.members.emplace();
  EXPECT_EQ(page_of(answers).find("mlcca_cluster"), std::string::npos);
}

/// A daemon that counts what it is asked, and refuses `refused` where that is not empty.
struct Scene {
  test::Server server{[this](const control::Request& request) {
    if (std::holds_alternative<control::StatusRequest>(request.body)) {
      control::Status status;
      status.loaded_unix_s = loaded;
      return test::Server::Answer{{{0, status}}};
    }
    if (std::holds_alternative<control::ChannelsRequest>(request.body))
      return test::Server::Answer{{{0, control::Channels{}}}};
    if (std::holds_alternative<control::NetworksRequest>(request.body)) {
      ++reports;
      control::Networks networks;
      networks.networks.push_back({.name = "n" + std::to_string(reports)});
      return test::Server::Answer{{{0, networks}}};
    }
    return test::Server::Answer{{{0, control::Error{control::ErrorKind::world, "full", {}}}}};
  }};
  std::uint64_t loaded = 1;
  int reports = 0;
  std::uint64_t now = 1'000'000'000;
  std::vector<std::string> said;
  exporter::Scrapes scrapes{{.socket = server.path(), .most = {}},
                            [this](const std::string& text) { said.push_back(text); },
                            [this] { return now; }};

  std::string network() {
    const auto page = scrapes.page();
    const auto at = page.find("mlcca_network_available{network=\"");
    return at == std::string::npos ? "" : page.substr(at + 33, 2);
  }
};

TEST(ExporterScrapes, AsksForReportsBetweenScrapesAndNeverShowsThoseOfAnotherDescription) {
  Scene scene;
  EXPECT_EQ(scene.network(), "n1");
  EXPECT_FALSE(scene.scrapes.has_work());
  EXPECT_EQ(scene.network(), "n1");
  ASSERT_TRUE(scene.scrapes.has_work());
  scene.now += 59'000'000'000;
  EXPECT_EQ(scene.network(), "n1");
  scene.now += 2'000'000'000;
  EXPECT_EQ(scene.network(), "n2");  // after a minute
  scene.loaded = 2;
  EXPECT_EQ(scene.network(), "n3");
}

TEST(ExporterScrapes, SaysOnceWhatTheDaemonRefusesAndCountsEachTime) {
  Scene scene;
  (void)scene.network();
  ASSERT_EQ(scene.said.size(), 5U);
  EXPECT_EQ(std::ranges::count(scene.said, "gate: full"), 1);
  scene.loaded = 2;
  const auto page = scene.scrapes.page();
  EXPECT_EQ(scene.said.size(), 5U);
  EXPECT_TRUE(has(page, R"(mlcca_exporter_scrape_errors_total{request="gate"} 2)"));
}

}  // namespace
}  // namespace mlcca
