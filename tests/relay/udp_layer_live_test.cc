// SPDX-License-Identifier: BSD-2-Clause
// The sockets of a UDP network, on a real device in a namespace of its own; needs root.
#include <gtest/gtest.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

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

TEST_F(UdpLayerLive, AnErrorThatIsReportedLaterIsReadAndForgotten) {
  const auto layer = open();
  shell_command("ip link set out0 mtu 68");
  static_cast<void>(send(*layer, 1'000));
  shell_command("ip link set out0 mtu 1500");
  EXPECT_TRUE(layer->receive(16, [](const Layer::Arrival&) {}));
  pollfd waits{.fd = layer->fd(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(::poll(&waits, 1, 0), 0) << "else a loop would have no rest";
}

}  // namespace
}  // namespace mlcca::relay
