// SPDX-License-Identifier: BSD-2-Clause
// mlccactl import of registers of Cyphal nodes, as yakut prints them.
#include <fmt/format.h>

#include "tests/tools/design/import/import_test.hpp"

namespace mlcca {
namespace {

struct CyphalImportTest : ImportTest {
  /// No finding but those that say what is missing.
  void expect_no_errors() const {
    for (const auto& finding : checked()["findings"])
      EXPECT_NE(finding["severity"], "error") << finding.dump() << draft_;
  }
};

/// A motor controller and who commands it, as `yakut --yaml register-batch` prints them.
constexpr const char* kNodes = R"(---
122:
  m.pole_count: 24
  uavcan.can.bitrate: [1000000, 0]
  uavcan.can.mtu: 8
  uavcan.node.description: left <wheel>
  uavcan.node.id: 122
  uavcan.pub.compact.id: 0xFFFF  # disabled
  uavcan.pub.compact.type: zubax.telega.CompactFeedback.0.1
  uavcan.pub.dynamics.id: 1220
  uavcan.pub.dynamics.rate: 50.0
  uavcan.pub.dynamics.type: reg.udral.physics.dynamics.rotation.PlanarTs.0.1
  uavcan.srv.low_level_io.id: 65535
  uavcan.sub.readiness.id: 10
  uavcan.sub.readiness.type: reg.udral.service.common.Readiness.0.1
10:
  uavcan.can.mtu: 8
  uavcan.pub.readiness.id: 10
  uavcan.pub.readiness.type: reg.udral.service.common.Readiness.0.1
  uavcan.pub.readiness.period: 0.2
  uavcan.pub.readiness.prio: 2
  uavcan.sub.state.id: 1220
  uavcan.sub.state.type: reg.udral.physics.dynamics.rotation.PlanarTs.0.1
...
)";

/// The same of a node of its own, as JSON in one line.
std::string node_of(const std::string& registers, unsigned node = 5) {
  return fmt::format("{{\"{}\":{{\"uavcan.can.bitrate\":[500000,0],\"uavcan.can.mtu\":8,{}}}}}",
                     node, registers);
}

TEST_F(CyphalImportTest, SubjectsAreChannelsWithPublishersAndSubscribers) {
  const auto out = json("esc.yaml", kNodes);
  EXPECT_EQ(out["networks"][0]["messages"], 2);
  EXPECT_EQ(out["networks"][0]["nodes"], 2);
  EXPECT_TRUE(has("<Profile>cyphal</Profile>") && has("<Bus bitrate=\"1000000\"/>")) << draft_;
  EXPECT_TRUE(has("<Binding channel=\"dynamics-1220\"><SubjectID>1220</SubjectID></Binding>"));
  EXPECT_TRUE(
      has("<Binding channel=\"readiness-10\"><SubjectID priority=\"2\">10</SubjectID></Binding>"))
      << draft_;
  const auto dynamics = part("<EventChannel name=\"dynamics-1220\">", "</EventChannel>");
  EXPECT_NE(dynamics.find("period=\"20ms\""), std::string::npos) << "50 a second: " << dynamics;
  EXPECT_NE(dynamics.find("maxPayload=\"23\""), std::string::npos) << dynamics;
  EXPECT_NE(dynamics.find("PlanarTs.0.1</Description>"), std::string::npos) << dynamics;
  const auto motor = part("<Component name=\"node-122\" network=\"esc\" node=\"122\">", "</Comp");
  EXPECT_NE(motor.find("left &lt;wheel&gt;"), std::string::npos) << draft_;
  EXPECT_NE(motor.find("<Publisher channel=\"dynamics-1220\"/>"), std::string::npos) << motor;
  EXPECT_NE(motor.find("<Subscriber channel=\"readiness-10\"/>"), std::string::npos) << motor;
  expect_no_errors();
}

TEST_F(CyphalImportTest, WhatHasNoCounterpartIsListedWithItsLine) {
  const auto out = json("esc.yaml", kNodes);
  EXPECT_EQ(lacking(out, "registers"), 1U);
  EXPECT_EQ(lacking(out, "unset"), 1U);
  EXPECT_EQ(lacking(out, "services"), 1U);
  EXPECT_EQ(lacking(out, "control"), 1U) << "the heart-beat";
  EXPECT_EQ(lacking(out, "no-cycle"), 0U);
  EXPECT_EQ(lacking(out, "no-size"), 0U);
  const auto said = import("esc.yaml", kNodes).error;
  EXPECT_NE(said.find("esc.yaml:3: node-122: m.pole_count\n"), std::string::npos) << said;
  EXPECT_NE(said.find("esc.yaml:8: node-122: compact\n"), std::string::npos) << said;
}

TEST_F(CyphalImportTest, WhatIsAssumedIsListed) {
  const auto out =
      json("a.json", "{\"5\":{\"uavcan.pub.x.id\":70,\"uavcan.pub.x.type\":\"a.B.1.0\"}}");
  for (const auto* const kind : {"no-size", "no-cycle", "no-mtu", "bit-rate"})
    EXPECT_EQ(lacking(out, kind), 1U) << kind;
  const auto channel = part("<EventChannel", "</EventChannel>");
  EXPECT_NE(channel.find("period=\"100ms\""), std::string::npos) << channel;
  EXPECT_NE(channel.find("maxPayload=\"7\""), std::string::npos) << channel;
  EXPECT_NE(channel.find("arrival=\"sporadic\""), std::string::npos) << channel;
  EXPECT_TRUE(has("<!-- Assumed: size and Period of x-70. -->")) << draft_;
  json("a.json", node_of("\"uavcan.pub.x.id\":70"), {"--default-period", "20ms"});
  EXPECT_TRUE(has("period=\"20ms\"")) << draft_;
}

TEST_F(CyphalImportTest, EveryFormOfAValueIsRead) {
  const std::string detailed =
      "5:\n"
      "  uavcan.can.mtu: {natural16: {value: [64]}, _meta_: {mutable: true, persistent: true}}\n"
      "  uavcan.can.bitrate: {natural32: {value: [1000000, 4000000]}}\n"
      "  uavcan.pub.x.id: {_meta_: {mutable: true}, natural16: {value: [0x46]}}\n"
      "  uavcan.pub.x.type: {string: {value: uavcan.si.sample.angular_velocity.Vector3.1.0}}\n"
      "  uavcan.pub.y.id: {empty: {}}\n";
  const auto out = json("a.yaml", detailed);
  EXPECT_TRUE(has("<Bus bitrate=\"1000000\" data-bitrate=\"4000000\"/>")) << draft_;
  EXPECT_TRUE(has("<Binding channel=\"x-70\" format=\"fd\"><SubjectID>70<")) << draft_;
  EXPECT_TRUE(has("maxPayload=\"19\"")) << draft_;
  EXPECT_EQ(lacking(out, "no-id"), 1U);
  json("a.json", node_of("\"uavcan.pub.x.id\":[70]"));
  EXPECT_TRUE(has("<SubjectID>70<")) << draft_;
}

TEST_F(CyphalImportTest, AliasesAndMergedMapsAreRead) {
  json("a.yaml",
       "122: &esc\n  uavcan.can.mtu: 8\n  uavcan.pub.x.id: 70\n  uavcan.sub.y.id: 10\n"
       "123:\n  <<: *esc\n  uavcan.pub.x.id: 71\n");
  EXPECT_TRUE(has("<SubjectID>70<") && has("<SubjectID>71<")) << draft_;
  const auto second = part("<Component name=\"node-123\"", "</Component>");
  EXPECT_NE(second.find("<Publisher channel=\"x-71\"/>"), std::string::npos) << draft_;
  EXPECT_NE(second.find("<Subscriber channel=\"y-10\"/>"), std::string::npos) << draft_;
}

TEST_F(CyphalImportTest, ANodeIsNamedByItsKeyTheOptionOrItsRegister) {
  const std::string plain = "uavcan.node.id: 7\nuavcan.pub.x.id: 70\n";
  json("a.yaml", plain);
  EXPECT_TRUE(has("node=\"7\"")) << draft_;
  json("a.yaml", plain, {"--node", "9"});
  EXPECT_TRUE(has("node=\"9\"") && !has("node=\"7\"")) << draft_;
  json("a.yaml", "0: {uavcan.node.id: 7, uavcan.pub.x.id: 70}");
  EXPECT_TRUE(has("node=\"0\"")) << draft_;
  EXPECT_NE(import("a.yaml", "uavcan.pub.x.id: 70\n").error.find("a.yaml:1: neither a key nor"),
            std::string::npos);
}

TEST_F(CyphalImportTest, FilesAndDocumentsOfOneNetworkAreItsNodes) {
  const auto second = folder_.write(
      "b.json", node_of(R"("uavcan.sub.in.id":70,"uavcan.pub.x.id":70,"uavcan.pub.x.rate":20)", 6));
  const auto out = json("a.json", node_of("\"uavcan.pub.x.id\":70"),
                        {second, "--network", "can", "--network", "can"});
  EXPECT_EQ(out["networks"].size(), 1U);
  EXPECT_EQ(out["networks"][0]["messages"], 1);
  EXPECT_NE(part("name=\"node-6\"", "</Component>").find("<Attributes period=\"50ms\"/>"),
            std::string::npos)
      << "a Period of its own: " << draft_;
  EXPECT_NE(part("name=\"node-5\"", "</Component>").find("<Publisher channel=\"x-70\"/>"),
            std::string::npos)
      << draft_;
  expect_no_errors();
  json("two.yaml", "---\n5: {uavcan.pub.x.id: 70}\n---\n6: {uavcan.sub.x.id: 70}\n");
  EXPECT_TRUE(has("name=\"node-5\"") && has("name=\"node-6\"")) << draft_;
}

TEST_F(CyphalImportTest, TwoFilesOfOneNodeAreOneNode) {
  const auto second = folder_.write("b.json", node_of("\"uavcan.pub.y.id\":71"));
  const auto out = json("a.json", node_of("\"uavcan.pub.x.id\":70"),
                        {second, "--network", "can", "--network", "can"});
  EXPECT_EQ(out["networks"][0]["nodes"], 1);
  EXPECT_EQ(out["networks"][0]["messages"], 2);
}

TEST_F(CyphalImportTest, WhatContradictsIsListed) {
  auto out = json("a.yaml",
                  "5: {uavcan.pub.x.id: 70, uavcan.pub.x.type: a.B.1.0, uavcan.pub.y.id: 70}\n"
                  "6: {uavcan.sub.x.id: 70, uavcan.sub.x.type: a.C.1.0}\n");
  EXPECT_EQ(lacking(out, "repeated-sender"), 1U) << "two ports of a node with one subject";
  EXPECT_EQ(lacking(out, "types"), 1U);
  out = json("a.yaml",
             "5: {uavcan.pub.x.id: 70, uavcan.can.bitrate: [1000000, 0]}\n"
             "6: {uavcan.sub.x.id: 70, uavcan.can.bitrate: [500000, 0]}\n");
  EXPECT_EQ(lacking(out, "bit-rates"), 1U);
  EXPECT_TRUE(has("<Bus bitrate=\"1000000\"/>"));
  out = json("a.yaml", "5: {uavcan.pub.x.id: 70}\n6: null\n");
  EXPECT_EQ(lacking(out, "no-answer"), 1U);
}

TEST_F(CyphalImportTest, ASubjectWithoutAPublisherIsListedAndFoundByCheck) {
  const auto out = json("a.json", node_of("\"uavcan.sub.in.id\":70"));
  EXPECT_EQ(lacking(out, "no-sender"), 1U);
  EXPECT_EQ(checked()["findings"][0]["id"], "MLCCA010") << checked().dump();
}

TEST_F(CyphalImportTest, NumbersAreTakenUpToTheirLimits) {
  const auto out = json("a.json", node_of(R"("uavcan.pub.a.id":8191,"uavcan.pub.b.id":8192,)"
                                          R"("uavcan.pub.c.id":65535,"uavcan.pub.d.id":65536,)"
                                          R"("uavcan.pub.e.id":-1,"uavcan.pub.a.prio":8,)"
                                          R"("uavcan.pub.a.rate":1000001)",
                                          127));
  EXPECT_EQ(out["networks"][0]["messages"], 1);
  EXPECT_TRUE(has("<SubjectID>8191<"));
  EXPECT_EQ(lacking(out, "no-binding"), 2U);
  EXPECT_EQ(lacking(out, "unset"), 1U);
  EXPECT_EQ(lacking(out, "no-id"), 1U);
  EXPECT_EQ(lacking(out, "registers"), 1U) << "the priority";
  EXPECT_EQ(lacking(out, "no-period"), 1U);
  EXPECT_NE(import("a.json", node_of("\"uavcan.pub.a.id\":1", 128)).error.find("0 to 127"),
            std::string::npos);
  json("a.json", node_of(R"("uavcan.pub.a.id":1,"uavcan.pub.a.rate":1000000)"));
  EXPECT_TRUE(has("period=\"1us\"")) << draft_;
}

struct CyphalWrongRow {
  const char* name;
  const char* text;
  const char* error;  ///< part of it
};
struct CyphalWrongTest : CyphalImportTest, ::testing::WithParamInterface<CyphalWrongRow> {};

TEST_P(CyphalWrongTest, IsRefusedWithItsLineAndWhatWouldBeRight) {
  const auto done = import("w.yaml", GetParam().text, {"--format", "cyphal"});
  EXPECT_EQ(done.status, 2) << done.out;
  EXPECT_NE(done.error.find(GetParam().error), std::string::npos) << done.error;
}

INSTANTIATE_TEST_SUITE_P(
    Files, CyphalWrongTest,
    ::testing::Values(
        CyphalWrongRow{"Empty", "", "w.yaml: there is no subject in it"},
        CyphalWrongRow{"NoRegisters", "5: {a: 1}\n", "w.yaml: there is no subject in it"},
        CyphalWrongRow{"Names", "- uavcan.node.id\n", "w.yaml:1: these are names of registers"},
        CyphalWrongRow{"NamesOfANode", "5:\n  - uavcan.node.id\n", "w.yaml:2: these are names"},
        CyphalWrongRow{"Scalar", "hello\n", "w.yaml:1: must be registers"},
        CyphalWrongRow{"Mixed", "5: {}\nuavcan.node.id: 5\n", "w.yaml:2: \"uavcan.node.id\": must"},
        CyphalWrongRow{"Twice", "5: {}\n5: {}\n", "w.yaml:2: \"5\" is there twice"},
        CyphalWrongRow{"Unclosed", "5: {a: 1\n", "neither YAML nor JSON"},
        CyphalWrongRow{"NoAnchor", "5: *a\n", "w.yaml:1: *a: nothing before it is called &a"},
        CyphalWrongRow{"InItself", "5: &a {x: *a}\n", "w.yaml:1: *a: nothing before it"},
        CyphalWrongRow{"KeyIsAMap", "{{a: 1}: 2}\n", "w.yaml:1: a key is a text or a number"},
        CyphalWrongRow{"MergedScalar", "5: {<<: 1}\n", "w.yaml:1: \"<<\" names maps"},
        CyphalWrongRow{"Control", "a: \x01\n", "w.yaml:1: neither YAML nor JSON"}),
    [](const auto& row) { return row.param.name; });

/// Lists in each other.
std::string nested(std::size_t depth) {
  return "5: {uavcan.pub.x.id: 70, a: " + std::string(depth, '[') + std::string(depth, ']') + "}\n";
}

TEST_F(CyphalImportTest, DepthIsLimited) {
  EXPECT_EQ(import("a.yaml", nested(30)).status, 0);
  const auto done = import("a.yaml", nested(31));
  EXPECT_EQ(done.status, 2);
  EXPECT_NE(done.error.find("a.yaml:1: values are in each other deeper than 32"), std::string::npos)
      << done.error;
  // By aliases, each of which is a level deeper.
  std::string text = "a: &l0 [0]\n";
  for (int i = 1; i < 40; ++i) text += fmt::format("b{}: &l{} [*l{}]\n", i, i, i - 1);
  EXPECT_NE(import("a.yaml", text, {"--format", "cyphal"}).error.find("deeper than 32"),
            std::string::npos);
}

TEST_F(CyphalImportTest, TheNumberOfValuesIsLimitedWithWhatAliasesName) {
  // Of each register its key and its value; and the map, the key of the node and the map of it.
  const auto registers = [](std::size_t count) {
    std::string text = "5:\n  uavcan.pub.x.id: 70\n";
    for (std::size_t i = 0; i < count; ++i) text += fmt::format("  r{}: 0\n", i);
    return text;
  };
  EXPECT_EQ(import("a.yaml", registers(131'069)).status, 0);
  const auto done = import("a.yaml", registers(131'070));
  EXPECT_NE(done.error.find("more than 262144 values"), std::string::npos)
      << done.error.substr(0, 500);
  std::string bomb = "a0: &a0 [0,0,0,0,0,0,0,0,0,0]\n";
  for (int i = 1; i < 8; ++i) {
    bomb += fmt::format("a{0}: &a{0} [*a{1}", i, i - 1);
    for (int n = 1; n < 10; ++n) bomb += fmt::format(",*a{}", i - 1);
    bomb += "]\n";
  }
  EXPECT_NE(import("a.yaml", bomb, {"--format", "cyphal"})
                .error.find("with what aliases name there are more than 262144 values"),
            std::string::npos);
}

TEST_F(CyphalImportTest, HostileMergesAndDirectivesTakeNoTime) {
  std::string merges = "a: &a {";
  for (int i = 0; i < 1000; ++i) merges += fmt::format("k{}: 0, ", i);
  merges += "z: 0}\n";
  for (int i = 0; i < 1000; ++i) merges += fmt::format("b{}: {{<<: *a}}\n", i);
  EXPECT_NE(import("a.yaml", merges, {"--format", "cyphal"}).error.find("\"<<\" names more than"),
            std::string::npos);
  std::string directives;
  for (int i = 0; i < 17; ++i) directives += fmt::format("%TAG !t{}! x\n", i);
  EXPECT_NE(import("a.yaml", directives + "---\n5: {}\n", {"--format", "cyphal"})
                .error.find("a.yaml:17: there are more than 16 directives %TAG"),
            std::string::npos);
}

TEST_F(CyphalImportTest, ANetworkIsOfOneProfile) {
  const auto dcf = folder_.write("d.dcf",
                                 "[DeviceInfo]\n[DeviceComissioning]\nNodeID=5\n"
                                 "[1017]\nParameterValue=100\n");
  const auto done = import("a.json", node_of("\"uavcan.pub.x.id\":70"),
                           {dcf, "--network", "can", "--network", "can"});
  EXPECT_EQ(done.status, 2);
  EXPECT_NE(done.error.find("give each a name by --network"), std::string::npos) << done.error;
}

}  // namespace
}  // namespace mlcca
