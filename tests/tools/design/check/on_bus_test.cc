// SPDX-License-Identifier: BSD-2-Clause
// What check and analyse-bus say of one bus: of what is refused on it, of what is left to the run
// time, and of options that state another bus than the description does.
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/design/check/program.hpp"

namespace mlcca {
namespace {

class OnBusTest : public test::CheckTest {
 protected:
  static std::string channel(const std::string& name, int subject, const std::string& attributes) {
    return "<EventChannel name='" + name + "'><SubjectUID>0x" + std::to_string(subject) +
           "</SubjectUID><Attributes maxPayload='8' " + attributes + "/></EventChannel>";
  }
  static std::string binding(const std::string& name, const std::string& id) {
    return "<Binding channel='" + name + "'><Identifier form='standard'>" + id +
           "</Identifier></Binding>";
  }
  static std::string ends(const std::string& name) {
    return "<Publisher name='" + name + "' channel='" + name +
           "' network='bus'/><Subscriber name='to-" + name + "' channel='" + name +
           "' network='bus'/>";
  }
  /// `pedal` must arrive within 0.6 ms and goes behind `noise`, of which this is stated.
  static std::string beside_noise(const std::string& noise) {
    return test::system_of(
        channel("noise", 5, noise) + channel("pedal", 6, "period='10ms' deadline='0.6ms'") +
        channel("low", 7, "period='10ms'") +
        "<Network name='bus'><Kind>can</Kind><Profile>raw</Profile><Bus bitrate='500000'/>" +
        binding("noise", "0x10") + binding("pedal", "0x20") + binding("low", "0x30") +
        "</Network>" + ends("low") + ends("noise") + ends("pedal"));
  }
  std::string checked(const std::string& text) {
    return test::run({"check", file("s.xml", text)}).out;
  }
};

/// It is late itself: the reason says nothing of pedal.
TEST_F(OnBusTest, WhatIsRefusedOnItsOwnBusMayMakeOthersLate) {
  const std::string out = checked(beside_noise("period='1ms' deadline='0.2ms'"));
  EXPECT_TRUE(
      out.contains("MLCCA031: with noise, the frames of noise (noise) on bus could take 270 "
                   "us of the 200 us"))
      << out;
  EXPECT_TRUE(
      out.contains("MLCCA044: noise is refused, and no gate keeps its frames off bus: while "
                   "they are sent, pedal could take 810 us of the 600 us"))
      << out;
}

TEST_F(OnBusTest, HowMuchARefusedSenderSendsMayBeUnknown) {
  const std::string out = checked(beside_noise(""));
  EXPECT_TRUE(out.contains("MLCCA027")) << out;
  EXPECT_TRUE(out.contains(
      "MLCCA044: noise is refused, and no gate keeps its frames off bus: how much it sends is not "
      "known, so whether what is granted there is in time is known only while it is silent"))
      << out;
}

TEST_F(OnBusTest, WhatWaitsForItsTagIsLeftToTheRunTimeEverywhere) {
  const auto path =
      file("s.xml",
           test::system_of(channel("speed", 5, "period='10ms'") +
                           "<Network name='bus'><Kind>can</Kind><Profile>famouso</Profile><Bus "
                           "bitrate='500000'/><Binding channel='speed' dynamic='true'/></Network>"
                           "<Publisher name='wheel' channel='speed' network='bus' node='20'/>"
                           "<Subscriber name='dial' channel='speed' network='bus'/>"));
  EXPECT_TRUE(test::run({"check", path}).out.contains("0 fit, 1 decided at run time"));
  const std::string page = test::run({"check", "--format", "html", path}).out;
  EXPECT_TRUE(page.contains("\"outcome\":\"run-time\"")) << page;
  EXPECT_FALSE(page.contains("\"outcome\":\"fit\""));
  const std::string json = test::run({"analyse-bus", "--json", path}).out;
  EXPECT_TRUE(json.contains("\"granted\":false,\"outcome\":\"run-time\"")) << json;
  EXPECT_TRUE(json.contains("\"counted\":true")) << json;
  EXPECT_TRUE(page.contains("in time, if it is granted")) << page;
}

/// The Deadline that follows from the Period is an hour, and the first bus needs next to nothing of
/// it.
TEST_F(OnBusTest, AHeartBeatOfAnHourGoesOverTwoBuses) {
  const auto bus = [](const std::string& name, const std::string& rate) {
    return "<Network name='" + name + "'><Kind>can</Kind><Profile>raw</Profile><Bus bitrate='" +
           rate + "'/>" + binding("alive", "0x20") + "</Network>";
  };
  const std::string out = checked(test::system_of(
      channel("alive", 5, "period='3600s'") + bus("near", "500000") + bus("far", "250000") +
      "<Gateway name='g'><Provision latency='1ms' jitter='1ms' omission='0'/><Port "
      "network='near'><Interface name='can0'/></Port><Port network='far'><Interface name='can1'/>"
      "</Port></Gateway><Publisher name='p' channel='alive' network='near'/>"
      "<Subscriber name='s' channel='alive' network='far'/>"));
  EXPECT_TRUE(out.contains("1 fit")) << out;
}

TEST_F(OnBusTest, WhatOptionsStateIsNotWhatCheckSays) {
  const auto path =
      file("s.xml",
           test::system_of(
               channel("low", 7, "period='10ms' deadline='5ms'") +
               "<Network name='bus'><Kind>can</Kind><Profile>raw</Profile><Bus bitrate='500000'/>" +
               binding("low", "0x30") + "</Network>" + ends("low")));
  EXPECT_EQ(test::run({"check", path}).status, 0);
  const std::string out = test::run({"analyse-bus", "--bitrate", "20k", path}).out;
  EXPECT_TRUE(
      out.contains("With these options in the description 'mlccactl check' would refuse "
                   "these"))
      << out;
  EXPECT_FALSE(out.contains("'mlccactl check' refuses these")) << out;
}

/// Its frame takes 27 ms, and 300 ns less are allowed.
TEST_F(OnBusTest, ABoundThatIsAboveItsLimitIsNotPrintedLikeIt) {
  const std::string out = checked(test::system_of(
      channel("slow", 5, "period='1s' deadline='26.9997ms'") +
      "<Network name='bus'><Kind>can</Kind><Profile>raw</Profile><Bus bitrate='5000'/>" +
      binding("slow", "0x10") + "</Network>" + ends("slow")));
  EXPECT_TRUE(out.contains("could take 27 ms of the 26.9997 ms")) << out;
}

/// What the gateway brings from another bus has the address of a node there.
TEST_F(OnBusTest, TwoNodesThatClaimOneAddressAreNamed) {
  const auto bus = [](const std::string& name, const std::string& bindings) {
    return "<Network name='" + name +
           "'><Kind>can</Kind><Profile>j1939</Profile><Bus bitrate='500000'/>" + bindings +
           "</Network>";
  };
  const auto message = [](const std::string& name, int subject) {
    return "<EventChannel name='" + name + "'><SubjectUID>0x" + std::to_string(subject) +
           "</SubjectUID><Attributes period='2s' maxPayload='20'/></EventChannel>";
  };
  const std::string c = "<Binding channel='c'><PGN>0xfef1</PGN></Binding>";
  const auto path = file(
      "s.xml",
      test::system_of(
          message("c", 1) + message("d", 2) + bus("a", c) +
          bus("b", c + "<Binding channel='d'><PGN>0xfef2</PGN></Binding>") +
          "<Gateway name='g'><Provision latency='1ms' jitter='1ms'/><Port network='a'><Interface "
          "name='can0'/></Port><Port network='b'><Interface name='can1'/></Port></Gateway>"
          "<Publisher name='p' channel='c' network='a' node='4'/>"
          "<Publisher name='q' channel='d' network='b' node='4'/>"
          "<Subscriber name='s' channel='c' network='b'/><Subscriber name='t' channel='d' "
          "network='b'/>"));
  const auto check = test::run({"check", path}).out;
  EXPECT_TRUE(
      check.contains("hint: q and p claim one address on b, 4: no bound holds there; give "
                     "one of them another node"))
      << check;
  const auto analysed = test::run({"analyse-bus", path}).out;
  EXPECT_TRUE(analysed.contains(" claim one address on b, 4: no bound holds there.")) << analysed;
}

/// 20 bytes take four frames, between which their sender pauses for 200 ms each.
TEST_F(OnBusTest, EventsThatTakeLongerThanTheirPeriodAreNotBlamedOnTheBus) {
  const auto path = file(
      "s.xml",
      test::system_of(
          "<EventChannel name='engine'><SubjectUID>0x5</SubjectUID><Attributes period='50ms' "
          "maxPayload='20'/></EventChannel><Network name='bus'><Kind>can</Kind><Profile>j1939"
          "</Profile><Bus bitrate='1000000'/><Binding channel='engine'><PGN>0xfef1</PGN></Binding>"
          "</Network><Publisher name='engine' channel='engine' network='bus' node='1'/>"
          "<Subscriber name='dash' channel='engine' network='bus'/>"));
  const auto done = test::run({"analyse-bus", path});
  EXPECT_TRUE(done.out.contains("engine is not bounded: its 4 frames take up to 600."))
      << done.out << done.error;
  EXPECT_TRUE(done.out.contains("and the next event comes after 50 ms.")) << done.out;
}

}  // namespace
}  // namespace mlcca
