// SPDX-License-Identifier: BSD-2-Clause
// mlccactl analyse-bus of descriptions: the numbers that check decides by.
#include <fmt/format.h>

#include <algorithm>

#include "tests/tools/design/analyse_bus/described_buses.hpp"

namespace mlcca {
namespace {

TEST_F(AnalyseBusTest, WhatCheckRefusesForSomethingElseIsNotFine) {
  const auto traffic = attribute("Period", time_value(50)) + payload_of_7();
  const auto fine = file("fine.xml", two_buses(traffic, "<Bus bitrate=\"250000\"/>"));
  EXPECT_EQ(analyse(fine).status, 0);
  const auto path = file("lossy.xml", two_buses(traffic + attribute("Omission", "<Value>2</Value>"),
                                                "<Bus bitrate=\"250000\"/>"));
  const auto refused = analyse(path);
  EXPECT_EQ(refused.status, 1) << "no bus states an Omission";
  EXPECT_NE(refused.out.find("every deadline is met, but mlccactl check refuses 1 message"),
            std::string::npos)
      << refused.out;
}

TEST_F(AnalyseBusTest, PublishersOfADescriptionAreAnalysedOnEachNetworkTheyCross) {
  const auto traffic = attribute("Period", time_value(50)) + payload_of_7();
  const auto path = file("two.xml", two_buses(traffic, "<Bus bitrate=\"250000\"/>"));
  const auto both = analyse(path, {"--json"});
  ASSERT_EQ(both.status, 0) << both.error << both.out;
  const Json out = Json::parse(both.out);
  ASSERT_EQ(out["networks"].size(), 2U);
  const Json& near = out["networks"][0]["messages"][0];
  EXPECT_EQ(out["networks"][0]["network"], "near");
  EXPECT_EQ(near["name"], "wheel");
  EXPECT_EQ(near["id"], 0x100);
  EXPECT_EQ(near["response_us"], 1000);
  EXPECT_EQ(near["period_us"], 50000);
  // Both buses share the 30 ms, as their bit times are 2 to 1.
  EXPECT_EQ(near["deadline_us"], 20000);
  const Json& far = out["networks"][1]["messages"][0];
  EXPECT_EQ(far["id"], 0x200);
  EXPECT_EQ(far["jitter_us"], 20000) << "whoever comes later may make it as late as that";
  EXPECT_EQ(far["on_bus_us"], 500);
  EXPECT_EQ(far["response_us"], 20500);
  EXPECT_EQ(far["deadline_us"], 30000);
  const auto one = analyse(path, {"--json", "--network", "far", "--bitrate", "125k"});
  EXPECT_EQ(bus_of(one.out)["messages"][0]["on_bus_us"], 1000);
  EXPECT_EQ(analyse(path, {"--network", "nowhere"}).status, 2);
}

TEST_F(AnalyseBusTest, WhatIsNotStatedOfTheWayIsReported) {
  const auto traffic = attribute("Period", time_value(50)) + payload_of_7();
  const auto path = file("open.xml", two_buses(traffic, "<Bus bitrate=\"250000\"/>", ""));
  const auto done = analyse(path);
  EXPECT_EQ(done.status, 1);
  EXPECT_NE(done.out.find("no message is admitted, but mlccactl check refuses 1 message"),
            std::string::npos)
      << done.out;
  EXPECT_NE(done.out.find("how long bridge delays events of wheel is not known"), std::string::npos)
      << done.out;
}

/// In another order of the identifiers on the first bus it would come earlier.
TEST_F(AnalyseBusTest, AnOrderThatIsNotFoundMayExistWhereTheBusBeforeCanBeBetter) {
  auto lines = late_on_the_second();
  lines.back().deadline = 2000;
  const auto path = file("later.xml", system_with(lines));
  const auto text = analyse(path, {"--assign"}).out;
  EXPECT_NE(text.find("No order of the identifiers was found"), std::string::npos) << text;
  EXPECT_NE(text.find("X comes here from another network with a jitter of 1890.000 us"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("There is no order"), std::string::npos) << text;
  const Json out = Json::parse(analyse(path, {"--assign", "--json"}).out);
  EXPECT_TRUE(out["networks"][0]["assignment"].is_array());
  EXPECT_TRUE(out["networks"][1]["assignment"].is_null());
  EXPECT_EQ(out["networks"][1]["assignment_may_exist"].size(), 2U);
  lines.back().id_a = 1;  // as the order on the first bus says
  const auto better = analyse(file("better.xml", system_with(lines)), {"--json"});
  EXPECT_EQ(better.status, 0) << better.out;
}

/// Channels of 1 ms and 8 bytes on a bus of 250 kbit/s, where a frame takes 540 us: one of them
/// fits: the first, which goes last on the bus.
std::string crowded_bus(int channels) {
  std::string all;
  std::string bindings;
  std::string ends;
  for (int i = 0; i < channels; ++i) {
    all += fmt::format(
        "<EventChannel name=\"c{0}\"><SubjectUID>{1:#x}</SubjectUID><Attributes>{2}{3}</Attributes>"
        "</EventChannel>\n",
        i, i + 1, attribute("Period", time_value(1)),
        attribute("MaxPayload",
                  "<Dimension><SIUnit><Bytes>1</Bytes></SIUnit></Dimension><Value>8</Value>"));
    bindings += fmt::format(
        "<Binding channel=\"c{}\"><Identifier form=\"standard\">{:#x}</Identifier></Binding>", i,
        0x300 - 0x100 * i);
    ends += fmt::format(
        "<Publisher name=\"p{0}\" channel=\"c{0}\" network=\"bus\"/>\n"
        "<Subscriber name=\"s{0}\" channel=\"c{0}\" network=\"bus\"/>\n",
        i);
  }
  return test::system_of(all +
                         "<Network name=\"bus\"><Kind>can</Kind><Profile>raw</Profile>"
                         "<Bus bitrate=\"250000\"/>" +
                         bindings + "</Network>\n" + ends);
}

TEST_F(AnalyseBusTest, SaysWhyCheckGrantsWhatIsLateWhereEverythingSends) {
  const auto crowded = analyse(file("crowded.xml", crowded_bus(3)));
  EXPECT_EQ(crowded.status, 1);
  EXPECT_TRUE(crowded.out.contains(
      "Check us counts what mlccactl check grants, and the message of the row. Response us also "
      "counts what the bus's own nodes send although it is refused.\n"
      "mlccactl check grants a message that is late here: it counts what it refuses as silent, but "
      "no gate is between a bus and its own nodes.\n"))
      << crowded.out;
  EXPECT_TRUE(crowded.out.contains(
      "'mlccactl check' refuses these; their times are beside the messages that it grants:"))
      << crowded.out;
  const auto alone = analyse(file("alone.xml", crowded_bus(1)));
  EXPECT_EQ(alone.status, 0) << alone.out;
  EXPECT_FALSE(alone.out.contains("Response us: what")) << alone.out;
}

TEST_F(AnalyseBusTest, ShowsTheTimeThatCheckRefusesAMessageFor) {
  const auto path = file("refused.xml", system_with({{"c0", "a", "a", 0x300, 0, 4000, 4000},
                                                     {"c1", "a", "a", 0x301, 0, 4000, 500},
                                                     {"c2", "a", "a", 0x302, 0, 4000, 500}}));
  // Each frame takes 270 us. c2 waits for c0 only, since check refuses c1.
  const auto check = test::run({"check", path}).out;
  EXPECT_TRUE(check.contains("the frames of c1 (c1) on a could take 540 us")) << check;
  EXPECT_TRUE(check.contains("the frames of c2 (c2) on a could take 540 us")) << check;
  const auto text = analyse(path, {"--network", "a"}).out;
  EXPECT_TRUE(text.contains("c2            0x302   270.000   540.000      810.000")) << text;
  const Json out = bus_of(analyse(path, {"--network", "a", "--json"}).out);
  EXPECT_EQ(out["messages"][2]["granted"], false);
  EXPECT_EQ(out["messages"][2]["refused_response_us"], 540.0);
  EXPECT_EQ(out["messages"][2]["response_us"], 810.0);
  EXPECT_FALSE(out["messages"][0].contains("refused_response_us"));
}

TEST_F(AnalyseBusTest, AQueueThatIsTooShortIsNoMissedDeadline) {
  std::vector<Line> lines;
  for (unsigned i = 0; i < 4; ++i)
    lines.push_back({"c" + std::to_string(i), "a", "b", 0x10 + i, 0x10 + i, 50000, 50000});
  const auto path = file("queue.xml", system_with(lines, " queue-length=\"3\""));
  const auto done = analyse(path, {"--json", "--network", "b"});
  ASSERT_EQ(done.status, 1) << done.error;
  const Json out = bus_of(done.out);
  // The fourth is refused: it would be one frame too many.
  for (const Json& m : out["messages"]) {
    const bool last = m["name"] == "c3";
    EXPECT_EQ(m["verdict"], last ? "queue-too-short" : "met");
    EXPECT_EQ(m["granted"], !last);
    EXPECT_EQ(m["queue"]["frames"], last ? 4 : 3);
    EXPECT_EQ(m["queue"]["length"], 3);
    if (last)
      EXPECT_TRUE(m["response_us"].is_null()) << "it does not come";
    else
      EXPECT_GT(m["slack_us"], 0);
  }
  const auto text = analyse(path).out;
  EXPECT_NE(text.find("queue too short: 3 of 4"), std::string::npos) << text;
  EXPECT_NE(text.find("every deadline is met, but mlccactl check refuses 1 message"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("can be missed"), std::string::npos) << text;
  const auto check = test::run({"check", path}).out;
  EXPECT_NE(check.find("MLCCA036"), std::string::npos) << check;
  EXPECT_NE(check.find("it holds 3 frames, and up to 4 wait in it"), std::string::npos) << check;
  EXPECT_NE(check.find("queue-length=\"4\""), std::string::npos) << check;
}

TEST_F(AnalyseBusTest, WhoHasNoSubscriberIsNotCountedAndNamed) {
  auto text = system_with(
      {{"heard", "a", "a", 1, 0, 20000, 20000}, {"unheard", "a", "a", 2, 0, 20000, 20000}});
  const auto at = text.find("<Subscriber name=\"to-unheard\"");
  text.erase(at, text.find('\n', at) - at);
  const auto done = analyse(file("unheard.xml", text), {"--json", "--network", "a"});
  ASSERT_EQ(done.status, 0) << done.error << done.out;
  const Json out = bus_of(done.out);
  EXPECT_EQ(out["messages"].size(), 1U);
  ASSERT_EQ(out["not_counted"].size(), 1U);
  EXPECT_NE(out["not_counted"][0].get<std::string>().find("unheard"), std::string::npos);
}

TEST_F(AnalyseBusTest, WhatIsNotCountedMayBreakNoDeadlineUnsaid) {
  auto text =
      system_with({{"heard", "a", "a", 2, 0, 20000, 20000}, {"unheard", "a", "a", 1, 0, 250, 900}});
  const auto at = text.find("<Subscriber name=\"to-unheard\"");
  text.erase(at, text.find('\n', at) - at);
  const auto path = file("unheard.xml", text);
  const auto done = analyse(path, {"--network", "a"});
  EXPECT_EQ(done.status, 1) << done.out;
  EXPECT_NE(done.out.find("every deadline is met only while what is not counted is silent\n"),
            std::string::npos)
      << done.out;
  const auto check = test::run({"check", path}).out;
  EXPECT_NE(check.find("MLCCA011: unheard publishes channel unheard, which nobody subscribes: its "
                       "frames on a are counted nowhere"),
            std::string::npos)
      << check;
}

/// Two events wait in a queue of 4 of the gateway: with the frames of `noise`, which nobody
/// subscribes, six do.
TEST_F(AnalyseBusTest, WhatIsNotCountedMayFillNoQueueUnsaid) {
  const auto channel = [](const std::string& name, const char* subject, const char* attributes) {
    return "<EventChannel name=\"" + name + "\"><SubjectUID>" + subject +
           "</SubjectUID><Attributes maxPayload=\"8\" " + attributes + "/></EventChannel>";
  };
  const auto binding = [](const char* name, const char* id) {
    return std::string("<Binding channel=\"") + name + "\"><Identifier form=\"standard\">" + id +
           "</Identifier></Binding>";
  };
  const auto bus = [&](const char* name, const char* rate, const std::string& more) {
    return std::string("<Network name=\"") + name + "\"><Kind>can</Kind><Profile>raw</Profile>" +
           "<Bus bitrate=\"" + rate + "\"/>" + more + binding("x", "0x11") + binding("y", "0x12") +
           "</Network>";
  };
  const std::string system =
      "<System name=\"queues\">" + channel("noise", "0x1", "period=\"400us\"") +
      channel("x", "0x4", "period=\"2ms\" deadline=\"40ms\"") +
      channel("y", "0x5", "period=\"2ms\" deadline=\"40ms\"") + bus("src", "1000000", "") +
      bus("bus", "500000", binding("noise", "0x10")) +
      "<Gateway name=\"g\"><Provision omission=\"0\" latency=\"1ms\" jitter=\"0us\"/>"
      "<Port network=\"src\"><Interface name=\"can1\"/></Port>"
      "<Port network=\"bus\" queue-length=\"4\"><Interface name=\"can0\"/></Port></Gateway>"
      "<Publisher name=\"n\" channel=\"noise\" network=\"bus\"/>"
      "<Publisher name=\"px\" channel=\"x\" network=\"src\"/>"
      "<Subscriber name=\"sx\" channel=\"x\" network=\"bus\"/>"
      "<Publisher name=\"py\" channel=\"y\" network=\"src\"/>"
      "<Subscriber name=\"sy\" channel=\"y\" network=\"bus\"/></System>";
  const auto done = analyse(file("queues.xml", system), {"--network", "bus"});
  EXPECT_EQ(done.status, 1) << done.out << done.error;
  EXPECT_TRUE(done.out.contains(
      "every deadline is met, and no frame is lost in a queue only while what is not counted is "
      "silent\n"))
      << done.out;
  const Json json = bus_of(analyse(file("queues.xml", system), {"--network", "bus", "--json"}).out);
  EXPECT_FALSE(json["schedulable"].get<bool>());
}

TEST_F(AnalyseBusTest, TwoSendersOfOneIdentifierAreRefusedWithBothLines) {
  const auto path = table(
      "a,0x10,0,8,10000,10000,0\nb,17,0,8,10000,10000,0\n"
      "c,16,0,8,10000,10000,0\nd,16,1,8,10000,10000,0\n"
      "a,18,0,8,10000,10000,0\n");
  const auto done = slow(path);
  EXPECT_EQ(done.status, 2);
  EXPECT_EQ(done.out, "");
  EXPECT_NE(done.error.find(path + ":4: identifier 0x10 of c is that of a already, from " + path +
                            ":2: an identifier has one sender"),
            std::string::npos)
      << done.error;
  EXPECT_NE(done.error.find(path + ":6: the name a is already taken in " + path + ":2"),
            std::string::npos)
      << done.error;
  // A program on a gateway, and a node of the bus.
  const auto both = file(
      "both.xml",
      test::system_of(
          "<EventChannel name=\"c\"><SubjectUID>0x1</SubjectUID></EventChannel>\n"
          "<Network name=\"bus\"><Kind>can</Kind><Profile>raw</Profile><Bus bitrate=\"500000\"/>"
          "<Binding channel=\"c\"><Identifier form=\"standard\">0x5</Identifier></Binding>"
          "</Network>\n<Gateway name=\"g\"><Port network=\"bus\"><Interface name=\"can0\"/></Port>"
          "</Gateway>\n"
          "<Publisher name=\"here\" channel=\"c\" gateway=\"g\" user=\"nobody\"><Attributes>" +
          attribute("Period", time_value(50)) + payload_of_7() +
          "</Attributes></Publisher>\n"
          "<Publisher name=\"there\" channel=\"c\" network=\"bus\"><Attributes>" +
          attribute("Period", time_value(50)) + payload_of_7() +
          "</Attributes></Publisher>\n<Subscriber name=\"s\" channel=\"c\" network=\"bus\"/>\n"));
  const auto described = analyse(both);
  EXPECT_EQ(described.status, 2) << described.out;
  const auto checked = test::run({"check", both}).out;
  const auto at = checked.find("MLCCA018: ");
  ASSERT_NE(at, std::string::npos) << checked;
  EXPECT_TRUE(described.error.contains(checked.substr(at, checked.find('\n', at) - at)))
      << described.error << checked;
}

TEST_F(AnalyseBusTest, FramesWithADataPhaseNeedItsBitRate) {
  const auto path = file("fd.csv", "name,id,extended,bytes,period_us,fd\nlong,1,0,64,10000,1\n");
  const auto done = analyse(path, {"--bitrate", "500k"});
  EXPECT_EQ(done.status, 2);
  EXPECT_NE(done.error.find(path + ":2: fd: "), std::string::npos) << done.error;
  EXPECT_EQ(analyse(path, {"--bitrate", "500k", "--data-bitrate", "500k"}).status, 0);
  auto text =
      two_buses(attribute("Period", time_value(50)) + payload_of_7(), "<Bus bitrate=\"250000\"/>");
  text.replace(text.rfind("<Binding channel=\"speed\""), 24,
               "<Binding channel=\"speed\" format=\"fd\"");
  const auto described = file("fd.xml", text);
  const auto refused = analyse(described);
  EXPECT_EQ(refused.status, 1) << "the other bus is analysed";
  EXPECT_TRUE(refused.out.contains("far has no bit rate for their data phase")) << refused.out;
  EXPECT_EQ(analyse(described, {"--network", "far"}).status, 2);
  EXPECT_NE(test::run({"check", described}).out.find("MLCCA035"), std::string::npos);
  EXPECT_EQ(analyse(described, {"--network", "far", "--data-bitrate", "2M"}).status, 0);
  // On both buses of its way.
  text.replace(text.find("<Binding channel=\"speed\""), 24,
               "<Binding channel=\"speed\" format=\"fd\"");
  const auto neither = analyse(file("fd2.xml", text));
  EXPECT_EQ(neither.status, 2) << neither.out;
  EXPECT_TRUE(neither.error.contains("near has no bit rate for their data phase")) << neither.error;
  EXPECT_TRUE(neither.error.contains("far has no bit rate for their data phase")) << neither.error;
}

TEST_F(AnalyseBusTest, AJitterThatIsTooLongIsNamedAndUnboundsOnlyWhatIsBelow) {
  auto text = system_with({{"up", "a", "a", 1, 0, 20000, 20000},
                           {"mad", "a", "a", 2, 0, 20000, 20000},
                           {"down", "a", "a", 3, 0, 20000, 20000}});
  const auto at = text.find("<Publisher name=\"mad\"");
  text.insert(text.find("<Attributes>", at) + 12, time_us("Jitter", 2'000'000'000));
  const auto done = analyse(file("mad.xml", text), {"--json", "--network", "a"});
  ASSERT_EQ(done.status, 1) << done.error;
  const Json out = bus_of(done.out);
  EXPECT_EQ(out["not_bounded"],
            "Because of mad nothing is bounded that it may win against: its jitter is longer than "
            "what is analysed.");
  EXPECT_EQ(message_of(out, "up")["verdict"], "met");
  EXPECT_EQ(message_of(out, "down")["verdict"], "not-bounded");
}

TEST_F(AnalyseBusTest, WhatADescriptionLacksIsNamedWithItsLine) {
  const auto no_period = file("period.xml", two_buses(payload_of_7(), "<Bus bitrate=\"250000\"/>"));
  auto done = analyse(no_period);
  EXPECT_EQ(done.status, 2);
  EXPECT_EQ(done.out, "");
  EXPECT_NE(done.error.find(no_period + ":6: publisher wheel states no Period"), std::string::npos)
      << done.error;
  const auto no_rate = file("rate.xml", two_buses(attribute("Period", time_value(50)), ""));
  done = analyse(no_rate, {"--network", "far"});
  EXPECT_EQ(done.status, 2);
  EXPECT_NE(done.error.find("the bit rate of network far is not described"), std::string::npos);
  EXPECT_EQ(analyse(file("broken.xml", "<System")).status, 2);
}

/// What is stated of one link counts, and so does a best case: neither is said to be missing.
TEST_F(AnalyseBusTest, SaysWhatCountsInPlaceOfADelayThatIsNotKnown) {
  const auto said_of = [&](const std::string& name, const std::string& gateway,
                           const std::string& per_hop) {
    auto text = two_buses(attribute("Period", time_value(50)) + payload_of_7(),
                          "<Bus bitrate=\"250000\"/>", gateway);
    if (!per_hop.empty()) {
      text.replace(text.find("<Network name=\"near\""),
                   text.find("<Network name=\"far\"") - text.find("<Network name=\"near\""),
                   "<Network name=\"near\"><Kind>mesh</Kind><Mesh>" + per_hop +
                       "<Node name=\"wheel\" address=\"02:00:00:00:00:01\"/><Node name=\"bridge\" "
                       "address=\"02:00:00:00:00:02\" gateway=\"bridge\"/><Source kind=\"file\" "
                       "endpoint=\"/links\"/></Mesh></Network>\n");
      text.replace(text.find("<Port network=\"near\""), 20,
                   "<Port network=\"near\" sender=\"root\"");
      text.replace(text.find("<Port network=\"far\""), 19, "<Port network=\"far\" sender=\"root\"");
    }
    const auto out = bus_of(analyse(file(name, text), {"--json", "--network", "far"}).out);
    return out.contains("unknown") ? out["unknown"].at(0).get<std::string>() : std::string();
  };
  EXPECT_EQ(said_of("known.xml", delays(0), ""), "");
  EXPECT_EQ(said_of("nothing.xml", "", ""),
            "how long bridge delays events of wheel is not known and counts as nothing: state its "
            "Latency");
  EXPECT_EQ(
      said_of("best.xml",
              "<Provision dynamic=\"true\">" + attribute("Latency", time_value(1)) + "</Provision>",
              ""),
      "how long bridge delays events of wheel is not known before the run time, and counts "
      "as its best case");
  EXPECT_EQ(said_of("mesh.xml", delays(0),
                    "<PerHop>" + attribute("Latency", time_value(1)) + "</PerHop>"),
            "how long near delays events of wheel is not known before the run time, and counts as "
            "that of one link (PerHop)");
  EXPECT_EQ(said_of("no-latency.xml", delays(0), "<PerHop></PerHop>"),
            "how long near delays events of wheel is not known and counts as nothing: state the "
            "Latency of a link (PerHop)");
}

}  // namespace
}  // namespace mlcca
