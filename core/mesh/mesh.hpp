// SPDX-License-Identifier: BSD-2-Clause
// What a description says of a mesh: its nodes, how its links share the medium, where the state of
// the links comes from.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/model/origin.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::core::mesh {

/// Which links share their medium's time.
enum class Interference : std::uint8_t {
  single_domain,  ///< all of the mesh: the paper's equation
  k_hop,          ///< same channel, and an end of one at most `hops` links away from an end of the
                  ///< other
  channel,        ///< all on the same channel
  explicit_sets,  ///< the described domains; a link in none of them shares with all
};

/// How a rate was come by. Overhead is added to PHY rates only: the others include it.
enum class RateKind : std::uint8_t {
  phy,        ///< bit rate of the modulation
  effective,  ///< what the driver or the protocol expects to get through
  derived,    ///< computed from a routing metric
};

struct Node {
  std::string name;
  std::string address;  ///< as the sources name it, lower case: a MAC or an IP address
  std::optional<std::uint32_t> gateway;  ///< index into System::gateways
  Origin origin;
  bool operator==(const Node&) const = default;
};

/// A link that the description states, in one direction.
struct DescribedLink {
  std::uint32_t from = 0;  ///< index into Mesh::nodes
  std::uint32_t to = 0;
  Value rate = 0;             ///< bit/s
  Value loss = 0;             ///< 1e-9 of the packets
  std::uint32_t channel = 0;  ///< any number; equal ones share the medium
  RateKind kind = RateKind::phy;
  Origin origin;
  bool operator==(const DescribedLink&) const = default;
};

/// Links (of both directions) that share one medium's time, for Interference::explicit_sets.
struct DescribedDomain {
  std::string name;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> links;  ///< node indices, either direction
  Origin origin;
  bool operator==(const DescribedDomain&) const = default;
};

enum class SourceKind : std::uint8_t {
  description,  ///< the described links, always
  file,         ///< a file of links, read again when it changes
  nl80211,      ///< stations, mesh paths and survey of a radio of this machine
  batman,       ///< batman-adv, BATMAN_V
  awds,         ///< topology packets of AWDS, from the unit mlcca-awds@INTERFACE
  babel,        ///< babeld's local interface
  olsr,         ///< OONF olsrd2: the graph with its airtime metric
  wire,         ///< speed of an Ethernet interface of this machine
};

/// What the 16-bit quality of an AWDS link means; the packets do not say.
enum class AwdsMetric : std::uint8_t { etx, hops, packet_pair, transmission_time };

struct Source {
  SourceKind kind = SourceKind::description;
  std::string interface;  ///< nl80211, awds, wire: kernel name; batman: the mesh interface (bat0)
  std::string endpoint;   ///< babel, olsr: HOST:PORT (numeric) or the path of a socket; file: path
  AwdsMetric metric = AwdsMetric::etx;
  Origin origin;
  bool operator==(const Source&) const = default;
};

/// What it says of links is stated, and neither measured nor ever old.
[[nodiscard]] inline bool is_description(const Source& source) {
  return source.kind == SourceKind::description;
}

inline constexpr std::uint32_t kWhole = 1'000'000;  ///< 1e-6 units of a whole

struct Mesh {
  Interference interference = Interference::single_domain;
  std::uint32_t hops = 2;             ///< k of k_hop, 0 to 16
  std::uint32_t limit = 800'000;      ///< 1e-6 of a domain's time that may be taken at most
  std::uint32_t packet_bytes = 1400;  ///< payload of the largest packet, 1 to 65535
  std::uint32_t header_bytes = 36;    ///< sent with each packet at the link's rate (MAC and LLC)
  Value packet_time = 0;  ///< ns for each packet beside its bits: gaps, preamble, acknowledgement
  Value stale_after = 3'000'000'000;  ///< ns; an older sample is unknown
  Value hold_up = 5'000'000'000;      ///< ns that a better rate must last before it counts
  std::uint32_t tolerance = 100'000;  ///< 1e-6; smaller improvements are ignored
  AttributeSet per_hop;               ///< what each link gives while no domain is above its limit
  std::vector<Node> nodes;
  std::vector<DescribedLink> links;
  std::vector<DescribedDomain> domains;
  std::vector<Source> sources;
  Origin origin;
  bool operator==(const Mesh&) const = default;
};

/// They say the same, wherever they say it.
[[nodiscard]] bool same_description(const Mesh& a, const Mesh& b);

}  // namespace mlcca::core::mesh
