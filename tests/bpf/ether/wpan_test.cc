// SPDX-License-Identifier: BSD-2-Clause
// MAC frames of IEEE 802.15.4 through the real programs. BPF_PROG_TEST_RUN takes no frame of less
// than 14 octets: the guest case relay-wpan sends those.
#include <gtest/gtest.h>

#include <optional>
#include <random>
#include <string>
#include <vector>

#include "tests/bpf/ether/events.hpp"

namespace mlcca::test {
namespace {

constexpr std::size_t kLeast = 14;

enum Mode : std::uint16_t { none = 0, reserved = 1, brief = 2, extended = 3 };

/// From 0x0002 of the PAN 0xbeef to all of it, unless it is changed.
struct Frame {
  std::uint16_t type = 1;
  std::uint16_t flags = 0x40;  // one PAN
  std::uint16_t version = 0;
  Mode to = brief;
  Mode from = brief;
  std::uint16_t to_pan = 0xbeef;
  std::uint16_t from_pan = 0xbeef;
  std::uint64_t destination = 0xffff;
  std::uint64_t source = 2;
  std::uint64_t subject = kSubject;
  std::size_t payload = 8;

  [[nodiscard]] Bytes bytes() const;
};

void put_little(Bytes& to, std::uint64_t number, unsigned octets) {
  for (; octets-- > 0; number >>= 8) to.push_back(static_cast<std::uint8_t>(number));
}

unsigned octets_of(Mode mode) { return mode == brief ? 2 : mode == extended ? 8 : 0; }

Bytes Frame::bytes() const {
  Bytes out;
  put_little(out, type | flags | to << 10U | version << 12U | from << 14U, 2);
  put_little(out, 0x5a, 1);
  if (to != none) put_little(out, to_pan, 2);
  put_little(out, destination, octets_of(to));
  if (from != none && (flags & 0x40U) == 0) put_little(out, from_pan, 2);
  put_little(out, source, octets_of(from));
  for (unsigned n = 8; n-- > 0;) out.push_back(static_cast<std::uint8_t>(subject >> 8 * n));
  out.resize(out.size() + payload, 0x77);
  return out;
}

Frame frame_with(auto change) {
  Frame f;
  change(f);
  return f;
}
Bytes bytes_with(auto change) { return frame_with(change).bytes(); }

constexpr std::uint64_t kBrief = ETHER_SHORT | 0xbeef0002;
constexpr std::uint64_t kAddress = 0x0200000000000001;
constexpr std::uint64_t kExtended = ETHER_EXTENDED | kAddress;
void from_extended(Frame& f) {
  f.from = extended;
  f.source = kAddress;
}
SlotSpec of(std::uint64_t station) {
  return with(in(), [=](SlotSpec& s) { s.station = station; });
}

struct Row {
  std::string name;
  std::vector<SlotSpec> slots;
  Bytes bytes;
  gate_reason reason;
};

std::vector<Row> event_rows() {
  const auto from_nobody = [](Frame& f) { f.from = none, f.flags = 0; };
  return {
      {"FromAShortAddress", {in()}, Frame().bytes(), GATE_R_PASSED},
      {"FromAnExtendedAddress", {in()}, bytes_with(from_extended), GATE_R_PASSED},
      {"OfVersion1", {in()}, bytes_with([](Frame& f) { f.version = 1; }), GATE_R_PASSED},
      {"FromAnotherPan", {in()}, bytes_with([](Frame& f) { f.flags = 0; }), GATE_R_PASSED},
      {"ToOneStation", {in()}, bytes_with([](Frame& f) { f.destination = 9; }), GATE_R_PASSED},
      {"ToAnExtendedAddress", {in()}, bytes_with([](Frame& f) { f.to = extended; }), GATE_R_PASSED},
      {"ToTheCoordinator",
       {in()},
       bytes_with([](Frame& f) { f.to = none, f.flags = 0; }),
       GATE_R_PASSED},
      {"FromTheCoordinator", {in()}, bytes_with(from_nobody), GATE_R_PASSED},
      {"WithFlagsOfTheMac", {in()}, bytes_with([](Frame& f) { f.flags = 0x3f0; }), GATE_R_PASSED},
      {"Empty", {sized(in(), 0)}, bytes_with([](Frame& f) { f.payload = 0; }), GATE_R_PASSED},
      {"TheLongest", {sized(in(), 8)}, Frame().bytes(), GATE_R_PASSED},
      {"Longer", {sized(in(), 8)}, bytes_with([](Frame& f) { f.payload = 9; }), GATE_R_LENGTH},
      {"FillingAFrame",
       {sized(in(), 102)},
       bytes_with([](Frame& f) { from_extended(f), f.payload = 102; }),
       GATE_R_PASSED},
      {"OfAnotherSubject", {in()}, bytes_with([](Frame& f) { ++f.subject; }), GATE_R_UNKNOWN},
      // IPv6 with compressed headers is no exception: a subject may begin alike.
      {"Of6Lowpan",
       {in()},
       bytes_with([](Frame& f) { f.subject = 0x7a3b3a1a02000000; }),
       GATE_R_UNKNOWN},
      {"Denied", {denied(in())}, Frame().bytes(), GATE_R_DENIED},
      {"FromTheStatedShortAddress", {of(kBrief)}, Frame().bytes(), GATE_R_PASSED},
      {"FromAnotherShortAddress",
       {of(kBrief)},
       bytes_with([](Frame& f) { f.source = 3; }),
       GATE_R_SOURCE},
      {"FromThatShortAddressOfAnotherPan",
       {of(kBrief)},
       bytes_with([](Frame& f) { f.flags = 0, f.from_pan = 0xbee0; }),
       GATE_R_SOURCE},
      {"FromThatShortAddressOfItsPanToAnother",
       {of(kBrief)},
       bytes_with([](Frame& f) { f.flags = 0, f.to_pan = 0xffff; }),
       GATE_R_PASSED},
      {"FromTheStatedExtendedAddress", {of(kExtended)}, bytes_with(from_extended), GATE_R_PASSED},
      {"FromAnotherExtendedAddress",
       {of(kExtended)},
       bytes_with([](Frame& f) { from_extended(f), ++f.source; }),
       GATE_R_SOURCE},
      {"FromNobodyWhereAStationIsStated", {of(kBrief)}, bytes_with(from_nobody), GATE_R_SOURCE},
  };
}

std::vector<Row> other_rows() {
  const auto row = [](std::string name, gate_reason reason, auto change) {
    return Row{std::move(name), {in()}, bytes_with(change), reason};
  };
  std::vector<Row> rows{
      row("Beacon", GATE_R_FOREIGN, [](Frame& f) { f.type = 0; }),
      row("Acknowledgement", GATE_R_FOREIGN, [](Frame& f) { f.type = 2; }),
      row("Command", GATE_R_FOREIGN, [](Frame& f) { f.type = 3; }),
      row("SecuredCommand", GATE_R_FOREIGN, [](Frame& f) { f.type = 3, f.flags |= 8; }),
      row("Secured", GATE_R_OPAQUE, [](Frame& f) { f.flags |= 8; }),
      row("OfVersion2", GATE_R_OPAQUE, [](Frame& f) { f.version = 2; }),
      row("OfVersion3", GATE_R_OPAQUE, [](Frame& f) { f.version = 3; }),
      row("ToAReservedMode", GATE_R_MALFORMED, [](Frame& f) { f.to = reserved; }),
      row("FromAReservedMode", GATE_R_MALFORMED, [](Frame& f) { f.from = reserved; }),
      row("OfOnePanToNobody", GATE_R_MALFORMED, [](Frame& f) { f.to = none; }),
      row("OfOnePanFromNobody", GATE_R_MALFORMED, [](Frame& f) { f.from = none; }),
      row("FromAGroup", GATE_R_MALFORMED, [](Frame& f) { f.source = 0xffff; }),
      row("FromAStationWithoutAddress", GATE_R_MALFORMED, [](Frame& f) { f.source = 0xfffe; }),
      row("FromTheLastShortAddress", GATE_R_PASSED, [](Frame& f) { f.source = 0xfffd; }),
      row("FromAnExtendedGroup", GATE_R_MALFORMED,
          [](Frame& f) { from_extended(f), f.source |= ETHER_EXTENDED; }),
  };
  for (std::uint16_t type = 4; type < 8; ++type)
    rows.push_back(
        row("OfType" + std::to_string(type), GATE_R_OPAQUE, [=](Frame& f) { f.type = type; }));
  Frame longest;
  longest.to = longest.from = extended;
  longest.flags = 0;
  longest.source = kAddress;
  longest.payload = 0;
  const Bytes whole = longest.bytes();
  for (std::size_t size = kLeast; size <= whole.size(); ++size)
    rows.push_back({"CutOffAt" + std::to_string(size),
                    {in()},
                    cut(whole, size),
                    size < whole.size() ? GATE_R_MALFORMED : GATE_R_PASSED});
  return rows;
}

class WpanFrames : public ::testing::TestWithParam<Row> {};

TEST_P(WpanFrames, Fate) {
  const Row& row = GetParam();
  for (const bool direct : {true, false}) {
    LoadedEther& gate = LoadedEther::with({.direct_access = direct, .wpan = true});
    gate.admit(row.slots);
    const Outcome got = gate.run(kIn, row.bytes, kWire);
    EXPECT_EQ(got.dropped, core::is_drop(gates::reason_of(row.reason)));
    EXPECT_EQ(gate.reasons(kIn).at(row.reason), 1U)
        << "not " << core::to_text(gates::reason_of(row.reason));
    EXPECT_EQ(got.mark,
              row.reason == GATE_R_PASSED ? mark_from(kIfindex, row.slots.front().station) : 0);
  }
}

std::string name_of(const ::testing::TestParamInfo<Row>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Event, WpanFrames, ::testing::ValuesIn(event_rows()), name_of);
INSTANTIATE_TEST_SUITE_P(Other, WpanFrames, ::testing::ValuesIn(other_rows()), name_of);

TEST(WpanGate, OnlyTheUserOfTheGrantSends) {
  LoadedEther& gate = LoadedEther::with({.wpan = true});
  gate.admit({of_user(0)});
  EXPECT_FALSE(gate.run(kOut, Frame().bytes(), kLocal).dropped);
  EXPECT_TRUE(gate.run(kOut, Frame().bytes(), kWire).dropped);
  EXPECT_EQ(gate.reasons(kOut).at(GATE_R_SOURCE), 1U);
  gate.reset();
  gate.admit({of_user(1000)});
  EXPECT_TRUE(gate.run(kOut, Frame().bytes(), kLocal).dropped);
}

TEST(WpanGate, WhatNobodyKnowsIsReportedWithItsSender) {
  const std::vector<std::pair<Bytes, std::string>> rows = {
      {Frame().bytes(), "0xbeef:0x0002"},
      {bytes_with(from_extended), "02:00:00:00:00:00:00:01"},
      {bytes_with([](Frame& f) { f.from = none, f.flags = 0; }), ""}};
  for (const auto& [bytes, sender] : rows) {
    LoadedEther& gate = LoadedEther::with({.wpan = true});
    EXPECT_TRUE(gate.run(kIn, bytes, kWire).dropped);
    const auto unknown = gates::unknown_frames(gate.cpus());
    ASSERT_EQ(unknown.size(), 1U);
    EXPECT_EQ(unknown[0].subject, kSubject);
    EXPECT_EQ(gates::sender_text(unknown[0].station, unknown[0].mac), sender);
  }
}

TEST(WpanGate, PolicesEachStationForItself) {
  constexpr std::uint64_t hour = 3'600'000'000'000;
  LoadedEther& gate = LoadedEther::with({.wpan = true});
  for (const std::uint64_t station : {kBrief, kExtended, std::uint64_t{0}})
    gate.admit({with(of(station), [](SlotSpec& s) { s.per_frame = s.tolerance = hour; })});
  const auto passed = [&](const Bytes& bytes) {
    int out = 0;
    for (int i = 0; i < 10; ++i) out += gate.run(kIn, bytes, kWire).dropped ? 0 : 1;
    return out;
  };
  EXPECT_EQ(passed(Frame().bytes()), 2) << "one, and one that is early";
  EXPECT_EQ(passed(bytes_with(from_extended)), 2);
  EXPECT_EQ(passed(bytes_with([](Frame& f) { f.source = 3; })), 2);
  EXPECT_EQ(passed(bytes_with([](Frame& f) { f.source = 4; })), 0) << "all others are one";
}

TEST(WpanGate, DropsAllEventsWhileItIsClosed) {
  LoadedEther& gate = LoadedEther::with({.wpan = true});
  gate.admit({in()});
  gate.control().open = 0;
  EXPECT_TRUE(gate.run(kIn, Frame().bytes(), kWire).dropped);
  EXPECT_FALSE(gate.run(kIn, bytes_with([](Frame& f) { f.type = 3; }), kWire).dropped);
}

// --- at random, against the same rules once more -------------------------------------------------

struct Seen {
  gate_reason reason = GATE_R_MALFORMED;  // GATE_R_PASSED: an event
  std::uint64_t subject = 0;
  std::uint64_t station = 0;
  std::size_t length = 0;
};

/// The octets of one frame, from its beginning.
class Reader {
 public:
  explicit Reader(const Bytes& bytes) : bytes_(bytes) {}
  std::uint64_t little(std::size_t octets) {
    std::uint64_t out = 0;
    for (std::size_t i = 0; i < octets; ++i) out |= std::uint64_t{next()} << 8 * i;
    return out;
  }
  std::uint64_t big(std::size_t octets) {
    std::uint64_t out = 0;
    for (std::size_t i = 0; i < octets; ++i) out = out << 8 | next();
    return out;
  }
  [[nodiscard]] bool ended() const { return at_ > bytes_.size(); }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

 private:
  std::uint8_t next() { return at_++ < bytes_.size() ? bytes_[at_ - 1] : 0; }
  const Bytes& bytes_;
  std::size_t at_ = 0;
};

Seen look_at(const Bytes& bytes) {
  Reader read(bytes);
  Seen seen;
  const auto control = read.little(2);
  read.little(1);
  const auto type = control % 8;
  if (type == 0 || type == 2 || type == 3) return {.reason = GATE_R_FOREIGN};
  if (type != 1 || (control & 8) != 0 || (control >> 13 & 1) != 0) return {.reason = GATE_R_OPAQUE};
  const auto to = control >> 10 & 3;
  const auto from = control >> 14;
  const bool one_pan = (control & 0x40) != 0;
  if (to == 1 || from == 1 || (one_pan && (to == 0 || from == 0))) return seen;
  std::uint64_t pan = to == 0 ? 0 : read.little(2);
  read.little(to == 0 ? 0 : to == 2 ? 2 : 8);
  if (from != 0 && !one_pan) pan = read.little(2);
  if (from == 2) {
    const auto address = read.little(2);
    if (address >= 0xfffe) return seen;
    seen.station = ETHER_SHORT + (pan << 16) + address;
  }
  if (from == 3) {
    const auto address = read.little(8);
    if ((address >> 56) % 2 != 0) return seen;
    seen.station = ETHER_EXTENDED + address;
  }
  seen.subject = read.big(8);
  if (read.ended()) return seen;
  seen.length = read.left();
  seen.reason = GATE_R_PASSED;
  return seen;
}

gate_reason expected(const Bytes& bytes, std::uint16_t longest) {
  const Seen seen = look_at(bytes);
  if (seen.reason != GATE_R_PASSED) return seen.reason;
  if (seen.subject != kSubject) return GATE_R_UNKNOWN;
  return seen.length > longest ? GATE_R_LENGTH : GATE_R_PASSED;
}

class AnyFrame {
 public:
  std::uint32_t below(std::size_t n) { return static_cast<std::uint32_t>(random_() % n); }
  Bytes next();

 private:
  std::mt19937 random_{4711};  // NOLINT(*-msc51-cpp): the same each time
};

Bytes AnyFrame::next() {
  Frame f;
  f.type = static_cast<std::uint16_t>(below(4) == 0 ? below(8) : 1);
  f.flags = static_cast<std::uint16_t>(below(1 << 10) & ~7U & (below(3) == 0 ? ~0U : ~8U));
  f.version = static_cast<std::uint16_t>(below(4) == 0 ? below(4) : 0);
  f.to = static_cast<Mode>(below(4));
  f.from = static_cast<Mode>(below(4));
  f.source = below(4) == 0 ? 0xfffc + below(4) : std::uint64_t{random_()} << 32 | random_();
  f.subject = kSubject + (below(4) == 0 ? 1 : 0);
  f.payload = below(30);
  Bytes bytes = f.bytes();
  if (below(8) == 0) bytes[below(bytes.size())] ^= static_cast<std::uint8_t>(1U << below(8));
  if (below(4) == 0) bytes.resize(below(bytes.size()));
  if (bytes.size() < kLeast) bytes.resize(kLeast);
  return bytes;
}

constexpr int kFrames = 20'000;

TEST(WpanGate, JudgesAnyFrameByTheRules) {
  constexpr std::uint16_t kLongest = 20;
  AnyFrame any;
  LoadedEther& gate = LoadedEther::with({.wpan = true});
  gate.admit({sized(in(), kLongest)});
  gates::ReasonCounters wanted{};
  for (int i = 0; i < kFrames; ++i) {
    const Bytes bytes = any.next();
    const gate_reason reason = expected(bytes, kLongest);
    ++wanted.at(reason);
    EXPECT_EQ(gate.run(kIn, bytes, kWire).dropped, core::is_drop(gates::reason_of(reason)))
        << core::to_text(gates::reason_of(reason));
    EXPECT_EQ(gate.dropped_early(bytes), core::is_drop(gates::reason_of(reason)));
  }
  const auto got = gate.reasons(kIn);
  for (const gate_reason reason : {GATE_R_PASSED, GATE_R_FOREIGN})
    EXPECT_EQ(got.at(reason), wanted.at(reason));
  for (const gate_reason reason :
       {GATE_R_OPAQUE, GATE_R_MALFORMED, GATE_R_UNKNOWN, GATE_R_LENGTH}) {
    EXPECT_EQ(got.at(reason), 2 * wanted.at(reason)) << "in the driver, and at ingress";
    EXPECT_GT(wanted.at(reason), 100U);
  }
  EXPECT_GT(wanted.at(GATE_R_PASSED), 100U);
}

TEST(WpanGate, BeforeThereIsADaemonNoDataFramePasses) {
  AnyFrame any;
  LoadedEther& gate = LoadedEther::with({.wpan = true});
  const auto closed =
      gates::ClosedPrograms::of_ethernet({.control = gate.control_fd(), .events = -1}, true);
  ASSERT_TRUE(closed) << closed.error().text;
  for (int i = 0; i < kFrames / 10; ++i) {
    const Bytes bytes = any.next();
    for (const Direction direction : {kIn, kOut})
      EXPECT_EQ(drops(*closed, direction, bytes), look_at(bytes).reason != GATE_R_FOREIGN);
  }
}

}  // namespace
}  // namespace mlcca::test
