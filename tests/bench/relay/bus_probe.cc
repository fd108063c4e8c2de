// SPDX-License-Identifier: BSD-2-Clause
// Times of events between a CAN bus and UDP, and the peer that carries them with nothing but the
// system calls. Addresses and groups are those of the subject "B".
//   bus-probe to-udp CAN-INTERFACE ADDRESS OUT-NAMESPACE COUNT GAP-US
//       from the bus to UDP, through whoever carries them
//   bus-probe to-bus ADDRESS CAN-INTERFACE OUT-NAMESPACE COUNT GAP-US
//       and back
//   bus-probe forward CAN-INTERFACE UDP-INTERFACE CAN-ID
//       the peer, both ways
//   bus-probe to-tunnel CAN-INTERFACE ADDRESS OUT-NAMESPACE COUNT GAP-US
//   bus-probe from-tunnel ADDRESS CAN-INTERFACE OUT-NAMESPACE COUNT GAP-US
//       the same through cannelloni, whose datagrams go to port 20000 of ADDRESS and come from
//       port 20000 of the address before it
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

constexpr canid_t kSenders = 0x1f480064 | CAN_EFF_FLAG;   // priority 0x7d, node 0x20, etag 0x64
constexpr canid_t kGateways = 0x1f484064 | CAN_EFF_FLAG;  // the same of node 0x21

/// Frames of its own are not received.
Fd bus_socket(const char* interface) {
  Fd socket(::socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(interface));
  const int off = 0;
  const int room = 1 << 20;
  ::setsockopt(socket.get(), SOL_CAN_RAW, CAN_RAW_LOOPBACK, &off, sizeof off);
  ::setsockopt(socket.get(), SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
  if (::bind(socket.get(), generic_of(address), sizeof address) != 0) give_up("bus");
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
  Lan(const std::string& own, const std::string& interface) : socket_(udp_socket(own, interface)) {}
  [[nodiscard]] int fd() const { return socket_.get(); }
  void send(const void* data, std::size_t size) const {
    std::array<char, kHeader + CAN_MAX_DLEN> event{'B'};
    std::memcpy(event.data() + kHeader, data, size);
    const sockaddr_in to = group();
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
};

/// The other end of cannelloni: datagrams of version 2 with one classic frame each when sent, and
/// the first one of several when received.
class Tunnel {
 public:
  explicit Tunnel(const std::string& own)
      : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(20000);
    ::inet_pton(AF_INET, own.c_str(), &address.sin_addr);
    if (::bind(socket_.get(), generic_of(address), sizeof address) != 0) give_up("bind");
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
  ssize_t receive(void* to, std::size_t room) const {
    std::array<std::uint8_t, 2048> bytes{};
    const ssize_t n = ::recv(socket_.get(), bytes.data(), bytes.size(), 0);
    if (n < static_cast<ssize_t>(kHead)) return -1;
    const std::size_t size = std::min<std::size_t>(static_cast<std::size_t>(n) - kHead, room);
    std::memcpy(to, bytes.data() + kHead, size);
    return static_cast<ssize_t>(size);
  }

 private:
  static constexpr std::size_t kIdentifier = 5;  ///< octets of a datagram before its first frame
  static constexpr std::size_t kHead = kIdentifier + 5;  ///< and before the data of that
  Fd socket_;
  std::uint8_t number_ = 0;
};

/// Each event is the time at which it was sent.
template <class Out, class In>
void measure(Out&& out, const In& in, std::size_t count, unsigned gap_us) {
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

int to_udp(char** argv, bool tunnel) {
  const Bus out(argv[0], kSenders);
  enter(argv[2]);
  const auto count = std::strtoul(argv[3], nullptr, 10);
  const auto gap_us = static_cast<unsigned>(std::strtoul(argv[4], nullptr, 10));
  if (tunnel)
    measure(out, Tunnel(argv[1]), count, gap_us);
  else
    measure(out, Lan(argv[1], ""), count, gap_us);
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

int forward(char** argv) {
  const Bus bus(argv[0], static_cast<canid_t>(std::strtoul(argv[2], nullptr, 16)) | CAN_EFF_FLAG);
  const Lan lan("", argv[1]);
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

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "to-udp" && argc == 7) return to_udp(argv + 2, false);
  if (what == "to-bus" && argc == 7) return to_bus(argv + 2, false);
  if (what == "to-tunnel" && argc == 7) return to_udp(argv + 2, true);
  if (what == "from-tunnel" && argc == 7) return to_bus(argv + 2, true);
  if (what == "forward" && argc == 5) return forward(argv + 2);
  std::fputs(
      "bus-probe to-udp|to-bus|to-tunnel|from-tunnel|forward …, see the head of its source\n",
      stderr);
  return 2;
}
