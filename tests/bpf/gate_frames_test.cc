// SPDX-License-Identifier: BSD-2-Clause
// Frame tables through the real gate programs: one row, one behaviour.
#include <gtest/gtest.h>
#include <linux/pkt_cls.h>

#include <string>

#include "daemon/gates/counters.hpp"
#include "tests/bpf/loaded_gate.hpp"

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::SlotSpec;

constexpr std::uint32_t kEff = CAN_EFF_FLAG;
constexpr std::uint32_t kRtr = CAN_RTR_FLAG;
constexpr std::uint32_t kStandard = kEff | kRtr | CAN_SFF_MASK;  // whole 11-bit identifier, no RTR
constexpr std::uint32_t kExtended = kEff | kRtr | CAN_EFF_MASK;
constexpr std::uint64_t kSubject = 0xa4efeccc3210b497;
constexpr std::uint64_t kPublisher = 5;
/// Mark of a frame of kSubject that the ingress gate of an interface has passed.
std::uint32_t mark_from(std::uint32_t ifindex, std::uint64_t subject = kSubject,
                        std::uint64_t publisher = kPublisher) {
  return gate_ingress_token(kToken, ifindex, gate_origin(subject, publisher));
}
const std::uint32_t kAdmitted = mark_from(kIfindex);
const std::uint32_t kFromOther = mark_from(kOther);
constexpr std::uint32_t kEcho = ~kToken;
constexpr auto kIn = Direction::ingress;
constexpr auto kOut = Direction::egress;

/// The channel of the paper's emergency switch: etag 0x64 of node 5 with priority 0x7d.
constexpr std::uint32_t famouso(std::uint32_t etag, std::uint32_t node = 5,
                                std::uint32_t priority = 0x7d, std::uint32_t fragment = 0) {
  return kEff | priority << 22 | fragment << 21 | node << 14 | etag;
}

SlotSpec slot(Direction direction, std::uint32_t id, std::uint32_t mask) {
  SlotSpec s;
  s.direction = direction;
  s.pass = true;
  s.id = id;
  s.mask = mask;
  s.subject = kSubject;
  if (direction == kIn) s.origin = gate_origin(kSubject, kPublisher);
  return s;
}
SlotSpec in(std::uint32_t id) { return slot(kIn, id, (id & kEff) != 0 ? kExtended : kStandard); }
SlotSpec out(std::uint32_t id, std::uint32_t source = kOther) {
  auto s = slot(kOut, id, (id & kEff) != 0 ? kExtended : kStandard);
  s.source = source;
  if (source != 0) s.origin = gate_origin(kSubject, kPublisher);
  return s;
}
SlotSpec with(SlotSpec s, auto change) {
  change(s);
  return s;
}
SlotSpec denied(SlotSpec s) {
  return with(s, [](auto& t) { t.pass = false; });
}
SlotSpec user(SlotSpec s, std::uint32_t uid) {
  return with(s, [=](auto& t) { t.uid = uid; });
}
SlotSpec sized(SlotSpec s, std::uint8_t max_len, std::uint8_t formats = GATE_CLASSIC) {
  return with(s, [=](auto& t) { t.max_len = max_len, t.formats = formats; });
}
SlotSpec remote(SlotSpec s) {
  return with(s, [](auto& t) { t.mask &= ~kRtr; });
}

constexpr Sender kBus{};
constexpr Sender kLocal{.local = true};
const Sender kForwarded{.mark = kFromOther, .ingress_ifindex = kOther};
constexpr Sender marked(std::uint32_t mark) { return {.mark = mark}; }

constexpr int kOwn = -1;  // counted by the direction's own slot
struct Expect {
  gate_reason reason;
  int slot = kOwn;  // index into the row's slots
  std::uint32_t mark = 0;
};
Expect admitted(int index = 0) { return {GATE_R_PASSED, index, kAdmitted}; }
constexpr Expect sent(int index = 0) { return {GATE_R_PASSED, index}; }

enum class State : std::uint8_t { open, closed, lapsed, overdue, audit };

struct Row {
  std::string name;
  GateOptions options;
  State state;
  std::vector<SlotSpec> slots;
  Direction direction;
  Bytes bytes;
  Sender sender;
  Expect expect;
};

Row raw(std::string name, std::vector<SlotSpec> slots, Direction direction, Bytes bytes,
        Sender sender, Expect expect, State state = State::open) {
  return {std::move(name),  {},     state, std::move(slots), direction,
          std::move(bytes), sender, expect};
}
Row fam(std::string name, std::vector<SlotSpec> slots, Direction direction, Bytes bytes,
        Sender sender, Expect expect) {
  auto row = raw(std::move(name), std::move(slots), direction, std::move(bytes), sender, expect);
  row.options.profile = GATE_PROFILE_FAMOUSO;
  return row;
}
Row echoing(Row row) {
  row.options.echo_by_mark = true;
  return row;
}

std::vector<Row> identifier_rows() {
  const auto f = [](std::uint32_t id, unsigned len = 8) { return frame(id, len); };
  return {
      raw("StandardIdPasses", {in(0x123)}, kIn, f(0x123), kBus, admitted()),
      raw("LowestStandardIdPasses", {in(0)}, kIn, f(0), kBus, admitted()),
      raw("HighestStandardIdPasses", {in(0x7ff)}, kIn, f(0x7ff), kBus, admitted()),
      raw("NeighbourIdIsUnknown", {in(0x123)}, kIn, f(0x124), kBus, {GATE_R_UNKNOWN}),
      raw("NothingAdmittedNothingPasses", {}, kIn, f(0x123), kBus, {GATE_R_UNKNOWN}),
      raw("ExtendedIdPasses", {in(kEff | 0x1abcdef)}, kIn, f(kEff | 0x1abcdef), kBus, admitted()),
      raw("HighestExtendedIdPasses", {in(kEff | 0x1fffffff)}, kIn, f(kEff | 0x1fffffff), kBus,
          admitted()),
      raw("ExtendedIdOfStandardValueIsUnknown", {in(0x123)}, kIn, f(kEff | 0x123), kBus,
          {GATE_R_UNKNOWN}),
      raw("StandardIdOfExtendedValueIsUnknown", {in(kEff | 0x123)}, kIn, f(0x123), kBus,
          {GATE_R_UNKNOWN}),
      // A controller sends the low 11 bits of it: on the wire it is the admitted frame.
      raw("StandardIdIsItsLow11Bits", {in(0x123)}, kIn, f(0x123 | 0x800), kBus, admitted()),
      raw("StandardIdIsWholeWhereTheMaskIs", {slot(kIn, 0x123, kExtended)}, kIn, f(0x123 | 0x800),
          kBus, {GATE_R_UNKNOWN}),
      raw("IngressSlotIsNoEgressSlot", {in(0x123)}, kOut, f(0x123), kForwarded, {GATE_R_UNKNOWN}),
      raw("DeniedSlotDrops", {denied(in(0x123))}, kIn, f(0x123), kBus, {GATE_R_DENIED, 0}),
      raw("RemoteFrameIsRefused", {in(0x123)}, kIn, f(kRtr | 0x123), kBus, {GATE_R_IDENTIFIER, 0}),
      raw("DeclaredRemoteFramePasses", {remote(in(0x123))}, kIn, f(kRtr | 0x123), kBus, admitted()),
      raw("DataFrameOfRemoteChannelPasses", {remote(in(0x123))}, kIn, f(0x123), kBus, admitted()),
      fam("EtagOfGrantedNodePasses", {in(famouso(0x64))}, kIn, f(famouso(0x64)), kBus, admitted()),
      fam("WrongNodeIsRefused", {in(famouso(0x64))}, kIn, f(famouso(0x64, 6)), kBus,
          {GATE_R_IDENTIFIER, 0}),
      fam("WrongPriorityIsRefused", {in(famouso(0x64))}, kIn, f(famouso(0x64, 5, 0)), kBus,
          {GATE_R_IDENTIFIER, 0}),
      fam("FragmentIsRefused", {in(famouso(0x64))}, kIn, f(famouso(0x64, 5, 0x7d, 1)), kBus,
          {GATE_R_IDENTIFIER, 0}),
      fam("GrantedFragmentPasses", {in(famouso(0x64, 5, 0x7d, 1))}, kIn,
          f(famouso(0x64, 5, 0x7d, 1)), kBus, admitted()),
      fam("AnyNodePassesWhereNoneIsNamed", {slot(kIn, famouso(0x64, 0), kExtended & ~0x1fc000U)},
          kIn, f(famouso(0x64, 0x7f)), kBus, admitted()),
      fam("OtherEtagIsUnknown", {in(famouso(0x64))}, kIn, f(famouso(0x65)), kBus, {GATE_R_UNKNOWN}),
      fam("HighestEtagPasses", {in(famouso(0x3fff))}, kIn, f(famouso(0x3fff)), kBus, admitted()),
      fam("StandardFrameIsUnknown", {in(famouso(0x64))}, kIn, f(0x64), kBus, {GATE_R_UNKNOWN}),
      fam("FamousoRemoteFrameIsRefused", {in(famouso(0x64))}, kIn, f(famouso(0x64) | kRtr), kBus,
          {GATE_R_IDENTIFIER, 0}),
  };
}

std::vector<Row> format_rows() {
  const auto id = 0x123U;
  std::vector<Row> rows = {
      raw("EmptyFramePasses", {in(id)}, kIn, frame(id, 0), kBus, admitted()),
      raw("GrantedLengthPasses", {sized(in(id), 4)}, kIn, frame(id, 4), kBus, admitted()),
      raw("LongerThanGrantedIsRefused", {sized(in(id), 4)}, kIn, frame(id, 5), kBus,
          {GATE_R_LENGTH, 0}),
      raw("FdWhereClassicIsGrantedIsRefused", {in(id)}, kIn, frame(id, 8, true), kBus,
          {GATE_R_FORMAT, 0}),
      raw("ClassicWhereFdIsGrantedIsRefused", {sized(in(id), 64, GATE_FD)}, kIn, frame(id, 8), kBus,
          {GATE_R_FORMAT, 0}),
      raw("FdPasses", {sized(in(id), 64, GATE_FD)}, kIn, frame(id, 64, true), kBus, admitted()),
      raw("FdLongerThanGrantedIsRefused", {sized(in(id), 32, GATE_FD)}, kIn, frame(id, 33, true),
          kBus, {GATE_R_LENGTH, 0}),
      raw("BothFormatsPassClassic", {sized(in(id), 64, GATE_FD | GATE_CLASSIC)}, kIn, frame(id, 8),
          kBus, admitted()),
      raw("BothFormatsPassFd", {sized(in(id), 64, GATE_FD | GATE_CLASSIC)}, kIn,
          frame(id, 12, true), kBus, admitted()),
      raw("ClassicLengthByteOf9IsMalformed", {sized(in(id), 64)}, kIn, frame(id, 9), kBus,
          {GATE_R_MALFORMED}),
      raw("FdLengthByteOf65IsMalformed", {sized(in(id), 255, GATE_FD)}, kIn, frame(id, 65, true),
          kBus, {GATE_R_MALFORMED}),
      raw("ErrorFramePassesIngressUnmarked", {}, kIn, frame(CAN_ERR_FLAG | 4, 8), kBus,
          {GATE_R_ERROR_IN}),
      raw("ErrorFramePassesClosedIngress", {}, kIn, frame(CAN_ERR_FLAG | 4, 8), kBus,
          {GATE_R_ERROR_IN}, State::closed),
      raw("ErrorFrameLosesForgedMark", {}, kIn, frame(CAN_ERR_FLAG | 4, 8), marked(kAdmitted),
          {GATE_R_ERROR_IN}),
      raw("ErrorFrameNeverLeaves", {out(0x4, 0)}, kOut, frame(CAN_ERR_FLAG | 4, 8), kLocal,
          {GATE_R_ERROR_FRAME}),
      raw("MalformedNeverLeaves", {out(id, 0)}, kOut, frame(id, 9), kLocal, {GATE_R_MALFORMED}),
  };
  // 14 bytes is the least that BPF_PROG_TEST_RUN takes.
  for (std::size_t size = 14; size <= 80; ++size) {
    if (size == CAN_MTU || size == CANFD_MTU) continue;
    Bytes bytes(size);
    bytes[0] = 0x23;
    bytes[1] = 0x01;
    const std::string name = "BufferOf" + std::to_string(size) + "Bytes";
    rows.push_back(raw(name + "NeverLeaves", {sized(out(id, 0), 64, GATE_CLASSIC | GATE_FD)}, kOut,
                       bytes, kLocal, {GATE_R_MALFORMED}));
    const bool led = (size - CAN_MTU) % 8 == 0 && size <= CAN_MTU + 32;
    if (size > CAN_MTU && (led || size == CANFD_MTU + 8)) continue;
    rows.push_back(raw(name + "IsMalformed", {sized(in(id), 64, GATE_CLASSIC | GATE_FD)}, kIn,
                       bytes, kBus, {GATE_R_MALFORMED}));
  }
  // A controller's driver leaves its private data in front of what it has received.
  const auto led = [](std::size_t lead, Bytes bytes) {
    bytes.insert(bytes.begin(), lead, 0x5a);
    return bytes;
  };
  // Not 8: the kernel would take bytes 12 and 13 of a test frame for an EtherType, here that of IP.
  for (const std::size_t lead : {16, 24, 32}) {
    const std::string name = "Behind" + std::to_string(lead) + "Bytes";
    rows.push_back(raw("ClassicFrame" + name + "Passes", {in(id)}, kIn, led(lead, frame(id, 8)),
                       kBus, admitted()));
    rows.push_back(raw("FdFrame" + name + "Passes", {sized(in(id), 64, GATE_FD)}, kIn,
                       led(lead, frame(id, 64, true)), kBus, admitted()));
    rows.push_back(raw("UnknownFrame" + name + "IsUnknown", {in(id)}, kIn,
                       led(lead, frame(0x7ff, 8)), kBus, {GATE_R_UNKNOWN}));
  }
  rows.push_back(raw("ClassicFrameBehind40BytesIsMalformed", {in(id)}, kIn, led(40, frame(id, 8)),
                     kBus, {GATE_R_MALFORMED}));
  return rows;
}

std::vector<Row> source_rows() {
  const auto f = frame(0x123, 8);
  const Sender unvouched{.ingress_ifindex = kOther};
  const Sender third{.mark = mark_from(11), .ingress_ifindex = 11};
  return {
      raw("ForwardedFromGrantedSourceLeavesUnmarked", {out(0x123)}, kOut, f, kForwarded, sent()),
      raw("ForwardedFromThirdBusIsRefused", {out(0x123)}, kOut, f, third, {GATE_R_SOURCE, 0}),
      raw("ForwardedButNotPassedByIngressIsRefused", {out(0x123)}, kOut, f, unvouched,
          {GATE_R_SOURCE, 0}),
      raw("TokenOfAnotherInterfaceIsRefused", {out(0x123)}, kOut, f,
          {.mark = mark_from(11), .ingress_ifindex = kOther}, {GATE_R_SOURCE, 0}),
      raw("AdmittedAsAnotherSubjectIsRefused", {out(0x123)}, kOut, f,
          {.mark = mark_from(kOther, kSubject + 1), .ingress_ifindex = kOther}, {GATE_R_SOURCE, 0}),
      raw("AdmittedAsAnotherPublishersIsRefused", {out(0x123)}, kOut, f,
          {.mark = mark_from(kOther, kSubject, kPublisher + 1), .ingress_ifindex = kOther},
          {GATE_R_SOURCE, 0}),
      raw("TokenWithoutInterfaceIsRefused", {out(0x123)}, kOut, f, marked(kFromOther),
          {GATE_R_SOURCE, 0}),
      raw("SenderWithoutSocketIsNotLocal", {out(0x123, 0)}, kOut, f, kBus, {GATE_R_SOURCE, 0}),
      raw("LocalWhereForwardedIsGrantedIsRefused", {out(0x123)}, kOut, f, kLocal,
          {GATE_R_SOURCE, 0}),
      raw("LocalWithTokenOfGrantedSourceIsRefused", {out(0x123)}, kOut, f,
          {.local = true, .mark = kFromOther, .ingress_ifindex = kOther}, {GATE_R_SOURCE, 0}),
      raw("ForwardedWhereLocalIsGrantedIsRefused", {out(0x123, 0)}, kOut, f, kForwarded,
          {GATE_R_SOURCE, 0}),
      raw("LocalOfAnyUserLeaves", {out(0x123, 0)}, kOut, f, kLocal, sent()),
      raw("LocalOfGrantedUserLeaves", {user(out(0x123, 0), 0)}, kOut, f, kLocal, sent()),
      raw("LocalOfAnotherUserIsRefused", {user(out(0x123, 0), 1000)}, kOut, f, kLocal,
          {GATE_R_SOURCE, 0}),
      raw("LocalMarkIsCleared", {out(0x123, 0)}, kOut, f, {.local = true, .mark = 77}, sent()),
      echoing(raw("EchoingDeviceMarksForwarded", {out(0x123)}, kOut, f, kForwarded,
                  {GATE_R_PASSED, 0, kEcho})),
      echoing(raw("EchoingDeviceMarksLocal", {out(0x123, 0)}, kOut, f, kLocal,
                  {GATE_R_PASSED, 0, kEcho})),
      raw("IngressReplacesForgedMark", {in(0x123)}, kIn, f, marked(kFromOther), admitted()),
  };
}

std::vector<Row> echo_rows() {
  const auto f = frame(0x123, 8);
  return {
      raw("EchoOfLocalSenderPassesUnmarked", {}, kIn, f, {.local = true, .mark = kAdmitted},
          {GATE_R_ECHO}),
      raw("EchoOfLocalSenderIsNoBusFrame", {in(0x123)}, kIn, f, kLocal, {GATE_R_ECHO}),
      raw("EchoPassesClosedGate", {}, kIn, f, kLocal, {GATE_R_ECHO}, State::closed),
      echoing(raw("EchoByMarkPasses", {}, kIn, f, marked(kEcho), {GATE_R_ECHO})),
      raw("EchoMarkFromAnotherNamespaceIsNotBelieved", {}, kIn, f, marked(kEcho), {GATE_R_UNKNOWN}),
      echoing(raw("NearlyEchoMarkIsNotBelieved", {}, kIn, f, marked(kEcho ^ 1U), {GATE_R_UNKNOWN})),
      raw("MarkOfAnotherInterfaceIsNoEcho", {out(0x123)}, kIn, f, marked(kFromOther),
          {GATE_R_UNKNOWN}),
      raw("MarkOfAnotherInterfacePassesNoClosedGate", {in(0x123), out(0x123)}, kIn, f,
          marked(kFromOther), {GATE_R_CLOSED}, State::closed),
      raw("EchoOfWhatEgressRefusesIsNone", {denied(out(0x123))}, kIn, f, marked(kFromOther),
          {GATE_R_UNKNOWN}),
      raw("EchoOfAnotherSourceIsNone", {out(0x123, 11)}, kIn, f, marked(kFromOther),
          {GATE_R_UNKNOWN}),
      raw("OwnTokenIsNoEcho", {out(0x123, kIfindex)}, kIn, f, marked(kAdmitted), {GATE_R_UNKNOWN}),
      raw("LocalGrantMakesNoForwardedEcho", {out(0x123, 0)}, kIn, f, marked(kToken),
          {GATE_R_UNKNOWN}),
  };
}

std::vector<Row> state_rows() {
  const auto f = frame(0x123, 8);
  return {
      raw("ClosedGateDropsAdmittedAtIngress", {in(0x123)}, kIn, f, kBus, {GATE_R_CLOSED},
          State::closed),
      raw("ClosedGateDropsAdmittedAtEgress", {out(0x123)}, kOut, f, kForwarded, {GATE_R_CLOSED},
          State::closed),
      raw("LapsedGateDropsAdmittedAtIngress", {in(0x123)}, kIn, f, kBus, {GATE_R_CLOSED},
          State::lapsed),
      raw("LapsedGateDropsAdmittedAtEgress", {out(0x123)}, kOut, f, kForwarded, {GATE_R_CLOSED},
          State::lapsed),
      raw("OverdueHeartBeatDropsAdmittedAtIngress", {in(0x123)}, kIn, f, kBus, {GATE_R_CLOSED},
          State::overdue),
      raw("OverdueHeartBeatDropsAdmittedAtEgress", {out(0x123)}, kOut, f, kForwarded,
          {GATE_R_CLOSED}, State::overdue),
      raw("AuditLetsUnknownThroughMarked", {}, kIn, f, kBus,
          {GATE_R_UNKNOWN, kOwn, kReportedBefore}, State::audit),
      raw("AuditLetsDeniedThroughMarked", {denied(in(0x123))}, kIn, f, marked(kFromOther),
          {GATE_R_DENIED, 0, kReportedBefore}, State::audit),
      raw("AuditDoesNotCountAtEgressWhatIngressHas", {denied(out(0x123))}, kOut, f,
          {.mark = kReportedBefore, .ingress_ifindex = 10}, {GATE_R_ECHO}, State::audit),
      raw("NorAnUnknownFrame", {}, kOut, f, {.mark = kReportedBefore, .ingress_ifindex = 10},
          {GATE_R_ECHO}, State::audit),
      raw("WhatAnIngressGateRefusedIsDroppedAfterAudit", {out(0x123)}, kOut, f,
          {.mark = kReportedBefore, .ingress_ifindex = 10}, {GATE_R_SOURCE, 0}),
      raw("AuditMarkOpensNothing", {in(0x123)}, kIn, f, marked(kReportedBefore), admitted(),
          State::audit),
      raw("AuditMarksAdmitted", {in(0x123)}, kIn, f, kBus, admitted(), State::audit),
      raw("AuditLetsWrongSourceOutUnmarked", {out(0x123)}, kOut, f,
          {.mark = mark_from(11), .ingress_ifindex = 11}, {GATE_R_SOURCE, 0}, State::audit),
      raw("AuditLetsErrorFrameOut", {}, kOut, frame(CAN_ERR_FLAG | 1, 8), kLocal,
          {GATE_R_ERROR_FRAME}, State::audit),
      raw("AuditLetsMalformedThrough", {}, kIn, Bytes(20), kBus,
          {GATE_R_MALFORMED, kOwn, kReportedBefore}, State::audit),
  };
}

/// Several publishers of one subject; the last added is asked first.
std::vector<Row> chain_rows() {
  const auto a = famouso(0x64, 5);
  const auto b = famouso(0x64, 6);
  std::vector<SlotSpec> full;
  for (std::uint32_t node = 1; node <= GATE_CHAIN; ++node) full.push_back(in(famouso(0x64, node)));
  return {
      fam("FirstOfTwoPublishersPasses", {in(a), in(b)}, kIn, frame(a, 8), kBus, admitted(0)),
      fam("SecondOfTwoPublishersPasses", {in(a), in(b)}, kIn, frame(b, 8), kBus, admitted(1)),
      fam("ThirdPublisherIsCountedByTheFirstAsked", {in(a), in(b)}, kIn, frame(famouso(0x64, 7), 8),
          kBus, {GATE_R_IDENTIFIER, 1}),
      fam("RefusedPublisherDoesNotShutItsNeighbour", {in(a), denied(in(b))}, kIn, frame(a, 8), kBus,
          admitted(0)),
      fam("RefusedPublisherIsDenied", {denied(in(a)), in(b)}, kIn, frame(a, 8), kBus,
          {GATE_R_DENIED, 0}),
      fam("TheSlotThatCameFurthestGivesTheReason", {sized(in(a), 4), in(b)}, kIn, frame(a, 5), kBus,
          {GATE_R_LENGTH, 0}),
      fam("LastOfAFullChainPasses", full, kIn, frame(famouso(0x64, 1), 8), kBus, admitted(0)),
      fam("FirstOfAFullChainPasses", full, kIn, frame(famouso(0x64, GATE_CHAIN), 8), kBus,
          admitted(GATE_CHAIN - 1)),
      raw("PassingGrantWinsOverDenyingOne", {sized(in(0x123), 8), denied(sized(in(0x123), 7))}, kIn,
          frame(0x123, 7), kBus, admitted(0)),
      raw("SourcesOfOneIdentifierPassEach", {out(0x123, 11), out(0x123), out(0x123, 0)}, kOut,
          frame(0x123, 8), kForwarded, sent(1)),
      raw("LocalNextToForwardedPasses", {out(0x123), out(0x123, 0), out(0x123, 11)}, kOut,
          frame(0x123, 8), kLocal, sent(1)),
      raw("GrantedUserBehindAnotherPasses", {user(out(0x123, 0), 0), user(out(0x123, 0), 1000)},
          kOut, frame(0x123, 8), kLocal, sent(0)),
  };
}

std::vector<Row> all_rows() {
  std::vector<Row> rows;
  for (auto& part :
       {identifier_rows(), format_rows(), source_rows(), echo_rows(), state_rows(), chain_rows()})
    rows.insert(rows.end(), part.begin(), part.end());
  return rows;
}

class GateFrames : public ::testing::TestWithParam<Row> {
 protected:
  static void check(const Row& row, const GateOptions& options) {
    auto& gate = LoadedGate::with(options);
    gate.admit(row.slots);
    gate.control().open = row.state != State::closed;
    gate.control().lapsed = row.state == State::lapsed;
    gate.control().deadline = row.state == State::overdue ? 1 : ~0ULL;
    gate.control().mode = row.state == State::audit ? GATE_AUDIT : GATE_ENFORCE;

    const Outcome outcome = gate.run(row.direction, row.bytes, row.sender);

    const bool counted_as_drop = core::is_drop(gates::reason_of(row.expect.reason));
    EXPECT_EQ(outcome.dropped, counted_as_drop && row.state != State::audit);
    if (!outcome.dropped) {
      EXPECT_EQ(outcome.mark, row.expect.mark);
    }
    gates::ReasonCounters once{};
    once.at(row.expect.reason) = 1;
    const bool passed_by_audit = counted_as_drop && !outcome.dropped;
    const auto dropped = gates::reason_counters(gate.cpus(), row.direction);
    const auto would_drop = gates::would_drop_counters(gate.table(), row.direction);
    EXPECT_EQ(passed_by_audit ? would_drop : dropped, once);
    EXPECT_EQ(passed_by_audit ? dropped : would_drop, gates::ReasonCounters{});

    std::uint32_t counting = row.direction == kIn ? GATE_INGRESS : GATE_EGRESS;
    if (row.expect.slot != kOwn)
      counting = gate.slots().find(row.slots.at(static_cast<std::size_t>(row.expect.slot))).value();
    const auto count = gates::slot_counters(gate.table(), gate.cpus(), counting);
    EXPECT_EQ(count.dropped, outcome.dropped ? 1U : 0U);
    EXPECT_EQ(count.would_drop, passed_by_audit ? 1U : 0U);
    EXPECT_EQ(count.passed, row.expect.reason == GATE_R_PASSED ? 1U : 0U);
    EXPECT_EQ(count.last_reason,
              gates::reason_of(counted_as_drop ? row.expect.reason : GATE_R_PASSED));
  }
};

TEST_P(GateFrames, WithDirectAccess) { check(GetParam(), GetParam().options); }

TEST_P(GateFrames, WithPortableLoads) {
  auto options = GetParam().options;
  options.direct_access = false;
  check(GetParam(), options);
}

INSTANTIATE_TEST_SUITE_P(Table, GateFrames, ::testing::ValuesIn(all_rows()),
                         [](const auto& row) { return row.param.name; });

TEST(GateCounters, CountPayloadBytesAndNoneOfRemoteFrames) {
  auto& gate = LoadedGate::with();
  const auto spec = remote(in(0x123));
  gate.admit({spec});
  for (unsigned len = 0; len <= 8; ++len) gate.run(kIn, frame(0x123, len));
  gate.run(kIn, frame(kRtr | 0x123, 8));
  const auto count =
      gates::slot_counters(gate.table(), gate.cpus(), gate.slots().find(spec).value());
  EXPECT_EQ(count.passed, 10U);
  EXPECT_EQ(count.bytes, 36U);
}

TEST(GateCounters, ListUnknownFramesNewestFirst) {
  auto& gate = LoadedGate::with();
  for (const std::uint32_t id : {0x100U, 0x200U, kEff | 0x300U, 0x100U})
    gate.run(kIn, frame(id, 3));
  gate.run(kOut, frame(0x200, 5, true), kLocal);
  const auto seen = gates::unknown_frames(gate.cpus());
  ASSERT_EQ(seen.size(), 4U);
  EXPECT_EQ(seen[0].can_id, 0x200U);
  EXPECT_EQ(seen[0].direction, kOut);
  EXPECT_EQ(seen[0].format, GATE_FD);
  EXPECT_EQ(seen[0].len, 5U);
  EXPECT_EQ(seen[1].can_id, 0x100U);
  EXPECT_EQ(seen[1].count, 2U);
  EXPECT_EQ(seen[2].can_id, kEff | 0x300U);
  EXPECT_EQ(seen[3].can_id, 0x200U);
  EXPECT_EQ(seen[3].sequence, 2U);
}

TEST(GateCounters, AtomicAdditionsCountTheSame) {
  auto& gate = LoadedGate::with({.profile = GATE_PROFILE_RAW, .atomic_counts = true});
  gate.admit({in(0x123), denied(in(0x124))});
  for (int i = 0; i < 1000; ++i) {
    gate.run(kIn, frame(0x123, 8));
    gate.run(kIn, frame(0x124, 8));
  }
  const auto reasons = gates::reason_counters(gate.cpus(), kIn);
  EXPECT_EQ(reasons.at(GATE_R_PASSED), 1000U);
  EXPECT_EQ(reasons.at(GATE_R_DENIED), 1000U);
}

/// A redirection to no interface: final in clsact and TCX, and success to the sender.
TEST(SilentGate, ReportsSuccessToSendersAndCountsAllTheSame) {
  const Bytes unknown = frame(0x124, 8);
  const auto drops = [](const LoadedGate& gate, Direction direction) {
    return gates::reason_counters(gate.cpus(), direction).at(GATE_R_UNKNOWN);
  };
  auto& reporting = LoadedGate::with();
  EXPECT_EQ(reporting.action(Direction::egress, unknown, {.local = true}), TC_ACT_SHOT);
  auto& gate = LoadedGate::with({.silent = true});
  EXPECT_EQ(gate.action(Direction::egress, unknown, {.local = true}), TC_ACT_REDIRECT);
  EXPECT_EQ(gate.action(Direction::ingress, unknown), TC_ACT_SHOT) << "no program here has sent it";
  EXPECT_EQ(drops(gate, Direction::egress), 1U);
  EXPECT_EQ(drops(gate, Direction::ingress), 1U);
  gate.control().open = 0;
  EXPECT_EQ(gate.action(Direction::egress, unknown, {.local = true}), TC_ACT_REDIRECT);
  gate.control().open = 1;
  gate.control().mode = GATE_AUDIT;
  EXPECT_EQ(gate.action(Direction::egress, unknown, {.local = true}), TC_ACT_UNSPEC);
  gate.reset();
}

TEST(GateWithoutProfile, KnowsNoSubject) {
  auto& gate = LoadedGate::with({.profile = GATE_PROFILE_NONE});
  EXPECT_TRUE(gate.run(kIn, frame(0x123, 8)).dropped);
  EXPECT_TRUE(gate.run(kOut, frame(kEff | 0x123, 8), kLocal).dropped);
  EXPECT_EQ(gates::reason_counters(gate.cpus(), kIn).at(GATE_R_UNKNOWN), 1U);
}

}  // namespace
}  // namespace mlcca::test
