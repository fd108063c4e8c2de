// SPDX-License-Identifier: BSD-2-Clause
// A pair of real Ethernet devices between two namespaces, one of them gated, and UDP sockets.
#pragma once
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "bpf/ether.h"
#include "daemon/gates/ether_gate.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/tcx.hpp"
#include "tests/bpf/ether/packets.hpp"
#include "tests/support/require.hpp"

namespace mlcca::gates {

using test::Bytes;
using test::Datagram;
using test::require;

inline void shell(const std::string& command) {
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

inline constexpr std::uint64_t kSubject = 0x44697374616e6365;
inline constexpr std::uint16_t kPort = 9999;

inline Bytes event(std::uint64_t subject, std::size_t payload) {
  const Bytes content = Datagram{.subject = subject, .payload = payload}.content();
  return {content.begin() + 8, content.end()};
}

inline bool send(const Fd& from, const char* address, std::uint16_t port, const Bytes& bytes) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = inet_addr(address);
  return sendto(from.get(), bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to),
                sizeof to) == std::ssize(bytes);
}

/// The next datagram, waited for; nothing after a generous time.
inline std::optional<std::size_t> received(const Fd& at) {
  pollfd wait{.fd = at.get(), .events = POLLIN, .revents = 0};
  if (poll(&wait, 1, 10'000) != 1) return std::nullopt;
  Bytes bytes(65536);
  return static_cast<std::size_t>(recv(at.get(), bytes.data(), bytes.size(), 0));
}

inline SlotSpec slot(Direction direction, std::uint64_t subject = kSubject) {
  SlotSpec s;
  s.direction = direction;
  s.pass = true;
  s.subject = subject;
  s.max_len = 1500;
  s.formats = ETHER_UNFRAGMENTED;
  return s;
}

/// By clsact, and by TCX where the kernel has it.
class EtherSockets : public ::testing::TestWithParam<Hook> {
 protected:
  EtherSockets() : control_(create()), gate_(attach()) {
    // As long as a test takes on a busy machine.
    require(control_.set_grace(kForEver) && control_.beat(0), "beat");
    control_.open();
  }
  ~EtherSockets() override {
    for (const auto hook : {Hook::clsact, Hook::tcx}) withdraw(place(hook, control_));
  }
  static GateLocation place(Hook hook, const Control& control) {
    const std::uint32_t ifindex = if_nametoindex("eth0");
    return {ifindex, gate_directory(control.directory(), ifindex), hook};
  }
  static Control create() {
    static int number = 0;
    shell("ip link set dev eth0 xdp off");  // of the test before
    auto control = Control::create(Wire::get().root + "/root" + std::to_string(++number));
    require(control.has_value(), "control");
    return std::move(*control);
  }
  static EtherConfig config(std::size_t slots = 0, bool silent = false) {
    return {if_nametoindex("eth0"), "eth0", slots, GetParam(), silent};
  }
  EtherGate attach(std::size_t slots = 0, Hook hook = GetParam(), bool silent = false) {
    auto gate = EtherGate::attach({if_nametoindex("eth0"), "eth0", slots, hook, silent}, control_);
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
  /// As another program would.
  void remove_gate() const {
    if (gate_.hook() == Hook::clsact) return shell("tc qdisc del dev eth0 clsact");
    const GateLocation there = place(Hook::tcx, control_);
    for (const auto direction : kBothDirections)
      require(tcx_detach(there.ifindex, direction,
                         open_pin(program_pin(there.directory, direction)).get())
                  .has_value(),
              "detach");
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

inline std::vector<Hook> hooks() {
  return kernel_has_tcx() ? std::vector{Hook::clsact, Hook::tcx} : std::vector{Hook::clsact};
}
inline std::string name_of(const ::testing::TestParamInfo<Hook>& hook) {
  return to_text(hook.param);
}
}  // namespace mlcca::gates
