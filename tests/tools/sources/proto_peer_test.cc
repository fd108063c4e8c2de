// SPDX-License-Identifier: BSD-2-Clause
// Who listens at an endpoint, as the kernel lists it.
#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <sstream>
#include <string>

#include "tools/sources/peer.hpp"

namespace mlcca::net {
namespace {

const char* const kHead =
    "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout "
    "inode\n";

/// The line of a socket, words of the address as this machine has them.
std::string line(const std::string& address, const char* port, const char* state, int uid,
                 int inode) {
  return "   0: " + address + ":" + port + " 00000000:0000 " + state +
         " 00000000:00000000 00:00000000 00000000 " + std::to_string(uid) + "        0 " +
         std::to_string(inode) + " 1 0000000000000000 100 0 0 10 0\n";
}

std::string loopback() {
  return std::endian::native == std::endian::little ? "0100007F" : "7F000001";
}
std::string one_v6() {
  return std::string(24, '0') +
         (std::endian::native == std::endian::little ? "01000000" : "00000001");
}

Listeners of(const std::string& text, const std::string& endpoint) {
  Reachable reachable(*parse_endpoint(endpoint));
  std::istringstream lines(kHead + text);
  for (std::string line; std::getline(lines, line);) reachable.take(line);
  return reachable.listeners();
}

TEST(Peer, TheSocketThatListensAtTheEndpointIsFound) {
  EXPECT_EQ(of(line(loopback(), "07D9", "0A", 1000, 7), "127.0.0.1:2009"),
            (Listeners{{.inode = 7, .owner = 1000}}));
  EXPECT_EQ(of(line(one_v6(), "8163", "0A", 0, 8), "[::1]:33123"),
            (Listeners{{.inode = 8, .owner = 0}}));
}

TEST(Peer, OneThatListensAtEveryAddressMayAnswerToo) {
  const std::string any(32, '0');
  EXPECT_EQ(of(line("00000000", "07D9", "0A", 5, 7), "127.0.0.1:2009"),
            (Listeners{{.inode = 7, .owner = 5}}));
  EXPECT_EQ(of(line(any, "07D9", "0A", 6, 8) + line(any, "07D9", "0A", 7, 9), "127.0.0.1:2009"),
            (Listeners{{.inode = 8, .owner = 6}, {.inode = 9, .owner = 7}}))
      << "IPv4 comes there, too";
  EXPECT_TRUE(of(line("00000000", "8163", "0A", 5, 7), "[::1]:33123").empty());
}

TEST(Peer, WhoListensAtTheVeryAddressAnswersWhoeverListensAtAll) {
  const std::string any_v6 = line(std::string(32, '0'), "07D9", "0A", 1000, 8);
  const std::string any_v4 = line("00000000", "07D9", "0A", 5, 7);
  const std::string exact = line(loopback(), "07D9", "0A", 0, 6);
  EXPECT_EQ(of(any_v6 + exact + any_v4, "127.0.0.1:2009"), (Listeners{{.inode = 6, .owner = 0}}));
  EXPECT_EQ(of(any_v6 + any_v4, "127.0.0.1:2009"), (Listeners{{.inode = 7, .owner = 5}}));
  EXPECT_EQ(of(any_v4 + any_v6, "127.0.0.1:2009"), (Listeners{{.inode = 7, .owner = 5}}));
  EXPECT_EQ(
      of(line(std::string(32, '0'), "8163", "0A", 1000, 8) + line(one_v6(), "8163", "0A", 0, 6),
         "[::1]:33123"),
      (Listeners{{.inode = 6, .owner = 0}}));
}

TEST(Peer, OtherSocketsDoNot) {
  EXPECT_TRUE(of(line(loopback(), "07D9", "01", 1000, 7), "127.0.0.1:2009").empty()) << "connected";
  EXPECT_TRUE(of(line(loopback(), "07DA", "0A", 1000, 7), "127.0.0.1:2009").empty()) << "port";
  EXPECT_TRUE(of(line(loopback(), "07D9", "0A", 1000, 7), "127.0.0.2:2009").empty()) << "address";
  EXPECT_TRUE(of(line(loopback(), "07D9", "0A", 1000, 7), "/run/socket").empty());
}

TEST(Peer, NonsenseIsNoSocket) {
  const std::string whole = line(loopback(), "07D9", "0A", 1000, 7);
  const auto end = whole.find(" 7 ") + 2;
  for (std::size_t size = 0; size < end; ++size)
    EXPECT_TRUE(of(whole.substr(0, size), "127.0.0.1:2009").size() <= 1);
  for (const char* text : {"", "\n\n", "a b c 0A", "0: 0100007F 0 0A 0 0 0 0 0 0",
                           "0: X100007F:07D9 0 0A 0 0 0 0 0 0", ":: 0A 0A 0A 0A 0A 0A 0A 0A 0A"})
    EXPECT_TRUE(of(text, "127.0.0.1:2009").empty()) << text;
}

TEST(Peer, OnlyRootAndWeAreBelieved) {
  EXPECT_TRUE(check_owner("it", 0));
  EXPECT_TRUE(check_owner("it", ::geteuid()));
  const auto other = check_owner("it", 64'999);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().text,
            "it belongs to uid 64999: only what belongs to root or to the user of mlccad is "
            "believed");
}

}  // namespace
}  // namespace mlcca::net
