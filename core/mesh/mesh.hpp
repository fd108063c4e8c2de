// SPDX-License-Identifier: BSD-2-Clause
// What a description states of a mesh: its nodes, how its links share the medium, and the sources
// of the state of its links.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/model/origin.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::core::mesh {

/// Which links share the time of one medium.
enum class Interference : std::uint8_t {
  single_domain,  ///< all links of the mesh, as in the paper's equation
  k_hop,          ///< links on the same channel with ends at most `hops` links apart
  channel,        ///< all links on the same channel
  explicit_sets,  ///< the described domains; a link in none of them shares with all links
};

/// How a rate was obtained. Overhead is added to PHY rates only, because the others include it.
enum class RateKind : std::uint8_t {
  phy,        ///< bit rate of the modulation
  effective,  ///< expected throughput according to the driver or the protocol
  derived,    ///< computed from a routing metric
};

/// A described node of a mesh.
struct Node {
  std::string name;
  std::string address;  ///< as the sources name it, in lower case: a MAC or IP address
  std::optional<std::uint32_t> gateway;  ///< index into System::gateways; nullopt: it is no gateway
  Origin origin;
  bool operator==(const Node&) const = default;
};

/// A described link in one direction.
struct DescribedLink {
  std::uint32_t from = 0;  ///< index into Mesh::nodes
  std::uint32_t to = 0;
  Value rate = 0;             ///< bit/s
  Value loss = 0;             ///< share of packets lost, in 1e-9
  std::uint32_t channel = 0;  ///< any number; links with equal numbers share the medium
  RateKind kind = RateKind::phy;
  Origin origin;
  bool operator==(const DescribedLink&) const = default;
};

/// A described domain, for Interference::explicit_sets.
struct DescribedDomain {
  std::string name;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> links;  ///< node indices, either direction
  Origin origin;
  bool operator==(const DescribedDomain&) const = default;
};

/// From where the state of links is known.
enum class SourceKind : std::uint8_t {
  description,  ///< the described links, which are always present
  file,         ///< a file of links, which is read again when it changes
  nl80211,      ///< stations, mesh paths and survey of a radio of this machine
  batman,       ///< batman-adv with BATMAN_V
  awds,         ///< topology packets of AWDS, read by the unit mlcca-awds@INTERFACE
  babel,        ///< babeld's local interface
  olsr,         ///< OONF olsrd2: the graph with its airtime metric
  wire,         ///< speed of an Ethernet interface of this machine
};

/// The meaning of the 16-bit quality of an AWDS link, which the packets do not state.
enum class AwdsMetric : std::uint8_t { etx, hops, packet_pair, transmission_time };

/// A described source of the state of links.
struct Source {
  SourceKind kind = SourceKind::description;
  std::string interface;  ///< nl80211, awds, wire: kernel name; batman: the mesh interface (bat0)
  std::string endpoint;   ///< babel, olsr: HOST:PORT (numeric) or socket path; file: its path
  AwdsMetric metric = AwdsMetric::etx;
  Origin origin;
  bool operator==(const Source&) const = default;
};

/// Whether the source is the description itself, whose links are stated, never measured and never
/// stale.
[[nodiscard]] inline bool is_description(const Source& source) {
  return source.kind == SourceKind::description;
}

inline constexpr std::uint32_t kWhole = 1'000'000;  ///< the 1e-6 units of a complete share

/// The parameters, nodes and links of a mesh whose routes are evaluated.
struct Mesh {
  Interference interference = Interference::single_domain;
  std::uint32_t hops = 2;             ///< the k of k_hop, 0 to 16
  std::uint32_t limit = 800'000;      ///< the most of a domain's time that may be taken, in 1e-6
  std::uint32_t packet_bytes = 1400;  ///< payload bytes of the largest packet, 1 to 65535
  std::uint32_t header_bytes = 36;    ///< bytes sent with each packet at the link's rate (MAC and
                                      ///< LLC)
  Value packet_time = 0;  ///< ns per packet beside its bits: gaps, preamble, acknowledgement
  Value stale_after = 3'000'000'000;  ///< ns; older samples do not count
  Value hold_up = 5'000'000'000;      ///< ns that a clearly better value must last before it counts
  std::uint32_t tolerance = 100'000;  ///< 1e-6 of a value; smaller improvements are not clear
  AttributeSet per_hop;               ///< what each link provides while no domain exceeds its limit
  std::vector<Node> nodes;
  std::vector<DescribedLink> links;
  std::vector<DescribedDomain> domains;
  std::vector<Source> sources;
  Origin origin;
  bool operator==(const Mesh&) const = default;
};

/// Whether two descriptions are equal apart from the places where things were declared.
[[nodiscard]] bool same_description(const Mesh& a, const Mesh& b);

}  // namespace mlcca::core::mesh
