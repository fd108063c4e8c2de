// SPDX-License-Identifier: BSD-2-Clause
// Bounds where it is decided at run time what is granted: none of what then is on the bus exceeds
// what analyse-bus and the page of check print.
#include <map>
#include <string>
#include <vector>

#include "tests/tools/design/analyse_bus/described_buses.hpp"

namespace mlcca {
namespace {

struct Frame {
  std::string name;
  std::string from;
  std::string id;
  unsigned bytes;
  std::string deadline;
};

/// Channels to the bus b: over a gateway from a, whose Latency is a best case, over another one
/// from c, and on b itself.
std::string onto_b(const std::vector<Frame>& frames, const std::string& far = "") {
  std::string text;
  std::string ends;
  std::map<std::string, std::string> bindings;
  unsigned subject = 0;
  for (const Frame& f : frames) {
    text += fmt::format(
        "<EventChannel name='{}'><SubjectUID>0x{:x}</SubjectUID><Attributes period='20ms' "
        "maxPayload='{}' deadline='{}'/></EventChannel>\n",
        f.name, ++subject, f.bytes, f.deadline);
    for (const std::string& bus :
         f.from == "b" ? std::vector<std::string>{"b"} : std::vector<std::string>{f.from, "b"})
      bindings[bus] +=
          fmt::format("<Binding channel='{}'><Identifier form='standard'>{}</Identifier></Binding>",
                      f.name, f.id);
    ends += fmt::format(
        "<Publisher name='{0}' channel='{0}' network='{1}'/><Subscriber name='to-{0}' "
        "channel='{0}' network='b'/>\n",
        f.name, f.from);
  }
  for (const std::string bus : {"a", "b", "c"})
    text += fmt::format(
        "<Network name='{}'><Kind>can</Kind><Profile>raw</Profile><Bus bitrate='500000'/>{}"
        "</Network>\n",
        bus, bindings[bus]);
  for (const std::string from : {"a", "c"})
    text += fmt::format(
        "<Gateway name='g{0}'><Provision{1} latency='0.1ms' jitter='0.1ms'/><Port network='{0}'>"
        "<Interface name='can0'/></Port><Port network='b'><Interface name='can1'/></Port>"
        "</Gateway>\n",
        from, from == "a" ? " dynamic='true'" : "");
  return test::system_of(text + far + ends);
}

/// x comes if the best case of its gateway holds, v if not: with both, V would take 940 us. With x
/// low takes 670 us, with v 810.
std::vector<Frame> one_of_two() {
  return {{"V", "b", "0x30", 8, "900us"},
          {"low", "b", "0x40", 8, "20ms"},
          {"x", "a", "0x10", 1, "10ms"},
          {"v", "c", "0x20", 8, "10ms"}};
}

TEST_F(AnalyseBusTest, WhatMayBeGrantedInThePlaceOfOthersCounts) {
  const auto path = file("contested.xml", onto_b(one_of_two()));
  const Json b = bus_of(analyse(path, {"--json", "--network", "b"}).out);
  EXPECT_EQ(message_of(b, "v")["verdict"], "run-time") << b;
  EXPECT_EQ(message_of(b, "v")["outcome"], "run-time");
  EXPECT_EQ(message_of(b, "v")["counted"], true);
  EXPECT_GE(message_of(b, "low")["response_us"].get<double>(), 810) << "if v is granted";
  EXPECT_EQ(message_of(b, "low")["verdict"], "met");
  EXPECT_EQ(message_of(b, "low")["granted"], true);
  EXPECT_EQ(message_of(b, "V")["response_us"], 900) << "x and v are never granted both";
  EXPECT_EQ(message_of(b, "V")["by_admission"], true);
  EXPECT_EQ(message_of(b, "V")["verdict"], "met");
  EXPECT_GT(b["bus_load_at_most"].get<double>(), b["bus_load"].get<double>());
}

TEST_F(AnalyseBusTest, BoundsOfWhatIsContestedAreTheSameInTextAndOnThePage) {
  const auto path = file("contested.xml", onto_b(one_of_two()));
  const auto text = analyse(path, {"--network", "b"}).out;
  EXPECT_TRUE(text.contains("by admission")) << text;
  EXPECT_TRUE(text.contains("also counts what may be granted in the place of others")) << text;
  EXPECT_FALSE(text.contains("is not counted beside them")) << text;
  const auto page = test::run({"check", "--format", "html", path}).out;
  EXPECT_TRUE(page.contains("900 us <span class=\"quiet\">by admission</span>")) << page;
  EXPECT_FALSE(page.contains("is not counted: with it times can be longer"));
}

/// hi comes over a gateway whose Latency is a best case, and whether the bus has room for it is
/// left to the run time: nothing is late, and nothing is refused.
TEST_F(AnalyseBusTest, WhatIsLeftToTheRunTimeIsNoReasonForTheStatus) {
  const auto lan = [](const std::string& name, const std::string& gateway) {
    return fmt::format(
        "<Network name='{0}'><Kind>udp-multicast</Kind><Profile>famouso</Profile><Provision "
        "latency='10us' jitter='0ns' omission='0' period='1ms' maxPayload='100'/></Network>"
        "<Gateway name='g-{0}'><Provision {1} omission='0'/><Port network='{0}'><Interface "
        "name='eth0'/></Port><Port network='bus'><Interface name='can0'/></Port></Gateway>\n",
        name, gateway);
  };
  const auto channel = [](const std::string& name, unsigned subject, const std::string& deadline,
                          const std::string& from) {
    return fmt::format(
        "<EventChannel name='{0}' importance='{1}'><SubjectUID>0x{2}</SubjectUID><Attributes "
        "period='20ms' deadline='{3}' maxPayload='8'/></EventChannel><Publisher name='{0}' "
        "channel='{0}' "
        "network='{4}'/><Subscriber channel='{0}' network='bus'/>\n",
        name, name == "hi" ? 9 : 0, subject, deadline, from);
  };
  std::string bindings;
  for (const auto& [name, id] :
       std::map<std::string, std::string>{{"hi", "0x20"}, {"lo", "0x10"}, {"lo2", "0x11"}})
    bindings += fmt::format(
        "<Binding channel='{}'><Identifier form='standard'>{}</Identifier></Binding>", name, id);
  const auto path = file(
      "left.xml", test::system_of(channel("hi", 1, "600us", "a") + channel("lo", 2, "4ms", "b") +
                                  channel("lo2", 3, "4ms", "b") +
                                  "<Network name='bus'><Kind>can</Kind><Profile>raw</Profile><Bus "
                                  "bitrate='500000'/>" +
                                  bindings + "</Network>\n" +
                                  lan("a", "dynamic='true' latency='10us' jitter='0ns'") +
                                  lan("b", "latency='10us' jitter='300us'")));
  const auto text = analyse(path);
  EXPECT_EQ(text.status, 0) << text.out << text.error;
  EXPECT_TRUE(text.out.contains("every deadline is met")) << text.out;
  const Json b = bus_of(analyse(path, {"--json", "--network", "bus"}).out);
  EXPECT_EQ(b["schedulable"], true) << b;
  EXPECT_EQ(message_of(b, "hi")["outcome"], "run-time");
}

/// own is refused and sent all the same: admission keeps nothing on its bus.
TEST_F(AnalyseBusTest, NothingIsBoundedByAdmissionWhereARefusedNodeSends) {
  auto frames = one_of_two();
  frames.push_back({"own", "b", "0x05", 8, "200us"});
  const auto path = file("own.xml", onto_b(frames));
  const Json b = bus_of(analyse(path, {"--json", "--network", "b"}).out);
  EXPECT_EQ(message_of(b, "own")["granted"], false) << b;
  EXPECT_EQ(message_of(b, "V")["by_admission"], false);
  EXPECT_EQ(message_of(b, "V")["verdict"], "late");
  EXPECT_TRUE(test::run({"check", path}).out.contains("MLCCA044: own is refused"));
}

/// If own is refused at run time, its node sends it and v is granted beside it.
TEST_F(AnalyseBusTest, NorWhereANodeOfTheBusMayBeRefusedAtRunTime) {
  auto frames = one_of_two();
  frames[2] = {"x", "b", "0x10", 1, "10ms"};
  auto text = onto_b(frames);
  const std::string to = "<Subscriber name='to-x' channel='x' network='b'/>";
  text.replace(text.find(to), to.size(), "<Subscriber name='to-x' channel='x' network='a'/>");
  text.insert(text.find("<Network name='b'>") - 11,
              "<Binding channel='x'><Identifier form='standard'>0x10</Identifier></Binding>");
  const auto path = file("own.xml", text);
  const Json b = bus_of(analyse(path, {"--json", "--network", "b"}).out);
  EXPECT_EQ(message_of(b, "x")["outcome"], "run-time") << b;
  EXPECT_EQ(message_of(b, "v")["outcome"], "run-time");
  EXPECT_EQ(message_of(b, "V")["by_admission"], false);
  EXPECT_EQ(message_of(b, "V")["verdict"], "late");
  const auto out = analyse(path, {"--network", "b"}).out;
  EXPECT_TRUE(
      out.contains("beside what may be granted in the place of others: a node of the bus "
                   "that is refused at run time sends all the same.\n"))
      << out;
  const auto checked = test::run({"check", path}).out;
  EXPECT_TRUE(
      checked.contains("MLCCA044: x may be refused, and no gate keeps its frames off b: "
                       "while they are sent, V could take 940 us of the 900 us"))
      << checked;
}

/// If V is granted on a, there is room for x or v, otherwise for both: on b it is in time.
TEST_F(AnalyseBusTest, SaysWhyWhatGoesToSeveralPlacesIsLateThoughGranted) {
  auto frames = one_of_two();
  frames[0].deadline = "5ms";
  auto text = onto_b(frames,
                     "<Subscriber name='V-on-a' channel='V' network='a'><Attributes "
                     "deadline='1900us'/></Subscriber>");
  text.insert(text.find("<Network name='b'>") - 11,
              "<Binding channel='V'><Identifier form='standard'>0x30</Identifier></Binding>");
  const auto path = file("several.xml", text);
  const Json b = bus_of(analyse(path, {"--json", "--network", "b"}).out);
  EXPECT_EQ(message_of(b, "V")["verdict"], "late") << b;
  EXPECT_EQ(message_of(b, "V")["deadline_us"], 900) << b;
  const auto out = analyse(path, {"--network", "b"}).out;
  EXPECT_TRUE(out.contains(
      "mlccactl check grants a message that is late here beside what may be granted in the place "
      "of others: what goes to several places is decided for each of them, and its deadline here "
      "is that of the strictest, which holds only while that place is granted.\n"))
      << out;
  EXPECT_FALSE(out.contains("it counts what it refuses as silent")) << out;
}

/// How late x comes is not known, and it is granted only as long as its deadline can be kept: once
/// in 20 ms it is in front of low, and V waits for one frame of whatever else there is.
TEST_F(AnalyseBusTest, ADelayThatIsNotKnownMakesNoBoundOfOthersTheirDeadline) {
  const auto path = file("delay.xml", onto_b({{"V", "b", "0x10", 8, "900us"},
                                              {"x", "a", "0x30", 1, "10ms"},
                                              {"low", "b", "0x40", 8, "20ms"}}));
  const Json b = bus_of(analyse(path, {"--json", "--network", "b"}).out);
  EXPECT_EQ(message_of(b, "V")["response_us"], 540) << b;
  EXPECT_EQ(message_of(b, "V")["by_admission"], false);
  EXPECT_EQ(message_of(b, "low")["response_us"], 670) << b;
  EXPECT_EQ(message_of(b, "low")["by_admission"], false);
  EXPECT_EQ(message_of(b, "x")["by_admission"], true) << b;
  EXPECT_TRUE(analyse(path, {"--network", "b"})
                  .out.contains("how long ga delays events of x is not known"));
}

/// The same, where x may come up to 19 ms late, and then two of it at once.
TEST_F(AnalyseBusTest, WhatMayComeLateCountsForThoseBehindIt) {
  const auto path = file("delay.xml", onto_b({{"V", "b", "0x10", 8, "900us"},
                                              {"x", "a", "0x30", 1, "20ms"},
                                              {"low", "b", "0x40", 8, "20ms"}}));
  const Json b = bus_of(analyse(path, {"--json", "--network", "b"}).out);
  EXPECT_EQ(message_of(b, "V")["response_us"], 540) << b;
  EXPECT_EQ(message_of(b, "low")["response_us"], 800) << b;
}

/// A second set of x is more frequent: how often x comes is not known.
TEST_F(AnalyseBusTest, OfAChannelWhoseAttributeSetIsOpenTheDeadlineIsTheBoundOfOthers) {
  auto text = onto_b(one_of_two());
  const std::string stated = "<Attributes period='20ms' maxPayload='1' deadline='10ms'/>";
  text.replace(text.find(stated), stated.size(),
               "<Attributes priority='2' period='20ms' maxPayload='1' deadline='10ms'/>"
               "<Attributes priority='1' period='5ms' maxPayload='1' deadline='10ms'/>");
  const auto path = file("open.xml", text);
  const Json b = bus_of(analyse(path, {"--json", "--network", "b"}).out);
  EXPECT_EQ(message_of(b, "low")["response_us"], 20000) << b;
  EXPECT_EQ(message_of(b, "low")["by_admission"], true);
  EXPECT_TRUE(analyse(path).out.contains(
      "which attribute set or which way channel x uses is decided at run time"));
}

}  // namespace
}  // namespace mlcca
