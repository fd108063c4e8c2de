// SPDX-License-Identifier: BSD-2-Clause
// Namespaces, tun devices and packet sockets.
#include "tests/daemon/gates/sandbox.hpp"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <fcntl.h>
#include <linux/if_ether.h>
#include <linux/if_link.h>
#include <linux/if_packet.h>
#include <linux/if_tun.h>
#include <linux/pkt_cls.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "bpf/gate.h"
#include "tests/support/require.hpp"

namespace mlcca::test {
namespace {

constexpr int kPatience = 10'000;  // ms

/// Makes the private namespaces; gives the mount point of a bpffs in them.
std::string enter_sandbox() {
  require(unshare(CLONE_NEWNET | CLONE_NEWNS) == 0, "unshare (needs root)");
  require(mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0, "private mounts");
  const std::string point = std::filesystem::temp_directory_path() / "mlcca-bpf-test";
  std::filesystem::create_directories(point);
  require(mount("bpf", point.c_str(), "bpf", 0, nullptr) == 0, "mount a bpffs");
  // No router solicitations: a test counts its own frames.
  std::ofstream("/proc/sys/net/ipv6/conf/default/disable_ipv6") << "1";
  return point;
}

const std::string& sandbox() {
  static const std::string point = enter_sandbox();
  return point;
}

bool readable(int fd) {
  pollfd wait{.fd = fd, .events = POLLIN, .revents = 0};
  return poll(&wait, 1, kPatience) == 1;
}

bpf_tc_hook hook_of(std::uint32_t ifindex, bpf_tc_attach_point point) {
  LIBBPF_OPTS(bpf_tc_hook, hook);
  hook.ifindex = static_cast<int>(ifindex);
  hook.attach_point = point;
  return hook;
}
bpf_tc_hook both_hooks_of(const Bus& bus) {
  return hook_of(bus.ifindex(), static_cast<bpf_tc_attach_point>(BPF_TC_INGRESS | BPF_TC_EGRESS));
}
bpf_tc_hook one_hook_of(const Bus& bus, bool ingress) {
  return hook_of(bus.ifindex(), ingress ? BPF_TC_INGRESS : BPF_TC_EGRESS);
}

Fd load(const std::vector<bpf_insn>& program, bpf_prog_type type = BPF_PROG_TYPE_SCHED_CLS) {
  Fd fd(bpf_prog_load(type, "foreign", "GPL", program.data(), program.size(), nullptr));
  require(static_cast<bool>(fd), "load a program");
  return fd;
}

/// An ingress filter.
void attach(std::uint32_t ifindex, const std::vector<bpf_insn>& program, std::uint32_t priority,
            std::uint32_t handle) {
  const Fd fd = load(program);
  auto hook = hook_of(ifindex, BPF_TC_INGRESS);
  const auto quiet = libbpf_set_print(nullptr);
  const int made = bpf_tc_hook_create(&hook);
  libbpf_set_print(quiet);
  require(made == 0 || made == -EEXIST, "make hooks");
  LIBBPF_OPTS(bpf_tc_opts, options);
  options.prog_fd = fd.get();
  options.priority = priority;
  options.handle = handle;
  require(bpf_tc_attach(&hook, &options) == 0, "attach a filter");
}

/// A tun device that is up; it goes with its descriptor.
Fd make_tun(const std::string& name, std::uint32_t ifindex) {
  Fd fd(open("/dev/net/tun", O_RDWR | O_CLOEXEC));
  require(static_cast<bool>(fd), "open /dev/net/tun");
  if (ifindex != 0) require(ioctl(fd.get(), TUNSETIFINDEX, &ifindex) == 0, "choose an ifindex");
  ifreq request{};
  name.copy(request.ifr_name, IFNAMSIZ - 1);
  request.ifr_flags = IFF_TUN;
  require(ioctl(fd.get(), TUNSETIFF, &request) == 0, "make a tun device");
  const Fd socket_fd(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  request.ifr_flags = IFF_UP;
  require(ioctl(socket_fd.get(), SIOCSIFFLAGS, &request) == 0, "bring the device up");
  return fd;
}

bpf_insn move(std::uint8_t reg, std::int32_t value) {
  bpf_insn i{};
  i.code = BPF_ALU64 | BPF_MOV | BPF_K;
  i.dst_reg = reg & 0xfU;
  i.imm = value;
  return i;
}
bpf_insn jump(std::uint8_t operation, std::int32_t value = 0) {
  bpf_insn i{};
  i.code = BPF_JMP | operation;
  i.imm = value;
  return i;
}

}  // namespace

Bytes frame(std::uint32_t can_id) {
  Bytes bytes(CAN_MTU);
  std::memcpy(bytes.data(), &can_id, sizeof(can_id));
  bytes[4] = 8;
  return bytes;
}

std::string new_bpf_root() {
  static int number = 0;
  return sandbox() + "/root" + std::to_string(++number);
}

Bus::Bus(const std::string& name, std::uint32_t ifindex) : name_(name) {
  sandbox();
  device_ = make_tun(name, ifindex);
  ifindex_ = if_nametoindex(name.c_str());
  const std::string wire = name + "-wire";
  wire_ = make_tun(wire, 0);
  // A frame from tun belongs to the socket of its descriptor; a clone belongs to no socket.
  attach(if_nametoindex(wire.c_str()),
         {move(BPF_REG_2, static_cast<std::int32_t>(ifindex_)), move(BPF_REG_3, BPF_F_INGRESS),
          jump(BPF_CALL, BPF_FUNC_clone_redirect), move(BPF_REG_0, TC_ACT_SHOT), jump(BPF_EXIT)},
         1, 1);
}

void Bus::inject(const Bytes& bytes) const {
  const tun_pi head{.flags = 0, .proto = htons(ETH_P_CAN)};
  Bytes packet(sizeof(head));
  std::memcpy(packet.data(), &head, sizeof(head));
  packet.insert(packet.end(), bytes.begin(), bytes.end());
  require(write(wire_.get(), packet.data(), packet.size()) == std::ssize(packet), "inject a frame");
}

std::optional<Bytes> Bus::sent() const {
  if (!readable(device_.get())) return std::nullopt;
  Bytes packet(256);
  const auto size = read(device_.get(), packet.data(), packet.size());
  require(size > static_cast<ssize_t>(sizeof(tun_pi)), "read a frame");
  return Bytes(packet.begin() + sizeof(tun_pi), packet.begin() + size);
}

Program::Program(const Bus& bus, std::uint32_t uid)
    : fd_(socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, htons(ETH_P_CAN))), ifindex_(bus.ifindex()) {
  require(static_cast<bool>(fd_), "packet socket");
  require(fchown(fd_.get(), uid, static_cast<gid_t>(-1)) == 0, "give the socket away");
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(ETH_P_CAN);
  address.sll_ifindex = static_cast<int>(ifindex_);
  require(bind(fd_.get(), reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0, "bind");
}

bool Program::send(const Bytes& bytes) const {
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(ETH_P_CAN);
  address.sll_ifindex = static_cast<int>(ifindex_);
  const auto size = sendto(fd_.get(), bytes.data(), bytes.size(), 0,
                           reinterpret_cast<sockaddr*>(&address), sizeof(address));
  require(size == std::ssize(bytes) || errno == ENOBUFS, "send a frame");
  return size == std::ssize(bytes);
}

void Program::skip_queueing() const {
  const int on = 1;
  require(setsockopt(fd_.get(), SOL_PACKET, PACKET_QDISC_BYPASS, &on, sizeof(on)) == 0,
          "skip the queueing layer");
}

std::optional<Bytes> Program::received() const {
  if (!readable(fd_.get())) return std::nullopt;
  Bytes bytes(256);
  const auto size = recv(fd_.get(), bytes.data(), bytes.size(), 0);
  require(size > 0, "receive a frame");
  bytes.resize(static_cast<std::size_t>(size));
  return bytes;
}

void forward(const Bus& from, const Bus& to) {
  attach(from.ifindex(),
         {move(BPF_REG_1, static_cast<std::int32_t>(to.ifindex())), move(BPF_REG_2, 0),
          jump(BPF_CALL, BPF_FUNC_redirect), jump(BPF_EXIT)},
         9, 1);
}

Fd load_foreign(int action) { return load({move(BPF_REG_0, action), jump(BPF_EXIT)}); }

std::uint32_t put_foreign_xdp(const std::string& interface) {
  const Fd program = load({move(BPF_REG_0, XDP_PASS), jump(BPF_EXIT)}, BPF_PROG_TYPE_XDP);
  const auto ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
  require(bpf_xdp_attach(ifindex, program.get(), XDP_FLAGS_SKB_MODE, nullptr) == 0, "attach XDP");
  bpf_prog_info info{};
  std::uint32_t size = sizeof info;
  require(bpf_obj_get_info_by_fd(program.get(), &info, &size) == 0, "read a program");
  return info.id;
}

void remove_foreign_xdp(const std::string& interface) {
  const auto ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
  require(bpf_xdp_detach(ifindex, XDP_FLAGS_SKB_MODE, nullptr) == 0, "detach XDP");
}

void add_foreign_filter(const Bus& bus, std::uint32_t priority, std::uint32_t handle, int action) {
  attach(bus.ifindex(), {move(BPF_REG_0, action), jump(BPF_EXIT)}, priority, handle);
}

std::uint32_t filter_at(const Bus& bus, bool ingress, std::uint32_t priority,
                        std::uint32_t handle) {
  const auto hook = one_hook_of(bus, ingress);
  LIBBPF_OPTS(bpf_tc_opts, options);
  options.priority = priority;
  options.handle = handle;
  const auto silent = libbpf_set_print(nullptr);
  const int error = bpf_tc_query(&hook, &options);
  libbpf_set_print(silent);
  return error == 0 ? options.prog_id : 0;
}

void remove_our_filter(const Bus& bus, bool ingress) {
  const auto hook = one_hook_of(bus, ingress);
  LIBBPF_OPTS(bpf_tc_opts, options);
  options.priority = GATE_TC_PRIORITY;
  options.handle = GATE_TC_HANDLE;
  require(bpf_tc_detach(&hook, &options) == 0, "remove a filter");
}

void remove_clsact(const Bus& bus) {
  auto hook = both_hooks_of(bus);
  require(bpf_tc_hook_destroy(&hook) == 0, "remove clsact");
}

void add_clsact(const Bus& bus) {
  auto hook = both_hooks_of(bus);
  require(bpf_tc_hook_create(&hook) == 0, "add clsact");
}

}  // namespace mlcca::test
