// SPDX-License-Identifier: BSD-2-Clause
// What is read out of netlink messages, well formed and not.
#include <gtest/gtest.h>
#include <linux/batman_adv.h>
#include <linux/ethtool.h>
#include <linux/ethtool_netlink.h>
#include <linux/if.h>
#include <linux/if_link.h>
#include <linux/nl80211.h>
#include <linux/rtnetlink.h>

#include <array>
#include <bit>
#include <span>
#include <vector>

#include "daemon/net/sources/batman.hpp"
#include "daemon/net/sources/nl80211_messages.hpp"
#include "daemon/net/sources/wire.hpp"
#include "tests/daemon/net/sources/radio_message.hpp"

namespace mlcca::net {
namespace {

using test::Mac;
using test::MessageMaker;

constexpr Mac kOne{0x02, 0x00, 0x00, 0x00, 0x0a, 0xf1};
constexpr Mac kTwo{0x02, 0x00, 0x00, 0x00, 0x0b, 0x02};

MessageMaker station() {
  MessageMaker made(NL80211_CMD_NEW_STATION);
  made.u32(NL80211_ATTR_IFINDEX, 3).mac(NL80211_ATTR_MAC, kOne).begin(NL80211_ATTR_STA_INFO);
  made.u32(NL80211_STA_INFO_INACTIVE_TIME, 384)
      .u8(NL80211_STA_INFO_PLINK_STATE, NL80211_PLINK_ESTAB)
      .begin(NL80211_STA_INFO_TX_BITRATE)
      .u16(NL80211_RATE_INFO_BITRATE, 130)
      .u32(NL80211_RATE_INFO_BITRATE32, 131)
      .end()
      .begin(NL80211_STA_INFO_RX_BITRATE)
      .u16(NL80211_RATE_INFO_BITRATE, 55)
      .end()
      .u32(NL80211_STA_INFO_TX_PACKETS, 286)
      .u32(NL80211_STA_INFO_TX_RETRIES, 7)
      .u32(NL80211_STA_INFO_TX_FAILED, 2)
      .u32(NL80211_STA_INFO_EXPECTED_THROUGHPUT, 9704)
      .u32(NL80211_STA_INFO_AIRTIME_LINK_METRIC, 820)
      .end();
  return made;
}

TEST(RadioMessages, AStationHasItsRatesCountersAndAge) {
  const auto octets = station().octets();
  const auto read = nl80211::read_station(octets);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->mac, "02:00:00:00:0a:f1");
  EXPECT_EQ(read->tx_bitrate, 13'100'000U) << "the 32-bit rate is preferred";
  EXPECT_EQ(read->rx_bitrate, 5'500'000U);
  EXPECT_EQ(read->expected_throughput, 9'704'000U);
  EXPECT_EQ(read->tx_packets, 286U);
  EXPECT_EQ(read->tx_retries, 7U);
  EXPECT_EQ(read->tx_failed, 2U);
  EXPECT_EQ(read->inactive, 384U);
  EXPECT_EQ(read->plink_state, NL80211_PLINK_ESTAB);
  EXPECT_EQ(read->airtime_metric, 820U);
}

// Numbers as netlink has them: in the byte order of the machine.
template <class Number>
void put(std::vector<std::byte>& to, Number number) {
  const auto octets = std::bit_cast<std::array<std::byte, sizeof number>>(number);
  to.insert(to.end(), octets.begin(), octets.end());
}
void put_attribute_head(std::vector<std::byte>& to, std::uint16_t length, std::uint16_t type) {
  put(to, length);
  put(to, type);
}

// Written by hand, field by field: libnl has no part in it.
TEST(RadioMessages, AStationIsReadFromItsOctets) {
  std::vector<std::byte> raw;
  put(raw, std::uint32_t{56});    // length of the message
  put(raw, std::uint16_t{0x1c});  // type: the family
  put(raw, std::uint16_t{2});     // flags: one of several
  put(raw, std::uint32_t{1});     // sequence
  put(raw, std::uint32_t{2});     // port
  for (const auto octet : {19, 1, 0, 0}) put(raw, static_cast<std::uint8_t>(octet));  // NEW_STATION
  put_attribute_head(raw, 10, 6);                                                     // MAC
  for (const auto octet : {2, 0, 0, 0, 1, 0}) put(raw, static_cast<std::uint8_t>(octet));
  put(raw, std::uint16_t{0});           // padding
  put_attribute_head(raw, 24, 0x8015);  // STA_INFO, nested
  put_attribute_head(raw, 8, 1);        // INACTIVE_TIME
  put(raw, std::uint32_t{384});
  put_attribute_head(raw, 12, 0x8008);  // TX_BITRATE, nested
  put_attribute_head(raw, 8, 5);        // BITRATE32
  put(raw, std::uint32_t{10});
  const auto read = nl80211::read_station(raw);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->mac, "02:00:00:00:01:00");
  EXPECT_EQ(read->inactive, 384U);
  EXPECT_EQ(read->tx_bitrate, 1'000'000U);
  EXPECT_FALSE(read->rx_bitrate);
  EXPECT_FALSE(read->expected_throughput);
}

TEST(RadioMessages, WhatAStationDoesNotReportIsUnknown) {
  MessageMaker made(NL80211_CMD_NEW_STATION);
  made.mac(NL80211_ATTR_MAC, kOne);
  auto octets = made.octets();
  auto read = nl80211::read_station(octets);
  ASSERT_TRUE(read);
  EXPECT_FALSE(read->tx_bitrate);
  EXPECT_FALSE(read->inactive);
  EXPECT_FALSE(read->plink_state);

  // Zero is what drivers write for "no rate".
  made.begin(NL80211_ATTR_STA_INFO)
      .begin(NL80211_STA_INFO_TX_BITRATE)
      .u32(NL80211_RATE_INFO_BITRATE32, 0)
      .end()
      .u32(NL80211_STA_INFO_EXPECTED_THROUGHPUT, 0)
      .end();
  octets = made.octets();
  read = nl80211::read_station(octets);
  ASSERT_TRUE(read);
  EXPECT_FALSE(read->tx_bitrate);
  EXPECT_FALSE(read->expected_throughput);
}

TEST(RadioMessages, AnAttributeOfAnotherSizeIsNotTaken) {
  MessageMaker made(NL80211_CMD_NEW_STATION);
  made.mac(NL80211_ATTR_MAC, kOne)
      .begin(NL80211_ATTR_STA_INFO)
      .u16(NL80211_STA_INFO_TX_PACKETS, 5)
      .u64(NL80211_STA_INFO_TX_FAILED, 6)
      .end();
  const auto octets = made.octets();
  const auto read = nl80211::read_station(octets);
  ASSERT_TRUE(read);
  EXPECT_FALSE(read->tx_packets);
  EXPECT_FALSE(read->tx_failed);

  MessageMaker half(NL80211_CMD_NEW_STATION);
  half.put(NL80211_ATTR_MAC, kOne.data(), 5);
  EXPECT_FALSE(nl80211::read_station(half.octets())) << "an address of 5 octets";
}

TEST(RadioMessages, AnotherCommandIsNotTakenForAStation) {
  MessageMaker made(NL80211_CMD_DEL_STATION);
  made.mac(NL80211_ATTR_MAC, kOne);
  EXPECT_FALSE(nl80211::read_station(made.octets()));
}

TEST(RadioMessages, AnInterfaceHasAnAddressAndAFrequencyIfItIsOnAChannel) {
  MessageMaker made(NL80211_CMD_NEW_INTERFACE);
  made.u32(NL80211_ATTR_IFTYPE, NL80211_IFTYPE_MESH_POINT).mac(NL80211_ATTR_MAC, kTwo);
  auto read = nl80211::read_interface(made.octets());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->mac, "02:00:00:00:0b:02");
  EXPECT_TRUE(read->mesh);
  EXPECT_FALSE(read->frequency);
  made.u32(NL80211_ATTR_WIPHY_FREQ, 2412);
  read = nl80211::read_interface(made.octets());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->frequency, 2412U);
}

MessageMaker mesh_path() {
  MessageMaker made(NL80211_CMD_NEW_MPATH);
  made.mac(NL80211_ATTR_MAC, kOne)
      .mac(NL80211_ATTR_MPATH_NEXT_HOP, kTwo)
      .begin(NL80211_ATTR_MPATH_INFO)
      .u32(NL80211_MPATH_INFO_METRIC, 1087)
      .u8(NL80211_MPATH_INFO_FLAGS, NL80211_MPATH_FLAG_ACTIVE | NL80211_MPATH_FLAG_RESOLVED)
      .u8(NL80211_MPATH_INFO_HOP_COUNT, 2)
      .end();
  return made;
}

TEST(RadioMessages, AMeshPathHasDestinationNextHopAndMetric) {
  const auto read = nl80211::read_mesh_path(mesh_path().octets());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->destination, "02:00:00:00:0a:f1");
  EXPECT_EQ(read->next_hop, "02:00:00:00:0b:02");
  EXPECT_EQ(read->metric, 1087U);
  EXPECT_EQ(read->hops, 2);
  EXPECT_EQ(read->flags, NL80211_MPATH_FLAG_ACTIVE | NL80211_MPATH_FLAG_RESOLVED);
}

MessageMaker survey() {
  MessageMaker made(NL80211_CMD_NEW_SURVEY_RESULTS);
  made.u32(NL80211_ATTR_IFINDEX, 3)
      .begin(NL80211_ATTR_SURVEY_INFO)
      .u32(NL80211_SURVEY_INFO_FREQUENCY, 5180)
      .flag(NL80211_SURVEY_INFO_IN_USE)
      .u64(NL80211_SURVEY_INFO_TIME, 0x1'0000'0000)
      .u64(NL80211_SURVEY_INFO_TIME_BUSY, 77)
      .u64(NL80211_SURVEY_INFO_TIME_TX, 33)
      .end();
  return made;
}

TEST(RadioMessages, ASurveyHasTimesOfSixtyFourBits) {
  const auto read = nl80211::read_survey(survey().octets());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->frequency, 5180U);
  EXPECT_TRUE(read->in_use);
  EXPECT_EQ(read->time, 0x1'0000'0000U);
  EXPECT_EQ(read->busy, 77U);
  EXPECT_EQ(read->sent, 33U);
}

MessageMaker batman_neighbour() {
  MessageMaker made(BATADV_CMD_GET_NEIGHBORS);
  made.mac(BATADV_ATTR_NEIGH_ADDRESS, kTwo)
      .u32(BATADV_ATTR_HARD_IFINDEX, 4)
      .u32(BATADV_ATTR_LAST_SEEN_MSECS, 120)
      .u32(BATADV_ATTR_THROUGHPUT, 8500);
  return made;
}
MessageMaker batman_originator() {
  MessageMaker made(BATADV_CMD_GET_ORIGINATORS);
  made.mac(BATADV_ATTR_ORIG_ADDRESS, kOne)
      .mac(BATADV_ATTR_NEIGH_ADDRESS, kTwo)
      .u32(BATADV_ATTR_HARD_IFINDEX, 4)
      .u32(BATADV_ATTR_LAST_SEEN_MSECS, 30)
      .u8(BATADV_ATTR_TQ, 51)
      .flag(BATADV_ATTR_FLAG_BEST);
  return made;
}

TEST(RadioMessages, BatmansThroughputOfANeighbourIsInKilobits) {
  const auto read = batman::read_neighbour(batman_neighbour().octets());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->mac, "02:00:00:00:0b:02");
  EXPECT_EQ(read->interface, 4U);
  EXPECT_EQ(read->last_seen, 120U);
  EXPECT_EQ(read->throughput, 8'500'000U);
}

TEST(RadioMessages, ABatmanOriginatorNamesTheBestWay) {
  const auto read = batman::read_originator(batman_originator().octets());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->mac, "02:00:00:00:0a:f1");
  EXPECT_EQ(read->next_hop, "02:00:00:00:0b:02");
  EXPECT_TRUE(read->best);
  EXPECT_EQ(read->quality, 51);
}

MessageMaker wire_link(unsigned flags) {
  ifinfomsg fixed{};
  fixed.ifi_index = 7;
  fixed.ifi_flags = flags;
  MessageMaker made(RTM_NEWLINK, fixed);
  made.mac(IFLA_ADDRESS, kOne);
  return made;
}
MessageMaker link_modes(std::uint32_t speed, std::uint8_t duplex) {
  MessageMaker made(ETHTOOL_MSG_LINKMODES_GET_REPLY);
  made.u32(ETHTOOL_A_LINKMODES_SPEED, speed).u8(ETHTOOL_A_LINKMODES_DUPLEX, duplex);
  return made;
}

TEST(RadioMessages, AWireRunsWithACarrierOnly) {
  auto read = wire::read_interface(wire_link(IFF_UP | IFF_RUNNING).octets());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->mac, "02:00:00:00:0a:f1");
  EXPECT_EQ(read->index, 7U);
  EXPECT_TRUE(read->running);
  read = wire::read_interface(wire_link(IFF_UP).octets());
  ASSERT_TRUE(read);
  EXPECT_FALSE(read->running);
}

TEST(RadioMessages, AWiresSpeedIsInMegabitsOrUnknown) {
  auto read = wire::read_link_modes(link_modes(100, DUPLEX_HALF).octets());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->speed, 100'000'000U);
  EXPECT_TRUE(read->half_duplex);
  read = wire::read_link_modes(link_modes(100'000, DUPLEX_FULL).octets());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->speed, 100'000'000'000U);
  EXPECT_FALSE(read->half_duplex);
  for (const std::uint32_t unknown : {0U, 0xffffffffU}) {
    read = wire::read_link_modes(link_modes(unknown, DUPLEX_UNKNOWN).octets());
    ASSERT_TRUE(read);
    EXPECT_FALSE(read->speed);
    EXPECT_TRUE(read->half_duplex) << "unknown counts as the worse";
  }
}

TEST(RadioMessages, DamagedMessagesAreSurvived) {
  const auto survives = [](const MessageMaker& made, auto read) {
    test::expect_survives_damage(made.octets(), read);
  };
  survives(station(), nl80211::read_station);
  survives(mesh_path(), nl80211::read_mesh_path);
  survives(survey(), nl80211::read_survey);
  survives(batman_neighbour(), batman::read_neighbour);
  survives(batman_originator(), batman::read_originator);
  survives(wire_link(IFF_UP), wire::read_interface);
  survives(link_modes(1000, DUPLEX_FULL), wire::read_link_modes);
}

TEST(RadioMessages, AMessageShorterThanItSaysIsNone) {
  auto octets = station().octets();
  octets.pop_back();
  EXPECT_FALSE(nl80211::read_station(octets));
}

TEST(RadioMessages, AnAttributeThatEndsAfterItsSurroundingsIsNone) {
  // Length 8 where 4 octets are left; then the same with all of them there.
  const std::array<std::uint16_t, 4> octets{8, NL80211_SURVEY_INFO_IN_USE, 0, 0};
  const auto all = std::as_bytes(std::span(octets));
  EXPECT_FALSE(genl::Attributes(all.first(4)).has(NL80211_SURVEY_INFO_IN_USE));
  EXPECT_TRUE(genl::Attributes(all).has(NL80211_SURVEY_INFO_IN_USE));
}

TEST(RadioMessages, AnAttributeThatSaysLessThanItsHeaderEndsTheList) {
  auto octets = station().octets();
  octets[20] = std::byte{3};  // length of the first attribute, in front of the address
  EXPECT_FALSE(nl80211::read_station(octets));
}

}  // namespace
}  // namespace mlcca::net
