// SPDX-License-Identifier: BSD-2-Clause
// The reports of nl80211 about an interface, as plain structs. Each reader returns nullopt for a
// message of another command, or one that does not identify its subject. Any other attribute may be
// missing.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "core/mesh/mesh.hpp"
#include "daemon/net/sources/genl.hpp"

namespace mlcca::net::nl80211 {

/// NL80211_CMD_NEW_INTERFACE: the interface itself.
struct Interface {
  std::string mac;
  bool mesh = false;                       ///< 802.11s mesh point
  std::optional<std::uint32_t> frequency;  ///< MHz; nullopt: on no channel
};
[[nodiscard]] std::optional<Interface> read_interface(genl::Octets message);

/// NL80211_CMD_NEW_STATION: a peer from which frames are received. Counters begin with the peering.
struct Station {
  std::string mac;
  std::optional<Value> tx_bitrate;  ///< bit/s of the latest frame sent
  std::optional<Value> rx_bitrate;  ///< bit/s of the latest frame received
  /// bit/s that get through, as the rate control expects. It is reported in kbit/s; minstrel uses
  /// units of 1024 bit/s, so that this value is 2.3 % too low.
  std::optional<Value> expected_throughput;
  std::optional<std::uint32_t> tx_packets;
  std::optional<std::uint32_t> tx_retries;
  std::optional<std::uint32_t> tx_failed;       ///< given up after all retries
  std::optional<std::uint32_t> inactive;        ///< ms since anything was received from it
  std::optional<std::uint8_t> plink_state;      ///< of a mesh peer: enum nl80211_plink_state
  std::optional<std::uint32_t> airtime_metric;  ///< 802.11s link metric, µs for 8192 bits
};
[[nodiscard]] std::optional<Station> read_station(genl::Octets message);

/// NL80211_CMD_NEW_MPATH: the path to a node of an 802.11s mesh.
struct MeshPath {
  std::string destination;
  std::string next_hop;
  std::uint32_t metric = 0;  ///< sum of the airtime metrics of its links; 0: not reported
  std::uint8_t hops = 0;     ///< 0: not reported
  std::uint8_t flags = 0;    ///< enum nl80211_mpath_flags
};
[[nodiscard]] std::optional<MeshPath> read_mesh_path(genl::Octets message);

/// NL80211_CMD_NEW_SURVEY_RESULTS: one channel. Times begin when the driver began to count.
struct Survey {
  std::uint32_t frequency = 0;          ///< MHz
  bool in_use = false;                  ///< the channel of the interface
  std::optional<std::uint64_t> time{};  ///< ms spent on the channel
  std::optional<std::uint64_t> busy{};  ///< ms of these in which it was busy, with any sender
  std::optional<std::uint64_t> sent{};  ///< ms of these in which this radio sent
};
[[nodiscard]] std::optional<Survey> read_survey(genl::Octets message);

}  // namespace mlcca::net::nl80211
