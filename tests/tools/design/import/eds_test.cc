// SPDX-License-Identifier: BSD-2-Clause
// mlccactl import of CANopen EDS and DCF files.
#include <fmt/format.h>

#include "tests/tools/design/import/import_test.hpp"

namespace mlcca {
namespace {

using EdsImportTest = ImportTest;

constexpr const char* kDrive = R"(; a drive
[FileInfo]
FileName=drive.dcf
[DeviceInfo]
ProductName=Servo Drive
[DeviceComissioning]
NodeID=5
NodeName=left
Baudrate=250
[1005]
DefaultValue=0x80
[1014]
DefaultValue=$NODEID+0x80
[1017]
DefaultValue=0
ParameterValue=100
[1200sub1]
DefaultValue=$NODEID+0x600
[1800sub1]
DefaultValue=$NODEID+0x180
[1800sub2]
DefaultValue=255
[1800sub3]
DefaultValue=50
[1800sub5]
DefaultValue=20
[1A00]
SubNumber=3
[1A00sub0]
DefaultValue=2
[1A00sub1]
DefaultValue=0x60410010
[1A00sub2]
DefaultValue=0x606c0020
[1801sub1]
DefaultValue=0x80000285
[1802sub1]
DefaultValue=0x385
[1400sub1]
DefaultValue=0x20A
)";

constexpr const char* kMaster =
    "[DeviceInfo]\nProductName=PLC\n[1800sub1]\nDefaultValue=$NODEID+0x200\n"
    "[1016sub0]\nDefaultValue=1\n[1016sub1]\nDefaultValue=0x000500fa\n"
    "[1400sub1]\nDefaultValue=0x185\n";

TEST_F(EdsImportTest, PdosAndTheHeartBeatAreChannels) {
  const auto out = json("drive.dcf", kDrive, {"--network", "can"});
  EXPECT_TRUE(has("<Profile>canopen</Profile>") && has("<Bus bitrate=\"250000\"/>")) << draft_;
  EXPECT_TRUE(has("<Binding channel=\"left-5-TPDO1\"><COBID>0x185</COBID></Binding>")) << draft_;
  EXPECT_TRUE(has("<Binding channel=\"left-5-heartbeat\"><COBID>0x705</COBID></Binding>"));
  const auto pdo = part("<EventChannel name=\"left-5-TPDO1\"", "</EventChannel>");
  EXPECT_NE(pdo.find("period=\"5ms\""), std::string::npos) << "inhibit time, 5 ms: " << pdo;
  EXPECT_NE(pdo.find("maxPayload=\"6\""), std::string::npos) << "16 and 32 bits: " << pdo;
  EXPECT_NE(part("name=\"left-5-heartbeat\"", "</EventChannel>").find("period=\"100ms\""),
            std::string::npos)
      << "ParameterValue goes before DefaultValue";
  EXPECT_FALSE(has("TPDO2")) << "it is switched off";
  EXPECT_EQ(lacking(out, "unused"), 1U);
  EXPECT_EQ(lacking(out, "control"), 2U) << "SYNC and EMCY";
  EXPECT_EQ(lacking(out, "sdo"), 1U);
  EXPECT_EQ(lacking(out, "no-mapping"), 2U) << "TPDO3 and RPDO1";
  EXPECT_EQ(lacking(out, "no-sender"), 1U) << "RPDO1";
  EXPECT_EQ(lacking(out, "distance"), 1U);
  for (const auto& finding : checked()["findings"])
    EXPECT_NE(finding["severity"], "error") << finding.dump();
}

TEST_F(EdsImportTest, HeartBeatsThatItWaitsForNeedNoNumberOfThem) {
  const std::string eds =
      "[DeviceInfo]\nProductName=PLC\n[1800sub1]\nDefaultValue=$NODEID+0x200\n"
      "[1016sub1]\nDefaultValue=0x000507d0\n[1016sub3]\nDefaultValue=0x000607d0\n";
  const auto out = json("plc.eds", eds, {"--node", "1"});
  EXPECT_TRUE(has("node-5-heartbeat") && has("node-6-heartbeat")) << draft_;
  EXPECT_EQ(lacking(out, "consumer-time"), 2U);
  const auto fewer = json("fewer.eds", eds + "[1016sub0]\nDefaultValue=1\n", {"--node", "1"});
  EXPECT_FALSE(has("node-6-heartbeat"));
  EXPECT_EQ(lacking(fewer, "consumer-count"), 1U);
}

/// kDrive with one text instead of another.
std::string drive_with(const std::string& instead_of, const std::string& text) {
  std::string out = kDrive;
  return out.replace(out.find(instead_of), instead_of.size(), text);
}

TEST_F(EdsImportTest, AMappingThatIsNoNumberIsEightBytesAndListed) {
  const auto out = json("drive.dcf", drive_with("0x606c0020", "qq"), {});
  EXPECT_NE(part("name=\"left-5-TPDO1\"", "</EventChannel>").find("maxPayload=\"8\""),
            std::string::npos)
      << draft_;
  EXPECT_EQ(lacking(out, "mapping"), 1U) << out.dump();
  const auto text = import("drive.dcf", drive_with("0x606c0020", "qq")).error;
  EXPECT_NE(text.find("drive.dcf:34: left-5-TPDO1: 'qq'"), std::string::npos) << text;
}

TEST_F(EdsImportTest, ATimeThatIsNoNumberIsListed) {
  const auto beat = json("drive.dcf", drive_with("ParameterValue=100", "ParameterValue=abc"), {});
  EXPECT_EQ(lacking(beat, "heartbeat"), 1U) << beat.dump();
  EXPECT_TRUE(has("left-5-heartbeat")) << "it is sent, at some time";
  const auto inhibit = json("drive.dcf", drive_with("DefaultValue=50", "DefaultValue=??"), {});
  EXPECT_EQ(lacking(inhibit, "no-number"), 1U) << inhibit.dump();
  const auto timer = json("drive.dcf", drive_with("DefaultValue=20", "DefaultValue=zzz"), {});
  EXPECT_EQ(lacking(timer, "no-number"), 1U) << timer.dump();
  const auto waited = json("master.eds",
                           "[DeviceInfo]\nProductName=PLC\n[1800sub1]\nDefaultValue=0x281\n"
                           "[1016sub1]\nDefaultValue=soon\n",
                           {"--node", "1"});
  EXPECT_EQ(lacking(waited, "no-number"), 1U) << waited.dump();
}

/// A PDO with these times as CiA 301 states them, in a network where a SYNC comes every 10 ms.
struct TimesRow {
  const char* name;
  const char* type;
  int inhibit;  ///< in 0.1 ms
  int timer;    ///< ms
  const char* period;
  bool sporadic;
  const char* kind;  ///< the kind under which it is listed; empty: it is not listed
};
struct EdsTimesTest : EdsImportTest, ::testing::WithParamInterface<TimesRow> {
  Json imported() {
    const auto& row = GetParam();
    return json("a.eds",
                fmt::format("[DeviceInfo]\nProductName=P\n[1006]\nDefaultValue=10000\n"
                            "[1800sub1]\nDefaultValue=0x181\n"
                            "[1800sub2]\nDefaultValue={}\n[1800sub3]\nDefaultValue={}\n"
                            "[1800sub5]\nDefaultValue={}\n[1A00sub0]\nDefaultValue=1\n"
                            "[1A00sub1]\nDefaultValue=0x60410010\n",
                            row.type, row.inhibit, row.timer),
                {"--node", "1"});
  }
};

TEST_P(EdsTimesTest, GivePeriodAndArrival) {
  const auto& row = GetParam();
  const auto out = imported();
  const auto pdo = part("<EventChannel name=\"P-1-TPDO1\"", "</EventChannel>");
  EXPECT_NE(pdo.find(fmt::format("period=\"{}\"", row.period)), std::string::npos) << pdo;
  EXPECT_EQ(pdo.find("arrival=\"sporadic\"") != std::string::npos, row.sporadic) << pdo;
  for (const char* kind : {"distance", "events", "no-cycle", "on-request", "short-timer",
                           "transmission-type", "unused-time"})
    EXPECT_EQ(lacking(out, kind), std::string(kind) == row.kind ? 1U : 0U) << kind;
}

INSTANTIATE_TEST_SUITE_P(
    Types, EdsTimesTest,
    ::testing::Values(TimesRow{"TimerAlone", "255", 0, 20, "20ms", false, "events"},
                      TimesRow{"InhibitTimeAlone", "254", 50, 0, "5ms", true, ""},
                      TimesRow{"Both", "254", 50, 20, "5ms", true, "distance"},
                      TimesRow{"BothAlike", "255", 200, 20, "20ms", false, ""},
                      TimesRow{"TimerBelowTheInhibitTime", "255", 500, 20, "20ms", true,
                               "short-timer"},
                      TimesRow{"Neither", "255", 0, 0, "100ms", true, "no-cycle"},
                      TimesRow{"EachSync", "1", 0, 0, "10ms", false, ""},
                      TimesRow{"EachFourthSync", "4", 0, 0, "40ms", false, ""},
                      TimesRow{"SyncWithAnInhibitTime", "1", 50, 0, "10ms", false, "unused-time"},
                      TimesRow{"AcyclicAfterASync", "0", 0, 0, "10ms", true, ""},
                      TimesRow{"OnRequest", "253", 50, 0, "5ms", true, "on-request"},
                      TimesRow{"Reserved", "245", 50, 0, "5ms", true, "transmission-type"}),
    [](const auto& row) { return row.param.name; });

TEST_F(EdsImportTest, WithoutATimeOfSyncAPdoAfterItIsSporadic) {
  const auto out = json("a.eds",
                        "[DeviceInfo]\nProductName=P\n[1800sub1]\nDefaultValue=0x181\n"
                        "[1800sub2]\nDefaultValue=1\n",
                        {"--node", "1"});
  EXPECT_TRUE(has("<EventChannel name=\"P-1-TPDO1\" arrival=\"sporadic\">")) << draft_;
  EXPECT_TRUE(has("Assumed: no time between SYNC messages is stated of P-1-TPDO1.")) << draft_;
  EXPECT_EQ(lacking(out, "no-cycle"), 1U);
}

/// How often it comes is not known, so that silence means nothing.
TEST_F(EdsImportTest, APdoOfWhichNobodySaysWhoSendsItIsSporadic) {
  json("drive.dcf", kDrive, {"--network", "can"});
  EXPECT_TRUE(has("<EventChannel name=\"left-5-RPDO1\" arrival=\"sporadic\">")) << draft_;
  const auto master = folder_.write("master.eds", kMaster);
  json("drive.dcf", drive_with("DefaultValue=50", "DefaultValue=0"),
       {master, "--network", "can", "--network", "can", "--node", "5", "--node", "10"});
  EXPECT_TRUE(has("<EventChannel name=\"left-5-TPDO1\">"))
      << "its sender says how often it comes: " << draft_;
}

TEST_F(EdsImportTest, ACommentMayStandBehindAValue) {
  const auto out = json(
      "drive.dcf", drive_with("ParameterValue=100", "ParameterValue=100 ; ms, as CiA says"), {});
  EXPECT_NE(part("name=\"left-5-heartbeat\"", "</EventChannel>").find("period=\"100ms\""),
            std::string::npos)
      << draft_;
  EXPECT_EQ(lacking(out, "heartbeat"), 0U);
}

/// CiA 306: CompactSubObj and a section of values.
TEST_F(EdsImportTest, ObjectsInTheCompactFormAreRead) {
  json("compact.eds",
       "[DeviceInfo]\nProductName=P\n[1800]\nObjectType=0x9\nCompactSubObj=5\n[1800Value]\n"
       "NrOfEntries=2\n1=$NODEID+0x180\n5=30\n[1A00]\nCompactSubObj=1\n[1A00Value]\n"
       "NrOfEntries=1\n1=0x60410010\n",
       {"--node", "3"});
  EXPECT_TRUE(has("<COBID>0x183</COBID>")) << draft_;
  EXPECT_TRUE(has("period=\"30ms\"") && has("maxPayload=\"2\"")) << draft_;
}

TEST_F(EdsImportTest, FilesOfOneNetworkAreItsNodes) {
  const auto master = folder_.write("master.eds", kMaster);
  json("drive.dcf", kDrive,
       {master, "--network", "can", "--network", "can", "--node", "5", "--node", "10"});
  EXPECT_NE(part("<Component name=\"PLC-10\"", "</Component>")
                .find("<Subscriber channel=\"left-5-TPDO1\"/>"),
            std::string::npos)
      << draft_;
  EXPECT_NE(part("<Component name=\"PLC-10\"", "</Component>")
                .find("<Subscriber channel=\"left-5-heartbeat\"/>"),
            std::string::npos)
      << draft_;
  EXPECT_NE(part("<Component name=\"left-5\"", "</Component>")
                .find("<Subscriber channel=\"PLC-10-TPDO1\"/>"),
            std::string::npos)
      << draft_;
  EXPECT_FALSE(has("unnamed-sender"));
}

TEST_F(EdsImportTest, OfSeveralFilesEachLineNamesItsOwn) {
  const auto master = folder_.write("master.eds", kMaster);
  const auto text =
      import("drive.dcf", kDrive,
             {master, "--network", "can", "--network", "can", "--node", "5", "--node", "10"})
          .error;
  EXPECT_NE(text.find("drive.dcf:40: left-5-RPDO1"), std::string::npos) << text;
  EXPECT_NE(text.find("drive.dcf:11: SYNC"), std::string::npos) << text;
  EXPECT_EQ(text.find("master.eds:40"), std::string::npos) << text;
}

TEST_F(EdsImportTest, AnEdsNeedsTheNumberOfItsNode) {
  const auto done = import("master.eds", kMaster);
  EXPECT_EQ(done.status, 2);
  EXPECT_NE(done.error.find("state --node"), std::string::npos) << done.error;
  EXPECT_EQ(import("master.eds", kMaster, {"--node", "10"}).status, 0);
}

TEST_F(EdsImportTest, IsRefusedWithItsLineAndWhatWouldBeRight) {
  EXPECT_NE(import("a.eds", "[DeviceInfo]\nProductName\n").error.find("a.eds:2: must be [SECTION]"),
            std::string::npos);
  EXPECT_NE(import("a.eds", "[DeviceInfo\n", {"--format", "eds"}).error.find("a.eds:1: a section"),
            std::string::npos);
  EXPECT_NE(import("a.eds", "[DeviceInfo]\n", {"--node", "1"}).error.find("there is no PDO"),
            std::string::npos);
}

}  // namespace
}  // namespace mlcca
