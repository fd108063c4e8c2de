// SPDX-License-Identifier: BSD-2-Clause
// What top computes, how it sorts, what keys do and how it lays rows out: no terminal, no daemon.
#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "tools/top/layout.hpp"
#include "tools/top/sample.hpp"
#include "tools/top/view.hpp"

namespace mlcca::tools::top {
namespace {

constexpr std::uint64_t kSecondNs = 1'000'000'000;

control::Channel delivery(const std::string& name, std::uint64_t passed, std::uint64_t dropped) {
  control::Channel c;
  c.subject = 0x10;
  c.name = name;
  c.publisher = "p-" + name;
  c.from = "second-can";
  c.to = "robot-can";
  c.route = {"second-can", "bridge", "robot-can"};
  c.granted = true;
  c.passed = passed;
  c.dropped = dropped;
  control::Row period;
  period.attribute = "Period";
  period.required = 50'000'000;
  c.rows = {period};
  return c;
}

Sample sample(std::uint64_t at_s, std::vector<control::Channel> channels) {
  Sample s;
  s.at_ns = at_s * kSecondNs;
  s.channels.channels = std::move(channels);
  return s;
}

// --- rates ---------------------------------------------------------------------------------------

TEST(TopRatesTest, ARateIsTheDifferenceOverTheTime) {
  const auto before = sample(10, {delivery("beat", 100, 7)});
  const auto now = sample(12, {delivery("beat", 140, 8)});
  const auto rows = rows_by_subject(&before, now);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].name, "beat");
  EXPECT_EQ(rows[0].place, "second-can > robot-can");
  EXPECT_DOUBLE_EQ(rows[0].rate.value(), 20);
  EXPECT_DOUBLE_EQ(rows[0].drops.value(), 0.5);
  EXPECT_DOUBLE_EQ(rows[0].used.value(), 1);  // 20 a second of one each 50 ms
}

/// Between two programs no gate counts its frames.
TEST(TopRatesTest, EventsThatCrossNoGateAreCountedWhereTheyAreWatched) {
  control::Channel c = delivery("beat", 0, 0);
  c.watch = control::Watch{.period_ns = 50'000'000, .events = 100};
  const auto before = sample(10, {c});
  c.watch->events = 140;
  EXPECT_DOUBLE_EQ(rows_by_subject(&before, sample(12, {c})).at(0).rate.value(), 20);
}

TEST(TopRatesTest, TheFirstPollHasNoRates) {
  const auto rows = rows_by_subject(nullptr, sample(10, {delivery("beat", 100, 7)}));
  EXPECT_FALSE(rows.at(0).rate);
  EXPECT_FALSE(rows.at(0).drops);
  EXPECT_FALSE(rows.at(0).used);
}

TEST(TopRatesTest, WhoIsNewHasNoRateYet) {
  const auto before = sample(10, {delivery("beat", 100, 7)});
  const auto rows =
      rows_by_subject(&before, sample(11, {delivery("beat", 100, 7), delivery("new", 9, 9)}));
  EXPECT_TRUE(rows.at(0).rate);
  EXPECT_FALSE(rows.at(1).rate);
}

TEST(TopRatesTest, ACounterThatStartedAgainCountsFromZero) {
  const auto before = sample(10, {delivery("beat", 100'000, 7)});
  const auto rows = rows_by_subject(&before, sample(11, {delivery("beat", 30, 0)}));
  EXPECT_DOUBLE_EQ(rows.at(0).rate.value(), 30);
  EXPECT_DOUBLE_EQ(rows.at(0).drops.value(), 0);
}

TEST(TopRatesTest, AClockThatStandsStillGivesNoRate) {
  const auto before = sample(10, {delivery("beat", 100, 7)});
  EXPECT_FALSE(rows_by_subject(&before, sample(10, {delivery("beat", 200, 7)})).at(0).rate);
}

TEST(TopRatesTest, WatchedEventsReportJitterLossAndWhatIsUsed) {
  auto channel = delivery("beat", 0, 0);
  channel.watch.emplace();
  channel.watch->period_ns = 100'000'000;
  channel.watch->events = 30;
  const auto before = sample(10, {channel});
  channel.passed = 60;  // three frames each
  channel.watch->events = 50;
  channel.watch->missing = 50;
  channel.watch->last_gap_ns = 99'000'000;
  channel.watch->jitter_ns = 1'200'000;
  auto rows = rows_by_subject(&before, sample(12, {channel}));
  EXPECT_DOUBLE_EQ(rows.at(0).jitter.value(), 0.0012);
  EXPECT_DOUBLE_EQ(rows.at(0).loss.value(), 0.5);
  EXPECT_DOUBLE_EQ(rows.at(0).used.value(), 1);
  EXPECT_EQ(rows.at(0).verdict, "granted");
  channel.watch->missing_now = true;
  rows = rows_by_subject(&before, sample(12, {channel}));
  EXPECT_EQ(rows.at(0).verdict, "MISSING");
  channel.watch->timeout_ns = 300'000'000;
  channel.watch->since_last_ns = 5'000'000;
  rows = rows_by_subject(&before, sample(12, {channel}));
  EXPECT_EQ(rows.at(0).verdict, "RETURNS") << "events come, and are not restored yet";
}

TEST(TopRatesTest, WhatIsWrongWithAGrantStandsInPlaceOfIt) {
  auto channel = delivery("beat", 0, 0);
  channel.problems = {"12 frames on second-can were more than was admitted"};
  EXPECT_EQ(rows_by_subject(nullptr, sample(1, {channel})).at(0).verdict, "PROBLEM");
}

TEST(TopRatesTest, UnknownSubjectsHaveRowsOfTheirOwn) {
  control::Interface can0;
  can0.name = "can0";
  can0.network = "second-can";
  can0.unknown = {{.can_id = 0x123, .egress = false, .frames = 40},
                  {.egress = true,
                   .frames = 7,
                   .subject = 0x10,
                   .address = "10.0.0.7",
                   .mac = "02:00:5e:10:00:01"}};
  auto before = sample(10, {delivery("beat", 0, 0)});
  before.status.interfaces = {can0};
  auto now = sample(12, {delivery("beat", 0, 0)});
  can0.unknown[0].frames = 60;
  can0.unknown.push_back({.can_id = 0x456, .frames = 4});
  now.status.interfaces = {can0};
  const auto rows = rows_by_subject(&before, now);
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[1].name, "123");
  EXPECT_EQ(rows[1].place, "second-can >");
  EXPECT_EQ(rows[1].verdict, "unknown");
  EXPECT_DOUBLE_EQ(rows[1].drops.value(), 10);
  EXPECT_EQ(rows[2].name, "0x0000000000000010");
  EXPECT_EQ(rows[2].place, "> second-can from 10.0.0.7 (02:00:5e:10:00:01)");
  EXPECT_DOUBLE_EQ(rows[2].drops.value(), 0);
  EXPECT_DOUBLE_EQ(rows[3].drops.value(), 2) << "was not among the last seen ones before";
  EXPECT_EQ(rows_by_network(&before, now).size(), 0U) << "no network is described";
  EXPECT_FALSE(rows_by_subject(nullptr, now).at(1).drops);
}

TEST(TopHeadingTest, NamesTheFirstReasonAndCountsTheOthers) {
  control::Status status;
  EXPECT_EQ(heading_of(status).problem, "");
  status.health = {.state = control::HealthState::degraded, .reasons = {"a", "b"}, .left_out = 3};
  EXPECT_EQ(heading_of(status).problem, "a (and 4 more)");
}

TEST(TopRatesTest, BeforeTwoEventsThereIsNoJitter) {
  auto channel = delivery("beat", 0, 0);
  channel.watch.emplace();
  channel.watch->events = 0;
  EXPECT_FALSE(rows_by_subject(nullptr, sample(1, {channel})).at(0).jitter);
  EXPECT_FALSE(rows_by_subject(nullptr, sample(1, {channel})).at(0).loss);
}

TEST(TopRatesTest, OfPublishersThatLookAlikeJitterAndLossOfOneAreNotKnown) {
  auto channel = delivery("beat", 0, 0);
  channel.watch = control::Watch{};
  channel.watch->events = 7;
  channel.watch->missing = 1;
  channel.watch->last_gap_ns = channel.watch->jitter_ns = 1'000'000;
  channel.watch->shared = true;
  channel.not_supervised = "the gate cannot distinguish a and b";
  channel.problems = {"not supervised: the gate cannot distinguish a and b"};
  const Row row = rows_by_subject(nullptr, sample(1, {channel})).at(0);
  EXPECT_FALSE(row.jitter);
  EXPECT_FALSE(row.loss);
  EXPECT_EQ(row.verdict, "NOWATCH");
  channel.watch->missing_now = true;
  EXPECT_EQ(rows_by_subject(nullptr, sample(1, {channel})).at(0).verdict, "MISSING");
  channel.watch.reset();
  channel.problems.emplace_back("nothing forwards them");
  EXPECT_EQ(rows_by_subject(nullptr, sample(1, {channel})).at(0).verdict, "PROBLEM");
}

Sample with_reservations(Sample s) {
  control::Resource bus;
  bus.name = "robot-can: bus time";
  bus.kind = "bus";
  bus.capacity_known = true;
  bus.capacity = 1'000'000;
  bus.reserved = 60'000;
  for (const auto& [channel, amount] :
       {std::pair{"beat", std::uint64_t{20'000}}, std::pair{"video", std::uint64_t{40'000}}}) {
    control::Reservation r;
    r.channel = channel;
    r.publisher = std::string("p-") + channel;
    r.amount = amount;
    bus.reservations.push_back(r);
  }
  control::Resource bytes;
  bytes.name = "robot-can";
  bytes.kind = "network";
  bytes.capacity_known = true;
  bytes.capacity = 50'000;
  bytes.reserved = 500;
  s.reservations.resources = {bytes, bus};
  control::Network network;
  network.name = "robot-can";
  network.available = true;
  s.networks.networks = {network};
  return s;
}

TEST(TopRatesTest, ReservedIsTheLargestShareThatADeliveryHolds) {
  const auto rows =
      rows_by_subject(nullptr, with_reservations(sample(1, {delivery("beat", 0, 0)})));
  EXPECT_DOUBLE_EQ(rows.at(0).reserved.value(), 0.02);
}

TEST(TopRatesTest, ARefusedDeliveryHoldsNothing) {
  auto refused = delivery("beat", 0, 3);
  refused.granted = false;
  const auto before = sample(0, {refused});
  const auto rows = rows_by_subject(&before, with_reservations(sample(1, {refused})));
  EXPECT_FALSE(rows.at(0).reserved);
  EXPECT_FALSE(rows.at(0).used);
  EXPECT_EQ(rows.at(0).verdict, "refused");
}

TEST(TopRatesTest, AuditModeCountsWhatItWouldDrop) {
  auto channel = delivery("beat", 0, 3);
  auto before = sample(10, {channel});
  channel.dropped = 5;
  channel.would_drop = 8;
  auto now = sample(12, {channel});
  EXPECT_DOUBLE_EQ(rows_by_subject(&before, now).at(0).drops.value(), 1);
  now.status.mode = "audit";
  EXPECT_DOUBLE_EQ(rows_by_subject(&before, now).at(0).drops.value(), 4);
}

TEST(TopRatesTest, ANetworkSumsItsInterfacesAndWeighsWhatIsUsed) {
  auto before = with_reservations(sample(10, {delivery("beat", 0, 0), delivery("video", 0, 0)}));
  auto now = with_reservations(sample(11, {delivery("beat", 20, 0), delivery("video", 5, 0)}));
  control::Interface interface;
  interface.network = "robot-can";
  interface.ingress.passed = 100;
  interface.egress.dropped = 5;
  before.status.interfaces = {interface};
  interface.ingress.passed = 160;
  interface.egress.passed = 40;
  interface.egress.dropped = 8;
  now.status.interfaces = {interface};
  const auto rows = rows_by_network(&before, now);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].place, "2 of 2");
  EXPECT_EQ(rows[0].verdict, "available");
  EXPECT_DOUBLE_EQ(rows[0].rate.value(), 100);
  EXPECT_DOUBLE_EQ(rows[0].drops.value(), 3);
  EXPECT_DOUBLE_EQ(rows[0].reserved.value(), 0.06);  // of the bus: of the bytes it is less
  EXPECT_DOUBLE_EQ(rows[0].used.value(), (20'000 * 1.0 + 40'000 * 0.25) / 60'000);
}

// --- keys ----------------------------------------------------------------------------------------

View typed(View view, std::string keys) { return after(std::move(view), keys, 10); }

TEST(TopKeysTest, EachKeyDoesWhatTheHelpSays) {
  EXPECT_TRUE(typed({}, "q").quit);
  EXPECT_EQ(typed({}, "s").sort, Field::jitter);
  EXPECT_EQ(typed({}, std::string(kFields, 's')).sort, Field::rate);
  EXPECT_TRUE(typed({}, "r").reverse);
  EXPECT_FALSE(typed({}, "rr").reverse);
  EXPECT_TRUE(typed({}, "n").by_network);
  EXPECT_TRUE(typed({}, " ").paused);
  EXPECT_TRUE(typed({}, "h").help);
  EXPECT_FALSE(typed({}, "hx").help);
  EXPECT_EQ(typed({}, "x"), View{});
}

TEST(TopKeysTest, AFilterIsTypedTakenAndLeft) {
  const View typing = typed({}, "/vid");
  EXPECT_TRUE(typing.typing);
  EXPECT_EQ(typing.filter, "");
  const View taken = typed(typing, "eo\r");
  EXPECT_EQ(taken.filter, "video");
  EXPECT_FALSE(taken.typing);
  const View left = typed(taken, "/x\x1b");
  EXPECT_EQ(left.filter, "video");
  EXPECT_FALSE(left.typing);
  EXPECT_EQ(typed(taken, "/\x15\r").filter, "");
  EXPECT_EQ(typed({}, "/a\xc3\xa4\x7f\r").filter, "a");
  EXPECT_EQ(typed({}, "/q\r").filter, "q");
}

TEST(TopKeysTest, AnArrowThatComesInPiecesIsOneKey) {
  std::string keys = "\x1b[";
  View view = after({}, keys, 10);
  EXPECT_EQ(view, View{});
  EXPECT_EQ(keys, "\x1b[");
  keys += "Bq";
  view = after(view, keys, 10);
  EXPECT_EQ(view.first, 1U);
  EXPECT_TRUE(view.quit);
  EXPECT_EQ(keys, "");
}

TEST(TopKeysTest, MovesByRowsAndPages) {
  EXPECT_EQ(typed({}, "jjk").first, 1U);
  EXPECT_EQ(typed({}, "k").first, 0U);
  EXPECT_EQ(typed({}, "\x1b[6~\x1b[6~\x1b[5~").first, 10U);
  EXPECT_EQ(typed({}, "\x1b[6~\x1b[H").first, 0U);
}

// --- order ---------------------------------------------------------------------------------------

Row row(const std::string& name, std::optional<double> rate) {
  Row r;
  r.name = name;
  r.place = "a > b";
  r.verdict = "granted";
  r.rate = rate;
  return r;
}

std::string names(const std::vector<Row>& rows) {
  std::string text;
  for (const Row& r : rows) text += r.name;
  return text;
}

TEST(TopOrderTest, TheLargestComesFirstAndTheUnknownLastEitherWay) {
  const std::vector rows = {row("a", 1), row("b", std::nullopt), row("c", 3), row("d", 2)};
  EXPECT_EQ(names(arranged(rows, {})), "cdab");
  View view;
  view.reverse = true;
  EXPECT_EQ(names(arranged(rows, view)), "adcb");
  view.sort = Field::name;
  EXPECT_EQ(names(arranged(rows, view)), "dcba");
}

TEST(TopOrderTest, EqualRowsKeepTheirOrder) {
  EXPECT_EQ(names(arranged({row("b", 1), row("a", 1)}, {})), "ba");
}

TEST(TopOrderTest, AFilterMatchesAllTextsInAnyCase) {
  View view;
  view.filter = "VID";
  EXPECT_EQ(names(arranged({row("video", 1), row("beat", 1)}, view)), "video");
  view.filter = "a > B";
  EXPECT_EQ(arranged({row("video", 1), row("beat", 1)}, view).size(), 2U);
  view.filter = "0x00";
  Row with_subject = row("x", 1);
  with_subject.subject = "0x0000000000000010";
  EXPECT_EQ(arranged({with_subject, row("beat", 1)}, view).size(), 1U);
}

TEST(TopOrderTest, EveryColumnHasAWord) {
  for (std::size_t i = 0; i < kFields; ++i) {
    const auto field = static_cast<Field>(i);
    EXPECT_EQ(field_named(name_of(field)), field);
  }
  EXPECT_FALSE(field_named("speed"));
}

// --- layout --------------------------------------------------------------------------------------

TEST(TopLayoutTest, NumbersFitTheirColumns) {
  const std::vector<std::pair<double, std::string>> expected = {
      {0, "0"},          {0.004, "<.01"},   {0.25, "0.25"}, {9.994, "9.99"}, {9.996, "10"},
      {99.94, "99.9"},   {99.96, "100"},    {1250, "1250"}, {9999, "9999"},  {9999.6, "10k"},
      {12'500, "12.5k"}, {999'400, "999k"}, {1e6, "1000k"}, {2.5e7, "25M"},  {1e18, "99999G"}};
  for (const auto& [value, text] : expected) EXPECT_EQ(short_number(value), text) << value;
  EXPECT_EQ(short_number(std::nullopt), "-");
  EXPECT_EQ(short_time(0.0125), "12.5ms");
  EXPECT_EQ(short_time(0.00031), "310us");
  EXPECT_EQ(short_time(2.0), "2s");
  EXPECT_EQ(short_time(5e-9), "5ns");
  EXPECT_EQ(short_share(0.125), "12.5%");
  EXPECT_EQ(short_share(0.0), "0%");
  EXPECT_EQ(short_share(0.0001), "<0.1%");
  EXPECT_EQ(short_share(1.0), "100%");
  EXPECT_EQ(short_share(1e9), ">999%");
  for (double value = 1e-9; value < 1e12; value *= 1.07) {
    EXPECT_LE(short_number(value).size(), 6U) << value;
    EXPECT_LE(short_time(value).size(), 7U) << value;
    EXPECT_LE(short_share(value).size(), 5U) << value;
  }
}

std::size_t width(std::string_view text) {
  std::size_t count = 0;
  bool escape = false;
  for (const char c : text) {
    if (c == '\x1b') escape = true;
    if (!escape && (static_cast<unsigned char>(c) & 0xc0U) != 0x80) ++count;
    if (escape && c == 'm') escape = false;
  }
  return count;
}

class ScreenSizeTest : public ::testing::TestWithParam<std::tuple<std::size_t, std::size_t>> {};

TEST_P(ScreenSizeTest, HasExactlyTheLinesAndNoLongerOnes) {
  const auto [columns, lines] = GetParam();
  std::vector<Row> rows(100,
                        row("a-channel-with-a-very-long-name-\xc3\xa4\xc3\xb6\xc3\xbc", 12'500));
  rows[0].used = 3;
  rows[0].drops = 1;
  Heading heading;
  heading.gateway = "bridge of volksbot";
  heading.state = "enforce, open, 1 granted, 100000 refused";
  for (const bool help : {false, true})
    for (const Color color : {Color::no, Color::yes}) {
      heading.problem = help ? "" : "can1 is missing (and 6 more)";
      View view;
      view.help = help;
      view.first = 1000;
      const auto text = screen(heading, rows, view, {columns, lines}, color);
      EXPECT_EQ(text.size(), lines);
      for (const auto& line : text) EXPECT_LE(width(line), columns) << line;
    }
}

INSTANTIATE_TEST_SUITE_P(Sizes, ScreenSizeTest,
                         ::testing::Combine(::testing::Values(1, 20, 79, 80, 132, 400),
                                            ::testing::Values(1, 2, 3, 4, 5, 24, 200)));

TEST(TopLayoutTest, EightyColumnsShowAllOfThem) {
  Row r = row("emergency-switch", 20);
  r.place = "second-can > robot-can";
  r.jitter = 0.0012;
  r.loss = 0;
  r.drops = 3;
  r.reserved = 0.02;
  r.used = 0.995;
  Heading heading;
  heading.gateway = "bridge of volksbot";
  heading.state = "enforce, open, 1 granted, 0 refused";
  const auto lines = screen(heading, {r}, {}, {80, 0}, Color::no);
  EXPECT_EQ(lines,
            (std::vector<std::string>{
                "bridge of volksbot: enforce, open, 1 granted, 0 refused",
                "by subject, sorted by rate, 1 row",
                "CHANNEL          ROUTE           VERDICT RATE/s JITTER  LOSS DROP/s  RESV  USED",
                "emergency-switch second-can > r~ granted     20  1.2ms    0%      3    2% 99.5%",
            }));
}

TEST(TopLayoutTest, TheStateOfANetworkIsNotCutOff) {
  Row r = row("second-can", 1);
  r.place = "2 of 2";
  r.verdict = "unavailable";
  View by_network;
  by_network.by_network = true;
  const auto lines = screen({}, {r}, by_network, {80, 0}, Color::no);
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_TRUE(lines[2].starts_with("NETWORK          GRANTED     STATE       RATE/s")) << lines[2];
  EXPECT_TRUE(lines[3].starts_with("second-can       2 of 2      unavailable ")) << lines[3];
}

TEST(TopLayoutTest, AProblemHasALineOfItsOwn) {
  Heading heading;
  heading.problem = "can1 is missing";
  const auto lines = screen(heading, {row("a", 1), row("b", 1)}, {}, {80, 6}, Color::no);
  ASSERT_EQ(lines.size(), 6U);
  EXPECT_TRUE(lines[1].starts_with("by subject"));
  EXPECT_EQ(lines[2], "can1 is missing");
  EXPECT_TRUE(lines[4].starts_with("a "));
  EXPECT_EQ(room_for_rows(heading, {80, 6}), 1U);
  EXPECT_EQ(room_for_rows({}, {80, 6}), 2U);
}

TEST(TopLayoutTest, NothingThatTheDaemonSaysSteersTheTerminal) {
  Heading heading;
  heading.gateway = "evil\x1b[2J";
  Row r = row("a\x1b]0;x\x07", 1);
  for (const auto& line : screen(heading, {r}, {}, {80, 24}, Color::no))
    EXPECT_EQ(line.find('\x1b'), std::string::npos);
}

TEST(TopLayoutTest, AlarmsAreLoudWithoutColourToo) {
  control::Status status;
  status.gateway = "bridge";
  status.system = "volksbot";
  status.mode = "audit";
  status.open = false;
  const auto lines = screen(heading_of(status), {}, {}, {80, 24}, Color::no);
  EXPECT_NE(lines[0].find("AUDIT MODE"), std::string::npos);
  EXPECT_NE(lines[0].find("CLOSED"), std::string::npos);
  EXPECT_NE(lines[2].find("  WOULD "), std::string::npos) << "nothing is dropped: " << lines[2];
  EXPECT_EQ(lines[2].find("DROP/s"), std::string::npos);
}

}  // namespace
}  // namespace mlcca::tools::top
