// SPDX-License-Identifier: BSD-2-Clause
// mlccactl import of the quality of service of DDS: ROS 2 parameters and topics, XML profiles.
#include <fmt/format.h>

#include "tests/tools/design/import/import_test.hpp"

namespace mlcca {
namespace {

struct DdsImportTest : ImportTest {
  [[nodiscard]] std::string component(const std::string& name) const {
    return part(fmt::format("<Component name=\"{}\"", name), "</Component>");
  }
  void expect_no_errors() const {
    for (const auto& finding : checked()["findings"])
      EXPECT_NE(finding["severity"], "error") << finding.dump() << draft_;
  }
};

constexpr const char* kParameters = R"(/robot:
  driver:
    ros__parameters:
      rate: 20
      qos_overrides:
        /robot/odom:
          publisher:
            reliability: best_effort
            history: keep_last
            depth: 5
            deadline: 50000000
            lifespan: 200000000
            liveliness: automatic
            liveliness_lease_duration: 175000000
/planner:
  ros__parameters:
    qos_overrides./robot/odom.subscription.deadline: 100000000
    qos_overrides./robot/odom.subscription.liveliness_lease_duration: 500000000
    qos_overrides:
      /plan:
        publisher_main: {depth: 1, deadline: 9223372036854775807}
)";

TEST_F(DdsImportTest, ParametersOfRos2AreChannelsWithTheirTimes) {
  const auto out = json("robot.yaml", kParameters);
  EXPECT_EQ(out["networks"][0]["messages"], 2);
  EXPECT_TRUE(has("<Kind>other</Kind>") && !has("<Binding")) << draft_;
  EXPECT_TRUE(has("DDS itself is not gated"));
  const auto odom = part("<EventChannel name=\"robot-odom\">", "</EventChannel>");
  EXPECT_NE(odom.find("<Attributes period=\"50ms\"/>"), std::string::npos) << odom;
  const auto driver = component("robot-driver");
  EXPECT_NE(driver.find("deadline=\"200ms\""), std::string::npos) << "lifespan: " << draft_;
  EXPECT_NE(driver.find("omission=\"2\""), std::string::npos) << "floor(175/50) - 1: " << driver;
  const auto planner = component("planner");
  EXPECT_NE(planner.find("<Attributes period=\"100ms\" omission=\"4\"/>"), std::string::npos)
      << planner;
  EXPECT_NE(planner.find("<Publisher channel=\"plan\"/>"), std::string::npos) << planner;
  EXPECT_TRUE(has("<EventChannel name=\"plan\" arrival=\"sporadic\">")) << "it has no deadline";
  expect_no_errors();
}

TEST_F(DdsImportTest, APatternOfTopicsIsListed) {
  const auto out = json("dds.xml",
                        "<dds><qos_library name=\"L\"><qos_profile name=\"P\">"
                        "<datawriter_qos topic_filter=\"a*\"><deadline><period><sec>1</sec>"
                        "</period></deadline></datawriter_qos></qos_profile></qos_library></dds>");
  EXPECT_EQ(lacking(out, "pattern"), 1U);
}

TEST_F(DdsImportTest, PoliciesWithoutACounterpartAreListedWithTheirLines) {
  const auto out = json("robot.yaml", kParameters);
  for (const auto* const kind : {"reliability", "history", "liveliness", "parameters", "deadline",
                                 "no-deadline", "not-gated"})
    EXPECT_EQ(lacking(out, kind), 1U) << kind;
  EXPECT_EQ(lacking(out, "depth"), 2U);
  EXPECT_EQ(lacking(out, "no-size"), 2U);
  const auto said = import("robot.yaml", kParameters).error;
  EXPECT_NE(said.find("robot.yaml:8: robot/driver writes /robot/odom: reliability best_effort\n"),
            std::string::npos)
      << said;
}

TEST_F(DdsImportTest, CheckFindsWhatDdsWouldCallIncompatible) {
  json("robot.yaml",
       "a: {ros__parameters: {qos_overrides: {/x: {publisher: {deadline: 100000000}}}}}\n"
       "b: {ros__parameters: {qos_overrides: {/x: {subscription: {deadline: 50000000}}}}}\n");
  EXPECT_EQ(checked()["findings"][0]["id"], "MLCCA020") << checked().dump();
}

TEST_F(DdsImportTest, NodesWithoutANameAreListed) {
  auto out = json("robot.yaml", "qos_overrides: {/x: {publisher: {depth: 1}}}\n");
  EXPECT_EQ(lacking(out, "no-node"), 1U);
  EXPECT_FALSE(component("robot").empty()) << draft_;
  out = json("robot.yaml",
             "/**: {ros__parameters: {qos_overrides: {/x: {publisher: {depth: 1}}}}}\n");
  EXPECT_EQ(lacking(out, "any-node"), 1U);
}

struct DurationRow {
  const char* name;
  const char* deadline;
  const char* lease;
  const char* omission;  ///< empty: none
  const char* kind;      ///< what is listed; empty: nothing
};
struct DdsOmissionTest : DdsImportTest, ::testing::WithParamInterface<DurationRow> {};

TEST_P(DdsOmissionTest, FollowsFromLeaseAndDeadline) {
  const auto out = json("a.yaml", fmt::format("n: {{ros__parameters: {{qos_overrides: {{/x: "
                                              "{{subscription: {{deadline: {}, "
                                              "liveliness_lease_duration: {}}}}}}}}}}}\n",
                                              GetParam().deadline, GetParam().lease));
  const auto node = component("n");
  if (*GetParam().omission == '\0')
    EXPECT_EQ(node.find("omission"), std::string::npos) << node;
  else
    EXPECT_NE(node.find(fmt::format("omission=\"{}\"", GetParam().omission)), std::string::npos)
        << node;
  if (*GetParam().kind != '\0') {
    EXPECT_EQ(lacking(out, GetParam().kind), 1U);
  }
}

INSTANTIATE_TEST_SUITE_P(Leases, DdsOmissionTest,
                         ::testing::Values(DurationRow{"Shorter", "100", "99", "0", "short-lease"},
                                           DurationRow{"Equal", "100", "100", "0", ""},
                                           DurationRow{"JustBelowTwo", "100", "199", "0", ""},
                                           DurationRow{"Two", "100", "200", "1", ""},
                                           DurationRow{"Zero", "100", "0", "", ""},
                                           DurationRow{"Infinite", "100", "2147483647000000000", "",
                                                       ""},
                                           DurationRow{"JustFinite", "2147483646999999999",
                                                       "2147483646999999999", "0", ""},
                                           DurationRow{"NoDeadline", "0", "100", "", "lease"}),
                         [](const auto& row) { return row.param.name; });

constexpr const char* kTopics = R"($ ros2 topic info --verbose /chatter
Type: std_msgs/msg/String

Publisher count: 1

Node name: talker
Node namespace: /
Topic type: std_msgs/msg/String
Topic type hash: RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18
Endpoint type: PUBLISHER
GID: 01.0f.ba.ec.43.55.39.96.00.00.00.00.00.00.14.03
QoS profile:
  Reliability: RELIABLE
  History (Depth): KEEP_LAST (7)
  Durability: VOLATILE
  Lifespan: Infinite
  Deadline: 100000000 nanoseconds
  Liveliness: AUTOMATIC
  Liveliness lease duration: Infinite

Subscription count: 1

Node name: listener
Node namespace: /far
Topic type: std_msgs/msg/String
Endpoint type: SUBSCRIPTION
GID: 01.0f.ba.ec.43.55.39.96.00.00.00.00.00.00.14.04
QoS profile:
  Reliability: BEST_EFFORT
  History (Depth): UNKNOWN
  Durability: VOLATILE
  Lifespan: Infinite
  Deadline: Infinite
  Liveliness: AUTOMATIC
  Liveliness lease duration: 400000000 nanoseconds

/other
Type: std_msgs/msg/Bool

Publisher count: 0

Subscription count: 1

Node name: listener
Node namespace: /far
Topic type: std_msgs/msg/Bool
Endpoint type: SUBSCRIPTION
)";

TEST_F(DdsImportTest, TopicsOfRos2AreReadFromWhatIsPrinted) {
  const auto out = json("topics.txt", kTopics);
  EXPECT_EQ(out["networks"][0]["messages"], 2);
  EXPECT_EQ(out["networks"][0]["nodes"], 3) << "and who sends /other";
  const auto chatter = part("<EventChannel name=\"chatter\">", "</EventChannel>");
  EXPECT_NE(chatter.find("period=\"100ms\""), std::string::npos) << draft_;
  EXPECT_NE(chatter.find("std_msgs/msg/String</Description>"), std::string::npos) << chatter;
  EXPECT_NE(component("talker").find("<Publisher channel=\"chatter\"/>"), std::string::npos);
  const auto listener = component("far-listener");
  EXPECT_NE(listener.find("<Attributes omission=\"3\"/>"), std::string::npos)
      << "of the Period of the publisher: " << listener;
  EXPECT_NE(listener.find("<Subscriber channel=\"other\"/>"), std::string::npos) << listener;
  EXPECT_EQ(lacking(out, "reliability"), 2U);
  EXPECT_EQ(lacking(out, "no-sender"), 1U);
  EXPECT_EQ(lacking(out, "lines"), 0U);
  expect_no_errors();
}

TEST_F(DdsImportTest, ATopicWithoutAnEndIsListed) {
  const std::string empty = "Type: a\nPublisher count: 0\nSubscription count: 0\n";
  const auto text = "/first\n" + empty + "/named\n" + kTopics + "/last\n" + empty;
  EXPECT_EQ(lacking(json("topics.txt", text), "no-ends"), 3U);
  const auto said = import("topics.txt", text).error;
  EXPECT_NE(said.find("topics.txt:1: /first\n"), std::string::npos) << said;
  EXPECT_NE(said.find("topics.txt:5: /named\n"), std::string::npos) << said;
  EXPECT_NE(said.find(": /last\n"), std::string::npos) << said;
}

TEST_F(DdsImportTest, ATopicIsCalledLikeItsFileIfNothingElseNamesIt) {
  std::string text = kTopics;
  text.erase(0, text.find('\n') + 1);
  text.resize(text.find("/other"));
  const auto out = json("scan.txt", text);
  EXPECT_EQ(lacking(out, "no-topic"), 1U);
  EXPECT_TRUE(has("<EventChannel name=\"scan\">")) << draft_;
  const auto done = import("scan.txt", text + text);
  EXPECT_NE(done.error.find("which topic is this?"), std::string::npos) << done.error;
}

constexpr const char* kProfiles = R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com">
  <profiles>
    <participant profile_name="p"><domainId>3</domainId></participant>
    <data_writer profile_name="/odom">
      <topic><historyQos><kind>KEEP_LAST</kind></historyQos></topic>
      <qos>
        <reliability><kind>RELIABLE</kind></reliability>
        <deadline><period><sec>0</sec><nanosec>20000000</nanosec></period></deadline>
        <lifespan><duration><sec>1</sec></duration></lifespan>
      </qos>
    </data_writer>
    <data_reader profile_name="/odom">
      <qos>
        <deadline><period><sec>DURATION_INFINITY</sec></period></deadline>
        <liveliness>
          <kind>AUTOMATIC</kind>
          <lease_duration><nanosec>100000000</nanosec></lease_duration>
        </liveliness>
      </qos>
    </data_reader>
  </profiles>
</dds>
)";

TEST_F(DdsImportTest, ProfilesOfFastDdsAreEndsOfTheTopicThatTheyAreCalledLike) {
  const auto out = json("fast.xml", kProfiles);
  EXPECT_EQ(out["networks"][0]["messages"], 1);
  EXPECT_NE(part("<EventChannel name=\"odom\">", "</EventChannel>").find("period=\"20ms\""),
            std::string::npos)
      << draft_;
  EXPECT_NE(component("writer-odom").find("deadline=\"1s\""), std::string::npos) << draft_;
  EXPECT_NE(component("reader-odom").find("<Attributes omission=\"4\"/>"), std::string::npos)
      << draft_;
  EXPECT_EQ(lacking(out, "settings"), 1U);
  EXPECT_EQ(lacking(out, "history"), 1U);
  EXPECT_EQ(lacking(out, "reliability"), 1U);
  EXPECT_NE(import("fast.xml", kProfiles)
                .error.find("fast.xml:8: writer-/odom writes /odom: "
                            "reliability/kind RELIABLE\n"),
            std::string::npos)
      << import("fast.xml", kProfiles).error;
  expect_no_errors();
}

TEST_F(DdsImportTest, ProfilesOfDdsXmlAreWriterAndReaderOfOneChannel) {
  const auto out = json("omg.xml",
                        "<qos_library name=\"Lib\"><qos_profile name=\"State\" base_name=\"Other\">"
                        "<datareader_qos><deadline><period><sec>1</sec><nanosec>0</nanosec>"
                        "</period></deadline></datareader_qos>"
                        "<datawriter_qos><deadline><period><sec>0</sec>"
                        "<nanosec>500000000</nanosec></period></deadline></datawriter_qos>"
                        "</qos_profile></qos_library>");
  EXPECT_EQ(out["networks"][0]["messages"], 1);
  EXPECT_TRUE(has("<EventChannel name=\"Lib-State\">")) << draft_;
  EXPECT_NE(component("reader-Lib-State").find("period=\"1s\""), std::string::npos) << draft_;
  EXPECT_EQ(lacking(out, "base"), 1U);
  expect_no_errors();
}

TEST_F(DdsImportTest, ParametersTopicsAndProfilesMayBeOneNetwork) {
  const auto topics = folder_.write("topics.txt", kTopics);
  const auto more =
      folder_.write("more.yaml",
                    "/far/listener: {ros__parameters: {qos_overrides: {/chatter: {subscription: "
                    "{deadline: 200000000}}}}}\n");
  const auto out = json("fast.xml", kProfiles,
                        {topics, more, "--network", "lan", "--network", "lan", "--network", "lan",
                         "--gateway", "gate", "--interface", "eth0"});
  EXPECT_EQ(out["networks"].size(), 1U);
  EXPECT_EQ(out["networks"][0]["messages"], 3);
  EXPECT_NE(component("far-listener").find("<Attributes period=\"200ms\" omission=\"3\"/>"),
            std::string::npos)
      << draft_;
  EXPECT_TRUE(has("<Port network=\"lan\"><Interface name=\"eth0\"/></Port>"));
  expect_no_errors();
}

TEST_F(DdsImportTest, ImportingAgainGivesTheSameSubjects) {
  json("robot.yaml", kParameters);
  const auto before = draft_;
  json("robot.yaml", kParameters);
  EXPECT_EQ(draft_, before);
  const auto subject = part("<SubjectUID>", "</SubjectUID>");
  json("other.yaml", kParameters);
  EXPECT_NE(part("<SubjectUID>", "</SubjectUID>"), subject) << "another network";
}

struct DdsWrongRow {
  const char* name;
  const char* format;
  const char* text;
  const char* error;  ///< part of it
};
struct DdsWrongTest : DdsImportTest, ::testing::WithParamInterface<DdsWrongRow> {};

TEST_P(DdsWrongTest, IsRefusedWithItsLineAndWhatWouldBeRight) {
  const auto done = import("w.file", GetParam().text, {"--format", GetParam().format});
  EXPECT_EQ(done.status, 2) << done.out;
  EXPECT_NE(done.error.find(GetParam().error), std::string::npos) << done.error;
}

INSTANTIATE_TEST_SUITE_P(
    Files, DdsWrongTest,
    ::testing::Values(
        DdsWrongRow{"NoParameters", "ros2-params", "a: {ros__parameters: {x: 1}}\n",
                    "w.file: there is no quality of service in it"},
        DdsWrongRow{"NoNode", "ros2-params", "a: 1\n", "w.file:1: must be a node with"},
        DdsWrongRow{"NoEntity", "ros2-params", "\nqos_overrides: {/x: {depth: 1}}\n",
                    "w.file:2: \"qos_overrides./x.depth\": must be"},
        DdsWrongRow{"NoTime", "ros2-params", "qos_overrides: {/x: {publisher: {deadline: soon}}}\n",
                    "w.file:1: deadline: must be a number of nanoseconds"},
        DdsWrongRow{"NegativeTime", "ros2-params",
                    "qos_overrides: {/x: {publisher: {lifespan: -1}}}\n",
                    "w.file:1: lifespan: must be a number of nanoseconds"},
        DdsWrongRow{"NoTopics", "ros2-topics", "Type: a\n", "w.file: there is no publisher"},
        DdsWrongRow{"NoKind", "ros2-topics", "Node name: a\n", "has no Endpoint type"},
        DdsWrongRow{"WrongKind", "ros2-topics", "Node name: a\nEndpoint type: INVALID\n",
                    "w.file:2: an endpoint is PUBLISHER or SUBSCRIPTION"},
        DdsWrongRow{"NoNumber", "ros2-topics",
                    "Node name: a\nEndpoint type: PUBLISHER\nDeadline: 1 hour\n",
                    "w.file:3: Deadline: must be Infinite or a number"},
        DdsWrongRow{"NoXml", "dds-xml", "hello", "w.file:1: this is not XML"},
        DdsWrongRow{"Empty", "dds-xml", "", "w.file:1: the file is empty"},
        DdsWrongRow{"NoProfile", "dds-xml", "<dds/>", "w.file: there is no profile"},
        DdsWrongRow{"OpenTag", "dds-xml", "<dds>\n<data_writer>", "w.file:2: not well-formed XML"},
        DdsWrongRow{"Doctype", "dds-xml",
                    "<!DOCTYPE d [<!ENTITY a \"b\">]>\n<data_writer name=\"a\">&a;</data_writer>",
                    "w.file:1: a DOCTYPE is refused"},
        DdsWrongRow{"Duration", "dds-xml",
                    "<data_writer name=\"a\">\n<deadline><period><sec>1.5</sec></period></deadline>"
                    "</data_writer>",
                    "w.file:2: \"1.5\": must be sec or nanosec with a number"}),
    [](const auto& row) { return row.param.name; });

TEST_F(DdsImportTest, DepthOfElementsIsLimited) {
  const auto nested = [](std::size_t depth) {
    std::string text = "<data_writer name=\"a\">";
    for (std::size_t i = 1; i < depth; ++i) text += "<a>";
    for (std::size_t i = 1; i < depth; ++i) text += "</a>";
    return text + "</data_writer>";
  };
  EXPECT_EQ(import("a.xml", nested(64)).status, 0);
  EXPECT_NE(import("a.xml", nested(65)).error.find("a.xml:1: is nested deeper than 64 elements"),
            std::string::npos);
}

TEST_F(DdsImportTest, TheNumberOfElementsIsLimited) {
  const auto elements = [](std::size_t count) {
    std::string text = "<data_writer name=\"a\">";
    for (std::size_t i = 1; i < count; ++i) text += "<a/>";
    return text + "</data_writer>";
  };
  EXPECT_EQ(import("a.xml", elements(262'144)).status, 0);
  EXPECT_NE(import("a.xml", elements(262'145)).error.find("there are more than 262144 elements"),
            std::string::npos);
}

TEST_F(DdsImportTest, TheNumberOfNodesIsLimited) {
  std::string text = "/x\nType: t\n";
  for (int i = 0; i < 4096; ++i)
    text += fmt::format("Node name: n{}\nEndpoint type: SUBSCRIPTION\n", i);
  EXPECT_EQ(import("a.txt", text).status, 0);
  text += "Node name: m\nEndpoint type: SUBSCRIPTION\n";
  EXPECT_NE(import("a.txt", text).error.find("a.txt:8196: there are more than 4096 nodes"),
            std::string::npos);
}

TEST_F(DdsImportTest, TheLengthOfALineIsLimited) {
  const std::string front = "/x\nType: t\nNode name: ";
  const std::string back = "\nEndpoint type: PUBLISHER\n";
  const std::string key = "Node name: ";
  EXPECT_EQ(import("a.txt", front + std::string(4096 - key.size(), 'a') + back).status, 0);
  EXPECT_NE(import("a.txt", front + std::string(4097 - key.size(), 'a') + back)
                .error.find("a.txt:3: a line has at most 4096 bytes"),
            std::string::npos);
}

}  // namespace
}  // namespace mlcca
