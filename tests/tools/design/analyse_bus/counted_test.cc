// SPDX-License-Identifier: BSD-2-Clause
// What can really be on a bus of a description, in mlccactl analyse-bus and on the page of check.
#include "tests/tools/design/analyse_bus/described_buses.hpp"

namespace mlcca {
namespace {

/// X would be in front of V twice, which would then take 1080 us: so it is refused, and a gate
/// drops it before it reaches b.
TEST_F(AnalyseBusTest, WhatAGateDropsBeforeABusMakesNothingLateThere) {
  const auto path = file("late.xml", system_with(late_on_the_second()));
  const auto done = analyse(path, {"--json"});
  ASSERT_EQ(done.status, 1) << done.error;
  const Json b = Json::parse(done.out)["networks"][1];
  EXPECT_EQ(message_of(b, "V")["response_us"], 540) << "one that blocks, and V";
  EXPECT_EQ(message_of(b, "V")["verdict"], "met");
  EXPECT_EQ(message_of(b, "V")["granted"], true);
  EXPECT_EQ(message_of(b, "X")["verdict"], "refused");
  EXPECT_EQ(message_of(b, "X")["counted"], false);
  EXPECT_EQ(message_of(b, "X")["jitter_us"], 2000) << "as late as a lets it be";
  const auto check = test::run({"check", path});
  EXPECT_NE(check.out.find("MLCCA031"), std::string::npos);
  EXPECT_NE(check.out.find("could take 1.08 ms of the 900 us"), std::string::npos) << check.out;
  ASSERT_EQ(b["findings"].size(), 1U);
  EXPECT_NE(b["findings"][0].get<std::string>().find("could take 1.08 ms of the 900 us"),
            std::string::npos);
  const auto text = analyse(path).out;
  EXPECT_TRUE(text.contains("every deadline is met, but mlccactl check refuses 1 message")) << text;
  EXPECT_FALSE(text.contains("can be missed")) << text;
  EXPECT_TRUE(text.contains(
      "is dropped before this bus. Its row has the time that mlccactl check refuses it for, or "
      "none"))
      << text;
  EXPECT_TRUE(message_of(b, "X")["response_us"].is_null()) << "it is not there, and V is why";
  EXPECT_FALSE(message_of(b, "X").contains("on_bus_us"));
}

TEST_F(AnalyseBusTest, WhatIsRefusedOnItsOwnBusIsThereAndOnTheNextOneNot) {
  auto lines = late_on_the_second();
  lines.back().deadline = 2000;  // 1 ms on each bus, and it takes 1.89 ms on the first
  const auto done = analyse(file("later.xml", system_with(lines)), {"--json"});
  ASSERT_EQ(done.status, 1) << done.error;
  const Json out = Json::parse(done.out);
  EXPECT_EQ(message_of(out["networks"][0], "X")["response_us"], 1890);
  EXPECT_EQ(message_of(out["networks"][0], "X")["counted"], true);
  EXPECT_EQ(message_of(out["networks"][1], "X")["jitter_us"], 1890);
  EXPECT_EQ(message_of(out["networks"][1], "X")["counted"], false);
  EXPECT_EQ(message_of(out["networks"][1], "V")["response_us"], 540);
}

/// Its own node sends it on a whatever check says: first is blocked and goes behind it once.
TEST_F(AnalyseBusTest, WhatIsRefusedOnItsOwnBusCountsInTextJsonAndHtml) {
  const auto path = file("own.xml", system_with({{"first", "a", "a", 0x20, 0, 5000, 700},
                                                 {"low", "a", "a", 0x30, 0, 50000, 50000},
                                                 {"own", "a", "a", 0x10, 0, 2000, 200}}));
  const auto done = analyse(path, {"--json", "--network", "a"});
  EXPECT_EQ(done.status, 1) << done.error;
  const Json a = bus_of(done.out);
  EXPECT_EQ(message_of(a, "own")["granted"], false);
  EXPECT_EQ(message_of(a, "own")["counted"], true);
  EXPECT_EQ(message_of(a, "first")["granted"], true);
  EXPECT_EQ(message_of(a, "first")["granted_response_us"], 540);
  EXPECT_EQ(message_of(a, "first")["response_us"], 810);
  EXPECT_EQ(message_of(a, "first")["verdict"], "late");
  EXPECT_NEAR(a["bus_load"].get<double>(), 0.1944, 1e-4) << "of all three";
  const auto page = test::run({"check", "--format", "html", path}).out;
  EXPECT_TRUE(page.contains("late while what is refused here is sent")) << page;
  EXPECT_TRUE(page.contains("<div>810 us</div>")) << page;
  EXPECT_TRUE(
      page.contains("19.44 % of the time of the bus at 500 kbit/s for what is granted and "
                    "what its own nodes send though it is refused"))
      << page;
  EXPECT_TRUE(page.contains("in time only while what is refused there is silent")) << page;
}

/// Granted to whoever is on a, and refused to whoever is on b: the deadline on a is that of a.
TEST_F(AnalyseBusTest, WhatIsGrantedForOnePlaceIsHeldAgainstItsOwnDeadline) {
  auto text = system_with(
      {{"both", "a", "b", 0x20, 0x20, 20000, 20000}, {"low", "a", "a", 0x30, 0, 50000, 50000}});
  const std::string far = "<Subscriber name=\"to-both\" channel=\"both\" network=\"b\"/>";
  text.replace(text.find(far), far.size(),
               "<Subscriber name=\"near\" channel=\"both\" network=\"a\"/>"
               "<Subscriber name=\"far\" channel=\"both\" network=\"b\"><Attributes>" +
                   time_us("Deadline", 500) + "</Attributes></Subscriber>");
  const auto done = analyse(file("both.xml", text), {"--json", "--network", "a"});
  const Json a = bus_of(done.out);
  EXPECT_EQ(message_of(a, "both")["granted"], true) << "what goes to b does not end here";
  EXPECT_EQ(message_of(a, "both")["outcome"], "fit");
  EXPECT_EQ(message_of(a, "both")["counted"], true);
  EXPECT_EQ(message_of(a, "both")["deadline_us"], 20000) << a;
  EXPECT_EQ(message_of(a, "both")["verdict"], "met");
}

/// From a to b, and to a mesh that states no Latency.
constexpr const char* kOneOfTwoPlaces =
    "<EventChannel name='c'><SubjectUID>0x1</SubjectUID><Attributes period='10ms' maxPayload='8' "
    "deadline='3ms'/></EventChannel>\n"
    "<Network name='b'><Kind>can</Kind><Profile>raw</Profile><Bus bitrate='500000'/><Binding "
    "channel='c'><Identifier form='standard'>0x10</Identifier></Binding></Network>\n"
    "<Network name='a'><Kind>can</Kind><Profile>raw</Profile><Bus bitrate='500000'/><Binding "
    "channel='c'><Identifier form='standard'>0x10</Identifier></Binding></Network>\n"
    "<Network name='m'><Kind>mesh</Kind><Mesh><PerHop/><Node name='n1' "
    "address='02:00:00:00:00:01' gateway='g'/><Node name='n2' address='02:00:00:00:00:02'/><Link "
    "from='n1' to='n2' rate='6000000'/></Mesh></Network>\n"
    "<Gateway name='g'><Provision latency='1ms' jitter='1ms' omission='0'/><Port network='b'>"
    "<Interface name='can0'/></Port><Port network='a'><Interface name='can1'/></Port><Port "
    "network='m'><Interface name='bat0'/></Port></Gateway>\n"
    "<Publisher name='p' channel='c' network='a'/><Subscriber name='s' channel='c' network='b'/>"
    "<Subscriber name='s2' channel='c' network='m' mesh-node='n2'/>\n";

TEST_F(AnalyseBusTest, WhatIsRefusedForOnePlaceIsAdmittedOnTheBusThatItCrossesForOthers) {
  const auto path = file("places.xml", test::system_of(kOneOfTwoPlaces));
  EXPECT_TRUE(test::run({"check", path}).out.contains("MLCCA021: p to s2"));
  const auto text = analyse(path).out;
  EXPECT_FALSE(text.contains("refused by check")) << text;
  EXPECT_FALSE(text.contains("check refuses")) << text;
  const Json out = Json::parse(analyse(path, {"--json"}).out);
  for (const Json& bus : out["networks"]) {
    const Json& p = message_of(bus, "p");
    EXPECT_EQ(p["outcome"], "fit") << bus;
    EXPECT_EQ(p["granted"], true);
    EXPECT_EQ(p["counted"], true);
    EXPECT_EQ(p["verdict"], "met");
  }
  const auto page = test::run({"check", "--format", "html", path}).out;
  EXPECT_TRUE(
      page.contains("in time</span></div></td><td role=\"cell\" data-label=\"Response, at "
                    "most\"><div>270 us"))
      << page;
}

/// p0 is a program's on a gateway, p1 comes over another one: neither is granted to any place, for
/// a mesh that is too slow, and check names no second sender.
std::string senders_of_one_identifier(const std::string& publishers) {
  return test::system_of(
      "<EventChannel name='c'><SubjectUID>0x1</SubjectUID><Attributes period='100ms' "
      "maxPayload='1'/></EventChannel>\n"
      "<Network name='m'><Kind>mesh</Kind><Profile>famouso</Profile><Mesh><PerHop "
      "latency='200ms'/><Node name='n1' address='02:00:00:00:00:01' gateway='g0'/><Node name='n2' "
      "address='02:00:00:00:00:02'/><Link from='n1' to='n2' rate='6000000'/></Mesh></Network>\n"
      "<Network name='b'><Kind>can</Kind><Profile>raw</Profile><Bus bitrate='500000'/><Binding "
      "channel='c'><Identifier form='standard'>0x101</Identifier></Binding></Network>\n"
      "<Gateway name='g0'><Provision latency='1ms' jitter='0s' omission='0'/><Port network='m'>"
      "<Interface name='bat0'/></Port><Port network='b'><Interface name='can0'/></Port></Gateway>\n"
      "<Gateway name='g1'><Provision latency='1ms' jitter='0s' omission='0'/><Port network='b'>"
      "<Interface name='can0'/></Port></Gateway>\n" +
      publishers +
      "<Subscriber name='s1' channel='c' gateway='g1'/>"
      "<Subscriber name='s' channel='c' network='m' mesh-node='n2'/>\n");
}

TEST_F(AnalyseBusTest, WhatIsDroppedBeforeABusIsNoSecondSenderThere) {
  const auto path = file(
      "dropped.xml",
      senders_of_one_identifier("<Publisher name='p0' channel='c' gateway='g1' user='nobody'/>"
                                "<Publisher name='p1' channel='c' network='m' mesh-node='n2'/>"));
  EXPECT_FALSE(test::run({"check", path}).out.contains("MLCCA018"));
  const auto text = analyse(path);
  EXPECT_EQ(text.status, 1) << text.error;
  EXPECT_TRUE(text.out.contains("Network b\nMessage")) << text.out << text.error;
  const Json b = bus_of(analyse(path, {"--json"}).out);
  for (const char* name : {"p0", "p1"}) EXPECT_EQ(message_of(b, name)["counted"], false) << b;
}

/// Whatever they are refused for, no gate is between the node and the bus.
TEST_F(AnalyseBusTest, WhoSendsByTheIdentifierOfANodeOfTheBusLeavesNoBound) {
  const auto path = file(
      "nodes.xml",
      senders_of_one_identifier("<Publisher name='p0' channel='c' network='b'/>"
                                "<Publisher name='p1' channel='c' network='m' mesh-node='n2'/>"));
  EXPECT_TRUE(test::run({"check", path}).out.contains("MLCCA018"));
  const auto done = analyse(path);
  EXPECT_EQ(done.status, 2) << done.out;
  EXPECT_TRUE(done.error.contains("MLCCA018")) << done.error;
}

/// p is late on both buses: on b check says 7.04 ms, with the jitter that a may leave it.
TEST_F(AnalyseBusTest, WhatIsDroppedBeforeABusHasTheTimeThatCheckRefusesItFor) {
  auto text = system_with(
      {{"q", "a", "a", 0x5, 0, 20000, 20000}, {"p", "a", "b", 0x10, 0x10, 20000, 7000}});
  for (auto at = text.find("500000"); at != std::string::npos; at = text.find("500000"))
    text.replace(at, 6, "250000");
  const std::string none = delays(0);
  text.replace(text.find(none), none.size(),
               "<Provision>" + time_us("Latency", 6000) + time_us("Jitter", 6000) + "</Provision>");
  const auto path = file("jitter.xml", text);
  EXPECT_TRUE(test::run({"check", path}).out.contains("on b could take 7.04 ms of the 7 ms"));
  const Json b = bus_of(analyse(path, {"--json", "--network", "b"}).out);
  EXPECT_EQ(message_of(b, "p")["counted"], false) << b;
  EXPECT_EQ(message_of(b, "p")["verdict"], "late");
  EXPECT_EQ(message_of(b, "p")["response_us"], 7040);
  EXPECT_EQ(message_of(b, "p")["refused_response_us"], 7040);
  EXPECT_EQ(message_of(b, "p")["jitter_us"], 6500);
  EXPECT_EQ(message_of(b, "p")["slack_us"], -40);
  const auto table = analyse(path, {"--network", "b"}).out;
  EXPECT_TRUE(table.contains("6500.000     7040.000     7000.000   -40.000  late")) << table;
  EXPECT_FALSE(table.contains("Check us")) << table;
  EXPECT_TRUE(test::run({"check", "--format", "html", path}).out.contains("<div>7.04 ms</div>"));
}

/// No bus promises an Omission. c1 is late as well beside c2, which was granted after it; on b
/// far would be late, if it came.
TEST_F(AnalyseBusTest, WhatIsRefusedForSomethingElseHasOneVerdictInTableAndPage) {
  auto text = system_with({{"c1", "a", "a", 0x20, 0, 4000, 600},
                           {"c2", "a", "a", 0x10, 0, 4000, 4000},
                           {"low", "a", "a", 0x30, 0, 50000, 50000},
                           {"far", "a", "b", 0x40, 0x40, 20000, 20000}});
  for (const char* name : {"c1", "far"}) {
    const auto at = text.find("<Attributes>", text.find(std::string("<Publisher name=\"") + name));
    text.insert(at + 12, attribute("Omission", "<Value>0</Value>"));
  }
  const auto path = file("else.xml", text);
  const Json out = Json::parse(analyse(path, {"--json"}).out);
  const Json& c1 = message_of(out["networks"][0], "c1");
  EXPECT_EQ(c1["counted"], true) << out;
  EXPECT_EQ(c1["verdict"], "late");
  EXPECT_EQ(c1["response_us"], 810);
  EXPECT_FALSE(c1.contains("refused_response_us"));
  const Json& far = message_of(out["networks"][1], "far");
  EXPECT_EQ(far["counted"], false);
  EXPECT_EQ(far["verdict"], "refused-by-check");
  EXPECT_TRUE(far["response_us"].is_null()) << far;
  EXPECT_TRUE(far["slack_us"].is_null());
  const auto page = test::run({"check", "--format", "html", path}).out;
  EXPECT_TRUE(
      page.contains("late</span></div></td><td role=\"cell\" data-label=\"Response, at "
                    "most\"><div>810 us"))
      << page;
  EXPECT_TRUE(
      page.contains("refused for another reason</span></div></td><td role=\"cell\" "
                    "data-label=\"Response, at most\"><div></div>"))
      << page;
}

}  // namespace
}  // namespace mlcca
