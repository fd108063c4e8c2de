// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/nl80211_messages.hpp"

#include <linux/nl80211.h>

#include <utility>

namespace mlcca::net::nl80211 {
namespace {

// The number of the family differs from boot to boot. The caller knows that the message is from
// nl80211.
std::optional<genl::Attributes> attributes_of(genl::Octets octets, std::uint8_t command) {
  auto message = genl::read_message(octets);
  if (!message || message->command != command) return {};
  return message->attributes;
}

/// The 16-bit rate cannot express more than 6.5 Gbit/s, so the 32-bit one is preferred.
std::optional<Value> read_bitrate(const genl::Attributes& rate) {
  std::optional<std::uint32_t> hundred_kbits = rate.u32(NL80211_RATE_INFO_BITRATE32);
  if (!hundred_kbits) hundred_kbits = rate.u16(NL80211_RATE_INFO_BITRATE);
  if (!hundred_kbits || *hundred_kbits == 0) return {};
  return Value{*hundred_kbits} * 100'000;
}

}  // namespace

std::optional<Interface> read_interface(genl::Octets message) {
  const auto attributes = attributes_of(message, NL80211_CMD_NEW_INTERFACE);
  if (!attributes) return {};
  auto mac = attributes->mac(NL80211_ATTR_MAC);
  if (!mac) return {};
  return Interface{.mac = std::move(*mac),
                   .mesh = attributes->u32(NL80211_ATTR_IFTYPE) ==
                           std::optional<std::uint32_t>(NL80211_IFTYPE_MESH_POINT),
                   .frequency = attributes->u32(NL80211_ATTR_WIPHY_FREQ)};
}

std::optional<Station> read_station(genl::Octets message) {
  const auto attributes = attributes_of(message, NL80211_CMD_NEW_STATION);
  if (!attributes) return {};
  auto mac = attributes->mac(NL80211_ATTR_MAC);
  if (!mac) return {};
  const genl::Attributes info = attributes->nested(NL80211_ATTR_STA_INFO);
  Station out;
  out.mac = std::move(*mac);
  out.tx_bitrate = read_bitrate(info.nested(NL80211_STA_INFO_TX_BITRATE));
  out.rx_bitrate = read_bitrate(info.nested(NL80211_STA_INFO_RX_BITRATE));
  if (const auto kbits = info.u32(NL80211_STA_INFO_EXPECTED_THROUGHPUT); kbits && *kbits != 0)
    out.expected_throughput = Value{*kbits} * 1000;
  out.tx_packets = info.u32(NL80211_STA_INFO_TX_PACKETS);
  out.tx_retries = info.u32(NL80211_STA_INFO_TX_RETRIES);
  out.tx_failed = info.u32(NL80211_STA_INFO_TX_FAILED);
  out.inactive = info.u32(NL80211_STA_INFO_INACTIVE_TIME);
  out.plink_state = info.u8(NL80211_STA_INFO_PLINK_STATE);
  out.airtime_metric = info.u32(NL80211_STA_INFO_AIRTIME_LINK_METRIC);
  return out;
}

std::optional<MeshPath> read_mesh_path(genl::Octets message) {
  const auto attributes = attributes_of(message, NL80211_CMD_NEW_MPATH);
  if (!attributes) return {};
  auto destination = attributes->mac(NL80211_ATTR_MAC);
  auto next_hop = attributes->mac(NL80211_ATTR_MPATH_NEXT_HOP);
  if (!destination || !next_hop) return {};
  const genl::Attributes info = attributes->nested(NL80211_ATTR_MPATH_INFO);
  return MeshPath{.destination = std::move(*destination),
                  .next_hop = std::move(*next_hop),
                  .metric = info.u32(NL80211_MPATH_INFO_METRIC).value_or(0),
                  .hops = info.u8(NL80211_MPATH_INFO_HOP_COUNT).value_or(0),
                  .flags = info.u8(NL80211_MPATH_INFO_FLAGS).value_or(0)};
}

std::optional<Survey> read_survey(genl::Octets message) {
  const auto attributes = attributes_of(message, NL80211_CMD_NEW_SURVEY_RESULTS);
  if (!attributes) return {};
  const genl::Attributes info = attributes->nested(NL80211_ATTR_SURVEY_INFO);
  const auto frequency = info.u32(NL80211_SURVEY_INFO_FREQUENCY);
  if (!frequency) return {};
  return Survey{.frequency = *frequency,
                .in_use = info.has(NL80211_SURVEY_INFO_IN_USE),
                .time = info.u64(NL80211_SURVEY_INFO_TIME),
                .busy = info.u64(NL80211_SURVEY_INFO_TIME_BUSY),
                .sent = info.u64(NL80211_SURVEY_INFO_TIME_TX)};
}

}  // namespace mlcca::net::nl80211
