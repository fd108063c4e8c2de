// SPDX-License-Identifier: BSD-2-Clause
// IP fragments, and the states of a gate, by the real programs.
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <string_view>

#include "tests/bpf/ether/events.hpp"

namespace mlcca::test {
namespace {

std::size_t cpus() { return static_cast<std::size_t>(sysconf(_SC_NPROCESSORS_ONLN)); }

/// This thread runs there and nowhere else.
class OnCpu {
 public:
  explicit OnCpu(std::size_t cpu) {
    EXPECT_EQ(sched_getaffinity(0, sizeof before_, &before_), 0);
    cpu_set_t only;
    CPU_ZERO(&only);
    CPU_SET(cpu, &only);
    EXPECT_EQ(sched_setaffinity(0, sizeof only, &only), 0);
  }
  OnCpu(const OnCpu&) = delete;
  OnCpu& operator=(const OnCpu&) = delete;
  ~OnCpu() { sched_setaffinity(0, sizeof before_, &before_); }

 private:
  cpu_set_t before_{};
};

class EtherFragments : public ::testing::Test {
 protected:
  EtherFragments() { gate_.admit({admitted_}); }
  bool passes(const Datagram& d, std::size_t begin, std::size_t end) {
    return !gate_.run(kIn, frame(d.fragment(begin, end))).dropped;
  }
  [[nodiscard]] std::uint64_t counted(gate_reason reason) const {
    return gate_.reasons(kIn).at(reason);
  }

  LoadedEther& gate_ = LoadedEther::with();
  SlotSpec admitted_ = sized(in(), 1400);
  Datagram known_ = event([](Datagram& d) { d.payload = 1383; });  // 1400 with its header
  Datagram unknown_ = event([](Datagram& d) { d.payload = 1383, d.subject = 1; });
};

TEST_F(EtherFragments, OfAnAdmittedEventPass) {
  EXPECT_TRUE(passes(known_, 0, 576));
  EXPECT_TRUE(passes(known_, 1152, 1400)) << "the last one before the others";
  EXPECT_TRUE(passes(known_, 576, 1152));
  EXPECT_EQ(counted(GATE_R_PASSED), 3U) << "packets";
  EXPECT_EQ(gate_.counted(admitted_).passed, 1U) << "datagrams";
  EXPECT_EQ(gate_.counted(admitted_).bytes, 1383U) << "of the event";
}

TEST_F(EtherFragments, HaveTheMarkOfTheirDatagram) {
  EXPECT_TRUE(passes(known_, 0, 576));
  const auto later = gate_.run(kIn, frame(known_.fragment(576, 1152)));
  EXPECT_EQ(later.mark, kAdmitted) << "so that egress knows it";
}

TEST_F(EtherFragments, BringNoMoreOctetsThanTheFirstOneSaid) {
  EXPECT_TRUE(passes(known_, 0, 576));
  int passed = 0;
  for (int i = 0; i < 1000; ++i) passed += passes(known_, 576, 1152) ? 1 : 0;
  EXPECT_EQ(passed, 1) << "of 824 octets that follow";
  EXPECT_EQ(counted(GATE_R_EXCESS), 999U);
  EXPECT_EQ(gate_.counted(admitted_).excess, 999U) << "of their channel";
  EXPECT_FALSE(passes(known_, 1144, 1400)) << "8 octets too many";
  EXPECT_TRUE(passes(known_, 1152, 1400)) << "what was refused has taken nothing";
  EXPECT_FALSE(passes(known_, 1392, 1400));
}

TEST_F(EtherFragments, MayOverlapWithinTheirOctets) {
  EXPECT_TRUE(passes(known_, 0, 576));
  EXPECT_TRUE(passes(known_, 576, 776));
  EXPECT_TRUE(passes(known_, 576, 776)) << "again";
  EXPECT_TRUE(passes(known_, 976, 1400)) << "824 in all";
  EXPECT_FALSE(passes(known_, 776, 976));
}

TEST_F(EtherFragments, ThatLeaveBringNoMoreOctetsEither) {
  const SlotSpec out = sized(of_user(0), 1400);
  gate_.admit({out});
  const auto leaves = [&](std::size_t begin, std::size_t end) {
    return !gate_.run(kOut, frame(known_.fragment(begin, end)), kLocal).dropped;
  };
  EXPECT_TRUE(leaves(0, 576));
  EXPECT_TRUE(leaves(576, 1152));
  EXPECT_FALSE(leaves(576, 1152));
  EXPECT_TRUE(leaves(1152, 1400));
  EXPECT_FALSE(leaves(1392, 1400));
  EXPECT_EQ(gate_.counted(out).excess, 2U);
}

TEST_F(EtherFragments, ANextFirstOneBringsOctetsOfItsOwn) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(passes(known_, 0, 576));
    EXPECT_TRUE(passes(known_, 576, 1400));
    EXPECT_FALSE(passes(known_, 576, 1400));
  }
  EXPECT_EQ(gate_.counted(admitted_).passed, 3U) << "each is counted and policed";
}

TEST_F(EtherFragments, OfAnotherEventDoNot) {
  EXPECT_FALSE(passes(unknown_, 0, 576));
  EXPECT_FALSE(passes(unknown_, 576, 1152));
  EXPECT_EQ(counted(GATE_R_UNKNOWN), 1U);
  EXPECT_EQ(counted(GATE_R_FRAGMENT), 1U);
}

TEST_F(EtherFragments, BeforeTheFirstOneAreDropped) {
  EXPECT_FALSE(passes(known_, 576, 1152));
  EXPECT_TRUE(passes(known_, 0, 576));
  EXPECT_TRUE(passes(known_, 576, 1152));
}

TEST_F(EtherFragments, OfAnotherDatagramAreDistinguished) {
  EXPECT_TRUE(passes(known_, 0, 576));
  for (const auto& change : std::vector<void (*)(Datagram&)>{
           [](Datagram& d) { ++d.id; }, [](Datagram& d) { ++d.source; },
           [](Datagram& d) { ++d.destination; }}) {
    Datagram other = known_;
    change(other);
    EXPECT_FALSE(passes(other, 576, 1152));
  }
  EXPECT_TRUE(gate_.run(kOut, frame(known_.fragment(576, 1152)), kLocal).dropped)
      << "the other way";
}

TEST_F(EtherFragments, AreNotLaidOverTheFirstOne) {
  EXPECT_TRUE(passes(known_, 0, 576));
  EXPECT_FALSE(passes(known_, 8, 576)) << "the subject again";
  EXPECT_FALSE(passes(known_, 568, 1152)) << "its last 8 bytes";
  EXPECT_TRUE(passes(known_, 576, 1152));
  EXPECT_EQ(counted(GATE_R_MALFORMED), 2U);
}

TEST_F(EtherFragments, EndWhereTheDatagramSaysSo) {
  Datagram longer = known_;
  longer.payload += 8;
  EXPECT_TRUE(passes(known_, 0, 576));
  EXPECT_FALSE(passes(longer, 576, 1408)) << "the last one, 8 bytes behind the end";
  EXPECT_FALSE(passes(longer, 1392, 1400)) << "more to come at the end";
  EXPECT_TRUE(passes(known_, 1152, 1400));
}

TEST_F(EtherFragments, MayEndWhereTheLongestDatagramEnds) {
  Datagram longest = known_;
  longest.port = 53;
  longest.payload = 65'535 - 17;
  EXPECT_TRUE(passes(longest, 0, 576));
  EXPECT_TRUE(passes(longest, 576, 1152));
  EXPECT_TRUE(passes(longest, 65'528, 65'535)) << "the last 7 octets that a length can state";
  EXPECT_EQ(counted(GATE_R_MALFORMED), 0U);
}

TEST_F(EtherFragments, OfADatagramThatLiesAboutItsLengthAreDropped) {
  Datagram lies = known_;
  lies.longer_udp = 576 - 1400;
  EXPECT_FALSE(passes(lies, 0, 576)) << "no more bytes than are here, and more fragments";
  lies.longer_udp = 8;
  EXPECT_TRUE(passes(lies, 0, 576)) << "this cannot be known yet";
  EXPECT_FALSE(passes(lies, 1152, 1400));
}

TEST_F(EtherFragments, TheLengthOfTheEventIsThatOfTheDatagram) {
  Datagram longer = known_;
  longer.payload = 1401;
  EXPECT_FALSE(passes(longer, 0, 576));
  EXPECT_EQ(counted(GATE_R_LENGTH), 1U);
}

TEST_F(EtherFragments, OfWhatIsNoEventAreLeftAlone) {
  Datagram dns = known_;
  dns.port = 53;
  EXPECT_FALSE(passes(dns, 576, 1152)) << "whose first one was not seen";
  EXPECT_TRUE(passes(dns, 0, 576));
  EXPECT_TRUE(passes(dns, 576, 1152));
  EXPECT_TRUE(passes(dns, 1152, 1400));
  EXPECT_EQ(counted(GATE_R_FOREIGN), 3U);
  EXPECT_EQ(counted(GATE_R_FRAGMENT), 1U);
}

TEST_F(EtherFragments, OneIdentificationIsNotUsedForTwoThings) {
  Datagram dns = known_;
  dns.port = 53;
  EXPECT_TRUE(passes(known_, 0, 576));
  EXPECT_FALSE(passes(dns, 0, 8)) << "its fragments would be laid over the subject";
  EXPECT_TRUE(passes(known_, 576, 1152));
  dns.id = known_.id + 1;
  Datagram next = known_;
  ++next.id;
  EXPECT_TRUE(passes(dns, 0, 8));
  EXPECT_FALSE(passes(next, 0, 576));
  EXPECT_EQ(counted(GATE_R_FRAGMENT), 2U);
}

TEST_F(EtherFragments, ARefusedSuccessorEndsThePassage) {
  EXPECT_TRUE(passes(known_, 0, 576));
  Datagram next = unknown_;
  EXPECT_FALSE(passes(next, 0, 576)) << "the same identification";
  EXPECT_FALSE(passes(known_, 576, 1152));
}

TEST_F(EtherFragments, ObeyTheVerdictOfNow) {
  EXPECT_TRUE(passes(known_, 0, 576));
  gates::SlotChanges close;
  close.close = {admitted_};
  ASSERT_TRUE(gate_.table().apply(close));
  EXPECT_FALSE(passes(known_, 576, 1152));
  gates::SlotChanges remove;
  remove.remove = {admitted_};
  ASSERT_TRUE(gate_.table().apply(remove));
  EXPECT_FALSE(passes(known_, 576, 1152));
  gate_.admit({admitted_});
  EXPECT_TRUE(passes(known_, 0, 576));
  gate_.control().lapsed = 1;
  EXPECT_FALSE(passes(known_, 576, 1152));
  EXPECT_EQ(counted(GATE_R_CLOSED), 1U);
  gate_.control().lapsed = 0;
  EXPECT_TRUE(passes(known_, 576, 1152));
}

TEST_F(EtherFragments, LeaveFromWhoeverMaySendTheFirstOne) {
  const Bytes first = frame(known_.fragment(0, 576));
  const Bytes later = frame(known_.fragment(576, 1152));
  const auto leaves = [&](const Bytes& bytes, const Sender& sender) {
    return !gate_.run(kOut, bytes, sender).dropped;
  };
  gate_.admit({sized(of_user(0), 1400)});
  EXPECT_TRUE(leaves(first, kLocal));
  EXPECT_FALSE(leaves(later, kWire)) << "from nowhere";
  EXPECT_FALSE(leaves(later, kForwarded)) << "from an interface";
  EXPECT_EQ(gate_.reasons(kOut).at(GATE_R_SOURCE), 2U);
  EXPECT_TRUE(leaves(later, kLocal));
}

TEST_F(EtherFragments, AreForwardedWithTheMarkOfTheirGate) {
  const auto leaves = [&](const Bytes& bytes, const Sender& sender) {
    return !gate_.run(kOut, bytes, sender).dropped;
  };
  gate_.admit({sized(from(kOther), 1400)});
  EXPECT_TRUE(leaves(frame(known_.fragment(0, 576)), kForwarded));
  const Bytes later = frame(known_.fragment(576, 1152));
  EXPECT_FALSE(leaves(later, Sender{.ingress_ifindex = kOther})) << "no gate has passed it";
  EXPECT_FALSE(leaves(later, kLocal));
  EXPECT_TRUE(leaves(later, kForwarded));
}

TEST_F(EtherFragments, HaveTheMarkOfTheirStation) {
  gate_.admit({with(admitted_, [](SlotSpec& s) { s.station = 0x0a000001; })});
  const auto mark = [&](std::size_t begin, std::size_t end) {
    return gate_.run(kIn, frame(known_.fragment(begin, end)), kWire).mark;
  };
  EXPECT_EQ(mark(0, 576), mark_from(kIfindex, 0x0a000001));
  EXPECT_EQ(mark(576, 1152), mark_from(kIfindex, 0x0a000001));
}

TEST_F(EtherFragments, ADatagramIsPolicedOnce) {
  SlotSpec policed = admitted_;
  policed.per_frame = 3'600'000'000'000;
  gates::SlotChanges change;
  change.police = {policed};
  ASSERT_TRUE(gate_.table().apply(change));
  EXPECT_TRUE(passes(known_, 0, 576));
  EXPECT_TRUE(passes(known_, 576, 1152));
  EXPECT_TRUE(passes(known_, 1152, 1400));
  Datagram next = known_;
  ++next.id;
  EXPECT_FALSE(passes(next, 0, 576));
  EXPECT_FALSE(passes(next, 576, 1152));
  EXPECT_EQ(gate_.counted(admitted_).excess, 1U);
}

/// Fragments that are lost of datagrams under way at once, where those of rounds before are still
/// in the map; first ones and later ones come on any CPU.
std::size_t lost(LoadedEther& gate, Datagram d, std::size_t under_way) {
  constexpr std::size_t burst = 128;
  std::size_t lost = 0;
  const auto pass = [&](std::size_t round, std::size_t begin, std::size_t end) {
    for (std::size_t first = 0; first < under_way; first += burst) {
      const OnCpu here((first / burst + round + begin) % cpus());
      for (std::size_t n = first; n < std::min(first + burst, under_way); ++n) {
        d.id = static_cast<std::uint16_t>(n);
        lost += gate.run(kIn, frame(d.fragment(begin, end))).dropped ? 1 : 0;
      }
    }
  };
  for (std::uint32_t round = 0; round < 4; ++round) {
    ++d.source;
    pass(round, 0, 576);
    pass(round, 576, 1152);
    pass(round, 1152, 1400);
  }
  return lost;
}

TEST_F(EtherFragments, SoManyDatagramsAtOnceAreRememberedAndNotManyMore) {
  Datagram dns = known_;
  dns.port = 53;
  dns.source += 1000;
  for (Datagram d : {known_, dns}) {
    EXPECT_EQ(lost(gate_, d, ETHER_FRAGMENTS), 0U);
    d.source += 100;
    EXPECT_GT(lost(gate_, d, 4 * ETHER_FRAGMENTS), 0U) << "of a map that has an end";
  }
}

TEST_F(EtherFragments, AFloodOfOthersPushesNoEventOut) {
  EXPECT_TRUE(passes(known_, 0, 576));
  Datagram dns = known_;
  dns.port = 53;
  ++dns.source;
  for (std::uint32_t i = 0; i < 8 * ETHER_FRAGMENTS; ++i) {
    dns.id = static_cast<std::uint16_t>(i);
    ASSERT_TRUE(passes(dns, 0, 576));
  }
  EXPECT_TRUE(passes(known_, 576, 1152));
}

TEST_F(EtherFragments, AreLeftToIngressByTheDriver) {
  EXPECT_FALSE(gate_.dropped_early(frame(unknown_.fragment(0, 576))));
  EXPECT_FALSE(gate_.dropped_early(frame(unknown_.fragment(576, 1152))));
}

// --- the states of a gate -----------------------------------------------------------------------

TEST(EtherStates, AClosedGateStopsEventsAndNothingElse) {
  LoadedEther& gate = LoadedEther::with();
  gate.admit({in()});
  const Bytes dns = packet([](Datagram& d) { d.port = 53; });
  for (const char* why : {"open", "lapsed", "deadline"}) {
    const std::string_view closed_by = why;
    gate.control().open = closed_by == "open" ? 0 : 1;
    gate.control().lapsed = closed_by == "lapsed" ? 1 : 0;
    gate.control().deadline = closed_by == "deadline" ? 1 : ~0ULL;
    EXPECT_TRUE(gate.run(kIn, packet()).dropped);
    EXPECT_TRUE(gate.dropped_early(packet()));
    EXPECT_FALSE(gate.run(kIn, dns).dropped);
    EXPECT_FALSE(gate.dropped_early(dns));
  }
  EXPECT_EQ(gate.reasons(kIn).at(GATE_R_CLOSED), 6U);
}

TEST(EtherStates, AuditCountsAndDropsNothing) {
  LoadedEther& gate = LoadedEther::with();
  gate.control().mode = GATE_AUDIT;
  EXPECT_FALSE(gate.run(kIn, packet()).dropped);
  EXPECT_FALSE(gate.dropped_early(packet()));
  EXPECT_EQ(gate.would_drop(kIn).at(GATE_R_UNKNOWN), 1U) << "once, at ingress";
  EXPECT_EQ(gate.reasons(kIn).at(GATE_R_UNKNOWN), 0U);
  EXPECT_EQ(gate.counted(kIn).would_drop, 1U);
  EXPECT_EQ(gate.counted(kIn).dropped, 0U);
  gate.control().mode = GATE_ENFORCE;
  EXPECT_TRUE(gate.run(kIn, packet()).dropped);
  EXPECT_TRUE(gate.dropped_early(packet()));
  EXPECT_EQ(gate.counted(kIn).would_drop, 1U) << "it stays";
  EXPECT_EQ(gate.counted(kIn).dropped, 2U);
}

TEST(EtherStates, AnUnknownFrameIsReported) {
  LoadedEther& gate = LoadedEther::with();
  for (int i = 0; i < 3; ++i) gate.run(kIn, packet());
  gate.run(kOut, packet([](Datagram& d) { d.subject = 5, d.payload = 300; }), kLocal);
  const auto unknown = gates::unknown_frames(gate.cpus());
  ASSERT_EQ(unknown.size(), 2U);
  EXPECT_EQ(unknown[0].subject, 5U);
  EXPECT_EQ(unknown[0].len, 300U);
  EXPECT_EQ(unknown[0].direction, kOut);
  EXPECT_EQ(unknown[1].subject, kSubject);
  EXPECT_EQ(unknown[1].count, 3U);
}

/// Puts a source address into an Ethernet header at `at`.
Bytes sent_by(const gates::Mac& mac, Bytes bytes, std::size_t at = 0) {
  std::ranges::copy(mac, bytes.begin() + static_cast<std::ptrdiff_t>(at + 6));
  return bytes;
}

/// The gate in front of drivers and that of tc note the same.
TEST(EtherStates, AnUnknownFrameIsReportedWithTheAddressOfItsSender) {
  constexpr gates::Mac near{0x02, 0, 0x5e, 0x10, 0, 1};
  constexpr gates::Mac inner{0x02, 0, 0x5e, 0x10, 0, 2};
  for (const bool direct : {true, false})
    for (const bool early : {false, true}) {
      LoadedEther& gate = LoadedEther::with({.direct_access = direct});
      const auto latest = [&](const Bytes& bytes) {
        EXPECT_TRUE(early ? gate.dropped_early(bytes) : gate.run(kIn, bytes).dropped);
        return gates::unknown_frames(gate.cpus()).at(0);
      };
      const auto udp =
          latest(sent_by(near, packet([](Datagram& d) { d.subject = 1, d.source = 0x0a000007; })));
      EXPECT_EQ(udp.subject, 1U);
      EXPECT_EQ(gates::sender_text(udp.station, udp.mac), "10.0.0.7 (02:00:5e:10:00:01)");
      const auto again =
          latest(sent_by(inner, packet([](Datagram& d) { d.subject = 1, d.source = 0x0a000008; })));
      EXPECT_EQ(again.count, 2U);
      EXPECT_EQ(gates::sender_text(again.station, again.mac), "10.0.0.8 (02:00:5e:10:00:02)")
          << "the latest";
      const auto tagged =
          latest(sent_by(near, ethernet(0x0800, Datagram{.subject = 2}.whole(), {0x8100})));
      EXPECT_EQ(gates::sender_text(tagged.station, tagged.mac), "10.0.0.1 (02:00:5e:10:00:01)");
      const auto awds = latest(sent_by(near, ethernet(0x8334, awds_flood(0x7c, awds_event(3, 8)))));
      EXPECT_EQ(gates::sender_text(awds.station, awds.mac), "02:a1:b2:c3:d4:e5")
          << "not the neighbour that passed it on";
      const auto in_awds = latest(sent_by(
          near,
          ethernet(0x8334,
                   awds_flood(98, sent_by(inner, packet([](Datagram& d) { d.subject = 4; }))))));
      EXPECT_EQ(gates::sender_text(in_awds.station, in_awds.mac), "10.0.0.1 (02:00:5e:10:00:02)");
    }
}

TEST(EtherStates, ExcessMayPassAndIsCountedAllTheSame) {
  LoadedEther& gate = LoadedEther::with();
  SlotSpec s = in();
  s.per_frame = 3'600'000'000'000;
  s.excess_passes = true;
  gate.admit({s});
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(gate.run(kIn, packet()).dropped);
  EXPECT_EQ(gate.counted(s).excess, 2U);
  EXPECT_EQ(gate.counted(s).passed, 3U);
}

TEST(EtherStates, ForeignTrafficKeepsItsMark) {
  LoadedEther& gate = LoadedEther::with();
  EXPECT_EQ(gate.run(kIn, ethernet(0x0806, Bytes(28)), {.mark = 77}).mark, 77U);
  EXPECT_EQ(gate.run(kIn, packet(), {.mark = kAdmitted}).mark, 0U) << "an event does not";
}

}  // namespace
}  // namespace mlcca::test
