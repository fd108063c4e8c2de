// SPDX-License-Identifier: BSD-2-Clause
// The sockets of a UDP network, on a real device in a namespace of its own; needs root.
#include <gtest/gtest.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sched.h>
#include <sys/socket.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/handle.hpp"
#include "relay/layers/udp_layer.hpp"
#include "tests/support/require.hpp"

namespace mlcca::relay {
namespace {

using test::require;

constexpr std::uint64_t kSubject = 0x44697374616e6365;

void shell_command(const std::string& command) {
  require(std::system(command.c_str()) == 0, command.c_str());  // NOLINT(*-command-processor)
}

struct UdpLayerLive : ::testing::Test {
  static void SetUpTestSuite() {
    require(::unshare(CLONE_NEWNET) == 0, "unshare (needs root)");
    shell_command("ip link set lo up && ip link add out0 type veth peer name far0");
    shell_command("ip addr add 192.0.2.1/24 dev out0");
    shell_command("ip link set out0 up && ip link set far0 up");
  }
  static std::unique_ptr<Layer> open() {
    control::Endpoint endpoint;
    endpoint.network = "field";
    endpoint.interface = "out0";
    endpoint.ifindex = ::if_nametoindex("out0");
    auto layer = UdpLayer::open(endpoint);
    require(layer.has_value(), "a layer");
    return std::move(*layer);
  }
  static Sent send(Layer& layer, std::size_t bytes) {
    const std::vector<std::uint8_t> event(bytes, 7);
    return layer.send({}, kSubject, event);
  }
};

TEST_F(UdpLayerLive, WhatTheKernelDropsOnItsWayOutIsNotCalledSent) {
  const auto layer = open();
  EXPECT_EQ(send(*layer, 100), Sent::sent);
  // A queue that takes nothing.
  shell_command("tc qdisc add dev out0 root tbf rate 8bit burst 1 limit 1");
  EXPECT_EQ(send(*layer, 100), Sent::dropped);
  EXPECT_EQ(send(*layer, 20'000), Sent::dropped) << "in fragments";
  shell_command("tc qdisc del dev out0 root");
  EXPECT_EQ(send(*layer, 100), Sent::sent);
}

/// A node of FAMOUSO at the other end of the wire, with `--broadcast-port`.
class BroadcastNode {
 public:
  BroadcastNode() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const int on = 1;
    require(::setsockopt(socket_.get(), SOL_SOCKET, SO_BINDTODEVICE, "far0", 5) == 0, "far0");
    require(::setsockopt(socket_.get(), SOL_SOCKET, SO_BROADCAST, &on, sizeof on) == 0,
            "broadcast");
    sockaddr_in own = address(INADDR_ANY);
    require(::bind(socket_.get(), reinterpret_cast<sockaddr*>(&own), sizeof own) == 0, "bind");
  }
  void send(const std::string& datagram) {
    sockaddr_in to = address(INADDR_BROADCAST);
    EXPECT_EQ(::sendto(socket_.get(), datagram.data(), datagram.size(), 0,
                       reinterpret_cast<sockaddr*>(&to), sizeof to),
              static_cast<ssize_t>(datagram.size()));
  }
  /// The next datagram; empty: none within a minute, or it has come from another port.
  std::string receive() {
    pollfd waits{.fd = socket_.get(), .events = POLLIN, .revents = 0};
    if (::poll(&waits, 1, 60'000) != 1) return {};
    std::string out(65'536, '\0');
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t n = ::recvfrom(socket_.get(), out.data(), out.size(), 0,
                                 reinterpret_cast<sockaddr*>(&from), &size);
    out.resize(n < 0 || from.sin_port != htons(kBroadcastPort) ? 0 : static_cast<std::size_t>(n));
    return out;
  }

 private:
  static sockaddr_in address(std::uint32_t of) {
    sockaddr_in out{};
    out.sin_family = AF_INET;
    out.sin_port = htons(kBroadcastPort);
    out.sin_addr.s_addr = htonl(of);
    return out;
  }
  Fd socket_;
};

/// As FAMOUSO has it: datagrams from port 8888 to 255.255.255.255:8888. The kernel hands an own
/// broadcast back.
TEST_F(UdpLayerLive, EventsOfABroadcastNetworkAreBroadcastAndComeFromOthersAlone) {
  shell_command("ip addr add 192.0.2.2/24 dev far0");
  for (const char* name : {"all", "out0", "far0"}) {
    const std::string key = std::string("/proc/sys/net/ipv4/conf/") + name;
    shell_command("echo 1 >" + key + "/accept_local && echo 0 >" + key + "/rp_filter");
  }
  control::Endpoint endpoint;
  endpoint.network = "field";
  endpoint.interface = "out0";
  endpoint.ifindex = ::if_nametoindex("out0");
  endpoint.broadcast = true;
  auto opened = UdpLayer::open(endpoint);
  require(opened.has_value(), "a layer");
  Layer& layer = **opened;
  ASSERT_TRUE(layer.follow(1, endpoint, kSubject, 100'000));
  BroadcastNode node;
  const std::vector<std::uint8_t> event{'a', 'b', 'c'};
  ASSERT_EQ(layer.send(endpoint, kSubject, event), Sent::sent);
  EXPECT_EQ(node.receive(), std::string("Distance\0abc", 12));
  const std::vector<std::uint8_t> large(20'000, 7);
  ASSERT_EQ(layer.send(endpoint, kSubject, large), Sent::sent);
  for (const std::size_t size : {8183U, 8183U, 20'000U - 2U * 8177U + 6U})
    EXPECT_EQ(node.receive().size(), kDatagramHeader + size);
  node.send(std::string("Distance\0xyz", 12));
  std::vector<std::string> came;
  while (came.empty()) {
    pollfd waits{.fd = layer.fd(), .events = POLLIN, .revents = 0};
    ASSERT_EQ(::poll(&waits, 1, 60'000), 1) << "nothing came";
    ASSERT_TRUE(layer.receive(16, [&](const Layer::Arrival& arrival) {
      EXPECT_EQ(arrival.source, 0xc0000202U);
      came.emplace_back(arrival.event.begin(), arrival.event.end());
    }));
  }
  EXPECT_EQ(came, std::vector<std::string>{"xyz"});
  EXPECT_FALSE(layer.holds_parts()) << "own fragments are none of its business";
  // More than one system call takes, and more than the caller asks for in a turn.
  constexpr std::size_t many = 30;
  for (std::size_t i = 0; i < many; ++i) node.send(std::string("Distance\0", 9) + char('A' + i));
  came.clear();
  while (came.size() < many) {
    pollfd waits{.fd = layer.fd(), .events = POLLIN, .revents = 0};
    ASSERT_EQ(::poll(&waits, 1, 60'000), 1) << came.size() << " came";
    ASSERT_TRUE(layer.receive(3, [&](const Layer::Arrival& arrival) {
      came.emplace_back(arrival.event.begin(), arrival.event.end());
    }));
  }
  for (std::size_t i = 0; i < many; ++i) EXPECT_EQ(came.at(i), std::string(1, char('A' + i)));
}

TEST_F(UdpLayerLive, AnErrorThatIsReportedLaterIsReadAndForgotten) {
  const auto layer = open();
  shell_command("ip link set out0 mtu 68");
  static_cast<void>(send(*layer, 1'000));
  shell_command("ip link set out0 mtu 1500");
  EXPECT_TRUE(layer->receive(16, [](const Layer::Arrival&) {}));
  pollfd waits{.fd = layer->fd(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(::poll(&waits, 1, 0), 0) << "else a loop would have no rest";
}

std::size_t lines_of(const std::string& path, const std::string& with) {
  std::ifstream file(path);
  std::size_t out = 0;
  for (std::string line; std::getline(file, line);) out += line.contains(with) ? 1 : 0;
  return out;
}
/// IPv4 groups that some socket is in on out0.
std::size_t groups_of_out0() { return lines_of("/proc/net/igmp", "\t\t\t\t"); }
std::size_t open_files() {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {}));
}

/// A description may admit any subject at run time, each for a while.
TEST_F(UdpLayerLive, GroupsThatNothingIsFollowedInAreLeft) {
  const auto layer = open();
  const auto subject = [](std::uint64_t number) { return number << 56U | (number >> 8U) << 16U; };
  const std::size_t groups = groups_of_out0();
  const std::size_t files = open_files();
  for (std::uint64_t i = 1; i <= 1'000; ++i) {
    ASSERT_TRUE(layer->follow(1, {}, subject(i), 100));
    if (i > 10) layer->leave(1, {}, subject(i - 10));
  }
  EXPECT_GE(groups_of_out0(), groups + 10);
  EXPECT_LE(groups_of_out0(), groups + 80);
  EXPECT_LE(open_files(), files + 5);
}

}  // namespace
}  // namespace mlcca::relay
