// SPDX-License-Identifier: BSD-2-Clause
// Tables of packets through the real programs: one row, one behaviour.
#include <gtest/gtest.h>
#include <linux/batadv_packet.h>

#include <string>

#include "tests/bpf/ether/events.hpp"

namespace mlcca::test {
namespace {

constexpr bool kOwn = true;  // counted by the direction's own slot
struct Row {
  std::string name;
  std::vector<SlotSpec> slots;
  Direction direction;
  Bytes bytes;
  Sender sender;
  gate_reason reason;
  bool own = false;
};

std::vector<Row> subject_rows() {
  const auto denied_too = with(denied(in()), [](SlotSpec& s) { s.max_len = 7; });
  return {
      {"AnAdmittedEventPasses", {in()}, kIn, packet(), kWire, GATE_R_PASSED},
      {"ABroadcastEventPasses",
       {in()},
       kIn,
       packet([](Datagram& d) { d.port = 8888, d.destination = 0xffffffff; }),
       kWire,
       GATE_R_PASSED},
      {"AUnicastDatagramToThePortIsAnEvent",
       {},
       kIn,
       packet([](Datagram& d) { d.destination = 0x0a000002; }),
       kWire,
       GATE_R_UNKNOWN,
       kOwn},
      {"ANeighbourOfTheSubjectIsUnknown",
       {in()},
       kIn,
       packet([](Datagram& d) { ++d.subject; }),
       kWire,
       GATE_R_UNKNOWN,
       kOwn},
      {"WhatIsAdmittedInDoesNotGoOut", {in()}, kOut, packet(), kLocal, GATE_R_UNKNOWN, kOwn},
      {"ADeniedEventIsDropped", {denied(in())}, kIn, packet(), kWire, GATE_R_DENIED},
      {"OneOfSeveralAdmits", {in(), denied_too}, kIn, packet(), kWire, GATE_R_PASSED},
      {"TheLongestEventPasses",
       {sized(in(), 8)},
       kIn,
       packet([](Datagram& d) { d.payload = 8; }),
       kWire,
       GATE_R_PASSED},
      {"ALongerOneDoesNot",
       {sized(in(), 8)},
       kIn,
       packet([](Datagram& d) { d.payload = 9; }),
       kWire,
       GATE_R_LENGTH},
      {"AnEmptyEventPasses",
       {sized(in(), 0)},
       kIn,
       packet([](Datagram& d) { d.payload = 0; }),
       kWire,
       GATE_R_PASSED},
      {"AFragmentOfAnEventWhereNoneWasGranted",
       {in()},
       kIn,
       packet([](Datagram& d) { d.flag = 1; }),
       kWire,
       GATE_R_FORMAT},
      {"AFragmentOfAnEventWhereOneWas",
       {fragmented(in())},
       kIn,
       packet([](Datagram& d) { d.flag = 1; }),
       kWire,
       GATE_R_PASSED},
      {"AnotherFlagIsMalformed",
       {fragmented(in())},
       kIn,
       packet([](Datagram& d) { d.flag = 2; }),
       kWire,
       GATE_R_MALFORMED,
       kOwn},
  };
}

std::vector<Row> sender_rows() {
  return {
      {"ALocalProgramOfTheUserSends", {of_user(0)}, kOut, packet(), kLocal, GATE_R_PASSED},
      {"AProgramOfAnyUserSends", {of_user(GATE_ANY_UID)}, kOut, packet(), kLocal, GATE_R_PASSED},
      {"AProgramOfAnotherUserDoesNot", {of_user(1000)}, kOut, packet(), kLocal, GATE_R_SOURCE},
      {"ForwardedFromTheInterfaceOfTheGrant",
       {from(kOther)},
       kOut,
       packet(),
       kForwarded,
       GATE_R_PASSED},
      {"ForwardedFromAnotherInterface",
       {from(kIfindex)},
       kOut,
       packet(),
       kForwarded,
       GATE_R_SOURCE},
      {"ForwardedWithoutTheMarkOfItsGate",
       {from(kOther)},
       kOut,
       packet(),
       Sender{.ingress_ifindex = kOther},
       GATE_R_SOURCE},
      {"ALocalProgramInTheNameOfAnInterface",
       {from(kOther)},
       kOut,
       packet(),
       Sender{.local = true, .mark = kFromOther},
       GATE_R_SOURCE},
      {"NobodySends", {of_user(GATE_ANY_UID)}, kOut, packet(), kWire, GATE_R_SOURCE},
      {"SeveralDatagramsInOneBuffer",
       {of_user(0)},
       kOut,
       packet(),
       Sender{.local = true, .segment = 8},
       GATE_R_MALFORMED,
       kOwn},
  };
}

std::vector<Row> station_rows() {
  constexpr std::uint64_t first = 0x0a000001;  // the sender of packet()
  constexpr std::uint64_t second = 0x0a000002;
  constexpr std::uint64_t mac = ETHER_MAC | kAwdsSource;
  const auto of = [](std::uint64_t station, SlotSpec s) {
    s.station = station;
    return s;
  };
  const auto forwarded = [](std::uint64_t station) {
    return Sender{.mark = mark_from(kOther, station), .ingress_ifindex = kOther};
  };
  const Bytes from_second = packet([](Datagram& d) { d.source = second; });
  const Bytes flood = ethernet(0x8334, awds_flood(0x7c, awds_event(kSubject, 8)));
  const Bytes one_hop = ethernet(0x8334, awds_unicast(0x7c, awds_event(kSubject, 8)));
  const Bytes in_awds = ethernet(0x8334, awds_flood(98, packet()));
  return {
      {"AStationsEventPasses", {of(first, in())}, kIn, packet(), kWire, GATE_R_PASSED},
      {"ThatOfAnotherDoesNot", {of(first, in())}, kIn, from_second, kWire, GATE_R_SOURCE},
      {"EachHasItsOwn",
       {of(second, in()), of(first, in())},
       kIn,
       from_second,
       kWire,
       GATE_R_PASSED},
      {"WhoHasNoneMeetsTheWildcard",
       {in(), of(first, in())},
       kIn,
       from_second,
       kWire,
       GATE_R_PASSED},
      {"WhoHasOneNeverMeetsTheWildcard",
       {of(first, denied(in())), in()},
       kIn,
       packet(),
       kWire,
       GATE_R_DENIED},
      {"WhicheverCameFirst",
       {of(first, sized(in(), 7)), in()},
       kIn,
       packet(),
       kWire,
       GATE_R_LENGTH},
      {"OfTwoOfOneStationOnePasses",
       {of(first, in()), of(first, sized(denied(in()), 9)), in()},
       kIn,
       packet(),
       kWire,
       GATE_R_PASSED},
      {"AMacIsNoIpAddress", {of(ETHER_MAC | first, in())}, kIn, packet(), kWire, GATE_R_SOURCE},
      {"AStationOfAMeshFloods", {of(mac, in())}, kIn, flood, kWire, GATE_R_PASSED},
      {"AStationOfAMeshSends", {of(mac, in())}, kIn, one_hop, kWire, GATE_R_PASSED},
      {"AnotherOneDoesNot", {of(mac + 1, in())}, kIn, flood, kWire, GATE_R_SOURCE},
      {"NorOneOfAnotherVendor", {of(mac ^ 1ULL << 47, in())}, kIn, flood, kWire, GATE_R_SOURCE},
      {"ADatagramInAMeshIsFromItsIpAddress", {of(first, in())}, kIn, in_awds, kWire, GATE_R_PASSED},
      {"AndNotFromTheMac", {of(mac, in())}, kIn, in_awds, kWire, GATE_R_SOURCE},
      {"AStationsEventIsForwarded",
       {of(first, from(kOther))},
       kOut,
       packet(),
       forwarded(first),
       GATE_R_PASSED},
      {"ThatOfAnotherIsNot",
       {of(first, from(kOther))},
       kOut,
       from_second,
       forwarded(first),
       GATE_R_SOURCE},
      {"NorThatOfAnotherWithItsAddress",
       {of(first, from(kOther))},
       kOut,
       packet(),
       forwarded(second),
       GATE_R_SOURCE},
      {"NorTheWildcardWithItsAddress",
       {of(first, from(kOther))},
       kOut,
       packet(),
       kForwarded,
       GATE_R_SOURCE},
      {"NorItsOwnAsTheWildcard",
       {from(kOther)},
       kOut,
       from_second,
       forwarded(first),
       GATE_R_SOURCE},
      {"FromAnotherInterfaceItMeetsTheWildcard",
       {of_user(0), of(first, from(kOther))},
       kOut,
       packet(),
       kLocal,
       GATE_R_PASSED},
  };
}

/// What is no event, whatever it resembles, is left alone.
std::vector<Row> foreign_rows() {
  const auto foreign = [](std::string name, Bytes bytes) {
    return Row{std::move(name), {}, kIn, std::move(bytes), kWire, GATE_R_FOREIGN, kOwn};
  };
  return {
      foreign("AnotherPort", packet([](Datagram& d) { d.port = 9998; })),
      foreign("AnotherPortWithALyingLength",
              packet([](Datagram& d) { d.port = 53, d.longer_udp = 3; })),
      foreign("Tcp", packet([](Datagram& d) { d.protocol = 6; })),
      foreign("TcpWithAnyHeaderLength", packet([](Datagram& d) { d.protocol = 6, d.ihl = 1; })),
      foreign("ATcpFragment", frame(event([](Datagram& d) { d.protocol = 6; }).fragment(8, 16))),
      foreign("UdpLite", packet([](Datagram& d) { d.protocol = 136; })),
      foreign("Arp", ethernet(0x0806, Bytes(28))),
      foreign("Ipv6", ethernet(0x86dd, event().whole())),
      foreign("AnUnknownType", ethernet(0x88b5, event().whole())),
      foreign("ALengthInTheTypeField", ethernet(46, Bytes(46))),
      foreign("AShortFrame", ethernet(0x88b5, {0})),
      foreign("AwdsBeacon", ethernet(0x8334, Bytes(20, 0))),
      foreign("AwdsBeaconWithTrace", ethernet(0x8334, Bytes(20, 0x80))),
      foreign("AwdsTopology", ethernet(0x8334, awds_flood(0, Bytes(8)))),
      foreign("AwdsMetric", ethernet(0x8334, awds_flood(97, Bytes(8)))),
      foreign("AwdsPing", ethernet(0x8334, awds_unicast(42, Bytes(8)))),
      foreign("AwdsSubscription", ethernet(0x8334, awds_flood(0x7d, Bytes(8)))),
      foreign("ForeignTrafficInAwds",
              ethernet(0x8334, awds_unicast(98, ethernet(0x0806, Bytes(28))))),
      foreign("BatmanOriginator", ethernet(0x4305, batman(BATADV_IV_OGM, Bytes(20)))),
      foreign("BatmanOriginatorOfVersionFive", ethernet(0x4305, batman(BATADV_OGM2, Bytes(20)))),
      foreign("BatmanNeighbour", ethernet(0x4305, batman(BATADV_ELP, Bytes(20)))),
      foreign("BatmanPing", ethernet(0x4305, batman(BATADV_ICMP, Bytes(20)))),
      foreign("BatmanTables", ethernet(0x4305, batman(BATADV_UNICAST_TVLV, Bytes(20)))),
      foreign("ForeignTrafficInBatman",
              ethernet(0x4305, batman(BATADV_UNICAST, ethernet(0x0806, Bytes(28))))),
  };
}

std::vector<Row> malformed_rows() {
  const auto bad = [](std::string name, Bytes bytes) {
    return Row{std::move(name), {fragmented(in())}, kIn, std::move(bytes),
               kWire,           GATE_R_MALFORMED,   kOwn};
  };
  std::vector<Row> rows{
      bad("HeaderLengthTooShort", packet([](Datagram& d) { d.ihl = 4; })),
      bad("HeaderLengthBeyondThePacket", packet([](Datagram& d) { d.ihl = 15; })),
      bad("AnotherVersion", packet([](Datagram& d) { d.version = 6; })),
      bad("TotalLengthTooLong", packet([](Datagram& d) { d.longer_ip = 1; })),
      bad("TotalLengthTooShort", packet([](Datagram& d) { d.longer_ip = -1; })),
      bad("TotalLengthOfTheHeaderAlone", packet([](Datagram& d) { d.longer_ip = -25; })),
      bad("UdpLengthTooLong", packet([](Datagram& d) { d.longer_udp = 1; })),
      bad("UdpLengthTooShort", packet([](Datagram& d) { d.longer_udp = -1; })),
      bad("UdpLengthWithoutAnEvent", packet([](Datagram& d) { d.longer_udp = -17; })),
      bad("AFragmentBeyondAnyDatagram",
          frame(event([](Datagram& d) { d.payload = 65'600; }).fragment(65'528, 65'544))),
      bad("AFragmentOneOctetBeyondAnyDatagram",
          frame(event([](Datagram& d) { d.payload = 65'519; }).fragment(65'528, 65'536))),
      bad("ALaterFragmentThatEndsNowhere",
          frame(event([](Datagram& d) { d.payload = 65; }).fragment(64, 72 + 1))),
      bad("ADatagramThatEndsInItsSubject",
          packet([](Datagram& d) { d.longer_ip = d.longer_udp = -10; })),
      bad("ADatagramThatEndsBehindItsSubject",
          packet([](Datagram& d) { d.longer_ip = d.longer_udp = -9; })),
      bad("AFragmentThatEndsNowhere",
          frame(event([](Datagram& d) { d.payload = 65; }).fragment(0, 63))),
      bad("AFirstFragmentWithoutASubject", frame(event().fragment(0, 16))),
      bad("ATagWithoutRoom", cut(ethernet(0x8100, {}), 15)),
      bad("AwdsWithoutAKind", ethernet(0x8334, {1})),
      bad("BatmanWithoutAVersion", ethernet(0x4305, {BATADV_BCAST})),
      bad("BatmanThatEndsBehindItsHeader", ethernet(0x4305, batman(BATADV_BCAST, {}))),

      bad("AwdsEventThatIsCutOff", ethernet(0x8334, awds_flood(0x7c, awds_event(kSubject, 8, 1)))),
      bad("AwdsEventWithoutASubject",
          ethernet(0x8334, awds_flood(0x7c, awds_event(kSubject, 8, -9)))),
  };
  // Cut off within its headers, wherever that is. A test run itself refuses untagged ones.
  const Bytes good = ethernet(0x0800, event().whole(), {0x8100});
  for (std::size_t size = 15; size < 18 + 20 + 8 + 9; ++size)
    rows.push_back(bad("CutOffAt" + std::to_string(size), cut(good, size)));
  return rows;
}

std::vector<Row> carrier_rows() {
  const auto passes = [](std::string name, Bytes bytes) {
    return Row{std::move(name), {fragmented(in())}, kIn, std::move(bytes), kWire, GATE_R_PASSED};
  };
  const auto opaque = [](std::string name, Bytes bytes) {
    return Row{std::move(name), {fragmented(in())}, kIn, std::move(bytes),
               kWire,           GATE_R_OPAQUE,      kOwn};
  };
  const Bytes ip = event().whole();
  std::vector<Row> rows{
      passes("OneTag", ethernet(0x0800, ip, {0x8100})),
      passes("AServiceTag", ethernet(0x0800, ip, {0x88a8})),
      passes("TwoTags", ethernet(0x0800, ip, {0x88a8, 0x8100})),
      opaque("ThreeTags", ethernet(0x0800, ip, {0x88a8, 0x8100, 0x8100})),
      passes("PaddingBehindThePacket", cut(frame(ip), 14 + ip.size() + 12)),
      passes("InAnAwdsFlood", ethernet(0x8334, awds_flood(98, frame(ip)))),
      passes("InAnAwdsPacket", ethernet(0x8334, awds_unicast(98, frame(ip)))),
      passes("InAwdsWithTagsOnBothSides",
             ethernet(0x8334, awds_flood(98, ethernet(0x0800, ip, {0x8100})), {0x8100})),
      passes("AsAwdsEvent", ethernet(0x8334, awds_unicast(0x7c, awds_event(kSubject, 8)))),
      passes("AsAwdsFragment", ethernet(0x8334, awds_unicast(0x7b, awds_event(kSubject, 8)))),
      passes("AsAwdsEventWithPadding",
             cut(ethernet(0x8334, awds_unicast(0x7c, awds_event(kSubject, 0))), 64)),
      passes("InABatmanBroadcast", ethernet(0x4305, batman(BATADV_BCAST, frame(ip)))),
      passes("InABatmanPacket", ethernet(0x4305, batman(BATADV_UNICAST, frame(ip)))),
      passes("InABatmanPacketWithASource",
             ethernet(0x4305, batman(BATADV_UNICAST_4ADDR, frame(ip)))),
      passes("InBatmanWithTagsOnBothSides",
             ethernet(0x4305, batman(BATADV_UNICAST, ethernet(0x0800, ip, {0x8100})), {0x8100})),
      opaque("ABatmanFragment", ethernet(0x4305, batman(BATADV_UNICAST_FRAG, frame(ip)))),
      opaque("CodedBatman", ethernet(0x4305, batman(BATADV_CODED, frame(ip)))),
      opaque("AnUnknownTypeOfBatman", ethernet(0x4305, batman(0x60, frame(ip)))),
      opaque("AnotherVersionOfBatman", ethernet(0x4305, batman(BATADV_UNICAST, frame(ip), 16))),
      opaque("BatmanInBatman",
             ethernet(0x4305, batman(BATADV_BCAST, ethernet(0x4305, batman(BATADV_BCAST, {}))))),
      opaque("AwdsInBatman",
             ethernet(0x4305, batman(BATADV_BCAST, ethernet(0x8334, awds_flood(98, {}))))),
      opaque("BatmanInAwds",
             ethernet(0x8334, awds_flood(98, ethernet(0x4305, batman(BATADV_BCAST, {}))))),
      opaque("AwdsInAwds", ethernet(0x8334, awds_flood(98, ethernet(0x8334, awds_flood(98, {}))))),
      opaque("EncryptedAwds", ethernet(0x8334, awds_flood(99, Bytes(40)))),
      opaque("AnAwdsFlow", ethernet(0x8334, Bytes(40, 3))),
      opaque("AnUnknownKindOfAwds", ethernet(0x8334, awds_unicast(200, Bytes(40)))),
  };
  for (std::uint8_t options = 4; options <= 40; options += 4)
    rows.push_back(passes("OptionsOf" + std::to_string(options),
                          packet([=](Datagram& d) { d.options = options; })));
  Row unknown = passes("AwdsEventThatNobodyKnows",
                       ethernet(0x8334, awds_unicast(0x7c, awds_event(kSubject + 1, 8))));
  unknown.reason = GATE_R_UNKNOWN;
  unknown.own = true;
  rows.push_back(unknown);
  return rows;
}

class EtherFrames : public ::testing::TestWithParam<Row> {
 protected:
  static void check(LoadedEther& gate, const Row& row) {
    gate.admit(row.slots);
    const Outcome got = gate.run(row.direction, row.bytes, row.sender);
    const bool drops = core::is_drop(gates::reason_of(row.reason));
    EXPECT_EQ(got.dropped, drops);
    EXPECT_EQ(gate.reasons(row.direction).at(row.reason), 1U)
        << "not " << core::to_text(gates::reason_of(row.reason));
    const std::uint32_t mark = row.reason == GATE_R_PASSED && row.direction == kIn
                                   ? mark_from(kIfindex, row.slots.front().station)
                                   : 0;
    EXPECT_EQ(got.mark, mark);
    if (row.reason == GATE_R_FOREIGN) return;
    const auto counted = row.own ? gate.counted(row.direction) : gate.counted(row.slots.front());
    EXPECT_EQ(counted.passed, drops ? 0U : 1U);
    EXPECT_EQ(counted.dropped, drops ? 1U : 0U);
    EXPECT_EQ(counted.last_reason, gates::reason_of(row.reason));
  }
};

TEST_P(EtherFrames, Fate) { check(LoadedEther::with(), GetParam()); }
TEST_P(EtherFrames, FateByLoads) { check(LoadedEther::with({.direct_access = false}), GetParam()); }

/// The driver drops what ingress would, and leaves everything else to it.
TEST_P(EtherFrames, FateInTheDriver) {
  const Row& row = GetParam();
  if (row.direction == kOut) return;
  for (const bool direct : {true, false}) {
    LoadedEther& gate = LoadedEther::with({.direct_access = direct});
    gate.admit(row.slots);
    EXPECT_EQ(gate.dropped_early(row.bytes), core::is_drop(gates::reason_of(row.reason)));
    EXPECT_EQ(gate.reasons(kIn).at(GATE_R_PASSED), 0U) << "ingress counts what passes";
    EXPECT_EQ(gate.reasons(kIn).at(row.reason),
              core::is_drop(gates::reason_of(row.reason)) ? 1U : 0U);
  }
}

TEST(EtherAudit, WhatIngressRefusesIsCountedOnce) {
  LoadedEther& gate = LoadedEther::with();
  gate.admit({denied(in()), denied(from(kIfindex))});
  gate.control().mode = GATE_AUDIT;
  const Outcome in_ = gate.run(kIn, packet(), kWire);
  EXPECT_FALSE(in_.dropped);
  EXPECT_FALSE(gate.run(kOut, packet(), {.mark = in_.mark, .ingress_ifindex = kIfindex}).dropped);
  EXPECT_EQ(gate.would_drop(kIn).at(GATE_R_DENIED), 1U);
  EXPECT_EQ(gate.counted(denied(in())).would_drop, 1U);
  EXPECT_EQ(gate.counted(denied(in())).dropped, 0U);
  EXPECT_EQ(gate.reasons(kOut).at(GATE_R_ECHO), 1U);
  EXPECT_EQ(gate.counted(denied(from(kIfindex))).would_drop, 0U);
  gate.control().mode = GATE_ENFORCE;
  EXPECT_TRUE(gate.run(kOut, packet(), {.mark = in_.mark, .ingress_ifindex = kIfindex}).dropped)
      << "a mark opens nothing";
}

TEST(EtherAudit, WhatIsTooMuchGoesOnAsWhatItIs) {
  const auto policed = with(in(), [](SlotSpec& s) { s.per_frame = 3'600'000'000'000; });
  LoadedEther& gate = LoadedEther::with();
  gate.admit({policed});
  gate.control().mode = GATE_AUDIT;
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(gate.run(kIn, packet(), kWire), (Outcome{.dropped = false, .mark = kAdmitted}));
  EXPECT_EQ(gate.counted(policed).would_exceed, 2U);
  EXPECT_EQ(gate.counted(policed).would_drop, 2U);
  EXPECT_EQ(gate.counted(policed).excess, 0U);
}

/// An event of one station comes in, and leaves with the address of another.
TEST(EtherStations, NoneLeavesAsAnotherOfItsSubject) {
  constexpr std::uint32_t first = 0x0a000001;
  constexpr std::uint32_t second = 0x0a000002;
  LoadedEther& gate = LoadedEther::with();
  for (const std::uint64_t station : {first, second, 0U})
    for (const SlotSpec& s : {in(), from(kIfindex)})
      gate.admit({with(s, [=](SlotSpec& t) { t.station = station; })});
  const auto of = [](std::uint32_t station) {
    return event([=](Datagram& d) { d.source = station; });
  };
  const auto leaves = [&](const Datagram& entering, const Datagram& leaving) {
    const std::uint32_t mark = gate.run(kIn, frame(entering.whole()), kWire).mark;
    return !gate.run(kOut, frame(leaving.whole()), {.mark = mark, .ingress_ifindex = kIfindex})
                .dropped;
  };
  constexpr std::uint32_t other = 0x0a000003;
  for (const std::uint32_t from : {first, second, other})
    for (const std::uint32_t to : {first, second, other})
      EXPECT_EQ(leaves(of(from), of(to)), from == to) << from << " as " << to;
}

TEST(EtherStations, OneThatBabblesTakesNothingFromAnother) {
  constexpr std::uint64_t hour = 3'600'000'000'000;
  const auto of = [](std::uint64_t station) {
    return with(in(), [=](SlotSpec& s) {
      s.station = station;
      s.per_frame = hour;
      s.tolerance = hour;
    });
  };
  LoadedEther& gate = LoadedEther::with();
  gate.admit({of(0x0a000001), of(0x0a000002), of(0)});
  const auto passed = [&](std::uint32_t station, int events) {
    int out = 0;
    for (int i = 0; i < events; ++i)
      out += gate.run(kIn, packet([=](Datagram& d) { d.source = station; }), kWire).dropped ? 0 : 1;
    return out;
  };
  EXPECT_EQ(passed(0x0a000001, 100), 2) << "one, and one that is early";
  EXPECT_EQ(passed(0x0a000002, 2), 2);
  EXPECT_EQ(passed(0x0a000003, 1), 1);
  EXPECT_EQ(passed(0x0a000004, 2), 1) << "all others are one";
  EXPECT_EQ(gate.counted(of(0x0a000001)).excess, 98U);
  EXPECT_EQ(gate.counted(of(0x0a000002)).excess, 0U);
}

std::string name_of(const ::testing::TestParamInfo<Row>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Subject, EtherFrames, ::testing::ValuesIn(subject_rows()), name_of);
INSTANTIATE_TEST_SUITE_P(Sender, EtherFrames, ::testing::ValuesIn(sender_rows()), name_of);
INSTANTIATE_TEST_SUITE_P(Station, EtherFrames, ::testing::ValuesIn(station_rows()), name_of);
INSTANTIATE_TEST_SUITE_P(Foreign, EtherFrames, ::testing::ValuesIn(foreign_rows()), name_of);
INSTANTIATE_TEST_SUITE_P(Malformed, EtherFrames, ::testing::ValuesIn(malformed_rows()), name_of);
INSTANTIATE_TEST_SUITE_P(Carrier, EtherFrames, ::testing::ValuesIn(carrier_rows()), name_of);

}  // namespace
}  // namespace mlcca::test
