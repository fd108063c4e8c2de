// SPDX-License-Identifier: BSD-2-Clause
// Datagrams of events, as FAMOUSO's own programs send them.
#include "relay/layers/udp_layer.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace mlcca::relay {
namespace {

std::uint64_t subject_of(const std::string& text) {
  std::uint64_t out = 0;
  for (std::size_t i = 0; i < 8; ++i)
    out = out << 8U | (i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0U);
  return out;
}

std::string group(std::uint64_t subject) {
  const std::uint32_t g = group_of(subject);
  return std::to_string(g >> 24U) + '.' + std::to_string(g >> 16U & 0xffU) + '.' +
         std::to_string(g >> 8U & 0xffU) + '.' + std::to_string(g & 0xffU);
}

TEST(UdpLayerTest, TheGroupsAreThoseOfTheReference) {
  EXPECT_EQ(group(subject_of("SUBSCRIB")), "239.83.66.82");
  EXPECT_EQ(group(subject_of("Distance")), "239.68.101.110");
  EXPECT_EQ(group(subject_of("Velocity")), "239.86.121.105");
  EXPECT_EQ(group(subject_of("ManChan!")), "239.77.33.97");
  EXPECT_EQ(group(0xf100000000000000), "239.241.0.1");
  EXPECT_EQ(group(0xf100000000ff0000), "239.241.0.254");
}

TEST(UdpLayerTest, ADatagramIsSubjectFlagAndData) {
  const auto header = datagram_header(subject_of("Velocity"), true);
  EXPECT_EQ(std::string(header.begin(), header.end()), std::string("Velocity\1"));
  std::vector<std::uint8_t> octets(header.begin(), header.end());
  octets.insert(octets.end(), {1, 2, 3});
  const auto read = parse_datagram(octets);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->subject, subject_of("Velocity"));
  EXPECT_TRUE(read->is_fragment);
  EXPECT_EQ(std::vector(read->data.begin(), read->data.end()),
            (std::vector<std::uint8_t>{1, 2, 3}));
  octets[8] = 0;
  EXPECT_FALSE(parse_datagram(octets)->is_fragment);
  octets[8] = 2;
  EXPECT_FALSE(parse_datagram(octets));
  octets.resize(9);
  octets[8] = 0;
  ASSERT_TRUE(parse_datagram(octets));
  EXPECT_TRUE(parse_datagram(octets)->data.empty());
  octets.resize(8);
  EXPECT_FALSE(parse_datagram(octets)) << "FAMOUSO's own receiver crashes at it";
}

}  // namespace
}  // namespace mlcca::relay
