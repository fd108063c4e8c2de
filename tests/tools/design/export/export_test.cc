// SPDX-License-Identifier: BSD-2-Clause
// Tests of `mlccactl export`, with the tools that read its output.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/design/describe/program.hpp"

namespace mlcca {
namespace {

using Json = nlohmann::json;

std::string attributes(const char* period, const char* bytes, const char* more = "") {
  return fmt::format(
      "<Attributes><Attribute><Name>Period</Name><Dimension><SIUnit><Seconds>1</Seconds></SIUnit>"
      "<Magnitude>-3</Magnitude></Dimension><Value>{}</Value></Attribute>"
      "<Attribute><Name>MaxPayload</Name><Dimension><SIUnit><Bytes>1</Bytes></SIUnit></Dimension>"
      "<Value>{}</Value></Attribute>{}</Attributes>",
      period, bytes, more);
}

constexpr const char* kOmission = "<Attribute><Name>Omission</Name><Value>0</Value></Attribute>";

std::string channel(const char* name, const char* subject, const std::string& with) {
  return fmt::format(
      "<EventChannel name=\"{}\"><SubjectUID>{}</SubjectUID><Description>a \"{}\"</Description>"
      "{}</EventChannel>\n",
      name, subject, name, with);
}

/// Two CAN buses and a gateway that loses events: the channels beat and moved cross it, strict does
/// not; wide has FD frames and does not leave its bus.
std::string robot() {
  return "<System name=\"robot\">\n" + channel("beat", "0x11", attributes("50", "8")) +
         channel("strict", "0x12", attributes("50", "8", kOmission)) +
         channel("moved", "0x13", attributes("100", "4")) +
         channel("wide", "0x14", attributes("20", "48")) + R"(
  <Network name="first"><Kind>can</Kind><Profile>raw</Profile>
    <Bus bitrate="500000" data-bitrate="2000000"/>
    <Binding channel="beat"><Identifier form="standard">0x123</Identifier></Binding>
    <Binding channel="strict"><Identifier form="standard">0x124</Identifier></Binding>
    <Binding channel="moved"><Identifier form="extended">0x1234567</Identifier></Binding>
    <Binding channel="wide" format="fd"><Identifier form="standard">0x126</Identifier></Binding>
  </Network>
  <Network name="second"><Kind>can</Kind><Profile>raw</Profile><Bus bitrate="500000"/>
    <Binding channel="beat"><Identifier form="standard">0x123</Identifier></Binding>
    <Binding channel="strict"><Identifier form="standard">0x124</Identifier></Binding>
    <Binding channel="moved"><Identifier form="extended">0x89</Identifier></Binding>
  </Network>
  <Gateway name="gate">
    <Provision>
      <Attribute><Name>Omission</Name><Value>1</Value></Attribute>
      <Attribute><Name>Latency</Name><Dimension><SIUnit><Seconds>1</Seconds></SIUnit><Magnitude>-3</Magnitude></Dimension><Value>1</Value></Attribute>
    </Provision>
    <Port network="first"><Interface name="can0"/></Port>
    <Port network="second"><Interface name="can1"/></Port>
  </Gateway>
  <Component name="switch" network="first">
    <Publisher channel="beat"/><Publisher channel="strict"/><Publisher channel="moved"/>
    <Publisher channel="wide"/>
  </Component>
  <Component name="logger" network="first"><Subscriber channel="wide"/></Component>
  <Component name="motors" network="second">
    <Subscriber channel="beat"/><Subscriber channel="strict"/><Subscriber channel="moved"/>
  </Component>
</System>
)";
}

class ExportTest : public ::testing::Test {
 protected:
  test::Ran run(const std::string& text, std::vector<std::string> options) {
    // The file keeps the text of the latest run.
    options.insert(options.begin(), {"export", folder_.write("robot.xml", text), "--format"});
    return test::run(std::move(options));
  }
  std::string exported(std::vector<std::string> options) {
    const auto done = run(robot(), std::move(options));
    EXPECT_EQ(done.status, 0) << done.error;
    said_ = done.error;
    return done.out;
  }
  static bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  }

  test::Folder folder_;
  std::string said_;  ///< output on standard error
};

TEST_F(ExportTest, ADbcFileHasWhatIsAdmittedOnTheNetwork) {
  const auto dbc = exported({"dbc", "--network", "second"});
  EXPECT_TRUE(has(dbc, "BO_ 291 beat: 8 gate\n SG_ Data0 : 0|64@1+ (1,0) [0|0] \"\" motors\n"))
      << dbc;
  EXPECT_TRUE(has(dbc, "BO_ 2147483785 moved: 4 gate")) << dbc;
  EXPECT_FALSE(has(dbc, "strict:")) << dbc;
  EXPECT_TRUE(has(dbc, "BA_ \"GenMsgCycleTime\" BO_ 291 50;")) << dbc;
  EXPECT_TRUE(has(dbc, "CM_ BO_ 291 \"a \\\"beat\\\"\";")) << dbc;
  EXPECT_TRUE(has(said_, "not-admitted")) << said_;
  EXPECT_TRUE(has(said_, "    strict on second\n")) << said_;
  const auto first = exported({"dbc", "--network", "first"});
  EXPECT_TRUE(has(first, "BO_ 294 wide: 48 switch\n")) << first;
  EXPECT_TRUE(has(first, "BA_ \"VFrameFormat\" BO_ 294 14;")) << first;
  EXPECT_TRUE(has(first, "(1,0) [0|0] \"\" gate")) << first;
}

TEST_F(ExportTest, WhatIsExportedCanBeImported) {
  const auto dbc = folder_.write("first.dbc", exported({"dbc", "--network", "first"}));
  const auto done = test::run({"import", dbc});
  ASSERT_EQ(done.status, 0) << done.error;
  for (const char* part :
       {"<Bus bitrate=\"500000\" data-bitrate=\"2000000\"/>",
        "<Binding channel=\"wide\" format=\"fd\"><Identifier form=\"standard\">0x126<",
        "<Binding channel=\"moved\"><Identifier form=\"extended\">0x01234567<", "period=\"50ms\"",
        "<Publisher channel=\"beat\"/>", "<Subscriber channel=\"wide\"/>"})
    EXPECT_TRUE(has(done.out, part)) << part << done.out;
  EXPECT_FALSE(has(done.error, "no-cycle")) << done.error;
}

/// A cycle time would say that its silence is a fault.
TEST_F(ExportTest, ASporadicChannelHasALeastDistanceAndNoCycle) {
  EXPECT_FALSE(has(exported({"dbc", "--network", "first"}), "GenMsgSendType"));
  std::string text = robot();
  const std::string name = "<EventChannel name=\"beat\"";
  text.replace(text.find(name), name.size(), name + " arrival=\"sporadic\"");
  const auto dbc = run(text, {"dbc", "--network", "first"});
  ASSERT_EQ(dbc.status, 0) << dbc.error;
  EXPECT_TRUE(has(dbc.out, "BA_ \"GenMsgSendType\" BO_ 291 1;")) << dbc.out;
  EXPECT_TRUE(has(dbc.out, "BA_ \"GenMsgDelayTime\" BO_ 291 50;")) << dbc.out;
  EXPECT_FALSE(has(dbc.out, "BA_ \"GenMsgCycleTime\" BO_ 291")) << dbc.out;
  const auto again = test::run({"import", folder_.write("first.dbc", dbc.out)});
  ASSERT_EQ(again.status, 0) << again.error;
  EXPECT_TRUE(has(again.out, "<EventChannel name=\"beat\" arrival=\"sporadic\">")) << again.out;
  EXPECT_TRUE(has(again.out, "<EventChannel name=\"moved\">")) << again.out;
  EXPECT_TRUE(has(again.out, "period=\"50ms\"")) << again.out;
}

TEST_F(ExportTest, CanGwHasARuleForWhatCrosses) {
  const auto script = exported({"can-gw"});
  EXPECT_TRUE(has(script, "cangw -A -s can0 -d can1 -e -f 123:DFFFFFFF # beat\n")) << script;
  EXPECT_TRUE(has(script,
                  "-f 81234567:DFFFFFFF -m AND:I:20000000.0.0000000000000000 "
                  "-m OR:I:80000089.0.0000000000000000 # moved\n"))
      << script;
  EXPECT_FALSE(has(script, "strict")) << script;
  EXPECT_FALSE(has(script, "wide")) << script;
}

TEST_F(ExportTest, RulesListWhatIsRefusedAndWhatARelayAloneCarries) {
  for (const char* format : {"can-gw", "em_canid"}) {
    exported({format});
    EXPECT_TRUE(has(said_, "refused: is not admitted: left out (1)\n    strict of ")) << said_;
    EXPECT_FALSE(has(said_, "relay:")) << said_;
    const auto rover = test::run({"export", "examples/rover/system.xml", "--format", format});
    EXPECT_EQ(rover.status, 0) << rover.error;
    EXPECT_TRUE(has(rover.error, "relay: is carried by mlcca-relay alone: left out ("))
        << format << rover.error;
    EXPECT_TRUE(has(rover.error, "    drive from air to drive-bus\n")) << rover.error;
  }
}

TEST_F(ExportTest, EmCanidLetsOutWhatIsAdmitted) {
  const auto script = exported({"em_canid"});
  EXPECT_TRUE(has(script,
                  "tc filter add dev can1 egress pref 1 protocol all basic match "
                  "'canid(sff 0x123:0x7ff eff 0x89:0x1fffffff)' action ok\n"))
      << script;
  EXPECT_TRUE(has(script, "dev can0 egress pref 60000 protocol all matchall action drop"))
      << script;
  EXPECT_FALSE(has(script, "0x124")) << script;
}

TEST_F(ExportTest, TheShellTakesTheScripts) {
  for (const char* format : {"can-gw", "em_canid"}) {
    const auto path = folder_.write("script", exported({format}));
    EXPECT_EQ(test::run_program({"sh", "-n", path}).status, 0) << format;
  }
}

TEST_F(ExportTest, SaysOfWhichKindThereIsNoneOrAreSeveral) {
  const auto several = run(robot(), {"dbc"});
  EXPECT_EQ(several.status, 2);
  EXPECT_TRUE(has(several.error, "there are several CAN networks; --network says which: first, "))
      << several.error;
  const auto none = run("<System name=\"s\"/>", {"dbc"});
  EXPECT_EQ(none.status, 2);
  EXPECT_TRUE(has(none.error, "there is no CAN network to export for")) << none.error;
}

TEST_F(ExportTest, AnInterfaceWithoutANameIsRefused) {
  auto text = robot();
  text.replace(text.find("name=\"can1\""), 11, "serial=\"7\"");
  const auto done = run(text, {"can-gw"});
  EXPECT_EQ(done.status, 2);
  EXPECT_TRUE(has(done.error, "its port on second does not state the name")) << done.error;
}

TEST_F(ExportTest, NothingIsOverwritten) {
  const auto output = folder_.write("there.dbc", "mine");
  const auto done = run(robot(), {"dbc", "--network", "second", "--output", output});
  EXPECT_EQ(done.status, 3) << "as of import, learn and new";
  EXPECT_TRUE(has(done.error, "there.dbc exists, and nothing is overwritten")) << done.error;
  EXPECT_EQ(test::content_of(output), "mine");
}

TEST_F(ExportTest, SaysWhichNetworksThereAre) {
  EXPECT_TRUE(has(run(robot(), {"dbc"}).error, "--network says which: first, second"));
  EXPECT_TRUE(has(run(robot(), {"dbc", "--network", "x"}).error, "there are first, second"));
  EXPECT_EQ(run("<System/>", {"wireshark"}).status, 2);
}

// --- Wireshark -----------------------------------------------------------------------------------

std::string big(std::uint64_t number, int bytes) {
  std::string out;
  for (int i = bytes - 1; i >= 0; --i) out += static_cast<char>(number >> (8 * i));
  return out;
}

/// A pcap file of frames of one link type.
std::string capture(unsigned link_type, const std::vector<std::string>& frames) {
  const auto little = [](std::uint32_t n) {
    auto text = big(n, 4);
    return std::string(text.rbegin(), text.rend());
  };
  std::string out = little(0xa1b2c3d4) + std::string("\2\0\4\0", 4) + little(0) + little(0) +
                    little(65535) + little(link_type);
  for (const auto& frame : frames) {
    const auto size = static_cast<std::uint32_t>(frame.size());
    out += little(1) + little(0) + little(size) + little(size) + frame;
  }
  return out;
}

std::string ethernet(unsigned type, const std::string& body) {
  return big(0x01005e000001, 6) + big(0x020000000001, 6) + big(type, 2) + body;
}

std::string datagram(const std::string& payload) {
  const auto udp = big(9999, 2) + big(9999, 2) + big(8 + payload.size(), 2) + big(0, 2) + payload;
  return ethernet(0x0800, big(0x4500, 2) + big(20 + udp.size(), 2) + big(0, 4) +
                              big(0x01110000, 4) + big(0x0a000001, 4) + big(0xef000001, 4) + udp);
}

/// A flooded AWDS packet: type, source, fields for the mesh, kind.
std::string flooded(unsigned kind, const std::string& body) {
  return ethernet(0x8334,
                  big(1, 1) + big(0x020000000007, 6) + std::string(9, '\0') + big(kind, 1) + body);
}

std::string can_frame(std::uint32_t id, const std::string& data) {
  return big(id, 4) + big(data.size(), 1) + std::string(3, '\0') + data;
}

class WiresharkTest : public ExportTest {
 protected:
  /// The fields of each frame as tshark shows them, one line for each frame, separated by bars.
  std::string dissected(unsigned link_type, const std::vector<std::string>& frames,
                        const std::vector<std::string>& fields) {
    return dissected_by({exported({"wireshark"})}, link_type, frames, fields);
  }
  /// The same with these scripts loaded, one after the other.
  std::string dissected_by(const std::vector<std::string>& scripts, unsigned link_type,
                           const std::vector<std::string>& frames,
                           const std::vector<std::string>& fields) {
    std::vector<std::string> arguments = {"tshark", "-n"};
    for (std::size_t i = 0; i < scripts.size(); ++i)
      arguments.insert(
          arguments.end(),
          {"-X", "lua_script:" + folder_.write(fmt::format("names{}.lua", i), scripts[i])});
    arguments.insert(arguments.end(), {"-r", folder_.write("a.pcap", capture(link_type, frames)),
                                       "-T", "fields", "-E", "separator=|"});
    for (const auto& field : fields) arguments.insert(arguments.end(), {"-e", field});
    auto out = test::run_program(arguments).out;
    if (const auto warning = out.find("Running as user"); warning != std::string::npos)
      out.erase(warning, out.find('\n', warning) + 1 - warning);
    while (out.starts_with('\n')) out.erase(0, 1);
    return out;
  }
};

TEST_F(WiresharkTest, NamesEventsInDatagrams) {
  const std::vector<std::string> fields = {"famouso.channel", "famouso.fragment",
                                           "famouso.afp.remaining", "famouso.afp.number",
                                           "famouso.data"};
  EXPECT_EQ(dissected(1,
                      {datagram(big(0x11, 8) + big(0, 1) + big(0x0102, 2)),
                       datagram(big(0x11, 8) + big(1, 1) + big(0x61, 1) + big(0, 1) + big(7, 4) +
                                big(0xaa, 1)),
                       datagram(big(0x99, 8) + big(0, 1))},
                      fields),
            "beat|0|||0102\nbeat|1|1|7|aa\n0x0000000000000099|0|||\n");
}

TEST_F(WiresharkTest, NamesSubscriptions) {
  EXPECT_EQ(dissected(1, {datagram("SUBSCRIB" + big(0, 1) + big(0x13, 8))}, {"famouso.subscribed"}),
            "moved\n");
}

TEST_F(WiresharkTest, NamesEventsInPacketsOfAwds) {
  const auto event = big(0, 1) + big(10, 2) + big(0x14, 8) + big(0x0506, 2);
  const std::vector<std::string> fields = {"awds.kind", "awds.source", "famouso.channel",
                                           "famouso.data"};
  EXPECT_EQ(dissected(1, {flooded(0x7c, event)}, fields), "0x7c|02:00:00:00:00:07|wide|0506\n");
  EXPECT_EQ(dissected(1, {flooded(98, datagram(big(0x11, 8) + big(0, 1) + big(3, 1)))}, fields),
            "0x62|02:00:00:00:00:07|beat|03\n");
}

TEST_F(WiresharkTest, NamesChannelsOfCanFrames) {
  EXPECT_EQ(
      dissected(227, {can_frame(0x123, "a"), can_frame(0x81234567, "b"), can_frame(0x777, "")},
                {"mlcca.can.channel", "mlcca.can.network", "mlcca.can.sender"}),
      "beat,beat|first,second|switch,gate\nmoved|first|switch\n||\n");
}

TEST_F(WiresharkTest, AChannelOfSeveralNetworksIsNamedOnceInALine) {
  const auto info = dissected(227, {can_frame(0x123, "a")}, {"_ws.col.Info"});
  EXPECT_EQ(info.find("[beat]"), info.rfind("[beat]")) << info;
  EXPECT_TRUE(has(info, " [beat]")) << info;
}

TEST_F(WiresharkTest, ScriptsOfSeveralSystemsWorkTogether) {
  const auto one = exported({"wireshark"});
  auto text = robot();
  for (auto at = text.find("\"beat\""); at != std::string::npos; at = text.find("\"beat\"", at))
    text.replace(at, 6, "\"pulse\"");
  const auto other = run(text, {"wireshark"}).out;
  const auto both = [&](unsigned link_type, const std::string& frame, const char* field) {
    return dissected_by({one, one, other}, link_type, {frame}, {field});
  };
  EXPECT_EQ(both(1, datagram(big(0x11, 8) + big(0, 1)), "famouso.channel"), "beat or pulse\n");
  EXPECT_EQ(both(1, datagram(big(0x13, 8) + big(0, 1)), "famouso.channel"), "moved\n");
  EXPECT_EQ(both(227, can_frame(0x123, "a"), "mlcca.can.channel"), "beat,beat,pulse,pulse\n");
  EXPECT_TRUE(has(both(227, can_frame(0x123, "a"), "_ws.col.Info"), " [beat] [pulse]\n"));
}

TEST_F(WiresharkTest, ReportsWhatIsTooShort) {
  EXPECT_EQ(dissected(1, {datagram("short")}, {"_ws.expert.message"}), "Too short for an event\n");
}

}  // namespace
}  // namespace mlcca
