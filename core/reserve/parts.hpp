// SPDX-License-Identifier: BSD-2-Clause
// What one gateway takes of networks that others use too, in terms that mean the same to every
// gateway with the same description.
#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/can/message.hpp"
#include "core/model/members.hpp"
#include "core/model/system.hpp"

namespace mlcca::core {

/// Identifies the traffic of one publisher on one resource (a network or gateway, see
/// System::resource_of). It is carried once however many subscribers are behind it, but once for
/// each resource from which it arrives.
struct Flow {
  std::size_t publisher = 0;
  std::size_t resource = 0;
  std::size_t from = kOwn;  ///< the resource that it arrives from; kOwn: the publisher itself

  static constexpr std::size_t kOwn = 0xffffffff;
  auto operator<=>(const Flow&) const = default;
};

}  // namespace mlcca::core

namespace mlcca::core::cluster {

/// Identifies the publisher of some traffic, described or admitted. Traffic of a described
/// publisher is the same whichever gateway reserved it, so it counts once.
struct Source {
  std::size_t publisher = 0;  ///< index into System::publishers; 0 for an admitted one
  AdmissionId admission = 0;  ///< an admission of the gateway that reserved it; 0 for a described
                              ///< publisher
  std::size_t from = Flow::kOwn;
  auto operator<=>(const Source&) const = default;
};

/// A reserved message on a CAN bus with the range of its identifiers.
struct BusPart {
  can::Message message;  ///< its key is 0
  std::uint64_t first_id = 0;
  std::uint64_t last_id = 0;
  bool extended = false;
  Subject subject = 0;
  Source source;
  std::size_t gateway = 0;  ///< the gateway that reserved it; unused in a Footprint
  bool operator==(const BusPart&) const = default;
};

/// Reserved payload from one node of a mesh to another; nodes are indices into Mesh::nodes.
struct PathPart {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  Value bytes_per_second = 0;
  Value event_bytes = 0;  ///< payload of one event; 0: not known
  Source source;
  std::size_t gateway = 0;  ///< see BusPart::gateway
  bool operator==(const PathPart&) const = default;
};

/// Reserved payload rate on a network of any kind.
struct RatePart {
  Value bytes_per_second = 0;
  Source source;
  std::size_t gateway = 0;  ///< see BusPart::gateway
  bool operator==(const RatePart&) const = default;
};

/// What is taken of one network. Each source has one rate, at most one message and any number of
/// paths.
struct Part {
  std::size_t network = 0;
  std::vector<RatePart> rates;
  std::vector<BusPart> bus;
  std::vector<PathPart> paths;
  bool operator==(const Part&) const = default;
};

/// What a channel takes of shared networks beyond the standing promises.
struct Footprint {
  std::vector<Part> parts;            ///< one per shared network, by rising index
  std::vector<std::size_t> gateways;  ///< other gateways on its routes, by rising index
  bool operator==(const Footprint&) const = default;
};

/// What other gateways hold of one network.
struct Foreign {
  std::vector<RatePart> rates;
  std::vector<BusPart> bus;
  std::vector<PathPart> paths;
  bool unreadable = false;  ///< there are further reservations that could not be read
  [[nodiscard]] bool empty() const {
    return rates.empty() && bus.empty() && paths.empty() && !unreadable;
  }
  bool operator==(const Foreign&) const = default;
};

/// What the description alone promises to a flow on a network. Every gateway with that description
/// counts it, whether or not it is in use.
struct Standing {
  Flow flow;
  Value bytes_per_second = 0;
  std::optional<can::Message> message;  ///< on an analysed bus; its key is 0
  std::vector<PathPart> paths;          ///< on a mesh
  /// Whether every delivery that needs it could also go over another gateway.
  bool elected = false;
  bool operator==(const Standing&) const = default;
};

}  // namespace mlcca::core::cluster
