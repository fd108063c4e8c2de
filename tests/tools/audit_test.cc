// SPDX-License-Identifier: BSD-2-Clause
#include "tools/audit.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/model/text.hpp"
#include "tests/control/messages.hpp"
#include "tools/elements.hpp"
#include "tools/json.hpp"
#include "tools/options.hpp"
#include "tools/render.hpp"
#include "tools/requests.hpp"

namespace mlcca::tools {
namespace {

std::size_t times(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++found;
  return found;
}

/// Reports in the time zone UTC, so that times are the same everywhere.
class AuditReport : public ::testing::Test {
 protected:
  void SetUp() override {
    ::setenv("TZ", "UTC", 1);
    ::tzset();
  }
  /// The additions for one finding only.
  [[nodiscard]] std::string addition_for(const control::Finding& finding) const {
    control::Audit alone = audit_;
    alone.findings = {finding};
    return additions(alone);
  }

  control::Audit audit_ = test::full_audit();
};

/// The time begins again with a reload, a start and a change of mode, too.
TEST_F(AuditReport, SaysInWordsThatTheTimeWithoutDropsHasJustBegun) {
  audit_.clean_ns = 400'000'000;
  EXPECT_TRUE(render(audit_, Color::no)
                  .contains("\nfor less than a second nothing would have been dropped: the time "
                            "begins again with each "
                            "such frame, reload, start and change of the mode; the gates"))
      << render(audit_, Color::no);
}

TEST_F(AuditReport, ListsWhatWasRefusedAndWhatADescriptionWouldNeed) {
  const std::string expected = R"(AUDIT MODE: nothing is dropped; counted since 2023-11-14 22:13:20
for 3 h nothing would have been dropped; the gates enforce after 1 d without

INTERFACE  DIRECTION  FRAME OR DELIVERY           SENDER                         WOULD DROP  DROPPED  FIRST                LAST                 REASON
can0       in         123                                                              4210        7  2023-11-14 22:13:21  2023-11-15 22:13:20  unknown subject
can1       in         0cf00417                    node 23                                 1           2023-11-14 22:13:22  2023-11-14 22:13:22  unknown subject
eth0       in         0x4e6f626f64790000          192.0.2.7 (02:00:5e:10:00:01)           3           2023-11-14 22:13:23  2023-11-14 22:13:24  unknown subject
can1       out        emergency-switch of switch                                         12           2023-11-14 22:13:25  2023-11-14 22:13:26  refused: Omission 2 required, field provides 5 (3 too many)
can0       out        321                         user 1000                                        2  2023-11-14 22:13:27  2023-11-14 22:13:28  malformed: at most 14 bytes with headers
31 further ones had fewer frames: they are in others
malformed: no addition admits these frames, because they have not the form that their network prescribes, for example are too short; tcpdump or candump shows their content

Of deliveries that the description has:
- 'mlccactl explain emergency-switch' says what would have to change

To admit what is wanted of it, add to the description:

<!-- 123 on can0: 4217 frames since 2023-11-14 22:13:21, in the busiest second one every 20ms: the Period is that. When within a second they came was not measured, so the Jitter lets them come at once, and with arrival="sporadic" silence is no fault: mlccactl learn, with its option merge, measures it. -->
<EventChannel name="robot-can-123" arrival="sporadic">
  <SubjectUID>{}</SubjectUID>
  <Attributes period="20ms" maxPayload="8"/>
</EventChannel>
<!-- in Network robot-can: -->
<Binding channel="robot-can-123" format="fd"><Identifier form="standard">0x123</Identifier></Binding>
<Publisher name="robot-can-123" channel="robot-can-123" network="robot-can">
  <Attributes jitter="1.951s"/>
</Publisher>
<Subscriber name="robot-can-123-receiver" channel="robot-can-123" gateway="bridge"/>

<!-- 0cf00417 on can1: 1 frame since 2023-11-14 22:13:22; the Period is assumed. When within a second they came was not measured, and with arrival="sporadic" silence is no fault: mlccactl learn, with its option merge, measures it. -->
<EventChannel name="truck-pgn-F004" arrival="sporadic">
  <SubjectUID>{}</SubjectUID>
  <Attributes period="100ms" maxPayload="8"/>
</EventChannel>
<!-- in Network truck: -->
<Binding channel="truck-pgn-F004"><PGN priority="3">0xf004</PGN></Binding>
<Publisher name="truck-pgn-F004" channel="truck-pgn-F004" network="truck" node="23"/>
<Subscriber name="truck-pgn-F004-receiver" channel="truck-pgn-F004" gateway="bridge"/>

<!-- 0x4e6f626f64790000 on eth0: 3 frames since 2023-11-14 22:13:23, in the busiest second one every 500ms: the Period is that. When within a second they came was not measured, so the Jitter lets them come at once, and with arrival="sporadic" silence is no fault: mlccactl learn, with its option merge, measures it. -->
<EventChannel name="lan-Nobody" arrival="sporadic">
  <SubjectUID>0x4e6f626f64790000</SubjectUID>
  <Attributes period="500ms" maxPayload="40"/>
</EventChannel>
<Publisher name="lan-Nobody" channel="lan-Nobody" network="lan" address="192.0.2.7">
  <Attributes jitter="500ms"/>
</Publisher>
<Subscriber name="lan-Nobody-receiver" channel="lan-Nobody" gateway="bridge"/>
)";
  EXPECT_EQ(render(audit_, Color::no),
            fmt::format(fmt::runtime(expected), core::format_subject(subject_of("robot-can-123")),
                        core::format_subject(subject_of("truck-pgn-F004"))));
}

TEST_F(AuditReport, FramesThatNoDescriptionCanAdmitNameWhatWasReadOfThemAndProposeNothing) {
  control::Finding f = audit_.findings[4];
  EXPECT_EQ(addition_for(f), "");
  EXPECT_EQ(name_of(f), "321");
  f.described = "distance";
  audit_.findings = {f};
  EXPECT_TRUE(render(audit_, Color::no)
                  .contains("malformed: at most 14 bytes with headers, it names distance\n"));
  EXPECT_FALSE(render(audit_, Color::no).contains("lacks"));
  f.can_id = 0;
  EXPECT_EQ(name_of(f), "") << "no identifier could be read";
  f.address = "192.0.2.7";
  EXPECT_EQ(name_of(f), "") << "no subject could be read";
  EXPECT_EQ(sender_of(f), "192.0.2.7 by user 1000");
  f.subject = 0x4e6f626f64790000;
  EXPECT_EQ(name_of(f), "0x4e6f626f64790000");
  EXPECT_EQ(addition_for(f), "");
}

TEST_F(AuditReport, APartOfNoAdmittedMessageNamesItsNode) {
  control::Finding f = audit_.findings[1];
  f.reason = "part of no admitted message";
  f.can_id = 0x98ebff17;
  EXPECT_EQ(name_of(f), "18ebff17");
  EXPECT_EQ(sender_of(f), "node 23");
  EXPECT_EQ(addition_for(f), "");
  audit_.findings = {f};
  EXPECT_TRUE(render(audit_, Color::no).contains("\npart of no admitted message: no addition"));
}

TEST_F(AuditReport, WhatThisComputerSendsIsOfAProgramHere) {
  audit_.findings[0].egress = true;
  const std::string text = addition_for(audit_.findings[0]);
  EXPECT_TRUE(text.contains("gateway=\"bridge\" user=\"root\">")) << text;
  EXPECT_TRUE(text.contains("-receiver\" channel=\"robot-can-123\" network=\"robot-can\"/>"))
      << text;
}

TEST_F(AuditReport, WhatNoChannelCanHaveHasNothingToAdd) {
  control::Finding f = audit_.findings[1];
  f.can_id = 0x123;
  EXPECT_EQ(addition_for(f), "") << "11 bits on a J1939 network";
  f.can_id = 0x98eeff17;
  EXPECT_EQ(addition_for(f), "") << "an address claim";
  f.profile = "of-a-later-version";
  EXPECT_EQ(addition_for(f), "");
  EXPECT_EQ(addition_for(audit_.findings[3]), "");
  EXPECT_EQ(addition_for(audit_.findings[4]), "");
}

/// A subject names one channel of the complete system.
TEST_F(AuditReport, ASubjectOnTwoNetworksIsOneChannelWithAPublisherForEach) {
  control::Finding f = audit_.findings[2];
  audit_.findings = {f};
  f.interface = "eth1";
  f.network = "field";
  f.address = "198.51.100.4";
  f.length = 60;
  f.busy_gap_ns = 20'000'000;
  audit_.findings.push_back(f);
  f.address = "198.51.100.5";
  audit_.findings.push_back(f);
  const std::string text = additions(audit_);
  EXPECT_EQ(times(text, "<EventChannel "), 1U) << text;
  EXPECT_EQ(times(text, "<Subscriber "), 1U) << text;
  EXPECT_TRUE(text.contains(R"(<Attributes period="20ms" maxPayload="60"/>)")) << text;
  const std::string of = R"( channel="lan-Nobody" network=)";
  EXPECT_TRUE(
      text.contains("<Publisher name=\"lan-Nobody\"" + of + "\"lan\" address=\"192.0.2.7\">"))
      << text;
  EXPECT_TRUE(text.contains("<Publisher name=\"field-Nobody\"" + of +
                            "\"field\" address=\"198.51.100.4\">"))
      << text;
  EXPECT_TRUE(text.contains("<Publisher name=\"field-Nobody-2\"" + of +
                            "\"field\" address=\"198.51.100.5\">"))
      << text;
  const auto json = nlohmann::json::parse(to_json(control::Reply{1, audit_}));
  std::string all;
  for (const auto& one : json["findings"])
    all += (all.empty() ? "" : "\n") + one["add"].get<std::string>();
  EXPECT_EQ(all, text);
}

TEST_F(AuditReport, SubjectsWithOneTextInNamesAreTwoChannels) {
  control::Finding f = audit_.findings[2];
  f.subject = 0x6120620000000000;  // "a b"
  audit_.findings = {f, f};
  audit_.findings[1].subject = 0x615f620000000000;  // "a_b"
  const std::string text = additions(audit_);
  EXPECT_EQ(times(text, "<EventChannel name=\"lan-a_b\" arrival="), 1U) << text;
  EXPECT_EQ(times(text, "<EventChannel name=\"lan-a_b-2\" arrival="), 1U) << text;
  EXPECT_EQ(times(text, " channel=\"lan-a_b-2\" network="), 1U) << text;
}

TEST_F(AuditReport, NodesOfOneMessageShareItsChannelAndItsBinding) {
  audit_.findings = {audit_.findings[1], audit_.findings[1], audit_.findings[1]};
  audit_.findings[1].can_id = 0x8cf00418;
  audit_.findings[2].egress = true;
  const std::string text = additions(audit_);
  EXPECT_EQ(times(text, "<EventChannel "), 1U) << text;
  EXPECT_EQ(times(text, "<Binding "), 1U) << text;
  EXPECT_EQ(times(text, "<Publisher "), 3U) << text;
  EXPECT_EQ(times(text, "<Subscriber "), 2U) << text;
  EXPECT_EQ(times(text, "name=\"truck-pgn-F004-receiver\""), 1U) << text;
}

TEST_F(AuditReport, ADescribedChannelGetsNoSecondOne) {
  control::Finding f = audit_.findings[2];
  f.described = "door";
  std::string text = addition_for(f);
  EXPECT_FALSE(text.contains("<EventChannel ")) << text;
  EXPECT_FALSE(text.contains("<Subscriber ")) << text;
  EXPECT_TRUE(text.contains("The description has its channel door, and lacks this publisher."));
  control::Audit alone = audit_;
  alone.findings = {f};
  EXPECT_TRUE(render(alone, Color::no).contains("unknown subject: door has no such publisher"));
  EXPECT_TRUE(text.contains(R"(<Publisher name="lan-Nobody" channel="door" )"
                            R"(network="lan" address="192.0.2.7"/>)"))
      << text;
  f.egress = true;
  text = addition_for(f);
  EXPECT_FALSE(text.contains("<EventChannel ")) << text;
  EXPECT_TRUE(text.contains(R"(channel="door" network="lan"/>)")) << text;
  f = audit_.findings[0];
  f.described = "door";
  text = addition_for(f);
  EXPECT_FALSE(text.contains("<EventChannel ")) << text;
  EXPECT_FALSE(text.contains("<Binding ")) << text;
  EXPECT_TRUE(text.contains(R"(<Publisher name="robot-can-123" channel="door" )")) << text;
}

TEST_F(AuditReport, NamesStayTextInTheAddition) {
  audit_.gateway = "g\"/><x";
  audit_.findings[0].interface = "a-->b";
  const std::string text = addition_for(audit_.findings[0]);
  EXPECT_FALSE(text.contains("<x")) << text;
  EXPECT_FALSE(text.contains("a-->b")) << text;
}

TEST_F(AuditReport, SaysOfADeliveryWhoSentAndWhatToDo) {
  control::Finding f = audit_.findings[3];
  const auto advised = [&f](const std::string& reason) {
    f.reason = reason;
    return advice(f);
  };
  EXPECT_TRUE(advised("longer than granted").contains("a larger maxPayload")) << f.reason;
  EXPECT_TRUE(advised("cause not known, the latest: longer than granted").contains("maxPayload"));
  EXPECT_TRUE(advised("more than admitted").contains("a shorter period, or a jitter"));
  EXPECT_TRUE(advised("not from the granted source").contains("others send"));
  EXPECT_EQ(advised("refused: withdrawn"),
            "'mlccactl explain emergency-switch' says what would have to change");
  EXPECT_EQ(advised("frame format not granted"), "");
  EXPECT_EQ(advice(audit_.findings[0]), "") << "it has an addition";
  f.reason = "longer than granted";
  f.sender = "node 23";
  audit_.findings = {f};
  EXPECT_TRUE(render(audit_, Color::no).contains("emergency-switch of switch  node 23"))
      << render(audit_, Color::no);
  const auto json = nlohmann::json::parse(to_json(control::Reply{1, audit_}));
  EXPECT_EQ(json["findings"][0]["advice"], advice(f));
  EXPECT_EQ(json["findings"][0]["sender"], "node 23");
}

TEST_F(AuditReport, FramesOfKindsThatAreNotKnownAreARowAndOtherFiguresAreLowerBounds) {
  control::Finding others = audit_.findings[2];
  others.others = true;
  others.subject = 0;
  others.address = others.mac = "";
  others.would_drop = 19'567;
  audit_.findings[2].at_least = true;
  audit_.findings = {others, audit_.findings[2]};
  audit_.left_out = 0;
  const std::string text = render(audit_, Color::no);
  EXPECT_TRUE(text.contains("eth0                  others ")) << text;
  EXPECT_TRUE(text.contains("  19567 ")) << text;
  EXPECT_TRUE(text.contains("  at least 3 ")) << text;
  EXPECT_TRUE(text.contains("others: frames of more kinds than are counted one by one;")) << text;
  EXPECT_TRUE(text.contains("<!-- 0x4e6f626f64790000 on eth0: at least 3 frames since ")) << text;
  const std::string xml = additions(audit_);
  EXPECT_TRUE(
      xml.ends_with("<!-- 19567 frames on eth0 (unknown subject) since 2023-11-14 22:13:23 "
                    "of further kinds: what they need is not known. -->\n"))
      << xml;
  const auto json = nlohmann::json::parse(to_json(control::Reply{1, audit_}));
  EXPECT_EQ(json["findings"][0]["others"], true);
  EXPECT_TRUE(json["findings"][0]["identifier"].is_null());
  EXPECT_TRUE(json["findings"][0]["add"].is_null());
  EXPECT_EQ(json["findings"][1]["at_least"], true);
}

/// A frame of a described channel that another node, station or program has sent.
class AuditReportOfSenders : public AuditReport {
 protected:
  control::Finding node() {
    control::Finding f = audit_.findings[1];
    f.reason = "priority, node, fragment or remote flag not granted";
    f.described = "speed";
    return f;
  }
  control::Finding station() {
    control::Finding f = audit_.findings[2];
    f.reason = "not from the granted source";
    f.described = "door";
    return f;
  }
  std::string table_of(const control::Finding& f) {
    audit_.findings = {f};
    return render(audit_, Color::no);
  }
};

TEST_F(AuditReportOfSenders, ANodeThatSendsForAnotherIsAPublisherToAdd) {
  EXPECT_EQ(
      addition_for(node()),
      "<!-- 0cf00417 on can1: 1 frame since 2023-11-14 22:13:22. The description has its "
      "channel speed, and lacks this publisher. This is a fault or an attack, unless you know node "
      "23: whoever sends can forge identifiers and addresses. -->\n"
      "<Publisher name=\"truck-pgn-F004\" channel=\"speed\" network=\"truck\" node=\"23\"/>\n");
  const std::string table = table_of(node());
  EXPECT_TRUE(table.contains("0cf00417           node 23 ")) << table;
  EXPECT_TRUE(table.contains("not granted: speed has no such publisher\n")) << table;
}

TEST_F(AuditReportOfSenders, AStationThatSendsForAnotherIsAPublisherToAdd) {
  EXPECT_TRUE(addition_for(station()).ends_with(
      "-->\n<Publisher name=\"lan-Nobody\" channel=\"door\" network=\"lan\" "
      "address=\"192.0.2.7\"/>\n"))
      << addition_for(station());
  const std::string table = table_of(station());
  EXPECT_TRUE(table.contains("  192.0.2.7 (02:00:5e:10:00:01)  ")) << table;
  EXPECT_TRUE(table.contains("not from the granted source: door has no such publisher\n")) << table;
}

TEST_F(AuditReportOfSenders, AProgramOfAnotherUserIsAPublisherOfThisGateway) {
  control::Finding f = station();
  f.egress = true;
  f.user = "1007";
  EXPECT_TRUE(addition_for(f).ends_with(
      "-->\n<Publisher name=\"lan-Nobody\" channel=\"door\" gateway=\"bridge\" "
      "user=\"1007\"/>\n"))
      << addition_for(f);
  EXPECT_EQ(sender_of(f), "192.0.2.7 (02:00:5e:10:00:01) by user 1007");
  EXPECT_TRUE(table_of(f).contains("door has no such publisher\n")) << table_of(f);
}

TEST_F(AuditReportOfSenders, WhatCameFromAnotherNetworkIsAPublisherThere) {
  control::Finding f = node();
  f.egress = true;
  f.entered_by = "can0";
  f.entered_network = "robot-can";
  EXPECT_TRUE(addition_for(f).ends_with(
      "<Publisher name=\"truck-pgn-F004\" channel=\"speed\" network=\"robot-can\" node=\"23\"/>\n"))
      << addition_for(f);
  EXPECT_EQ(sender_of(f), "node 23 by can0");
  f.entered_by = "interface 7";
  f.entered_network = "";
  EXPECT_EQ(addition_for(f), "") << "no Publisher can be on a network that is not described";
  f.entered_by = "kernel";
  EXPECT_EQ(addition_for(f), "");
}

TEST_F(AuditReportOfSenders, ADescribedPublisherThatDiffersHasAdviceAndNothingToAdd) {
  control::Finding f = node();
  f.publisher = "engine";
  f.differs = {"priority"};
  EXPECT_EQ(addition_for(f), "");
  EXPECT_EQ(advice(f),
            "if such frames of speed are wanted, state priority=\"3\" at the PGN of its Binding");
  EXPECT_TRUE(table_of(f).contains("not granted: it differs from speed of engine\n"))
      << table_of(f);
  f.profile = "famouso";
  f.can_id = 0x9f484070;
  EXPECT_EQ(advice(f),
            "if such frames of speed are wanted, state priority=\"125\" at its Publisher engine");
  f.profile = "raw";
  f.can_id = 0x40000123;
  f.differs = {"remote"};
  EXPECT_EQ(advice(f),
            "if such frames of speed are wanted, state remote-frames=\"true\" at its Binding");
  f.can_id = 0x123;
  f.differs = {};
  EXPECT_EQ(advice(f), "");
}

TEST_F(AuditReportOfSenders, TheAdviceNamesOnlyWhatDiffers) {
  control::Finding f = node();
  f.publisher = "engine";
  f.profile = "famouso";
  f.can_id = 0x9f684070;  // a fragment with priority 125
  f.differs = {"fragment"};
  EXPECT_EQ(advice(f),
            "if such frames of speed are wanted, state a maxPayload that takes several frames");
  f.differs = {"priority", "fragment"};
  EXPECT_EQ(advice(f),
            "if such frames of speed are wanted, state priority=\"125\" at its Publisher engine, "
            "and a maxPayload that takes several frames");
}

TEST_F(AuditReportOfSenders, FramesOfFurtherSendersAreARowOfTheirDelivery) {
  control::Finding others = audit_.findings[3];
  others.reason = "not from the granted source";
  others.others = true;
  others.user = others.entered_by = others.entered_network = "";
  control::Finding one = station();
  one.at_least = true;
  audit_.findings = {others, one};
  const std::string text = render(audit_, Color::no);
  EXPECT_TRUE(text.contains("can1       out        emergency-switch of switch  others ")) << text;
  EXPECT_TRUE(text.contains("others as the sender: more senders of a delivery than are ")) << text;
  EXPECT_FALSE(text.contains("others: frames of more kinds")) << text;
  EXPECT_TRUE(text.contains("at least 3 ")) << text;
  EXPECT_TRUE(additions(audit_).contains(
      "<!-- 12 frames on can1 (not from the granted source) since 2023-11-14 22:13:25 of further "
      "senders of emergency-switch: what they need is not known. -->\n"))
      << additions(audit_);
}

TEST_F(AuditReportOfSenders, AnAdditionWarnsOfWhoSendsInPlaceOfAnother) {
  EXPECT_TRUE(addition_for(station()).contains("unless you know 192.0.2.7 (02:00:5e:10:00:01):"));
  control::Finding unknown = audit_.findings[2];
  unknown.described = "door";
  EXPECT_FALSE(addition_for(unknown).contains("attack")) << addition_for(unknown);
}

TEST_F(AuditReportOfSenders, AreInJson) {
  audit_.findings = {node(), station()};
  const auto json = nlohmann::json::parse(to_json(control::Reply{1, audit_}));
  EXPECT_EQ(json["findings"][0]["identifier"], "0cf00417");
  EXPECT_EQ(json["findings"][0]["sender"], "node 23");
  EXPECT_EQ(json["findings"][0]["described"], "speed");
  EXPECT_EQ(json["findings"][1]["sender"], "192.0.2.7 (02:00:5e:10:00:01)");
  for (const auto& one : json["findings"])
    EXPECT_TRUE(one["add"].get<std::string>().contains("<Publisher ")) << one;
}

TEST_F(AuditReport, OnlyTheFirstAdditionsFollowTheTable) {
  audit_.findings.resize(1);
  for (std::uint32_t i = 1; i < 10; ++i) {
    audit_.findings.push_back(audit_.findings[0]);
    audit_.findings.back().can_id += i;
  }
  const std::string text = render(audit_, Color::no);
  EXPECT_TRUE(text.contains("\n2 more: 'mlccactl audit report --xml' prints them all\n")) << text;
}

TEST_F(AuditReport, SaysThatNothingWasRefused) {
  EXPECT_EQ(render(control::Audit{.mode = "enforce", .since_unix_s = 1'700'000'000}, Color::no),
            "enforcing; counted since 2023-11-14 22:13:20\n\n"
            "nothing was refused when the gates were last read, about a second ago\n");
}

TEST_F(AuditReport, IsJsonWithTheAddition) {
  const auto json = nlohmann::json::parse(to_json(control::Reply{1, audit_}));
  EXPECT_EQ(json["findings"][0]["identifier"], "123");
  EXPECT_EQ(json["findings"][0]["add"], addition_for(audit_.findings[0]));
  EXPECT_TRUE(json["findings"][2]["identifier"].is_null());
  EXPECT_EQ(json["findings"][2]["subject"], "0x4e6f626f64790000");
  EXPECT_TRUE(json["findings"][3]["add"].is_null());
  EXPECT_EQ(json["when_clean_ns"], 86'400'000'000'000);
}

TEST_F(AuditReport, TheStatusSaysThatAuditModeOutlastsRestarts) {
  control::Status status = test::full_status();
  status.mode = "audit";
  status.audit_until_enforced = true;
  EXPECT_TRUE(render(status, Color::no)
                  .contains("mode         audit, over restarts until 'mlccactl mode enforce'\n"))
      << render(status, Color::no);
}

TEST_F(AuditReport, TheStatusSaysWhenTheGatesEnforce) {
  control::Status status = test::full_status();
  status.mode = "audit";
  status.when_clean_ns = 86'400'000'000'000;
  status.clean_ns = 60'500'000'000;
  EXPECT_TRUE(render(status, Color::no)
                  .contains("mode         audit; enforces when nothing would have been dropped for "
                            "1 d: it has been 1 min\n"))
      << render(status, Color::no);
}

TEST_F(AuditReport, TheTimeToEnforceIsASpan) {
  Arguments arguments;
  arguments.mode = "enforce";
  EXPECT_EQ(mode(arguments)->when_clean_ns, 0U);
  arguments.when_clean = "24h";
  EXPECT_EQ(mode(arguments)->when_clean_ns, 86'400'000'000'000U);
  for (const char* wrong : {"24", "soon", "0s"}) {
    arguments.when_clean = wrong;
    EXPECT_FALSE(mode(arguments)) << wrong;
  }
}

}  // namespace
}  // namespace mlcca::tools
