// SPDX-License-Identifier: BSD-2-Clause
// The gate on real Ethernet devices with real UDP sockets, so that the kernel's own IP fragments
// cross it.
#include <bpf/bpf.h>
#include <linux/bpf.h>
#include <linux/if_packet.h>

#include <array>

#include "daemon/gates/counters.hpp"
#include "daemon/gates/early.hpp"
#include "daemon/gates/ether_programs.hpp"
#include "daemon/gates/programs.hpp"
#include "daemon/gates/retire.hpp"
#include "tests/bpf/ether/sockets_fixture.hpp"

namespace mlcca::gates {
namespace {

TEST_P(EtherSockets, AnAdmittedEventArrivesAndAnotherDoesNot) {
  admit({slot(Direction::ingress)});
  ASSERT_TRUE(send(far_, "239.68.101.110", kPort, event(kSubject + 1, 8)));
  ASSERT_TRUE(send(far_, "239.68.101.110", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(near_), 17U) << "the first one that arrives is the admitted one";
  EXPECT_EQ(counted(Direction::ingress, GATE_R_PASSED), 1U);
  EXPECT_EQ(counted(Direction::ingress, GATE_R_UNKNOWN), 1U);
  EXPECT_EQ(gate_.counters(slot(Direction::ingress)).value().passed, 1U);
  EXPECT_EQ(gate_.unknown().at(0).subject, kSubject + 1);
}

TEST_P(EtherSockets, TheDriverDropsWhatIsUnknown) {
  EXPECT_TRUE(gate_.drops_early()) << "veth has XDP";
  EXPECT_NE(early_program(if_nametoindex("eth0")), 0U);
  // A packet socket sees what passes the driver, whatever tc does with it.
  const Fd tap(::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, htons(0x0800)));
  admit({slot(Direction::ingress)});
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject + 1, 3)));
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 5)));
  EXPECT_EQ(received(tap), 20U + 8 + 9 + 5);
  EXPECT_EQ(counted(Direction::ingress, GATE_R_UNKNOWN), 1U);
}

TEST_P(EtherSockets, FragmentsOfAnAdmittedEventArriveAndThoseOfAnotherDoNot) {
  admit({slot(Direction::ingress)});
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject + 1, 1400)));
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 1400)));
  EXPECT_EQ(received(near_), 1409U);
  EXPECT_EQ(counted(Direction::ingress, GATE_R_PASSED), 3U);
  EXPECT_EQ(counted(Direction::ingress, GATE_R_UNKNOWN), 1U) << "the first one";
  EXPECT_EQ(counted(Direction::ingress, GATE_R_FRAGMENT), 2U) << "those that follow it";
  EXPECT_EQ(gate_.counters(slot(Direction::ingress)).value().passed, 1U);
}

TEST_P(EtherSockets, FragmentsLeaveAsTheyCame) {
  SlotSpec out = slot(Direction::egress);
  out.uid = ::geteuid();
  admit({out});
  send(near_, "10.0.0.2", kPort, event(kSubject + 1, 1400));
  ASSERT_TRUE(send(near_, "10.0.0.2", kPort, event(kSubject, 1400)));
  EXPECT_EQ(received(far_), 1409U);
  EXPECT_EQ(counted(Direction::egress, GATE_R_PASSED), 3U);
  EXPECT_EQ(counted(Direction::egress, GATE_R_UNKNOWN), 1U) << "the kernel sends no others then";
}

TEST_P(EtherSockets, AnotherSenderCannotSendTheRestOfAnEvent) {
  SlotSpec out = slot(Direction::egress);
  out.uid = ::geteuid();
  admit({out});
  Datagram d{.subject = kSubject, .payload = 800};
  d.source = inet_addr("10.0.0.1");
  d.destination = inet_addr("10.0.0.2");
  const auto by = [&](uid_t user, std::size_t begin, std::size_t end) {
    const Fd raw(::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0));
    EXPECT_EQ(fchown(raw.get(), user, static_cast<gid_t>(-1)), 0);
    sockaddr_ll to{};
    to.sll_family = AF_PACKET;
    to.sll_protocol = htons(0x0800);
    to.sll_ifindex = static_cast<int>(if_nametoindex("eth0"));
    const Bytes bytes = test::frame(d.fragment(begin, end));
    ::sendto(raw.get(), bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to);
  };
  by(::geteuid(), 0, 400);
  by(12345, 400, 817);
  EXPECT_EQ(counted(Direction::egress, GATE_R_SOURCE), 1U);
  by(::geteuid(), 400, 817);
  EXPECT_EQ(counted(Direction::egress, GATE_R_PASSED), 2U);
}

TEST_P(EtherSockets, WhatAProgramSendsIsItsUsers) {
  SlotSpec of_another = slot(Direction::egress);
  of_another.uid = 12345;
  admit({of_another});
  send(near_, "10.0.0.2", kPort, event(kSubject, 3));  // the kernel reports it to no UDP sender
  EXPECT_EQ(counted(Direction::egress, GATE_R_SOURCE), 1U);
  const auto senders = gate_.refused_senders();
  ASSERT_EQ(senders.size(), 1U);
  EXPECT_EQ(senders[0].uid, ::geteuid());
  EXPECT_EQ(senders[0].source, 0U);
  EXPECT_EQ(senders[0].frame.station, 0x0a000001U);
  const Fd theirs = Wire::get().socket(false, kPort);
  ASSERT_EQ(fchown(theirs.get(), 12345, static_cast<gid_t>(-1)), 0);
  EXPECT_TRUE(send(theirs, "10.0.0.2", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(far_), 17U);
}

TEST_P(EtherSockets, BroadcastsAreEvents) {
  const Fd near = Wire::get().socket(false, 8888);
  const Fd far = Wire::get().socket(true, 8888);
  admit({slot(Direction::ingress)});
  ASSERT_TRUE(send(far, "10.0.0.255", 8888, event(kSubject + 1, 8)));
  ASSERT_TRUE(send(far, "10.0.0.255", 8888, event(kSubject, 4)));
  EXPECT_EQ(received(near), 13U);
}

/// The kernel makes the local copy before the gate sees whose event it is: any program could give
/// others here events that were admitted to nobody.
TEST_P(EtherSockets, LocalCopiesOfEventsReachNobody) {
  const SlotSpec out = slot(Direction::egress);
  admit({out, slot(Direction::ingress)});
  const Fd listener = Wire::get().socket(false, kPort);
  for (const char* const to : {"239.68.101.110", "10.0.0.255"}) {
    ASSERT_TRUE(send(near_, to, kPort, event(kSubject, 1400)));
    ASSERT_TRUE(send(near_, to, kPort, event(kSubject, 8)));
    EXPECT_EQ(received(far_), 1409U);
    EXPECT_EQ(received(far_), 17U);
  }
  ASSERT_TRUE(send(far_, "239.68.101.110", kPort, event(kSubject, 3)));
  EXPECT_EQ(received(listener), 12U) << "from the wire, and none of the copies before it";
  EXPECT_EQ(counted(Direction::ingress, GATE_R_ECHO), 4U);
}

TEST_P(EtherSockets, LocalCopiesOfOtherTrafficAreLeftAlone) {
  const Fd listener = Wire::get().socket(false, 5353);
  const Fd sender = Wire::get().socket(false, 0);
  const Bytes large = event(kSubject, 1400);
  ASSERT_TRUE(send(sender, "239.68.101.110", 5353, large));
  EXPECT_EQ(received(listener), large.size());
  control_.close_all();
  ASSERT_TRUE(send(sender, "10.0.0.255", 5353, large));
  EXPECT_EQ(received(listener), large.size());
}

TEST_P(EtherSockets, SeveralDatagramsInOneBufferDoNotLeave) {
  admit({slot(Direction::egress)});
  constexpr int segment = 103;  // UDP_SEGMENT
  const int size = 17;
  const Fd sender = Wire::get().socket(false, 0);
  ASSERT_EQ(setsockopt(sender.get(), IPPROTO_UDP, segment, &size, sizeof size), 0);
  Bytes two = event(kSubject, 8);
  const Bytes hidden = event(kSubject + 1, 8);
  two.insert(two.end(), hidden.begin(), hidden.end());
  send(sender, "10.0.0.2", kPort, two);
  EXPECT_EQ(counted(Direction::egress, GATE_R_MALFORMED), 1U);
  EXPECT_EQ(counted(Direction::egress, GATE_R_PASSED), 0U);
}

TEST_P(EtherSockets, OtherTrafficIsLeftAloneWhenTheGateIsClosed) {
  control_.close_all();
  const Fd near = Wire::get().socket(false, 5353);
  const Fd far = Wire::get().socket(true, 5353);
  ASSERT_TRUE(send(far, "10.0.0.1", kPort, event(kSubject, 8)));
  ASSERT_TRUE(send(far, "10.0.0.1", 5353, Bytes(1400)));
  EXPECT_EQ(received(near), 1400U);
  ASSERT_TRUE(send(near, "10.0.0.2", 5353, Bytes(300)));
  EXPECT_EQ(received(far), 300U);
  EXPECT_EQ(eventually(1, [&] { return counted(Direction::ingress, GATE_R_CLOSED); }), 1U);
}

/// What UDP does with an error of the device is its own matter: a packet socket gets to see it.
TEST_P(EtherSockets, ASilentGateDropsAndTheSenderSeesSuccess) {
  Datagram unknown{.subject = kSubject + 1, .payload = 8};
  unknown.source = inet_addr("10.0.0.1");
  unknown.destination = inet_addr("10.0.0.2");
  const Bytes bytes = test::frame(unknown.whole());
  sockaddr_ll to{};
  to.sll_family = AF_PACKET;
  to.sll_protocol = htons(0x0800);
  to.sll_ifindex = static_cast<int>(if_nametoindex("eth0"));
  const Fd raw(::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0));
  const auto sent = [&] {
    return ::sendto(raw.get(), bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to),
                    sizeof to);
  };
  admit({slot(Direction::ingress), slot(Direction::egress)});
  EXPECT_EQ(sent(), -1);
  EXPECT_EQ(errno, ENOBUFS);
  EXPECT_EQ(counted(Direction::egress, GATE_R_UNKNOWN), 1U);

  EXPECT_FALSE(gate_.holds(config(0, true)));
  gate_ = attach(0, GetParam(), true);
  EXPECT_TRUE(gate_.holds(config(0, true)));
  EXPECT_EQ(gate_.present().size(), 2U) << "what was granted stays";
  EXPECT_EQ(sent(), std::ssize(bytes));
  EXPECT_EQ(counted(Direction::egress, GATE_R_UNKNOWN), 2U) << "it is counted all the same";
  ASSERT_TRUE(send(near_, "10.0.0.2", kPort, event(kSubject, 3)));
  EXPECT_EQ(received(far_), 12U) << "nothing of the others has come";
  control_.close_all();
  EXPECT_EQ(sent(), std::ssize(bytes));
  EXPECT_EQ(counted(Direction::egress, GATE_R_CLOSED), 1U);
  control_.open();
}

TEST_P(EtherSockets, ANewObjectTakesOverWhatIsThere) {
  admit({slot(Direction::ingress)});
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(near_), 17U);
  gate_ = attach();
  EXPECT_TRUE(gate_.reused());
  EXPECT_TRUE(gate_.drops_early());
  EXPECT_EQ(gate_.present(), std::vector{slot(Direction::ingress)});
  EXPECT_EQ(gate_.counters(slot(Direction::ingress)).value().passed, 1U);
  EXPECT_TRUE(gate_.attached().value());
}

TEST_P(EtherSockets, ALargerOneTakesTheSlotsAlong) {
  admit({slot(Direction::ingress)});
  EXPECT_FALSE(gate_.holds(config(20'000)));
  gate_ = attach(20'000);
  EXPECT_TRUE(gate_.holds(config(20'000)));
  EXPECT_EQ(gate_.present(), std::vector{slot(Direction::ingress)});
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(near_), 17U);
  EXPECT_TRUE(gate_.drops_early());
}

/// After an upgrade the pins of the version before lie beside ours.
TEST_P(EtherSockets, TheProgramOfAnotherLayoutIsReplacedInTheDriver) {
  const std::string layout = control_.directory();
  const std::string other = layout.substr(0, layout.rfind('/')) + "/v0";
  std::filesystem::create_directories(other);
  const std::string pins = "/if" + std::to_string(if_nametoindex("eth0"));
  std::filesystem::create_directories(other + pins);
  std::filesystem::rename(layout + pins + "/early", other + pins + "/early");
  const auto before = early_program(if_nametoindex("eth0"));
  gate_ = attach();
  EXPECT_TRUE(gate_.drops_early());
  EXPECT_NE(early_program(if_nametoindex("eth0")), before);
}

TEST_P(EtherSockets, AForeignProgramInTheDriverStays) {
  std::array<bpf_insn, 2> pass{};
  pass[0].code = BPF_ALU64 | BPF_MOV | BPF_K;
  pass[0].imm = XDP_PASS;
  pass[1].code = BPF_JMP | BPF_EXIT;
  const Fd foreign(
      bpf_prog_load(BPF_PROG_TYPE_XDP, "ether_early", "GPL", pass.data(), pass.size(), nullptr));
  ASSERT_TRUE(foreign);
  ASSERT_TRUE(put_early(if_nametoindex("eth0"), foreign.get(), true));
  gate_ = attach();
  EXPECT_FALSE(gate_.drops_early());
  EXPECT_EQ(early_program(if_nametoindex("eth0")), program_info(foreign.get()).id)
      << "the name of ours, and no map of ours";
  EXPECT_TRUE(gate_.attached().value()) << "tc holds all of it";
}

/// It would go on by a word that gets no heart-beat, and drop what the gate of tc holds to be
/// admitted.
TEST_P(EtherSockets, AProgramInTheDriverWhosePinsAreGoneIsReplaced) {
  const auto before = early_program(if_nametoindex("eth0"));
  ASSERT_NE(before, 0U);
  ASSERT_TRUE(control_.set_grace(0));
  std::filesystem::remove_all(std::filesystem::path(control_.directory()).parent_path());
  control_ = create();
  ASSERT_TRUE(control_.set_grace(kForEver));
  ASSERT_TRUE(control_.beat(0));
  control_.open();
  gate_ = attach();
  EXPECT_FALSE(gate_.reused());
  EXPECT_TRUE(gate_.drops_early());
  admit({slot(Direction::ingress)});
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject + 1, 8)));
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 9)));
  EXPECT_EQ(received(near_), 18U);
}

/// No heart-beat comes, and nothing is left that could close: neither daemon nor pins nor timer.
TEST_P(EtherSockets, ClosesByItselfWhenDaemonAndPinsAreGone) {
  admit({slot(Direction::egress)});
  const Fd counters =
      open_pin(ether_map_pin(place(GetParam(), control_).directory, &EtherMaps::cpus));
  const Mapped<ether_cpu> cpus(counters.get(), possible_cpus());
  ASSERT_TRUE(cpus);
  const auto counts = [&](gate_reason reason) {
    return reason_counters(cpus.span(), Direction::egress).at(reason);
  };
  ASSERT_TRUE(send(near_, "10.0.0.2", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(far_), 17U);
  EXPECT_EQ(counts(GATE_R_PASSED), 1U);
  ASSERT_TRUE(control_.set_grace(0));
  std::filesystem::remove_all(std::filesystem::path(control_.directory()).parent_path());
  control_ = create();
  // This process holds nothing of eth0 any more: its gate is of another interface now.
  shell("ip link add other0 type veth peer name other1");
  auto elsewhere = EtherGate::attach({if_nametoindex("other0"), "other0", 0, GetParam()}, control_);
  ASSERT_TRUE(elsewhere);
  gate_ = std::move(*elsewhere);
  const auto closed = [&]() -> std::uint64_t {
    static_cast<void>(send(near_, "10.0.0.2", kPort, event(kSubject, 8)));
    return counts(GATE_R_CLOSED) > 0 ? 1 : 0;
  };
  EXPECT_EQ(eventually(1, closed), 1U);
  shell("ip link del other0");
  gate_ = attach();  // takes its place, so that the next test begins with one
  EXPECT_TRUE(gate_.attached().value());
}

TEST_P(EtherSockets, WhatWasRemovedIsPutBack) {
  admit({slot(Direction::ingress)});
  remove_gate();
  EXPECT_FALSE(gate_.attached().value());
  const auto back = gate_.reattach();
  ASSERT_TRUE(back) << back.error().text;
  EXPECT_TRUE(gate_.attached().value());
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(near_), 17U);
}

TEST_P(EtherSockets, WithoutItsPinsItStaysInForceAndGetsThemAgain) {
  admit({slot(Direction::ingress)});
  const std::string directory = place(GetParam(), control_).directory;
  std::filesystem::remove_all(directory);
  EXPECT_TRUE(gate_.attached().value());
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject + 1, 8)));
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 9)));
  EXPECT_EQ(received(near_), 18U) << "what is not admitted is dropped";
  EXPECT_FALSE(gate_.keep_pinned().value().empty());
  EXPECT_TRUE(gate_.keep_pinned().value().empty());
  gate_ = attach();
  EXPECT_TRUE(gate_.reused());
  EXPECT_EQ(gate_.present(), std::vector{slot(Direction::ingress)});
}

TEST_P(EtherSockets, WhatWasRemovedFromTheDriverIsPutBackThere) {
  EXPECT_FALSE(gate_.lost_early());
  shell("ip link set dev eth0 xdp off");
  EXPECT_TRUE(gate_.attached().value()) << "tc holds all of it";
  EXPECT_TRUE(gate_.lost_early());
  EXPECT_FALSE(gate_.drops_early());
  ASSERT_TRUE(gate_.put_early_back());
  EXPECT_FALSE(gate_.lost_early());
  EXPECT_TRUE(gate_.drops_early());
  EXPECT_EQ(early_program(if_nametoindex("eth0")), gate_.early());
}

/// It goes with its device to another namespace, and comes back when its pins are gone.
TEST_P(EtherSockets, TheProgramThatAGateLeftInTheDriverLetsAllPassAndIsReplaced) {
  const std::string directory = place(GetParam(), control_).directory;
  const Fd left = open_pin(early_pin(directory));
  const auto drops = [&] {
    const Bytes bytes = test::frame(Datagram{.subject = kSubject}.whole());
    LIBBPF_OPTS(bpf_test_run_opts, run);
    run.data_in = bytes.data();
    run.data_size_in = static_cast<std::uint32_t>(bytes.size());
    EXPECT_EQ(bpf_prog_test_run_opts(left.get(), &run), 0);
    return run.retval == XDP_DROP;
  };
  EXPECT_TRUE(drops());
  const auto before = gate_.early();
  retire_gate(directory);
  gate_.unpin();
  EXPECT_FALSE(drops());
  EXPECT_EQ(early_program(if_nametoindex("eth0")), before);
  for (const auto hook : {Hook::clsact, Hook::tcx}) withdraw(place(hook, control_));
  gate_ = attach();
  EXPECT_FALSE(gate_.reused());
  EXPECT_TRUE(gate_.drops_early());
  EXPECT_NE(early_program(if_nametoindex("eth0")), before);
  admit({slot(Direction::ingress)});
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(near_), 17U);
}

TEST_P(EtherSockets, OneHookTakesOverFromTheOther) {
  if (!kernel_has_tcx()) return;
  admit({slot(Direction::ingress)});
  gate_ = attach(0, GetParam() == Hook::tcx ? Hook::clsact : Hook::tcx);
  EXPECT_TRUE(gate_.reused());
  EXPECT_NE(gate_.hook(), GetParam());
  EXPECT_TRUE(gate_.attached().value());
  EXPECT_EQ(gate_.present(), std::vector{slot(Direction::ingress)});
  EXPECT_EQ(in_place(place(GetParam(), control_)).value().ingress, 0U) << "one of them is enough";
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(near_), 17U);
  EXPECT_EQ(counted(Direction::ingress, GATE_R_PASSED), 1U);
}

TEST_P(EtherSockets, ACopyGoesFirstAndKnowsWhatWasThere) {
  admit({slot(Direction::ingress)});
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(near_), 17U);
  const auto first = gate_.go_first();
  ASSERT_TRUE(first) << first.error().text;
  EXPECT_TRUE(gate_.attached().value());
  EXPECT_TRUE(gate_.drops_early());
  EXPECT_TRUE(gate_.ahead().value().empty());
  EXPECT_EQ(gate_.counters(slot(Direction::ingress)).value().passed, 1U);
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject + 1, 8)));
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(near_), 17U);
  gate_ = attach();
  EXPECT_TRUE(gate_.reused());
}

TEST_P(EtherSockets, ADeviceWithoutEthernetFramesHasNoGate) {
  shell("ip tuntap add dev none0 mode tun");
  const auto gate = EtherGate::attach({if_nametoindex("none0"), "none0", 0, {}}, control_);
  ASSERT_FALSE(gate);
  EXPECT_EQ(gate.error().text,
            "gate of none0: it has frames neither of Ethernet nor of IEEE 802.15.4");
  shell("ip link del none0");
}

INSTANTIATE_TEST_SUITE_P(By, EtherSockets, ::testing::ValuesIn(hooks()), name_of);

}  // namespace
}  // namespace mlcca::gates
