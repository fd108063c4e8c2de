// SPDX-License-Identifier: BSD-2-Clause
// mlccactl analyse-bus and check of descriptions that lack something or have too much of it: what
// is not known is said, what can be analysed is, and hints have the numbers that help.
#include "tests/tools/design/analyse_bus/described_buses.hpp"

namespace mlcca {
namespace {

/// A channel from a bus on which it is not bounded to another one.
std::string unbounded_before() {
  const auto period = attribute("Period",
                                "<Dimension><SIUnit><Seconds>1</Seconds></SIUnit><Magnitude>-6"
                                "</Magnitude></Dimension><Value>7000</Value>");
  return test::system_of(
      "<EventChannel name=\"c\"><SubjectUID>0x4</SubjectUID><Attributes>" + period +
      "</Attributes></EventChannel>\n"
      "<Network name=\"n0\"><Kind>can</Kind><Profile>cyphal</Profile><Bus bitrate=\"50000\" "
      "errors=\"1\" error-interval=\"0.02\"/><Binding channel=\"c\"><SubjectID>258</SubjectID>"
      "</Binding></Network>\n"
      "<Network name=\"n1\"><Kind>can</Kind><Profile>famouso</Profile><Bus bitrate=\"125000\"/>"
      "<Binding channel=\"c\"><ETag>0x102</ETag></Binding></Network>\n"
      "<Gateway name=\"g\"><Port network=\"n0\"><Interface name=\"can0\"/></Port>"
      "<Port network=\"n1\"><Interface name=\"can1\"/></Port></Gateway>\n"
      "<Publisher name=\"p\" channel=\"c\" network=\"n0\" node=\"40\"/>\n"
      "<Subscriber name=\"q\" channel=\"c\" network=\"n1\"/>\n");
}

TEST_F(AnalyseBusTest, AJitterWithoutBoundIsNoNumberAndTheBusThatMakesItIsNamed) {
  const auto path = file("red.xml", unbounded_before());
  const auto text = analyse(path);
  EXPECT_EQ(text.status, 1) << text.error;
  EXPECT_FALSE(text.out.contains("18446744073")) << text.out;
  EXPECT_TRUE(
      text.out.contains("p is not bounded here: it is not bounded on n0, from where it comes."))
      << text.out;
  const Json out = Json::parse(analyse(path, {"--json"}).out);
  EXPECT_TRUE(out["networks"][1]["messages"][0]["jitter_us"].is_null()) << out;
  EXPECT_EQ(out["networks"][0]["messages"][0]["jitter_us"], 0);
  EXPECT_TRUE(analyse(path, {"--assign", "--network", "n1"})
                  .out.contains("p comes here from another network with a jitter that is not "
                                "bounded."));
}

/// Six channels of one node; the tag of the first is the broker's to deal.
std::string dealt_tag() {
  std::string text;
  std::string bindings;
  std::string ends;
  for (int i = 0; i < 6; ++i) {
    const std::string n = std::to_string(i);
    const std::string us = i == 0 ? "900" : "5000";
    text += "<EventChannel name=\"c" + n + "\"><SubjectUID>0x" + std::to_string(i + 1) +
            "</SubjectUID><Attributes>" + attribute("Period", time_value(5)) +
            attribute("MaxPayload",
                      "<Dimension><SIUnit><Bytes>1</Bytes></SIUnit></Dimension><Value>8</Value>") +
            attribute("Deadline",
                      "<Dimension><SIUnit><Seconds>1</Seconds></SIUnit><Magnitude>-6</Magnitude>"
                      "</Dimension><Value>" +
                          us + "</Value>") +
            "</Attributes></EventChannel>\n";
    bindings += i == 0 ? "<Binding channel=\"c0\" dynamic=\"true\"/>"
                       : "<Binding channel=\"c" + n + "\"><ETag>0x7" + n + "</ETag></Binding>";
    ends += "<Publisher name=\"p" + n + "\" channel=\"c" + n + "\" network=\"n\" node=\"1\"/>\n" +
            "<Subscriber name=\"q" + n + "\" channel=\"c" + n + "\" network=\"n\"/>\n";
  }
  return test::system_of(text +
                         "<Network name=\"n\"><Kind>can</Kind><Profile>famouso</Profile><Bus "
                         "bitrate=\"500000\"/>" +
                         bindings + "</Network>\n" + ends);
}

TEST_F(AnalyseBusTest, ATagThatNobodyKnowsIsNotShownAsAnIdentifier) {
  const auto path = file("dealt.xml", dealt_tag());
  const auto text = analyse(path);
  EXPECT_TRUE(text.out.contains("tag not known")) << text.out << text.error;
  EXPECT_FALSE(text.out.contains("0x1f404000")) << text.out;
  const Json out = bus_of(analyse(path, {"--json"}).out);
  EXPECT_TRUE(message_of(out, "p0")["id"].is_null());
  EXPECT_EQ(message_of(out, "p1")["id"], 0x1f404071);
  const auto checked = test::run({"check", path}).out;
  EXPECT_TRUE(
      checked.contains("hint: state the ETag of channel c0 on n in place of dynamic: as long "
                       "as it is not known, it counts as the first one for others and as "
                       "the last one for p0"))
      << checked;
  EXPECT_FALSE(checked.contains("no identifier there is better than its own")) << checked;
}

TEST_F(AnalyseBusTest, TagsThatNobodyKnowsAreDifferentOnes) {
  auto text = dealt_tag();
  const std::string stated = "<Binding channel=\"c1\"><ETag>0x71</ETag></Binding>";
  text.replace(text.find(stated), stated.size(), "<Binding channel=\"c1\" dynamic=\"true\"/>");
  const auto done = analyse(file("two.xml", text));
  EXPECT_EQ(done.status, 1) << done.error;
  EXPECT_FALSE(done.out.contains("an identifier has one sender")) << done.out;
}

TEST_F(AnalyseBusTest, OfSeveralBusesThoseAreAnalysedThatCanBe) {
  const auto traffic = attribute("Period", time_value(50)) + payload_of_7();
  const auto no_rate = file("rate.xml", two_buses(traffic, ""));
  const auto text = analyse(no_rate);
  EXPECT_EQ(text.status, 1) << text.error;
  EXPECT_TRUE(text.out.contains("Network near\nMessage")) << text.out;
  EXPECT_TRUE(text.out.contains("Network far\nNot analysed:\n  " + no_rate +
                                ":4: the bit rate of network far is not described: state it with "
                                "--bitrate\n"))
      << text.out;
  const Json out = Json::parse(analyse(no_rate, {"--json"}).out);
  EXPECT_EQ(out["schedulable"], false);
  EXPECT_EQ(out["networks"][0]["messages"].size(), 1U);
  EXPECT_EQ(out["networks"][1]["not_analysed"].size(), 1U) << out;
  EXPECT_FALSE(analyse(no_rate, {"--network", "near"}).out.contains("Not analysed"));
  EXPECT_EQ(analyse(no_rate, {"--network", "far"}).status, 2) << "none of those that are asked for";
}

TEST_F(AnalyseBusTest, APublisherWithoutAPeriodIsNotKnownBesideTheOthers) {
  auto text = dealt_tag();
  const auto at = text.find("<EventChannel name=\"c5\">");
  const std::string period = attribute("Period", time_value(5));
  text.erase(text.find(period, at), period.size());
  const auto path = file("aperiodic.xml", text);
  const auto done = analyse(path);
  EXPECT_EQ(done.status, 1) << done.error;
  EXPECT_TRUE(done.out.contains("Not known:\n")) << done.out;
  EXPECT_TRUE(
      done.out.contains("publisher p5 states no Period: how often it sends on network n must "
                        "be bounded; it counts as nothing"))
      << done.out;
  EXPECT_TRUE(done.out.contains("p1 ")) << done.out;
}

/// Channels over a gateway whose queue on the far bus has that length.
std::string many_over_a_queue(unsigned length) {
  std::string text;
  std::string bindings;
  std::string ends;
  for (int i = 0; i < 9; ++i) {
    const std::string n = std::to_string(i);
    text += "<EventChannel name=\"c" + n + "\"><SubjectUID>0x" + std::to_string(i + 1) +
            "</SubjectUID><Attributes>" + attribute("Period", time_value(20)) + payload_of_7() +
            "</Attributes></EventChannel>\n";
    bindings += "<Binding channel=\"c" + n + "\"><Identifier form=\"standard\">0x1" + n +
                "</Identifier></Binding>";
    ends += "<Publisher name=\"p" + n + "\" channel=\"c" + n + "\" network=\"near\"/>\n" +
            "<Subscriber name=\"q" + n + "\" channel=\"c" + n + "\" network=\"far\"/>\n";
  }
  const std::string bus =
      "<Kind>can</Kind><Profile>raw</Profile><Bus bitrate=\"500000\"/>" + bindings + "</Network>\n";
  return test::system_of(text + "<Network name=\"near\">" + bus + "<Network name=\"far\">" + bus +
                         "<Gateway name=\"g\">" + delays(0) +
                         "<Port network=\"near\"><Interface name=\"can0\"/></Port>"
                         "<Port network=\"far\" queue-length=\"" +
                         std::to_string(length) +
                         "\"><Interface name=\"can1\"/></Port></Gateway>\n" + ends);
}

/// Of one channel of several frames are FD frames, and the bus states no bit rate for their data.
TEST_F(AnalyseBusTest, OneBindingWithoutABitRateForItsDataLeavesTheOthersAnalysed) {
  auto text = many_over_a_queue(20);
  const auto at = text.find("<Binding channel=\"c3\"");
  text.insert(at + 9, "format=\"fd\" ");
  const auto path = file("fd.xml", text);
  const auto done = analyse(path, {"--json"});
  EXPECT_EQ(done.status, 1) << done.error;
  const Json near = Json::parse(done.out)["networks"][0];
  EXPECT_EQ(near["messages"].size(), 8U) << near;
  EXPECT_TRUE(message_of(near, "p3").is_null());
  EXPECT_EQ(near["schedulable"], false) << "nobody knows how long frames of p3 are";
  ASSERT_EQ(near["unknown"].size(), 1U);
  EXPECT_TRUE(near["unknown"][0].get<std::string>().contains(
      "frames of channel c3 are not all classic, and near has no bit rate for their data phase: "
      "state it with --data-bitrate; it counts as nothing"))
      << near;
  const Json far = Json::parse(done.out)["networks"][1];
  EXPECT_EQ(far["messages"].size(), 9U) << "there its frames are classic, and it does not come";
  EXPECT_EQ(message_of(far, "p3")["counted"], false);
  EXPECT_EQ(message_of(far, "p0")["verdict"], "met");
  EXPECT_EQ(analyse(path, {"--data-bitrate", "1M"}).status, 0);
}

/// A publisher on the far bus sends by the identifier that the gateway sends by; and somebody asks
/// more than the near one offers.
TEST_F(AnalyseBusTest, TwoSendersOfAnIdentifierAreNamedByCheckWhateverElseIsWrong) {
  auto text =
      two_buses(attribute("Period", time_value(100)) + payload_of_7(), "<Bus bitrate=\"250000\"/>");
  text.insert(text.find("<Subscriber"),
              "<Publisher name=\"other\" channel=\"speed\" network=\"far\"><Attributes>" +
                  attribute("Period", time_value(50)) + payload_of_7() +
                  "</Attributes></Publisher>\n");
  text.insert(text.find("<Attributes>", text.find("<Subscriber")) + 12,
              attribute("Period", time_value(50)));
  const auto path = file("clash.xml", text);
  const auto checked = test::run({"check", path}).out;
  EXPECT_TRUE(checked.contains("MLCCA020")) << checked;
  EXPECT_TRUE(
      checked.contains("MLCCA018: events of channel speed reach far over publisher other (line 7) "
                       "and over gateway bridge (line 5): two senders of one identifier"))
      << checked;
  const auto done = analyse(path);
  EXPECT_EQ(done.status, 1) << done.error;
  EXPECT_TRUE(done.out.contains("Network far\nNot analysed:\n")) << done.out;
  EXPECT_TRUE(done.out.contains("Network near\nMessage")) << done.out;
}

TEST_F(AnalyseBusTest, TheLengthThatAQueueNeedsForAllIsWhatTheHintSays) {
  const auto checked = test::run({"check", file("queue.xml", many_over_a_queue(1))}).out;
  const std::string before = "give the port of the gateway queue-length=\"";
  const auto at = checked.find(before);
  ASSERT_NE(at, std::string::npos) << checked;
  const unsigned long length = std::stoul(checked.substr(at + before.size()));
  EXPECT_EQ(length, 9U) << checked;
  EXPECT_TRUE(
      checked.contains("\"9\": so many frames wait there at most if all messages of far are "
                       "sent"))
      << checked;
  const auto mended = test::run({"check", file("mended.xml", many_over_a_queue(9))}).out;
  EXPECT_FALSE(mended.contains("MLCCA036")) << mended;
  EXPECT_TRUE(
      test::run({"check", file("short.xml", many_over_a_queue(8))}).out.contains("MLCCA036"));
}

/// A bus that is too slow for one publisher, whose channel has subscribers on two others.
TEST_F(AnalyseBusTest, WhatIsFoundOfSeveralPlacesAlikeIsSaidOnce) {
  const auto traffic = attribute("Period", time_value(50)) + payload_of_7();
  auto text = two_buses(traffic, "<Bus bitrate=\"250000\"/>");
  const std::string rate = "bitrate=\"125000\"";
  text.replace(text.find(rate), rate.size(), "bitrate=\"3000\"");
  text.insert(text.find("</System>"),
              "<Subscriber name=\"lamp\" channel=\"speed\" network=\"near\"/>\n"
              "<Subscriber name=\"horn\" channel=\"speed\" gateway=\"bridge\"/>\n");
  const auto checked = test::run({"check", file("slow.xml", text)}).out;
  const std::string said = "with wheel, the frames of wheel (speed) on near could take";
  const auto first = checked.find(said);
  ASSERT_NE(first, std::string::npos) << checked;
  const auto line = checked.substr(first, checked.find('\n', first) - first);
  EXPECT_EQ(checked.find(line, first + 1), std::string::npos) << checked;
}

TEST_F(AnalyseBusTest, AnOverloadIsThatOfAllFramesOnTheBus) {
  auto text = many_over_a_queue(40);
  for (auto at = text.find("500000"); at != std::string::npos; at = text.find("500000"))
    text.replace(at, 6, "5000");
  const auto checked = test::run({"check", file("full.xml", text)}).out;
  EXPECT_TRUE(checked.contains(
      "use a faster bus: what is granted there and these frames would take 125.0 %"))
      << checked;
}

}  // namespace
}  // namespace mlcca
