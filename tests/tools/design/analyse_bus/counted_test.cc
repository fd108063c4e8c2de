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
  EXPECT_TRUE(
      text.contains("is dropped before this bus. Its row says how late it would be if it came"))
      << text;
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
  EXPECT_EQ(message_of(a, "both")["granted"], false) << "to everybody";
  EXPECT_EQ(message_of(a, "both")["counted"], true);
  EXPECT_EQ(message_of(a, "both")["deadline_us"], 20000) << a;
  EXPECT_NE(message_of(a, "both")["verdict"], "late");
}

}  // namespace
}  // namespace mlcca
