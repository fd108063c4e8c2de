// SPDX-License-Identifier: BSD-2-Clause
// The gate on real Ethernet devices with real UDP sockets: a pair of them between two namespaces,
// so that the kernel's own IP fragments cross it.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>

#include "bpf/ether.h"
#include "core/handle.hpp"
#include "daemon/clock.hpp"
#include "daemon/enforce/early.hpp"
#include "daemon/enforce/ether_gate.hpp"
#include "daemon/enforce/events.hpp"
#include "ether/packets.hpp"

namespace mlcca::enforce {
namespace {

using test::Bytes;
using test::Datagram;

void require(bool done, const char* what) {
  if (done) return;
  std::perror(what);
  std::abort();
}

void shell(const std::string& command) {
  require(std::system(command.c_str()) == 0, command.c_str());  // NOLINT(*-command-processor)
}

/// Two namespaces, this one with eth0 (10.0.0.1), the other with far0 (10.0.0.2), MTU 600.
class Wire {
 public:
  static Wire& get() {
    static Wire wire;
    return wire;
  }
  /// A UDP socket there.
  [[nodiscard]] Fd socket(bool far, std::uint16_t port) const {
    require(setns(far ? far_.get() : near_.get(), CLONE_NEWNET) == 0, "setns");
    Fd fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    const int yes = 1;
    setsockopt(fd.get(), SOL_SOCKET, SO_BROADCAST, &yes, sizeof yes);
    setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    require(bind(fd.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) == 0, "bind");
    ip_mreqn group{};
    group.imr_multiaddr.s_addr = inet_addr("239.68.101.110");
    group.imr_ifindex = static_cast<int>(if_nametoindex(far ? "far0" : "eth0"));
    require(setsockopt(fd.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) == 0, "join");
    setsockopt(fd.get(), IPPROTO_IP, IP_MULTICAST_IF, &group, sizeof group);
    require(setns(near_.get(), CLONE_NEWNET) == 0, "setns");
    return fd;
  }

  std::string root;

 private:
  Wire() {
    require(unshare(CLONE_NEWNET | CLONE_NEWNS) == 0, "unshare (needs root)");
    require(mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0, "private mounts");
    root = std::filesystem::temp_directory_path() / "mlcca-ether-test";
    std::filesystem::create_directories(root);
    require(mount("bpf", root.c_str(), "bpf", 0, nullptr) == 0, "mount a bpffs");
    near_ = Fd(open("/proc/self/ns/net", O_RDONLY | O_CLOEXEC));
    require(unshare(CLONE_NEWNET) == 0, "unshare");
    far_ = Fd(open("/proc/self/ns/net", O_RDONLY | O_CLOEXEC));
    shell("ip link set lo up");
    require(setns(near_.get(), CLONE_NEWNET) == 0, "setns");
    const std::string far =
        "/proc/" + std::to_string(getpid()) + "/fd/" + std::to_string(far_.get());
    shell("ip link set lo up");
    shell("ip link add eth0 mtu 600 type veth peer name far0 mtu 600 netns " + far);
    // No neighbour discovery: a test counts its own packets.
    shell("echo 1 2>/dev/null > /proc/sys/net/ipv6/conf/eth0/disable_ipv6 || true");
    shell("ip addr add 10.0.0.1/24 brd + dev eth0");
    shell("ip link set eth0 up");
    require(setns(far_.get(), CLONE_NEWNET) == 0, "setns");
    shell("echo 1 2>/dev/null > /proc/sys/net/ipv6/conf/far0/disable_ipv6 || true");
    shell("ip addr add 10.0.0.2/24 brd + dev far0");
    shell("ip link set far0 up");
    require(setns(near_.get(), CLONE_NEWNET) == 0, "setns");
  }

  Fd near_;
  Fd far_;
};

constexpr std::uint64_t kSubject = 0x44697374616e6365;
constexpr std::uint16_t kPort = 9999;

Bytes event(std::uint64_t subject, std::size_t payload) {
  const Bytes content = Datagram{.subject = subject, .payload = payload}.content();
  return {content.begin() + 8, content.end()};
}

bool send(const Fd& from, const char* address, std::uint16_t port, const Bytes& bytes) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = inet_addr(address);
  return sendto(from.get(), bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to),
                sizeof to) == std::ssize(bytes);
}

/// The next datagram, waited for; nothing after a generous time.
std::optional<std::size_t> received(const Fd& at) {
  pollfd wait{.fd = at.get(), .events = POLLIN, .revents = 0};
  if (poll(&wait, 1, 10'000) != 1) return std::nullopt;
  Bytes bytes(65536);
  return static_cast<std::size_t>(recv(at.get(), bytes.data(), bytes.size(), 0));
}

SlotSpec slot(Direction direction, std::uint64_t subject = kSubject) {
  SlotSpec s;
  s.direction = direction;
  s.pass = true;
  s.subject = subject;
  s.max_len = 1500;
  s.formats = ETHER_WHOLE;
  return s;
}

class EtherSockets : public testing::Test {
 protected:
  EtherSockets() : control_(create()), gate_(attach()) { control_.open(); }
  static Control create() {
    static int number = 0;
    shell("ip link set dev eth0 xdp off");  // of the test before
    auto control = Control::create(Wire::get().root + "/root" + std::to_string(++number));
    require(control.has_value(), "control");
    return std::move(*control);
  }
  EtherGate attach(std::size_t slots = 0) {
    auto gate = EtherGate::attach({if_nametoindex("eth0"), "eth0", slots}, control_);
    if (!gate) std::fprintf(stderr, "%s\n", gate.error().text.c_str());
    require(gate.has_value(), "attach");
    return std::move(*gate);
  }
  void admit(const std::vector<SlotSpec>& specs) {
    SlotChanges changes;
    changes.add = specs;
    ASSERT_TRUE(gate_.apply(changes));
  }
  [[nodiscard]] std::uint64_t counted(Direction direction, gate_reason reason) const {
    return gate_.reasons(direction).at(reason);
  }
  /// The number once it is what it should be; else, after a generous time, what it is.
  static std::uint64_t eventually(std::uint64_t wanted, auto number) {
    for (int i = 0; i < 5000 && number() != wanted; ++i) poll(nullptr, 0, 1);
    return number();
  }

  Control control_;
  EtherGate gate_;
  Fd near_ = Wire::get().socket(false, kPort);
  Fd far_ = Wire::get().socket(true, kPort);
};

TEST_F(EtherSockets, AnAdmittedEventArrivesAndAnotherDoesNot) {
  admit({slot(Direction::ingress)});
  ASSERT_TRUE(send(far_, "239.68.101.110", kPort, event(kSubject + 1, 8)));
  ASSERT_TRUE(send(far_, "239.68.101.110", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(near_), 17U) << "the first one that arrives is the admitted one";
  EXPECT_EQ(counted(Direction::ingress, GATE_R_PASSED), 1U);
  EXPECT_EQ(counted(Direction::ingress, GATE_R_UNKNOWN), 1U);
  EXPECT_EQ(gate_.counters(slot(Direction::ingress)).value().passed, 1U);
  EXPECT_EQ(gate_.unknown().at(0).subject, kSubject + 1);
}

TEST_F(EtherSockets, TheDriverDropsWhatIsUnknown) {
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

TEST_F(EtherSockets, FragmentsOfAnAdmittedEventArriveAndThoseOfAnotherDoNot) {
  admit({slot(Direction::ingress)});
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject + 1, 1400)));
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 1400)));
  EXPECT_EQ(received(near_), 1409U);
  EXPECT_EQ(counted(Direction::ingress, GATE_R_PASSED), 3U);
  EXPECT_EQ(counted(Direction::ingress, GATE_R_UNKNOWN), 1U) << "the first one";
  EXPECT_EQ(counted(Direction::ingress, GATE_R_FRAGMENT), 2U) << "those that follow it";
  EXPECT_EQ(gate_.counters(slot(Direction::ingress)).value().passed, 1U);
}

TEST_F(EtherSockets, FragmentsLeaveAsTheyCame) {
  SlotSpec out = slot(Direction::egress);
  out.uid = ::geteuid();
  admit({out});
  send(near_, "10.0.0.2", kPort, event(kSubject + 1, 1400));
  ASSERT_TRUE(send(near_, "10.0.0.2", kPort, event(kSubject, 1400)));
  EXPECT_EQ(received(far_), 1409U);
  EXPECT_EQ(counted(Direction::egress, GATE_R_PASSED), 3U);
  EXPECT_EQ(counted(Direction::egress, GATE_R_UNKNOWN), 1U) << "the kernel sends no others then";
}

TEST_F(EtherSockets, NobodyElseSendsTheRestOfAnEvent) {
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

TEST_F(EtherSockets, WhatAProgramSendsIsItsUsers) {
  SlotSpec of_another = slot(Direction::egress);
  of_another.uid = 12345;
  admit({of_another});
  send(near_, "10.0.0.2", kPort, event(kSubject, 3));  // the kernel tells no UDP sender
  EXPECT_EQ(counted(Direction::egress, GATE_R_SOURCE), 1U);
  const Fd theirs = Wire::get().socket(false, kPort);
  ASSERT_EQ(fchown(theirs.get(), 12345, static_cast<gid_t>(-1)), 0);
  EXPECT_TRUE(send(theirs, "10.0.0.2", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(far_), 17U);
}

TEST_F(EtherSockets, BroadcastsAreEvents) {
  const Fd near = Wire::get().socket(false, 8888);
  const Fd far = Wire::get().socket(true, 8888);
  admit({slot(Direction::ingress)});
  ASSERT_TRUE(send(far, "10.0.0.255", 8888, event(kSubject + 1, 8)));
  ASSERT_TRUE(send(far, "10.0.0.255", 8888, event(kSubject, 4)));
  EXPECT_EQ(received(near), 13U);
}

TEST_F(EtherSockets, LocalCopiesOfAGroupAreNoneOfTheWires) {
  SlotSpec out = slot(Direction::egress);
  admit({out});
  const Fd listener = Wire::get().socket(false, kPort);
  ASSERT_TRUE(send(near_, "239.68.101.110", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(listener), 17U) << "by the loop of the group";
  EXPECT_EQ(received(far_), 17U);
  EXPECT_EQ(counted(Direction::ingress, GATE_R_ECHO), 1U);
}

TEST_F(EtherSockets, SeveralDatagramsInOneBufferDoNotLeave) {
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

TEST_F(EtherSockets, OtherTrafficIsLeftAloneWhenTheGateIsClosed) {
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

TEST_F(EtherSockets, ANewObjectTakesOverWhatIsThere) {
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

TEST_F(EtherSockets, ALargerOneTakesTheSlotsAlong) {
  admit({slot(Direction::ingress)});
  EXPECT_FALSE(gate_.holds(20'000));
  gate_ = attach(20'000);
  EXPECT_TRUE(gate_.holds(20'000));
  EXPECT_EQ(gate_.present(), std::vector{slot(Direction::ingress)});
  ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 8)));
  EXPECT_EQ(received(near_), 17U);
  EXPECT_TRUE(gate_.drops_early());
}

/// After an upgrade the pins of the version before lie beside ours.
TEST_F(EtherSockets, TheProgramOfAnotherLayoutIsReplacedInTheDriver) {
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

TEST_F(EtherSockets, AForeignProgramInTheDriverStays) {
  shell("ip link set dev eth0 xdp off");
  std::filesystem::remove(control_.directory() + "/if" + std::to_string(if_nametoindex("eth0")) +
                          "/early");
  auto other = EtherGate::attach({if_nametoindex("eth0"), "eth0", 0}, create());
  ASSERT_TRUE(other);
  const auto foreign = early_program(if_nametoindex("eth0"));
  ASSERT_NE(foreign, 0U);
  gate_ = attach();
  EXPECT_FALSE(gate_.drops_early());
  EXPECT_EQ(early_program(if_nametoindex("eth0")), foreign);
  EXPECT_TRUE(gate_.attached().value()) << "tc holds all of it";
}

TEST_F(EtherSockets, WhatWasRemovedIsPutBack) {
  admit({slot(Direction::ingress)});
  shell("tc qdisc del dev eth0 clsact");
  EXPECT_FALSE(gate_.attached().value());
  ASSERT_TRUE(gate_.reattach());
  EXPECT_TRUE(gate_.attached().value());
  shell("ip link set dev eth0 xdp off");
  EXPECT_FALSE(gate_.attached().value());
  ASSERT_TRUE(gate_.reattach());
  EXPECT_TRUE(gate_.attached().value());
  EXPECT_NE(early_program(if_nametoindex("eth0")), 0U);
}

constexpr std::uint64_t kMillisecond = 1'000'000;
constexpr std::uint64_t kPeriod = 100 * kMillisecond;
constexpr std::uint64_t kSilence = 250 * kMillisecond;

class EtherSilence : public EtherSockets {
 protected:
  EtherSilence()
      : reader_(EventReader::open(control_.events_fd(), [this](const gate_event& e) {
                  got_.push_back(e);
                }).value()) {}
  static SlotSpec watched(std::uint64_t subject = kSubject) {
    SlotSpec s = slot(Direction::ingress, subject);
    s.period = kPeriod;
    s.silence = kSilence;
    return s;
  }
  /// The next one, waited for.
  gate_event next() {
    while (got_.empty() && !HasFailure()) {
      pollfd ready{reader_.fd(), POLLIN, 0};
      EXPECT_EQ(poll(&ready, 1, 20'000), 1) << "nothing was told";
      EXPECT_TRUE(reader_.read());
    }
    const gate_event event = got_.empty() ? gate_event{} : got_.front();
    if (!got_.empty()) got_.pop_front();
    return event;
  }
  /// A beat each fifth of a period.
  void beat_until(std::uint64_t end) {
    while (monotonic_ns() < end) {
      ASSERT_TRUE(send(far_, "10.0.0.1", kPort, event(kSubject, 8)));
      poll(nullptr, 0, 20);
    }
  }

  std::deque<gate_event> got_;
  EventReader reader_;
};

TEST_F(EtherSilence, AHeartBeatThatNeverComesIsToldWithinAPeriod) {
  const std::uint64_t before = monotonic_ns();
  admit({watched()});
  const std::uint64_t after = monotonic_ns();
  const gate_event event = next();
  EXPECT_EQ(event.kind, std::uint32_t{GATE_E_MISSING});
  EXPECT_EQ(event.ifindex, gate_.ifindex());
  EXPECT_EQ(event.subject, kSubject);
  EXPECT_EQ(event.slot, gate_.watched_as(watched()));
  EXPECT_EQ(event.never, 1U);
  EXPECT_GE(event.at, before + kSilence);
  EXPECT_LT(event.at, after + kSilence + kPeriod);
}

TEST_F(EtherSilence, TheEndOfAHeartBeatAndItsReturnAreTold) {
  admit({watched()});
  const auto number = gate_.watched_as(watched()).value();
  beat_until(monotonic_ns() + 6 * kPeriod);
  EXPECT_TRUE(got_.empty());
  const gate_event missing = next();
  const std::uint64_t last = missing.at - gate_.arrivals(number, missing.at).since_last;
  EXPECT_EQ(missing.at - missing.silent, last);
  EXPECT_GE(missing.silent, kSilence);
  EXPECT_LT(missing.silent, kSilence + kPeriod);
  EXPECT_TRUE(gate_.arrivals(number, monotonic_ns()).silent);
  beat_until(monotonic_ns() + GATE_CALM + 5 * kPeriod);
  EXPECT_EQ(next().kind, std::uint32_t{GATE_E_RESTORED});
  EXPECT_FALSE(gate_.arrivals(number, monotonic_ns()).silent);
}

TEST_F(EtherSilence, TheNextObjectGoesOnAndTellsOnceMore) {
  admit({watched()});
  EXPECT_EQ(next().kind, std::uint32_t{GATE_E_MISSING});
  gate_ = attach();
  EXPECT_EQ(gate_.present(), std::vector{watched()});
  EXPECT_EQ(next().kind, std::uint32_t{GATE_E_MISSING});
  ASSERT_TRUE(gate_.tell_again(gate_.watched_as(watched()).value()));
  EXPECT_EQ(next().kind, std::uint32_t{GATE_E_MISSING});
  gate_ = attach(20'000);
  EXPECT_EQ(next().subject, kSubject) << "in the larger table, too";
}

TEST_F(EtherSilence, NobodyWaitsForWhatDoesNotPassAnyMore) {
  admit({watched(), watched(kSubject + 1)});
  SlotChanges changes;
  changes.remove = {watched()};
  ASSERT_TRUE(gate_.apply(changes));
  EXPECT_EQ(next().subject, kSubject + 1);
  gate_.deny_all();
  admit({watched(kSubject + 2)});
  EXPECT_EQ(next().subject, kSubject + 2) << "nothing more was told of the others";
}

TEST_F(EtherSockets, ADeviceWithoutEthernetFramesHasNoGate) {
  shell("ip tuntap add dev none0 mode tun");
  const auto gate = EtherGate::attach({if_nametoindex("none0"), "none0", 0}, control_);
  ASSERT_FALSE(gate);
  EXPECT_EQ(gate.error().text, "gate of none0: it is no Ethernet interface");
  shell("ip link del none0");
}

}  // namespace
}  // namespace mlcca::enforce
