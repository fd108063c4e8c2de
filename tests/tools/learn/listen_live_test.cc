// SPDX-License-Identifier: BSD-2-Clause
// Listening to a real Ethernet device, in a namespace of its own; needs root.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/handle.hpp"
#include "tests/support/require.hpp"
#include "tests/tools/design/describe/program.hpp"
#include "tests/tools/learn/traffic.hpp"
#include "tools/learn/live.hpp"

namespace mlcca::learn {
namespace {

using mlcca::test::require;
using test::event;
using test::kDistance;
using test::Sent;
using test::station;

void shell_command(const std::string& command) {
  require(std::system(command.c_str()) == 0, command.c_str());  // NOLINT(*-command-processor)
}

struct ListenLive : ::testing::Test {
  static void SetUpTestSuite() {
    require(::unshare(CLONE_NEWNET) == 0, "unshare (needs root)");
    shell_command("ip link set lo up && ip link add eth0 type veth peer name far0");
    shell_command("sysctl -qw net.ipv6.conf.all.disable_ipv6=1");
    shell_command("ip link set eth0 up && ip link set far0 up");
    shell_command("ip addr add 192.0.2.1/24 dev eth0");
  }

  /// Sends a frame out of a device, past everything, once or several times.
  static void inject(const std::string& device, const std::vector<std::uint8_t>& frame,
                     std::size_t times = 1) {
    const Fd socket(::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0));
    sockaddr_ll to{};
    to.sll_family = AF_PACKET;
    to.sll_halen = 6;
    to.sll_ifindex = static_cast<int>(::if_nametoindex(device.c_str()));
    for (std::size_t i = 0; i < times; ++i)
      require(::sendto(socket.get(), frame.data(), frame.size(), 0,
                       reinterpret_cast<const sockaddr*>(&to), sizeof to) == std::ssize(frame),
              "send a frame");
  }

  /// A program of this host: a datagram to the group of "Distance".
  static void send_here(const std::vector<std::uint8_t>& data) {
    const Fd socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    ip_mreqn by{};
    by.imr_ifindex = static_cast<int>(::if_nametoindex("eth0"));
    require(::setsockopt(socket.get(), IPPROTO_IP, IP_MULTICAST_IF, &by, sizeof by) == 0, "by");
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(9999);
    to.sin_addr.s_addr = ::inet_addr("239.68.101.110");
    require(::sendto(socket.get(), data.data(), data.size(), 0,
                     reinterpret_cast<const sockaddr*>(&to), sizeof to) == std::ssize(data),
            "send a datagram");
  }

  /// What comes while `traffic` is sent, until there are so many.
  template <class Send>
  static std::vector<Sent> heard(std::size_t count, Send traffic) {
    Interfaces interfaces;
    const auto listener = Listener::open({"eth0"}, interfaces);
    require(listener.has_value(), "listen");
    EXPECT_EQ(interfaces.media().at(0), Medium::ethernet);
    traffic();
    std::vector<Sent> out;
    constexpr std::uint64_t patience = 10'000'000'000;
    const auto done = (*listener)->listen(
        patience, [&] { return out.size() >= count; },
        [&](const Frame& f) {
          out.push_back(
              {f.ns, f.interface, f.id, {f.data.begin(), f.data.end()}, f.fd, f.local, f.datagram});
        });
    EXPECT_TRUE(done.has_value());
    EXPECT_EQ((*listener)->lost(), 0U);
    return out;
  }
};

TEST_F(ListenLive, HearsDatagramsOfOthersWithTagsAndWithoutAndNothingElse) {
  const Sent sent = event(0, 0, kDistance, station(7), {1, 2, 3});
  const auto is = heard(5, [&] {
    auto other = frame_of(sent);
    other[23] = IPPROTO_TCP;
    inject("far0", other);
    auto fragment = frame_of(sent);
    fragment[21] = 100;
    inject("far0", fragment);
    // The device takes one off; two more are skipped.
    inject("far0", frame_of(sent, 4));
    for (unsigned tags = 0; tags <= 3; ++tags) inject("far0", frame_of(sent, tags));
    auto last = sent;
    last.data.back() = 9;
    inject("far0", frame_of(last));
  });
  ASSERT_EQ(is.size(), 5U);
  for (const Sent& one : is) {
    EXPECT_FALSE(one.local);
    EXPECT_NE(one.ns, 0U);
    EXPECT_EQ(one.datagram->source, station(7));
    EXPECT_EQ(one.datagram->port, 9999);
    EXPECT_EQ(one.datagram->mac, sent.datagram->mac);
    EXPECT_EQ(one.data.size(), 12U);
  }
  EXPECT_EQ(is.back().data.back(), 9);
}

TEST_F(ListenLive, WhatHasArrivedWhenItIsStoppedIsRead) {
  // Frames gather in the kernel for some time before they are read.
  const Sent sent = event(0, 0, kDistance, station(7), {1, 2, 3});
  constexpr std::size_t many = 300;  // more than is read at once
  Interfaces interfaces;
  const auto listener = Listener::open({"eth0"}, interfaces);
  require(listener.has_value(), "listen");
  inject("far0", frame_of(sent), many);
  std::size_t heard = 0;
  ASSERT_TRUE(
      (*listener)->listen(1'000'000'000, [] { return true; }, [&](const Frame&) { ++heard; }));
  EXPECT_EQ(heard, many);
}

TEST_F(ListenLive, WhatAProgramOfThisHostSendsIsLocal) {
  const Sent sent = event(0, 0, kDistance, station(1), {1, 2, 3});
  const auto is = heard(1, [&] { send_here(sent.data); });
  ASSERT_EQ(is.size(), 1U);
  EXPECT_TRUE(is[0].local);
  EXPECT_EQ(is[0].datagram->source, station(1));
  EXPECT_EQ(is[0].data, sent.data);
}

TEST_F(ListenLive, OfALongDatagramTheFirstFragmentSaysTheLength) {
  Sent sent = event(0, 0, kDistance, station(1), std::vector<std::uint8_t>(8000, 5));
  const auto is = heard(1, [&] { send_here(sent.data); });
  ASSERT_EQ(is.size(), 1U);
  EXPECT_EQ(is[0].datagram->bytes, 8009U);
  EXPECT_GE(is[0].data.size(), 9U + 64U);
}

TEST_F(ListenLive, TheKernelSaysHowManyFramesWereReceived) {
  const std::uint64_t before = received_on("eth0");
  inject("far0", frame_of(event(0, 0, kDistance, station(7), {1})), 5);
  EXPECT_EQ(received_on("eth0"), before + 5);
  EXPECT_EQ(received_on("none0"), 0U);
}

TEST_F(ListenLive, OtherInterfacesAreRefused) {
  Interfaces interfaces;
  const auto lo = Listener::open({"lo"}, interfaces);
  ASSERT_FALSE(lo.has_value());
  EXPECT_EQ(lo.error().text, "lo: is neither a CAN nor an Ethernet interface");
  EXPECT_FALSE(Listener::open({"none0"}, interfaces).has_value());
}

TEST_F(ListenLive, WithoutAnyFrameNothingIsDrafted) {
  shell_command("ip link add down0 type veth peer name down1");
  const mlcca::test::Folder folder;
  const auto draft = folder.path("draft.xml");
  const auto ran = mlcca::test::run({"learn", "eth0", "down0", "--for", "1ms", "--output", draft});
  EXPECT_EQ(ran.status, 2) << ran.out;
  EXPECT_TRUE(ran.error.contains("no frame was seen; nothing was drafted")) << ran.error;
  EXPECT_TRUE(ran.error.contains("eth0: nothing came while it was listened to")) << ran.error;
  EXPECT_TRUE(ran.error.contains("down0: it is down, so nothing comes")) << ran.error;
  EXPECT_FALSE(std::filesystem::exists(draft));
}

TEST_F(ListenLive, WhatCannotBeMergedIsSaidBeforeItListens) {
  const std::uint64_t begin = monotonic_ns();
  const auto ran = mlcca::test::run({"learn", "eth0", "--for", "1min", "--merge",
                                     "examples/volksbot/system.xml", "--gateway", "bridge"});
  EXPECT_EQ(ran.status, 2) << ran.out;
  EXPECT_TRUE(ran.error.contains("no port of the gateway names the interface eth0")) << ran.error;
  EXPECT_LT(monotonic_ns() - begin, 30'000'000'000U);
}

TEST_F(ListenLive, WithoutTheCapabilityItSaysWhatIsMissing) {
  __user_cap_header_struct head{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct had[2] = {};
  require(::syscall(SYS_capget, &head, had) == 0, "capget");
  __user_cap_data_struct less[2] = {had[0], had[1]};
  less[0].effective &= ~(1U << CAP_NET_RAW);
  require(::syscall(SYS_capset, &head, less) == 0, "capset");
  Interfaces interfaces;
  const auto refused = Listener::open({"eth0"}, interfaces);
  require(::syscall(SYS_capset, &head, had) == 0, "capset");
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().text,
            "eth0: listening to Ethernet needs CAP_NET_RAW, which CAN does not: take sudo, or "
            "record with tcpdump and learn from the file");
}

}  // namespace
}  // namespace mlcca::learn
