// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/station.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "bpf/ether.h"
#include "core/model/system.hpp"

namespace mlcca::core {
namespace {

TEST(Station, IsReadAsItIsWritten) {
  const std::vector<std::pair<std::string, std::uint64_t>> rows = {
      {"192.0.2.7", 0xc0000207},
      {"02:00:00:00:00:ab", ETHER_MAC | 0x0200000000ab},
      {"0xbeef:0x0001", ETHER_SHORT | 0xbeef0001},
      {"0x0000:0xfffd", ETHER_SHORT | 0xfffd},
      {"0xffff:0x0000", ETHER_SHORT | 0xffff0000},
      {"02:00:00:00:00:00:00:01", ETHER_EXTENDED | 0x0200000000000001},
      {"fe:ff:ff:ff:ff:ff:ff:ff", ~0ULL},
      // Of its octets some are in the place of the other marks.
      {"00:03:00:00:c0:00:02:07", ETHER_EXTENDED | ETHER_MAC | ETHER_SHORT | 0xc0000207},
  };
  for (const auto& [text, bits] : rows) {
    const auto station = station_of(text);
    ASSERT_TRUE(station) << text;
    EXPECT_EQ(station->bits, bits) << text;
    EXPECT_EQ(to_text(*station), text);
    EXPECT_EQ(station->is_wpan(), bits >= ETHER_SHORT) << text;
  }
  EXPECT_EQ(to_text(Station{}), "");
  EXPECT_EQ(station_of("0XBEEF:0X00aB")->bits, ETHER_SHORT | 0xbeef00ab);
}

TEST(Station, IsNoneThatNobodySendsFrom) {
  for (const std::string text :
       {"", "192.0.2", "0.0.0.1", "127.0.0.1", "224.0.0.1", "01:00:00:00:00:01",
        "00:00:00:00:00:00", "02:00:00:00:00:00:01", "01:00:00:00:00:00:00:01",
        "00:00:00:00:00:00:00:00", "02:00:00:00:00:00:00:00:01", "0xbeef", "0xbeef:", "beef:0001",
        "0xbeef:0x001", "0xbeef:0x00001", "0xbeef:0xfffe", "0xbeef:0xffff", "0xbeef:0x0001 "})
    EXPECT_FALSE(station_of(text)) << text;
}

TEST(Station, IsOfTheKindOfItsNetwork) {
  EXPECT_TRUE(station_on(NetworkKind::ieee802154, "0xbeef:0x0001"));
  EXPECT_FALSE(station_on(NetworkKind::ieee802154, "192.0.2.7"));
  EXPECT_FALSE(station_on(NetworkKind::ieee802154, "02:00:00:00:00:01"));
  EXPECT_TRUE(station_on(NetworkKind::mesh, "02:00:00:00:00:01"));
  EXPECT_FALSE(station_on(NetworkKind::udp_multicast, "02:00:00:00:00:00:00:01"));
  EXPECT_NE(station_words(NetworkKind::ieee802154), station_words(NetworkKind::mesh));
}

}  // namespace
}  // namespace mlcca::core
