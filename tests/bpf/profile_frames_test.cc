// SPDX-License-Identifier: BSD-2-Clause
// What each profile takes for one subject, held against identifiers that the public documents work
// out themselves; masked slots, CAN XL, and every length.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "daemon/gates/counters.hpp"
#include "tests/bpf/loaded_gate.hpp"

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::SlotSpec;

constexpr std::uint32_t kEff = CAN_EFF_FLAG;
constexpr std::uint32_t kForm = CAN_EFF_FLAG | CAN_RTR_FLAG;
constexpr std::uint32_t kWhole = kForm | CAN_EFF_MASK;

SlotSpec slot(std::uint32_t id, std::uint32_t mask = kWhole) {
  SlotSpec s;
  s.pass = true;
  s.id = id & mask;
  s.mask = mask;
  s.subject = 1;
  return s;
}
SlotSpec denied(SlotSpec s) {
  s.pass = false;
  return s;
}

struct Row {
  std::string name;
  std::uint32_t profile;
  std::vector<SlotSpec> slots;
  std::uint32_t can_id;
  gate_reason reason;
};

// --- SAE J1939-21
// ---------------------------------------------------------------------------------
// priority 26..28, extended data page 25, data page 24, PDU format 16..23, PDU specific 8..15,
// source 0..7. Identifiers as in the J1939 chapter of the kernel's documentation
// (Documentation/networking/j1939.rst) and in SAE J1939-71, -73 and -81.

constexpr std::uint32_t kNoPriority = ~0x1c000000U;
constexpr std::uint32_t kNoDestination = ~0xff00U;

std::vector<Row> j1939_rows() {
  const auto row = [](std::string name, std::vector<SlotSpec> slots, std::uint32_t id,
                      gate_reason reason) {
    return Row{"J1939" + std::move(name), GATE_PROFILE_J1939, std::move(slots), id, reason};
  };
  // EEC1 (PGN 61444, 0xF004) of the engine: 0CF00400.
  const auto eec1 = slot(kEff | 0x0cf00400);
  const auto any_priority = slot(kEff | 0x0cf00400, kWhole & kNoPriority);
  // TSC1 (PGN 0): 0C000003 from the transmission (3) to the engine (0).
  const auto tsc1 = slot(kEff | 0x0c000003, kWhole & kNoDestination);
  // Address claimed (PGN 60928, 0xEE00), always to all: 18EEFF80.
  const auto claim = slot(kEff | 0x18eeff00, kWhole & ~0xffU);
  return {
      row("BroadcastPasses", {eec1}, kEff | 0x0cf00400, GATE_R_PASSED),
      row("BroadcastOfAnotherSource", {eec1}, kEff | 0x0cf00401, GATE_R_IDENTIFIER),
      row("BroadcastOfAnotherPriority", {eec1}, kEff | 0x18f00400, GATE_R_IDENTIFIER),
      row("AnyPriorityPasses", {any_priority}, kEff | 0x1cf00400, GATE_R_PASSED),
      row("AnyPriorityOfAnotherSource", {any_priority}, kEff | 0x1cf00401, GATE_R_IDENTIFIER),
      row("GroupExtensionIsPartOfThePgn", {eec1}, kEff | 0x0cf00300, GATE_R_UNKNOWN),
      row("DataPageIsPartOfThePgn", {eec1}, kEff | 0x0df00400, GATE_R_UNKNOWN),
      row("ExtendedDataPageIsPartOfThePgn", {eec1}, kEff | 0x0ef00400, GATE_R_UNKNOWN),
      row("StandardFrame", {eec1}, 0x400, GATE_R_UNKNOWN),
      row("RemoteFrame", {eec1}, kForm | 0x0cf00400, GATE_R_IDENTIFIER),
      row("DestinationIsNoPartOfThePgn", {tsc1}, kEff | 0x0c00ff03, GATE_R_PASSED),
      row("FixedDestination", {slot(kEff | 0x0c000003)}, kEff | 0x0c00ff03, GATE_R_UNKNOWN),
      row("FixedDestinationFromAnotherSource", {slot(kEff | 0x0c000003)}, kEff | 0x0c000004,
          GATE_R_IDENTIFIER),
      row("ClaimOfAnyNode", {claim}, kEff | 0x18eeff80, GATE_R_PASSED),
      row("ClaimOfNullAddress", {claim}, kEff | 0x18eefffe, GATE_R_PASSED),
      row("ClaimToOne", {claim}, kEff | 0x18ee0180, GATE_R_UNKNOWN),
      // PDU format 239 is the last with a destination, 240 the first without (J1939-21, 5.3).
      row("Format239HasADestination", {slot(kEff | 0x18ef0080, kWhole & kNoDestination)},
          kEff | 0x18ef2180, GATE_R_PASSED),
      row("Format240HasNone", {slot(kEff | 0x18f00080)}, kEff | 0x18f02180, GATE_R_UNKNOWN),
      row("LastPgn", {slot(kEff | 0x1bffff80)}, kEff | 0x1bffff80, GATE_R_PASSED),
  };
}

// --- Cyphal/CAN
// ----------------------------------------------------------------------------------- The Cyphal
// Specification v1.0, section 4.2: priority 26..28, service 25, anonymous 24, reserved 23
// (0), 22..21 (1, receivers ignore them), subject-id 8..20, reserved 7 (0), source 0..6. Its
// examples: heartbeat (subject 7509) of node 42: 107D552A; String (subject 4919) of node 59:
// 1013373B, anonymous: 11133775; GetInfo (a service) 136B957B.

std::vector<Row> cyphal_rows() {
  const auto row = [](std::string name, std::vector<SlotSpec> slots, std::uint32_t id,
                      gate_reason reason) {
    return Row{"Cyphal" + std::move(name), GATE_PROFILE_CYPHAL, std::move(slots), id, reason};
  };
  constexpr std::uint32_t ignored = 0x600000;
  const auto heartbeat = slot(kEff | 0x107d552a, kWhole & ~ignored);
  const auto text = slot(kEff | 0x1013373b, kWhole & ~ignored);
  const auto any_text = slot(kEff | 0x10133700, kWhole & ~ignored & ~0x100007fU);
  return {
      row("HeartbeatPasses", {heartbeat}, kEff | 0x107d552a, GATE_R_PASSED),
      row("MessagePasses", {text}, kEff | 0x1013373b, GATE_R_PASSED),
      row("IgnoredBitsAreIgnored", {text}, kEff | 0x1073373b, GATE_R_PASSED),
      row("AnotherNode", {heartbeat}, kEff | 0x107d552b, GATE_R_IDENTIFIER),
      row("AnotherPriority", {heartbeat}, kEff | 0x0c7d552a, GATE_R_IDENTIFIER),
      row("AnotherSubject", {heartbeat}, kEff | 0x107d542a, GATE_R_UNKNOWN),
      row("AnonymousIsNotTheNode", {text}, kEff | 0x1113373b, GATE_R_IDENTIFIER),
      row("AnonymousPassesWhereGranted", {any_text}, kEff | 0x11133775, GATE_R_PASSED),
      row("ServiceHasNoSubject", {heartbeat, text}, kEff | 0x136b957b, GATE_R_UNKNOWN),
      row("ServiceBitOnTheHeartbeat", {heartbeat}, kEff | 0x127d552a, GATE_R_UNKNOWN),
      row("ReservedBit23", {heartbeat}, kEff | 0x10fd552a, GATE_R_UNKNOWN),
      row("ReservedBit7", {heartbeat}, kEff | 0x107d55aa, GATE_R_UNKNOWN),
      row("LastSubject", {slot(kEff | 0x101fff7f)}, kEff | 0x101fff7f, GATE_R_PASSED),
      row("StandardFrame", {heartbeat}, 0x52a, GATE_R_UNKNOWN),
  };
}

// --- CANopen
// -------------------------------------------------------------------------------------- CiA 301
// v4.2, table 39: NMT 000, SYNC 080, EMCY 081..0FF, TIME 100, PDO 181..57F, SDO 581..67F, NMT error
// control 701..77F.

std::vector<Row> canopen_rows() {
  const auto row = [](std::string name, std::vector<SlotSpec> slots, std::uint32_t id,
                      gate_reason reason) {
    return Row{"Canopen" + std::move(name), GATE_PROFILE_CANOPEN, std::move(slots), id, reason};
  };
  const auto emergencies = slot(0x80, kForm | 0x1fffff80);
  const auto error_control = slot(0x700, kForm | 0x1fffff80);
  return {
      row("NmtPasses", {slot(0)}, 0, GATE_R_PASSED),
      row("PdoPasses", {slot(0x181)}, 0x181, GATE_R_PASSED),
      row("PdoOfAnotherNode", {slot(0x181)}, 0x182, GATE_R_UNKNOWN),
      row("RemotePdo", {slot(0x181)}, CAN_RTR_FLAG | 0x181, GATE_R_IDENTIFIER),
      row("ExtendedFrame", {slot(0x181)}, kEff | 0x181, GATE_R_UNKNOWN),
      row("ExtendedFrameMeetsNoMask", {error_control}, kEff | 0x701, GATE_R_UNKNOWN),
      row("FirstEmergency", {emergencies}, 0x081, GATE_R_PASSED),
      row("LastEmergency", {emergencies}, 0x0ff, GATE_R_PASSED),
      row("TimeIsNoEmergency", {emergencies}, 0x100, GATE_R_UNKNOWN),
      row("SyncThatIsRefusedIsNoEmergency", {emergencies, denied(slot(0x80))}, 0x080,
          GATE_R_DENIED),
      row("LastHeartbeat", {error_control}, 0x77f, GATE_R_PASSED),
      row("LssIsNoHeartbeat", {error_control}, 0x7e5, GATE_R_UNKNOWN),
  };
}

// --- masks and control traffic -------------------------------------------------------------------

std::vector<Row> masked_rows() {
  const auto row = [](std::string name, std::vector<SlotSpec> slots, std::uint32_t id,
                      gate_reason reason) {
    return Row{"Masked" + std::move(name), GATE_PROFILE_RAW, std::move(slots), id, reason};
  };
  const auto standard = slot(0x120, kForm | 0x1ffffff0);
  const auto extended = slot(kEff | 0x1abcd00, kForm | 0x1fffff00);
  std::vector<SlotSpec> full;
  for (std::uint32_t i = 0; i < GATE_WALK; ++i) full.push_back(slot(i << 4, kForm | 0x1ffffff0));
  return {
      row("FirstOfAMaskPasses", {standard}, 0x120, GATE_R_PASSED),
      row("LastOfAMaskPasses", {standard}, 0x12f, GATE_R_PASSED),
      row("BelowTheMask", {standard}, 0x11f, GATE_R_UNKNOWN),
      row("AboveTheMask", {standard}, 0x130, GATE_R_UNKNOWN),
      row("ExtendedMeetsNoStandardMask", {standard}, kEff | 0x120, GATE_R_UNKNOWN),
      row("ExtendedPasses", {extended}, kEff | 0x1abcdef, GATE_R_PASSED),
      row("StandardMeetsNoExtendedMask", {slot(kEff, kForm | 0x1ffff800)}, 0x12, GATE_R_UNKNOWN),
      row("RemoteFrame", {standard}, CAN_RTR_FLAG | 0x123, GATE_R_IDENTIFIER),
      row("ExactSlotIsAskedFirst", {standard, slot(0x123)}, 0x123, GATE_R_PASSED),
      row("NameThatIsRefusedIsNotOpenedByAMask", {standard, denied(slot(0x123))}, 0x123,
          GATE_R_DENIED),
      row("NeighbourOfARefusedNamePasses", {standard, denied(slot(0x123))}, 0x124, GATE_R_PASSED),
      row("OfTwoMasksThatPass", {denied(standard), slot(0x100, kForm | 0x1fffff00)}, 0x123,
          GATE_R_PASSED),
      row("FirstOfAFullChain", full, 0x005, GATE_R_PASSED),
      row("LastOfAFullChain", full, (GATE_WALK - 1) << 4, GATE_R_PASSED),
      row("BehindAFullChain", full, GATE_WALK << 4, GATE_R_UNKNOWN),
  };
}

// The 29-bit identifiers of FAMOUSO's configuration and binding, as the reference sends them.
std::vector<Row> famouso_rows() {
  const auto row = [](std::string name, std::vector<SlotSpec> slots, std::uint32_t id,
                      gate_reason reason) {
    return Row{"Famouso" + std::move(name), GATE_PROFILE_FAMOUSO, std::move(slots), id, reason};
  };
  const auto request = slot(kEff | 0x1f400001, kWhole & ~0x3fc000U);
  const auto get = slot(kEff | 0x1f400002, kWhole & ~0x1fc000U);
  return {
      row("StageRequestPasses", {request}, kEff | 0x1f7d4001, GATE_R_PASSED),
      row("LastStageRequestPasses", {request}, kEff | 0x1f404001, GATE_R_PASSED),
      row("StageRequestOfRealTime", {request}, kEff | 0x003d4001, GATE_R_IDENTIFIER),
      row("TagRequestPasses", {get}, kEff | 0x1f5f4002, GATE_R_PASSED),
      row("TagRequestIsNoFragment", {get}, kEff | 0x1f7f4002, GATE_R_IDENTIFIER),
      row("TagReplyPasses", {slot(kEff | 0x1f5fc004)}, kEff | 0x1f5fc004, GATE_R_PASSED),
      row("TagReplyOfAnotherNode", {slot(kEff | 0x1f5fc004)}, kEff | 0x1f5f4004, GATE_R_IDENTIFIER),
  };
}

std::vector<Row> all_rows() {
  std::vector<Row> rows;
  for (auto& part : {j1939_rows(), cyphal_rows(), canopen_rows(), masked_rows(), famouso_rows()})
    rows.insert(rows.end(), part.begin(), part.end());
  return rows;
}

class ProfileFrames : public ::testing::TestWithParam<Row> {};

TEST_P(ProfileFrames, AreJudgedAlikeInBothDirections) {
  for (const auto direction : {Direction::ingress, Direction::egress}) {
    auto slots = GetParam().slots;
    for (auto& s : slots) s.direction = direction;
    auto& gate = LoadedGate::with({.profile = GetParam().profile});
    gate.admit(slots);
    const bool out = direction == Direction::egress;
    const auto outcome = gate.run(direction, frame(GetParam().can_id, 8), {.local = out});
    EXPECT_EQ(outcome.dropped, GetParam().reason != GATE_R_PASSED);
    EXPECT_EQ(gates::reason_counters(gate.cpus(), direction).at(GetParam().reason), 1U);
  }
}

INSTANTIATE_TEST_SUITE_P(Documents, ProfileFrames, ::testing::ValuesIn(all_rows()),
                         [](const auto& row) { return row.param.name; });

// --- what the kernel itself sends ----------------------------------------------------------------

TEST(FramesOfTheKernel, LeaveOnlyWhereASlotNamesIt) {
  auto& gate = LoadedGate::with({.profile = GATE_PROFILE_J1939});
  auto transport = slot(kEff | 0x18ecff80);
  transport.direction = Direction::egress;
  transport.source = GATE_NO_SOURCE;
  auto local = slot(kEff | 0x18ebff80);
  local.direction = Direction::egress;
  gate.admit({transport, local});
  const auto dropped = [&](std::uint32_t id, const Sender& sender) {
    return gate.run(Direction::egress, frame(id, 8), sender).dropped;
  };
  EXPECT_FALSE(dropped(transport.id, {}));
  EXPECT_TRUE(dropped(transport.id, {.local = true}));
  EXPECT_TRUE(dropped(transport.id, {.ingress_ifindex = kOther}));
  EXPECT_TRUE(dropped(local.id, {}));
}

// --- CAN XL (CiA 610-1): 11 bits of priority, 1 to 2048 bytes ------------------------------------

class XlFrames : public ::testing::Test {
 protected:
  static SlotSpec xl_slot(unsigned max_len, std::uint8_t formats = GATE_XL) {
    auto s = slot(0x123, kForm | CAN_EFF_MASK);
    s.max_len = static_cast<std::uint16_t>(max_len);
    s.formats = formats;
    return s;
  }
  gate_reason reason(const Bytes& bytes, Direction direction = Direction::ingress) {
    const auto before = gates::reason_counters(gate_.cpus(), direction);
    gate_.run(direction, bytes, {.local = direction == Direction::egress, .xl = true});
    const auto after = gates::reason_counters(gate_.cpus(), direction);
    for (std::size_t r = 0; r < after.size(); ++r)
      if (after.at(r) != before.at(r)) return static_cast<gate_reason>(r);
    return GATE_REASONS;
  }
  LoadedGate& gate_ = LoadedGate::with();
};

TEST_F(XlFrames, EveryLengthUpToTheGrantPasses) {
  // Less than 14 bytes BPF_PROG_TEST_RUN does not take: a length of 1 stands behind a lead.
  for (const unsigned most : {1U, 8U, 64U, 65U, 255U, 256U, 2047U, 2048U}) {
    auto grant = xl_slot(most);
    gate_.reset();
    gate_.admit({grant});
    for (unsigned len = 1; len <= 2048; ++len)
      ASSERT_EQ(reason(xl_frame(0x123, len, len == 1 ? 16 : 0)),
                len <= most ? GATE_R_PASSED : GATE_R_LENGTH)
          << len << " of " << most;
  }
}

TEST_F(XlFrames, CountTheirPayload) {
  gate_.admit({xl_slot(2048)});
  reason(xl_frame(0x123, 2048));
  reason(xl_frame(0x123, 300));
  const auto number = gate_.slots().find(xl_slot(2048)).value();
  EXPECT_EQ(gates::slot_counters(gate_.table(), gate_.cpus(), number).bytes, 2348U);
  reason(xl_frame(0x124, 2000));
  EXPECT_EQ(gates::unknown_frames(gate_.cpus()).at(0).len, 2000U);
  EXPECT_EQ(gates::unknown_frames(gate_.cpus()).at(0).format, GATE_XL);
}

TEST_F(XlFrames, AreAFormatOfTheirOwn) {
  gate_.admit({xl_slot(8, GATE_CLASSIC | GATE_FD)});
  EXPECT_EQ(reason(xl_frame(0x123, 8)), GATE_R_FORMAT);
  gate_.reset();
  gate_.admit({xl_slot(8)});
  EXPECT_TRUE(gate_.run(Direction::ingress, frame(0x123, 8)).dropped);
  EXPECT_TRUE(gate_.run(Direction::ingress, frame(0x123, 8, true)).dropped);
  // What says that it is classic or FD and has the XL flag where their length stands.
  Bytes forged = xl_frame(0x123, 4);
  EXPECT_TRUE(gate_.run(Direction::ingress, forged).dropped);
  EXPECT_EQ(gates::reason_counters(gate_.cpus(), Direction::ingress).at(GATE_R_MALFORMED), 1U);
}

TEST_F(XlFrames, OfAnotherNetworkNumberAreUnknown) {
  gate_.admit({xl_slot(8)});
  EXPECT_EQ(reason(xl_frame(0x00010123, 8)), GATE_R_UNKNOWN);
  auto second = xl_slot(8);
  second.mask &= ~0x00ff0000U;
  gate_.reset();
  gate_.admit({second});
  EXPECT_EQ(reason(xl_frame(0x00010123, 8)), GATE_R_PASSED) << "where the grant leaves it open";
}

TEST_F(XlFrames, PassAMask) {
  auto mask = xl_slot(64);
  mask.id = 0x120;
  mask.mask = kForm | 0x1ffffff0;
  gate_.admit({mask});
  EXPECT_EQ(reason(xl_frame(0x12f, 64)), GATE_R_PASSED);
  EXPECT_EQ(reason(xl_frame(0x130, 64)), GATE_R_UNKNOWN);
}

TEST_F(XlFrames, ThatAreNoneAreMalformed) {
  gate_.admit({xl_slot(2048)});
  const auto spoilt = [](std::size_t at, std::uint8_t value) {
    auto bytes = xl_frame(0x123, 64);
    bytes[at] = value;
    return bytes;
  };
  EXPECT_EQ(reason(spoilt(4, 0x7f)), GATE_R_MALFORMED) << "no XL flag";
  EXPECT_EQ(reason(spoilt(6, 63)), GATE_R_MALFORMED) << "shorter than what is there";
  EXPECT_EQ(reason(spoilt(6, 65)), GATE_R_MALFORMED) << "longer than what is there";
  EXPECT_EQ(reason(spoilt(1, 0x08)), GATE_R_MALFORMED) << "a priority of 12 bits";
  EXPECT_EQ(reason(spoilt(3, 0x80)), GATE_R_MALFORMED) << "a flag that XL has not";
  EXPECT_EQ(reason(spoilt(3, 0x20)), GATE_R_MALFORMED) << "no error frame";
  auto empty = xl_frame(0x123, 2);
  empty[6] = 0;
  EXPECT_EQ(reason(empty), GATE_R_MALFORMED);
  EXPECT_EQ(reason(xl_frame(0x123, 2049)), GATE_R_MALFORMED);
}

TEST_F(XlFrames, BehindADriversDataPassIngressOnly) {
  auto out = xl_slot(64);
  out.direction = Direction::egress;
  gate_.admit({xl_slot(64), out});
  EXPECT_EQ(reason(xl_frame(0x123, 64, 16)), GATE_R_PASSED);
  EXPECT_EQ(reason(xl_frame(0x123, 64, 8)), GATE_R_MALFORMED);
  EXPECT_EQ(reason(xl_frame(0x123, 64), Direction::egress), GATE_R_PASSED);
  EXPECT_EQ(reason(xl_frame(0x123, 64, 16), Direction::egress), GATE_R_MALFORMED);
}

TEST_F(XlFrames, ThatHoldAnotherOneAreNotTakenForIt) {
  auto outer = xl_slot(2048);
  outer.id = 0x100;
  gate_.admit({outer, xl_slot(2048)});
  // A frame of 0x7ff whose payload resembles one of 0x123 behind a driver's data.
  auto bytes = xl_frame(0x7ff, 64);
  const auto inner = xl_frame(0x123, 64 - 16);
  std::copy(inner.begin(), inner.begin() + 12, bytes.begin() + 16);
  EXPECT_EQ(reason(bytes), GATE_R_MALFORMED);
  EXPECT_EQ(reason(xl_frame(0x7ff, 64)), GATE_R_UNKNOWN);
}

// --- every length of the other formats
// ------------------------------------------------------------

TEST(LengthOfAFrame, UpToTheGrantPasses) {
  for (const bool fd : {false, true}) {
    const unsigned longest = fd ? 64 : 8;
    for (unsigned most = 0; most <= longest; ++most) {
      auto grant = slot(0x123);
      grant.formats = fd ? GATE_FD : GATE_CLASSIC;
      grant.max_len = static_cast<std::uint16_t>(most);
      auto& gate = LoadedGate::with();
      gate.admit({grant});
      for (unsigned len = 0; len <= longest; ++len)
        ASSERT_EQ(gate.run(Direction::ingress, frame(0x123, len, fd)).dropped, len > most)
            << len << " of " << most;
    }
  }
}

}  // namespace
}  // namespace mlcca::test
