// SPDX-License-Identifier: BSD-2-Clause
// What nl80211 reports of an interface, as plain structs. Each reader gives nothing for a message
// of another command or without what identifies its subject; any other attribute may be missing.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "core/mesh/mesh.hpp"
#include "daemon/net/sources/genl.hpp"

namespace mlcca::net::nl80211 {

/// NL80211_CMD_NEW_INTERFACE.
struct Interface {
  std::string mac;
  bool mesh = false;                       ///< 802.11s mesh point
  std::optional<std::uint32_t> frequency;  ///< MHz; nothing: on no channel
};
[[nodiscard]] std::optional<Interface> read_interface(genl::Octets message);

/// NL80211_CMD_NEW_STATION: a peer that is received. Counters run from the beginning of the
/// peering.
struct Station {
  std::string mac;
  std::optional<Value> tx_bitrate;  ///< bit/s of the frame sent last
  std::optional<Value> rx_bitrate;  ///< bit/s of the frame received last
  /// bit/s that get through, by the rate control. Reported in kbit/s; minstrel's are 1024 bit/s, so
  /// that this is 2.3 % less than it means.
  std::optional<Value> expected_throughput;
  std::optional<std::uint32_t> tx_packets;
  std::optional<std::uint32_t> tx_retries;
  std::optional<std::uint32_t> tx_failed;       ///< given up after all retries
  std::optional<std::uint32_t> inactive;        ///< ms since something was received from it
  std::optional<std::uint8_t> plink_state;      ///< of a mesh peer: enum nl80211_plink_state
  std::optional<std::uint32_t> airtime_metric;  ///< 802.11s link metric, µs for 8192 bits
};
[[nodiscard]] std::optional<Station> read_station(genl::Octets message);

/// NL80211_CMD_NEW_MPATH: the way to a node of an 802.11s mesh.
struct MeshPath {
  std::string destination;
  std::string next_hop;
  std::uint32_t metric = 0;  ///< sum of the airtime metrics of its links; 0: not reported
  std::uint8_t hops = 0;     ///< 0: not reported
  std::uint8_t flags = 0;    ///< enum nl80211_mpath_flags
};
[[nodiscard]] std::optional<MeshPath> read_mesh_path(genl::Octets message);

/// NL80211_CMD_NEW_SURVEY_RESULTS: one channel. Times run from when the driver began to count.
struct Survey {
  std::uint32_t frequency = 0;          ///< MHz
  bool in_use = false;                  ///< the channel that the interface is on
  std::optional<std::uint64_t> time{};  ///< ms spent on the channel
  std::optional<std::uint64_t> busy{};  ///< ms of these in which it was taken, by anyone
  std::optional<std::uint64_t> sent{};  ///< ms of these in which this radio sent
};
[[nodiscard]] std::optional<Survey> read_survey(genl::Octets message);

}  // namespace mlcca::net::nl80211
