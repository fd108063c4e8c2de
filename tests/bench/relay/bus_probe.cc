// SPDX-License-Identifier: BSD-2-Clause
// Times of events between a CAN bus and UDP, and the peer that carries them with nothing but the
// system calls. Addresses and groups are those of the subject "B"; on a mesh the subject is "M",
// and is broadcast.
//   bus-probe to-udp CAN-INTERFACE ADDRESS OUT-NAMESPACE COUNT GAP-US
//       from the bus to UDP, through whoever carries them
//   bus-probe to-bus ADDRESS CAN-INTERFACE OUT-NAMESPACE COUNT GAP-US
//       and back
//   bus-probe to-mesh CAN-INTERFACE ADDRESS OUT-NAMESPACE COUNT GAP-US
//       from the bus to a mesh
//   bus-probe forward CAN-INTERFACE UDP-INTERFACE CAN-ID
//   bus-probe forward-mesh CAN-INTERFACE MESH-INTERFACE CAN-ID
//       the peer, both ways
//   bus-probe to-tunnel CAN-INTERFACE ADDRESS OUT-NAMESPACE COUNT GAP-US
//   bus-probe from-tunnel ADDRESS CAN-INTERFACE OUT-NAMESPACE COUNT GAP-US
//       the same through cannelloni, whose datagrams go to port 20000 of ADDRESS and come from
//       port 20000 of the address before it
//   bus-probe count ADDRESS
//   bus-probe count-tunnel ADDRESS
//       prints how many events have come when none has for 5 s; of cannelloni those that come to
//       ports 20000 to 20003
#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/clock.hpp"
#include "base/handle.hpp"
#include "tests/bench/relay/udp.hpp"

namespace {

using namespace mlcca;         // NOLINT(google-build-using-namespace): a bench
using namespace mlcca::bench;  // NOLINT(google-build-using-namespace)

constexpr canid_t kSenders = 0x1f480064 | CAN_EFF_FLAG;  // priority 0x7d, node 0x20, etag 0x64
constexpr std::uint16_t kTunnelPort = 20'000;
constexpr canid_t kMeshSenders = 0x1f480065 | CAN_EFF_FLAG;
constexpr canid_t kGateways = 0x1f484064 | CAN_EFF_FLAG;  // the same of node 0x21

/// Frames of its own are not received.
Fd bus_socket(const char* interface) {
  Fd socket(::socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(interface));
  const int off = 0;
  ::setsockopt(socket.get(), SOL_CAN_RAW, CAN_RAW_LOOPBACK, &off, sizeof off);
  widen(socket);
  if (!socket || ::bind(socket.get(), generic_of(address), sizeof address) != 0) give_up("bus");
  return socket;
}

class Bus {
 public:
  Bus(const char* interface, canid_t id) : socket_(bus_socket(interface)), id_(id) {}
  [[nodiscard]] int fd() const { return socket_.get(); }
  void send(const void* data, std::size_t size) const {
    can_frame frame{};
    frame.can_id = id_;
    frame.len = static_cast<__u8>(std::min<std::size_t>(size, CAN_MAX_DLEN));
    std::memcpy(frame.data, data, frame.len);
    // A queue that is full for a moment is no loss of who carries it.
    while (::write(socket_.get(), &frame, sizeof frame) < 0 && errno == ENOBUFS)
      std::this_thread::sleep_for(std::chrono::microseconds(20));
  }
  /// Octets; below 0: none came in time.
  ssize_t receive(void* to, std::size_t room) const {
    can_frame frame{};
    if (::read(socket_.get(), &frame, sizeof frame) != sizeof frame) return -1;
    const std::size_t n = std::min<std::size_t>(frame.len, room);
    std::memcpy(to, frame.data, n);
    return static_cast<ssize_t>(n);
  }

 private:
  Fd socket_;
  canid_t id_;
};

class Lan {
 public:
  Lan(const std::string& own, const std::string& interface, char subject = 'B')
      : socket_(udp_socket(own, interface, subject)), subject_(subject) {}
  [[nodiscard]] int fd() const { return socket_.get(); }
  void send(const void* data, std::size_t size) const {
    std::array<char, kHeader + CAN_MAX_DLEN> event{subject_};
    std::memcpy(event.data() + kHeader, data, size);
    const sockaddr_in to = group(subject_);
    ::sendto(socket_.get(), event.data(), kHeader + size, 0, generic_of(to), sizeof to);
  }
  ssize_t receive(void* to, std::size_t room) const {
    std::array<char, 2048> buffer{};
    const ssize_t n = ::recv(socket_.get(), buffer.data(), buffer.size(), 0);
    if (n < static_cast<ssize_t>(kHeader)) return -1;
    const std::size_t size = std::min<std::size_t>(static_cast<std::size_t>(n) - kHeader, room);
    std::memcpy(to, buffer.data() + kHeader, size);
    return static_cast<ssize_t>(size);
  }

 private:
  Fd socket_;
  char subject_;
};

/// The other end of cannelloni: datagrams of version 2, with one classic frame each when sent.
class Tunnel {
 public:
  explicit Tunnel(const std::string& own, std::uint16_t port = kTunnelPort)
      : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    ::inet_pton(AF_INET, own.c_str(), &address.sin_addr);
    if (!socket_ || ::bind(socket_.get(), generic_of(address), sizeof address) != 0)
      give_up("bind");
    address.sin_addr.s_addr = htonl(ntohl(address.sin_addr.s_addr) - 1);
    if (::connect(socket_.get(), generic_of(address), sizeof address) != 0) give_up("connect");
  }
  [[nodiscard]] int fd() const { return socket_.get(); }
  void send(const void* data, std::size_t size) {
    std::array<std::uint8_t, kHead + CAN_MAX_DLEN> bytes{2, 0, number_++, 0, 1};
    const std::uint32_t id = htonl(kGateways);
    std::memcpy(bytes.data() + kIdentifier, &id, sizeof id);
    bytes[kHead - 1] = static_cast<std::uint8_t>(size);
    std::memcpy(bytes.data() + kHead, data, size);
    ::send(socket_.get(), bytes.data(), kHead + size, 0);
  }
  /// One frame after the other, of which several come in a datagram.
  ssize_t receive(void* to, std::size_t room) {
    if (end_ < at_ + kFrame) {
      const ssize_t n = ::recv(socket_.get(), bytes_.data(), bytes_.size(), 0);
      if (n < static_cast<ssize_t>(kHead)) return -1;
      end_ = static_cast<std::size_t>(n);
      at_ = kIdentifier;
    }
    const std::size_t length = bytes_.at(at_ + kFrame - 1);
    const std::size_t size = std::min({length, room, end_ - at_ - kFrame});
    std::memcpy(to, bytes_.data() + at_ + kFrame, size);
    at_ += kFrame + length;
    return static_cast<ssize_t>(size);
  }
  /// Frames of a datagram that has come.
  static std::uint64_t frames_of(const std::uint8_t* bytes, std::size_t size) {
    constexpr std::size_t number_at = 3;
    return size < kIdentifier ? 0U : std::uint64_t{bytes[number_at]} << 8U | bytes[number_at + 1];
  }

 private:
  static constexpr std::size_t kIdentifier = 5;  ///< octets of a datagram before its first frame
  static constexpr std::size_t kFrame = 5;       ///< and of a frame before its data
  static constexpr std::size_t kHead = kIdentifier + kFrame;
  Fd socket_;
  std::uint8_t number_ = 0;
  std::array<std::uint8_t, 2048> bytes_{};  ///< the latest datagram
  std::size_t at_ = 0;
  std::size_t end_ = 0;
};

/// Each event is the time at which it was sent.
template <class Out, class In>
void measure(Out&& out, In&& in, std::size_t count, unsigned gap_us) {
  timeval patience{.tv_sec = 2, .tv_usec = 0};
  ::setsockopt(in.fd(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  std::vector<std::uint64_t> times;
  times.reserve(count);
  std::thread receiver([&] {
    while (times.size() < count) {
      std::uint64_t sent = 0;
      if (in.receive(&sent, sizeof sent) < 0) return;
      times.push_back(monotonic_ns() - sent);
    }
  });
  std::uint64_t due = monotonic_ns();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t now = monotonic_ns();
    out.send(&now, sizeof now);
    due += gap_us * std::uint64_t{1'000};
    if (const std::uint64_t at = monotonic_ns(); at < due)
      std::this_thread::sleep_for(std::chrono::nanoseconds(due - at));
  }
  receiver.join();
  print("events", times, count);
}

void enter(const char* name_space) {
  const Fd other(::open(name_space, O_RDONLY | O_CLOEXEC));
  if (::setns(other.get(), CLONE_NEWNET) != 0) give_up("setns");
}

enum class To : std::uint8_t { lan, mesh, tunnel };

int from_bus(char** argv, To to) {
  const Bus out(argv[0], to == To::mesh ? kMeshSenders : kSenders);
  enter(argv[2]);
  const auto count = std::strtoul(argv[3], nullptr, 10);
  const auto gap_us = static_cast<unsigned>(std::strtoul(argv[4], nullptr, 10));
  if (to == To::tunnel)
    measure(out, Tunnel(argv[1]), count, gap_us);
  else
    measure(out, Lan(argv[1], "", to == To::mesh ? 'M' : 'B'), count, gap_us);
  return 0;
}

int to_bus(char** argv, bool tunnel) {
  std::optional<Lan> lan;
  std::optional<Tunnel> far_end;
  if (tunnel)
    far_end.emplace(argv[0]);
  else
    lan.emplace(argv[0], "");
  enter(argv[2]);
  const Bus in(argv[1], kSenders);
  const auto count = std::strtoul(argv[3], nullptr, 10);
  const auto gap_us = static_cast<unsigned>(std::strtoul(argv[4], nullptr, 10));
  if (tunnel)
    measure(*far_end, in, count, gap_us);
  else
    measure(*lan, in, count, gap_us);
  return 0;
}

int forward(char** argv, char subject) {
  const Bus bus(argv[0], static_cast<canid_t>(std::strtoul(argv[2], nullptr, 16)) | CAN_EFF_FLAG);
  const Lan lan("", argv[1], subject);
  std::array<pollfd, 2> waits{pollfd{.fd = bus.fd(), .events = POLLIN, .revents = 0},
                              pollfd{.fd = lan.fd(), .events = POLLIN, .revents = 0}};
  std::array<char, CAN_MAX_DLEN> event{};
  for (;;) {
    ::poll(waits.data(), waits.size(), -1);
    if (waits[0].revents != 0)
      if (const ssize_t n = bus.receive(event.data(), event.size()); n >= 0)
        lan.send(event.data(), static_cast<std::size_t>(n));
    if (waits[1].revents != 0)
      if (const ssize_t n = lan.receive(event.data(), event.size()); n >= 0)
        bus.send(event.data(), static_cast<std::size_t>(n));
  }
}

/// Of each socket, until none of them has had anything for 5 s.
template <class EventsOf>
int count(const std::vector<int>& sockets, const EventsOf& events_of) {
  constexpr int patience_ms = 5'000;
  std::vector<pollfd> waits;
  waits.reserve(sockets.size());
  for (const int socket : sockets) waits.push_back({.fd = socket, .events = POLLIN, .revents = 0});
  std::array<std::uint8_t, 2048> bytes{};
  std::uint64_t events = 0;
  std::puts("ready");
  std::fflush(stdout);
  bool any = false;
  while (::poll(waits.data(), waits.size(), any ? patience_ms : -1) > 0)
    for (const pollfd& one : waits) {
      if (one.revents == 0) continue;
      const ssize_t n = ::recv(one.fd, bytes.data(), bytes.size(), 0);
      if (n >= 0) events += events_of(bytes.data(), static_cast<std::size_t>(n));
      any = true;
    }
  std::printf("%llu\n", static_cast<unsigned long long>(events));
  return 0;
}

int count_lan(const std::string& own) {
  const Lan lan(own, "");
  return count({lan.fd()}, [](const auto*, std::size_t) { return 1U; });
}

int count_tunnels(const std::string& own) {
  std::vector<Tunnel> tunnels;
  std::vector<int> sockets;
  for (std::uint16_t port = kTunnelPort; port < kTunnelPort + 4; ++port)
    sockets.push_back(tunnels.emplace_back(own, port).fd());
  return count(sockets, Tunnel::frames_of);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "to-udp" && argc == 7) return from_bus(argv + 2, To::lan);
  if (what == "to-bus" && argc == 7) return to_bus(argv + 2, false);
  if (what == "to-tunnel" && argc == 7) return from_bus(argv + 2, To::tunnel);
  if (what == "from-tunnel" && argc == 7) return to_bus(argv + 2, true);
  if (what == "to-mesh" && argc == 7) return from_bus(argv + 2, To::mesh);
  if (what == "forward" && argc == 5) return forward(argv + 2, 'B');
  if (what == "forward-mesh" && argc == 5) return forward(argv + 2, 'M');
  if (what == "count" && argc == 3) return count_lan(argv[2]);
  if (what == "count-tunnel" && argc == 3) return count_tunnels(argv[2]);
  std::fputs(
      "bus-probe "
      "to-udp|to-bus|to-mesh|to-tunnel|from-tunnel|forward|forward-mesh|count|count-tunnel …, "
      "see the head of its source\n",
      stderr);
  return 2;
}
