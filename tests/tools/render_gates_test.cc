// SPDX-License-Identifier: BSD-2-Clause
// What `mlccactl gate` prints, for a person and for programs.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/control/messages.hpp"
#include "tools/json.hpp"
#include "tools/render.hpp"

namespace mlcca::tools {
namespace {

using Json = nlohmann::ordered_json;

TEST(RenderGates, ListsControlTrafficOfAGateBeforeItsChannels) {
  auto gate = test::full_gates().gates.front();
  gate.channels[1].passes = false;
  gate.channels[1].per_frame_ns = 0;
  gate.channels[1].per_byte = 2560;
  EXPECT_EQ(render(control::Gates{{gate}}, Color::no),
            R"(can0 on powertrain: profile j1939, attached, 21 of 4094 slots, 3 of 32 masks
  can0 is down
  CONTROL TRAFFIC  DIRECTION  SOURCE  IDENTIFIER  MASK      FORMATS  MAX LENGTH  VERDICT  LIMIT                                PASSED  DROPPED  WOULD DROP  EXCESS  LAST REASON
  address-claim    out        user 0  00eeff00    03ffff00  classic           8  passes   50/s, 257 at once, more is reported       7        2           4       1  more than admitted
  CHANNEL        DIRECTION  SOURCE  IDENTIFIER  MASK      FORMATS  MAX LENGTH  VERDICT  LIMIT                                PASSED  DROPPED  WOULD DROP  EXCESS  LAST REASON
  engine-speed   in                 00eeff00    03ffff00  classic           8  passes   50/s, 257 at once, more is reported       7        2           4       1  more than admitted
  address-claim  out        user 0  00eeff00    03ffff00  classic           8  refused  100 MB/s, more is reported                7        2           4       1  more than admitted
)");
  EXPECT_EQ(render(control::Gates{}, Color::no), "this gateway has no gates\n");
}

/// An Ethernet gate with one channel listed of those that it has, and its interface.
control::Gate ethernet_gate() {
  control::GateSlot foreign;
  foreign.name = "no event traffic";
  foreign.passes = true;
  foreign.passed = 12;
  control::GateSlot channel = test::full_gates().gates.front().channels.front();
  channel.name = "distance";
  channel.id = channel.mask = 0;
  channel.formats = "unfragmented";
  return {.interface = "eth1",
          .network = "lan",
          .profile = "famouso",
          .attached = true,
          .problem = "",
          .slots = 5000,
          .slots_limit = 8190,
          .masked_slots = 0,
          .masked_slots_limit = 0,
          .control = {foreign},
          .channels = {channel}};
}
std::vector<control::Interface> its_interface() {
  control::Interface eth1;
  eth1.name = "eth1";
  eth1.network = "lan";
  eth1.hook = "clsact";
  eth1.drops_early = true;
  eth1.ingress.reasons = {{"no event traffic", 12}, {"malformed", 3}};
  eth1.egress.reasons = {{"passed", 1}};
  return {eth1};
}

TEST(RenderGates, ListsWhatAnEthernetGatePassesBesidesSubjectsAndWhatBecameOfFrames) {
  EXPECT_EQ(
      render(control::Gates{{ethernet_gate()}}, its_interface(), Color::no),
      R"(eth1 on lan: profile famouso, attached by clsact, early in the driver, 5000 of 8190 slots
  OTHER TRAFFIC     DIRECTION  VERDICT  PASSED
  no event traffic  in         passes       12
  CHANNEL   DIRECTION  FORMATS       MAX LENGTH  VERDICT  LIMIT                                PASSED  DROPPED  WOULD DROP  EXCESS  LAST REASON
  distance  in         unfragmented           8  passes   50/s, 257 at once, more is reported       7        2           4       1  more than admitted
  and 4999 slots more
  REASON            DIRECTION  FRAMES
  no event traffic  in             12
  malformed         in              3
  passed            out             1
)");
}

TEST(RenderGates, ExcessThatAuditModeLetThroughIsAmongWhatWouldHaveBeenDropped) {
  auto gate = ethernet_gate();
  gate.channels[0].excess = 9;
  gate.channels[0].would_drop = 8;
  gate.channels[0].would_exceed = 6;
  const std::string text = render(control::Gates{{gate}}, its_interface(), Color::no);
  EXPECT_TRUE(text.contains("      7        2           8       3  more than admitted")) << text;
}

TEST(RenderGates, AReasonHasOneRowForWhatIsDroppedAndWhatWouldBe) {
  auto status = test::full_status();
  control::Traffic& in = status.interfaces.at(0).ingress;
  in.reasons = {{"unknown", 21}, {"length", 1}};
  in.would_drop_reasons = {{"source", 5}, {"unknown", 7}};
  const std::string text = render(status, Color::no);
  EXPECT_NE(text.find("  can0       in         unknown                 21           7\n"
                      "  can0       in         length                   1\n"
                      "  can0       in         source                               5\n"),
            std::string::npos)
      << text;
}

TEST(GatesAsJson, ReportGates) {
  const auto json = Json::parse(to_json(control::Reply{1, test::full_gates()}));
  EXPECT_EQ(json.at("gates").at(0).at("masked_slots_limit"), 32);
  EXPECT_EQ(json.at("gates").at(0).at("control").at(0),
            Json::parse(R"({"name": "address-claim", "egress": true, "passes": true,
      "id": 2163146496, "mask": 3288334080, "formats": "classic",
      "max_length": 8, "source": "user 0", "per_frame_ns": 20000000, "per_byte": 3,
      "tolerance_ns": 5120000000, "excess_passes": true, "passed": 7, "dropped": 2, "excess": 1,
      "bytes": 56, "last_reason": "more than admitted", "would_drop": 4, "would_exceed": 0,
      "identifier": "00eeff00"})"));
}

TEST(GatesAsJson, ReportAnEthernetGateWithItsInterface) {
  const auto json = Json::parse(to_json(control::Gates{{ethernet_gate(), {}}}, its_interface()));
  const auto& gate = json.at("gates").at(0);
  EXPECT_EQ(gate.at("hook"), "clsact");
  EXPECT_EQ(gate.at("drops_early"), true);
  EXPECT_EQ(gate.at("slots_limit"), 8190);
  EXPECT_EQ(gate.at("ingress").at("reasons").at("malformed"), 3);
  EXPECT_FALSE(gate.at("channels").at(0).contains("identifier"));
  EXPECT_EQ(gate.at("channels").at(0).at("formats"), "unfragmented");
  EXPECT_FALSE(json.at("gates").at(1).contains("hook")) << "of another interface";
}

}  // namespace
}  // namespace mlcca::tools
