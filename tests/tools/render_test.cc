// SPDX-License-Identifier: BSD-2-Clause
// What a person sees, and what a program sees, of the same replies.
#include "tools/render.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/control/messages.hpp"
#include "tests/tools/json_of.hpp"
#include "tools/json.hpp"
#include "tools/words.hpp"

namespace mlcca::tools {
namespace {

struct RenderTest : ::testing::Test {
  RenderTest() {
    ::setenv("TZ", "UTC", 1);  // NOLINT(concurrency-mt-unsafe)
    ::tzset();
  }
};

/// An alias of an interface may hold any character; ESC, DEL and CSI (U+009B) steer a terminal.
TEST_F(RenderTest, GivesProgramsNoCharacterThatSteersATerminal) {
  const std::string alias =
      "\x1b[2J \x7f \xc2\x9b"
      "2J \xc3\xa4";
  EXPECT_EQ(to_json({1, control::Done{alias}}),
            "{\"message\":\"\\u001b[2J \\u007f \\u009b2J \xc3\xa4\"}\n");
  EXPECT_EQ(json_of({1, control::Done{alias}})["message"], alias);
}

TEST_F(RenderTest, ExplainsARefusalAttributeByAttribute) {
  EXPECT_EQ(
      explain({{test::refused_channel()}}, Color::no, true),
      R"(refused  emergency-switch (0xa4efeccc3210b497) from second-can to robot-can: Omission 2 required, bridge provides 5 (3 too many)
  WHERE       ATTRIBUTE   REQUIRED       PROVIDED  OUTCOME              MARGIN
  second-can  Period         50 ms        12.5 ms  fit                  37.5 ms to spare
  bridge      Omission           2              5  unfit                3 too many
  robot-can   PacketLoss     0.5 %  at best 0.1 %  decided at run time  0.4 % to spare
  end to end  Bandwidth   400 kB/s        nothing  unfit                not provided
  route        second-can > bridge > robot-can
  publisher    switch
  subscribers  motor-left, motor-right
  importance   3
  frames       in all 12 passed, 345 dropped; 6 were more than admitted
)");
}

TEST_F(RenderTest, ExplainsWhatTheMediaGiveAndWhichSetIsInUse) {
  EXPECT_EQ(
      explain({{test::switched_channel()}}, Color::no, true),
      R"(granted  video (0x0000000000000010) from awds to robot-can: Period 50 ms required, the route provides 12.5 ms (37.5 ms to spare)
  WHERE      ATTRIBUTE  REQUIRED  PROVIDED  OUTCOME  MARGIN
  robot-can  Period        50 ms   12.5 ms  fit      37.5 ms to spare
  set          2 of 2
  route        awds > bridge > robot-can
  awds         path laptop > relay > control, path rate 7.543 Mbit/s, 600 kB/s free or its own, in all links
  robot-can    response 310 us, at most 5 ms guaranteed
  publisher    switch
  subscribers  motor-left, motor-right
  importance   9
  frames       in all 12 passed, 0 dropped; 12 would have been dropped, audit mode passed them; 6 were more than admitted (5 of these passed in audit mode)
)");
}

TEST_F(RenderTest, SaysThatNoSetFits) {
  auto channel = test::switched_channel();
  channel.granted = false;
  EXPECT_NE(explain({{channel}}, Color::no, false).find("  set          none of 2\n"),
            std::string::npos);
}

TEST_F(RenderTest, NamesTheAdmissionThatCanBeReleased) {
  const auto text = explain({{test::granted_channel()}}, Color::no, false);
  EXPECT_TRUE(text.starts_with(
      "granted  emergency-switch (0xa4efeccc3210b497) from robot-can to robot-can: "));
  EXPECT_NE(text.find("  admission    7 (mlccactl release --id 7 takes it back)\n"),
            std::string::npos);
  EXPECT_EQ(text.find("passed"), std::string::npos);
}

TEST_F(RenderTest, ReportsHowWatchedEventsCome) {
  auto channel = test::granted_channel();
  const auto watched = [&] { return explain({{channel}}, Color::no, true); };
  EXPECT_NE(watched().find("  watched      1001 events, 19.975 a second, jitter 6 ms, 4 missing; "
                           "the latest 200 ms ago: MISSING\n"),
            std::string::npos)
      << watched();
  EXPECT_NE(watched().find("  gaps         44 ms to 101 ms, the latest 49 ms; in periods "
                           "0.875 to 1: 499, 1 to 1.125: 500, 1.875 and more: 1\n"),
            std::string::npos)
      << watched();
  channel.watch.emplace();
  channel.watch->since_last_ns = 3'000'000'000;
  EXPECT_NE(watched().find("  watched      nothing has come for 3 s\n"), std::string::npos);
  EXPECT_EQ(watched().find("  gaps "), std::string::npos);
  channel.watch.reset();
  EXPECT_EQ(watched().find("  watched "), std::string::npos);
}

TEST_F(RenderTest, StartsEachDeliveryWithItsVerdict) {
  const auto text =
      explain({{test::refused_channel(), test::granted_channel()}}, Color::yes, false);
  EXPECT_TRUE(text.starts_with("\x1b[1;31mrefused\x1b[0m  "));
  EXPECT_NE(text.find("\n\n\x1b[32mgranted\x1b[0m  "), std::string::npos);
}

TEST_F(RenderTest, AnswersAQuestionAboutNothing) {
  EXPECT_TRUE(explain({}, Color::no, false).starts_with("refused  nothing to deliver"));
}

TEST_F(RenderTest, ListsDeliveries) {
  EXPECT_EQ(
      render(control::Channels{{test::refused_channel(), test::granted_channel()}}, Color::no),
      R"(CHANNEL           SUBJECT             FROM        TO         VERDICT  PROBLEMS                                           PASSED  DROPPED  WOULD DROP  ADMISSION  REASON
emergency-switch  0xa4efeccc3210b497  second-can  robot-can  refused                                                         12      345                         Omission 2 required, bridge provides 5 (3 too many)
emergency-switch  0xa4efeccc3210b497  robot-can   robot-can  granted  nothing has come for 200 ms: 4 events are missing      12        0          12          7  Period 50 ms required, the route provides 12.5 ms (37.5 ms to spare)
)");
}

TEST_F(RenderTest, ListsSetsAndMediaWhereThereAreAny) {
  EXPECT_EQ(
      render(control::Channels{{test::refused_channel(), test::switched_channel()}}, Color::no),
      R"(CHANNEL           SUBJECT             FROM        TO         VERDICT  SET     PASSED  DROPPED  WOULD DROP  MEDIA                                                     REASON
emergency-switch  0xa4efeccc3210b497  second-can  robot-can  refused              12      345                                                                        Omission 2 required, bridge provides 5 (3 too many)
video             0x0000000000000010  awds        robot-can  granted  2 of 2      12        0          12  awds 600 kB/s free or its own, robot-can response 310 us  Period 50 ms required, the route provides 12.5 ms (37.5 ms to spare)
)");
}

TEST_F(RenderTest, ShowsRoutesMediaLinksAndWhatIsWrongAboutSources) {
  EXPECT_EQ(render(test::full_routes(), Color::no),
            R"(FROM        TO         GRANTED  REFUSED  ROUTE
awds        robot-can        2        1  awds > bridge > robot-can
second-can  awds             0        3  none: no gateway leads there

what their media give
  FROM  TO         NETWORK    RESPONSE  GUARANTEED  PATH                         PATH RATE  AVAILABLE  LIMITED BY
  awds  robot-can  awds                             laptop > relay > control  7.543 Mbit/s   600 kB/s  all links
  awds  robot-can  robot-can    310 us        5 ms

links
  NETWORK  FROM    TO                      RATE  BELIEVED RATE  KIND       LOSS   BUSY     AGE  STATE  SOURCE
  awds     laptop  relay              24 Mbit/s    22.5 Mbit/s  phy      1.25 %  4.3 %  1.25 s         nl80211 mesh0
  awds     relay   02:00:00:00:00:03    unknown        nothing  derived                   60 s  stale  awds eth1

can-gw rules
  FROM  TO    FILTER    FORMAT   OWNER       HANDLED  DROPPED  DELETED  HOPS  CHANGE          CHANNEL
  can1  can0  1f480064  FD       mlccad   7000000000        1        2        id to 1f480065  emergency-switch
  can0  can2  100/7ff   classic  foreign           0        0              1  the frame

awds: babel: connection refused
awds: olsr: no such node
)");
}

TEST_F(RenderTest, SaysThatThereIsNothingToRoute) {
  EXPECT_EQ(render(control::Routes{}, Color::no), "no channel has a publisher and a subscriber\n");
}

TEST_F(RenderTest, ShowsWhoHoldsWhatAndWhatIsLeft) {
  EXPECT_EQ(render(test::full_reservations(), Color::no),
            R"(RESOURCE             KIND     CAPACITY  RESERVED  BACKGROUND              FREE
robot-can: bus time  bus          60 %     1.5 %        10 %            48.5 %
awds: all links      domain       80 %  42.424 %                      37.576 %
uplink               network  300 kB/s  400 kB/s              over by 100 kB/s
bridge               gateway   unknown   160 B/s

robot-can: bus time
  CHANNEL           PUBLISHER  AMOUNT  SHARE
  emergency-switch  switch      1.5 %  2.5 %

awds: all links
  CHANNEL           PUBLISHER     AMOUNT      SHARE  ADMISSION  SET  IMPORTANCE  LEASE
  video             camera      42.424 %    53.03 %          8    2           9  7.5 s
  emergency-switch  switch     < 0.001 %  < 0.001 %

uplink
  CHANNEL  PUBLISHER    AMOUNT      SHARE  ADMISSION  SET  IMPORTANCE  LEASE
  video    camera     400 kB/s  133.333 %          8    2           9  7.5 s
)");
}

TEST_F(RenderTest, SaysThatThereIsNothingToReserve) {
  EXPECT_EQ(render(control::Reservations{}, Color::no),
            "nothing that can be reserved is described\n");
}

TEST_F(RenderTest, ShowsTheLosersFirst) {
  EXPECT_EQ(render(test::full_what_if(), Color::no),
            R"(EFFECT    CHANNEL  PUBLISHER  TO         NOW      THEN     REASON
lost      speech   camera     robot-can  set 2    refused  300 kB/s too much
degraded  video    camera     robot-can  set 1    set 2    100 kB/s fit
upgraded  sonar    camera     robot-can  set 3    set 1    fits again
gained    map      camera     robot-can  refused  granted  fits
1 lost, 1 degraded, 1 upgraded, 1 gained, 12 as now
)");
}

TEST_F(RenderTest, SaysThatNothingWouldChange) {
  EXPECT_EQ(render(control::WhatIf{.outlooks = {}, .unchanged = 3}, Color::no),
            "nothing would change; 3 deliveries are as they are now\n");
}

TEST_F(RenderTest, ShowsTheNewestDecisionLast) {
  EXPECT_EQ(render(test::full_history(), Color::no),
            R"(TIME                     KIND      CHANNEL  FROM  TO         NETWORK  MESSAGE
2023-11-14 22:13:20.123  reload                                       read again
2023-11-14 22:15:00.000  degraded  video    awds  robot-can  awds     set 2 of 2: laptop > relay is slower
)");
  EXPECT_EQ(render(control::History{}, Color::no), "nothing of that is recorded\n");
}

TEST_F(RenderTest, RoundsSharesAndRatesToThreeDecimals) {
  EXPECT_EQ(percent(0, 1'000'000), "0 %");
  EXPECT_EQ(percent(4, 1'000'000), "< 0.001 %");  // 0.0004 %
  EXPECT_EQ(percent(5, 1'000'000), "0.001 %");    // 0.0005 %
  EXPECT_EQ(percent(1, 3), "33.333 %");
  EXPECT_EQ(percent(2, 3), "66.667 %");
  EXPECT_EQ(percent(~std::uint64_t{0} - 1, ~std::uint64_t{0} - 1), "100 %");
  EXPECT_EQ(bits_per_second(999), "999 bit/s");
  EXPECT_EQ(bits_per_second(1'000), "1 kbit/s");
  EXPECT_EQ(bits_per_second(1'500'499), "1.5 Mbit/s");
  EXPECT_EQ(bits_per_second(1'500'500), "1.501 Mbit/s");
  EXPECT_EQ(bits_per_second(2'000'000'000), "2 Gbit/s");
  EXPECT_EQ(bits_per_second(~std::uint64_t{0}), "unbounded");
}

TEST_F(RenderTest, ShowsTheGatewayAsItIs) {
  EXPECT_EQ(render(test::full_status(), Color::no),
            R"(gateway      bridge of robot
mlccad       0.1.0, since 2023-11-14 22:13:20
description  /etc/mlcca/system.xml, read 2023-11-14 22:15:00
gate         open: verdicts are in force
health       DEGRADED
             can1 is missing
             1 delivery is refused
             and 5 more
mode         enforce
channels     3 granted, 1 refused
grace        10 s, lapsed 2 times

INTERFACE  NETWORK     PROFILE  LINK    CAN STATE        BITRATE  GATE            SLOTS  IN PASSED  IN DROPPED  OUT PASSED  OUT DROPPED  OUT WOULD DROP  MANAGED  IDENTITY
can0       robot-can   famouso  up      ERROR-ACTIVE  500 kbit/s  attached early      4       1001          22        2002           33              34  yes      name can0
can1       second-can           absent                                                0          0           0           0            0

frames by reason
  INTERFACE  DIRECTION  REASON              FRAMES  WOULD DROP
  can0       in         unknown                 21
  can0       in         length                   1
  can0       out        source                   3
  can0       out        more than admitted                  34

unknown frames, last seen first
  INTERFACE  DIRECTION  IDENTIFIER          FORMAT    LENGTH  FRAMES  SENDER
  can0       in         18ffa533            classic        8      19
  can0       out        123                 FD            64       2
  can0       in         017                 XL          2048       1
  can0       in         0xa4efeccc3210b497  datagram    8183       3  10.0.0.7 (02:00:5e:10:00:01)
)");
}

TEST_F(RenderTest, OfAnOlderDaemonShowsTheProblemsThemselves) {
  auto status = test::full_status();
  status.health = {};
  const std::string text = render(status, Color::no);
  for (const char* line :
       {"health       unknown: this mlccad does not say\n", "problem      can1 is missing\n",
        "last reload  system.xml:7: <Period>: not a number\n", "\ncan0: queue is full\n",
        "\nbefore the gate of can0 runs another\n",
        "\ncan0: 70000 frames were sent past its gate\n", "\ncan1: no such interface\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
}

TEST_F(RenderTest, HealthIsOneLineForAMonitoringSystem) {
  EXPECT_EQ(check_line(test::full_status().health),
            "DEGRADED: can1 is missing; 1 delivery is refused; and 5 more\n");
  EXPECT_EQ(check_line({.state = control::HealthState::healthy}), "healthy\n");
  EXPECT_EQ(check_line({.state = control::HealthState::closed, .reasons = {"a\nb"}}),
            "CLOSED: a?b\n");
}

TEST_F(RenderTest, SaysWhatAWithdrawalStops) {
  EXPECT_EQ(what_stops({{test::refused_channel(), test::granted_channel()}}, "emergency-switch",
                       Color::no),
            "emergency-switch, once it is withdrawn: 1 delivery stops; everything of it is "
            "refused, also what is "
            "described, until it is reinstated\n"
            "  stops  from robot-can (switch) to robot-can (motor-left, motor-right)\n"
            "         reaction to its loss: 174 ms = (Omission 2 + 1) x Period 50 ms + Latency 12 "
            "ms + Jitter 12 ms\n");
  EXPECT_EQ(what_stops({{test::refused_channel()}}, "a", Color::no),
            "a, once it is withdrawn: nothing of it is granted now; everything of it is refused, "
            "also what is described, "
            "until it is reinstated\n");
}

TEST_F(RenderTest, ShowsThatAChannelIsWithdrawn) {
  auto channel = test::refused_channel();
  channel.withdrawn = true;
  EXPECT_NE(render(control::Channels{{channel}}, Color::no).find("refused  WITHDRAWN"),
            std::string::npos);
}

TEST_F(RenderTest, ShowsWhatIsWrongWithAGrant) {
  const control::Channels channels{{test::granted_channel()}};
  const std::string line = "nothing has come for 200 ms: 4 events are missing";
  EXPECT_NE(render(channels, Color::no).find("granted  " + line), std::string::npos)
      << render(channels, Color::no);
  EXPECT_NE(explain(channels, Color::no, false).find("  problem      " + line + "\n"),
            std::string::npos);
}

TEST_F(RenderTest, SaysAuditModeFirstAndLoudly) {
  auto status = test::full_status();
  status.mode = "audit";
  EXPECT_TRUE(
      render(status, Color::yes)
          .starts_with("\x1b[1;31mAUDIT MODE: nothing is dropped, unfit data passes\x1b[0m\n"));
}

TEST_F(RenderTest, SaysThatAClosedGateDeniesEverything) {
  auto status = test::full_status();
  status.open = false;
  EXPECT_NE(render(status, Color::no).find("gate         CLOSED: everything is denied\n"),
            std::string::npos);
}

TEST_F(RenderTest, SaysThatNoGateIsAttachedToAnInterface) {
  auto status = test::full_status();
  status.interfaces[0].attached = false;
  EXPECT_NE(render(status, Color::no).find("NOT ATTACHED"), std::string::npos);
}

TEST_F(RenderTest, OfANetworkWithoutAProfileOnlyAFormerGateIsThere) {
  for (const bool attached : {false, true}) {
    auto status = test::full_status();
    status.interfaces[0].profile = "none";
    status.interfaces[0].attached = attached;
    EXPECT_TRUE(render(status, Color::no).contains(attached ? "closed: no profile" : "none: not"));
  }
}

TEST_F(RenderTest, ShowsWhatNetworksProvideAndWhatIsReserved) {
  EXPECT_EQ(
      render(test::full_networks(), Color::no),
      R"(NETWORK    KIND  PROFILE  STATE        RESERVED  CAPACITY  GATEWAYS               PROVISION
robot-can  can   famouso  available     160 B/s   40 kB/s  bridge, second-bridge  Latency 5 ms, Omission at best 5
mesh       mesh  none     unavailable     0 B/s   unknown
mesh: wlan0 is down
)");
}

TEST_F(RenderTest, PrintsAnEventOnOneLine) {
  EXPECT_EQ(
      render(test::full_event(), Color::no),
      "2023-11-14 22:13:20.123  refused    emergency-switch (0xa4efeccc3210b497) on robot-can: "
      "Omission 2 required, bridge provides 5\n");
  auto event = test::full_event();
  event.kind = "mode";
  event.subject = 0;
  event.network.clear();
  event.message = "audit\nmode";
  EXPECT_EQ(render(event, Color::no), "2023-11-14 22:13:20.123  mode       audit?mode\n");
}

TEST_F(RenderTest, PrintsEveryDetailOfAnError) {
  EXPECT_EQ(render(control::Error{control::ErrorKind::unreadable, "2 errors", {"a:1: x", "a:2: y"}},
                   Color::no),
            "mlccactl: 2 errors\n  a:1: x\n  a:2: y\n");
}

}  // namespace
}  // namespace mlcca::tools
