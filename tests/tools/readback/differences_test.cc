// SPDX-License-Identifier: BSD-2-Clause
// Slot by slot: each difference is one line, with what is and what ought to be.
#include "tools/readback/differences.hpp"

#include <gtest/gtest.h>
#include <linux/can.h>

#include <string>

#include "bpf/ether.h"
#include "daemon/store/records.hpp"

namespace mlcca::readback {
namespace {

using gates::Direction;
using gates::GateReading;
using gates::SlotSpec;
using Lines = std::vector<std::string>;

SlotSpec slot(std::uint32_t id = 0x123, std::uint64_t subject = 7) {
  SlotSpec s;
  s.pass = true;
  s.id = id;
  s.mask = CAN_EFF_FLAG | CAN_SFF_MASK;
  s.subject = subject;
  s.per_frame = 1000;
  s.tolerance = 5;
  return s;
}
SlotSpec out(SlotSpec s, std::uint32_t source) {
  s.direction = Direction::egress;
  s.source = source;
  return s;
}
template <class Change>
SlotSpec but(SlotSpec s, const Change& change) {
  change(s);
  return s;
}
GateReading gate(std::vector<SlotSpec> slots) {
  GateReading g;
  g.ifindex = 3;
  g.interface = "can0";
  g.readable = true;
  g.slots = std::move(slots);
  return g;
}
Lines between(const std::vector<SlotSpec>& is, const std::vector<SlotSpec>& ought,
              bool ethernet = false) {
  GateReading g = gate(is);
  g.ethernet = ethernet;
  return differences(g, ought, [](std::uint32_t n) { return "can" + std::to_string(n); });
}
const std::string kIn = "can0 ingress 0x0000000000000007: ";

TEST(Differences, OfWhatIsAsItOughtToBeAreNone) {
  EXPECT_EQ(between({}, {}), Lines{});
  EXPECT_EQ(between({slot(), out(slot(), 4)}, {out(slot(), 4), slot()}), Lines{});
}

TEST(Differences, EachPartOfASlotIsCompared) {
  const SlotSpec good = out(slot(), 4);
  const auto line = [&](const auto& change) {
    const Lines lines = between({but(good, change)}, {good});
    return lines.size() == 1 ? lines[0] : std::to_string(lines.size()) + " lines";
  };
  const std::string at = "can0 egress 0x0000000000000007: ";
  EXPECT_EQ(line([](SlotSpec& s) { s.pass = false; }),
            at + "is verdict deny; ought to be verdict pass");
  EXPECT_EQ(line([](SlotSpec& s) { s.id = 0x124; }),
            at + "is identifier 0x124; ought to be identifier 0x123");
  EXPECT_EQ(line([](SlotSpec& s) { s.mask = 0x700; }),
            at + "is mask 0x700; ought to be mask 0x800007ff");
  EXPECT_EQ(line([](SlotSpec& s) { s.source = 5; }),
            at + "is source can5; ought to be source can4");
  EXPECT_EQ(line([](SlotSpec& s) { s.source = 0; }),
            at + "is source a local program; ought to be source can4");
  EXPECT_EQ(line([](SlotSpec& s) { s.source = GATE_NO_SOURCE; }),
            at + "is source the kernel; ought to be source can4");
  EXPECT_EQ(line([](SlotSpec& s) { s.origin = 0x12; }),
            at + "is origin 0x12; ought to be no origin");
  EXPECT_EQ(line([](SlotSpec& s) { s.uid = 0; }), at + "is user 0; ought to be any user");
  EXPECT_EQ(line([](SlotSpec& s) { s.station = 0xc0000207; }),
            at + "is station 192.0.2.7; ought to be any station");
  EXPECT_EQ(line([](SlotSpec& s) { s.max_len = 64; }), at + "is length 64; ought to be length 8");
  EXPECT_EQ(line([](SlotSpec& s) { s.formats = GATE_FD | GATE_XL; }),
            at + "is formats FD XL; ought to be formats classic");
  EXPECT_EQ(line([](SlotSpec& s) { s.per_frame = 1; }),
            at + "is 1 ns a frame; ought to be 1000 ns a frame");
  EXPECT_EQ(line([](SlotSpec& s) { s.per_byte = 3; }),
            at + "is 3/256 ns a byte; ought to be 0/256 ns a byte");
  EXPECT_EQ(line([](SlotSpec& s) { s.tolerance = 6; }),
            at + "is tolerance 6 ns; ought to be tolerance 5 ns");
  EXPECT_EQ(line([](SlotSpec& s) { s.excess_passes = true; }),
            at + "is excess passes; ought to be excess dropped");
  EXPECT_EQ(line([](SlotSpec& s) { s.period = 9; }),
            at + "is period 9 ns; ought to be period 0 ns");
  EXPECT_EQ(line([](SlotSpec& s) { s.silence = 9; }),
            at + "is timeout 9 ns; ought to be timeout 0 ns");
  EXPECT_EQ(line([](SlotSpec& s) { s.together = 9; }),
            at + "is together 9 ns; ought to be together 0 ns");
}

TEST(Differences, SeveralInOneSlotAreOneLine) {
  EXPECT_EQ(between({but(slot(), [](SlotSpec& s) { s.id = 1, s.per_frame = 0; })}, {slot()}),
            Lines{kIn + "is identifier 0x1, 0 ns a frame; ought to be identifier 0x123, 1000 ns a "
                        "frame"});
}

TEST(Differences, SlotsThatAreTooManyOrMissingAreReported) {
  const std::string all =
      "verdict pass, identifier 0x123, mask 0x800007ff, source a local program, any user, no "
      "origin, any station, "
      "length 8, formats classic, 1000 ns a frame, 0/256 ns a byte, tolerance 5 ns, excess "
      "dropped, "
      "period 0 ns, timeout 0 ns, together 0 ns";
  EXPECT_EQ(between({slot()}, {}), Lines{kIn + "is " + all + "; ought not to be there"});
  EXPECT_EQ(between({}, {slot()}), Lines{kIn + "is not there; ought to be " + all});
}

TEST(Differences, OfSeveralSlotsTheAlteredOneIsComparedWithItsOwn) {
  const SlotSpec altered = but(slot(0x200), [](SlotSpec& s) { s.max_len = 7; });
  EXPECT_EQ(between({slot(0x100), altered, slot(0x300)}, {slot(0x300), slot(0x200), slot(0x100)}),
            Lines{kIn + "is length 7; ought to be length 8"});
}

TEST(Differences, PublishersWithOneGrantShareASlot) {
  const SlotSpec refused = but(slot(), [](SlotSpec& s) { s.pass = false; });
  EXPECT_EQ(between({slot()}, {refused, slot()}), Lines{});
  EXPECT_EQ(between({slot()}, {refused, refused}).size(), 1U);
}

TEST(Differences, AnEthernetGateThatWatchesAllItCanLacksNone) {
  std::vector<SlotSpec> ought;
  for (std::uint64_t n = 0; n < ETHER_WATCHES; ++n)
    ought.push_back(but(slot(0, n), [](SlotSpec& s) { s.period = 9; }));
  auto is = ought;
  is.back().period = 0;
  EXPECT_EQ(between(is, ought, true), Lines{});
  EXPECT_EQ(between(is, ought).size(), 1U) << "on CAN there is a watch for each";
  is.front().period = 0;
  EXPECT_EQ(between(is, ought, true).size(), 2U) << "there was room for one of them";
}

store::Contents journal_of(const std::vector<gates::PlacedSlot>& slots) {
  store::Contents journal;
  journal.gated = {{"name can0", {"name can0", "robot", "can0", 3}}};
  if (!slots.empty()) journal.enforced = {{7, store::record_of(slots)}};
  return journal;
}
Lines problems(const GateReading& g, const store::Contents& journal) {
  gates::Reading reading;
  reading.gates = {g};
  compare_slots(reading, journal);
  Lines all = reading.problems;
  all.insert(all.end(), reading.gates[0].problems.begin(), reading.gates[0].problems.end());
  return all;
}

TEST(CompareSlots, TakesWhatTheJournalSaysOfThisInterface) {
  const SlotSpec elsewhere = slot(0x200);
  const auto journal = journal_of({{3, slot()}, {4, elsewhere}});
  EXPECT_EQ(problems(gate({slot()}), journal), Lines{});
  EXPECT_EQ(problems(gate({slot(0x124)}), journal),
            Lines{kIn + "is identifier 0x124; ought to be identifier 0x123"});
  EXPECT_EQ(problems(gate({}), journal).size(), 1U);
}

TEST(CompareSlots, AnInterfaceThatIsNoPortAndATableThatCannotBeReadAreLeftOut) {
  auto journal = journal_of({{3, slot()}});
  GateReading broken = gate({});
  broken.readable = false;
  EXPECT_EQ(problems(broken, journal), Lines{});
  journal.gated.clear();
  EXPECT_EQ(problems(gate({slot(0x124)}), journal), Lines{});
}

TEST(CompareSlots, AJournalWithoutSlotsIsReportedOnce) {
  EXPECT_EQ(problems(gate({}), journal_of({})), Lines{});
  const auto found = problems(gate({slot(), slot(0x124)}), journal_of({}));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NE(found[0].find("did not write them down, restart it"), std::string::npos) << found[0];
}

TEST(CompareSlots, OctetsThatAreNotUnderstoodAreReported) {
  auto journal = journal_of({});
  journal.enforced = {{7, "\x80"}};
  EXPECT_EQ(problems(gate({}), journal),
            Lines{"what the journal says of the slots of subject 0x0000000000000007 is not "
                  "understood"});
}

}  // namespace
}  // namespace mlcca::readback
