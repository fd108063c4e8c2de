// SPDX-License-Identifier: BSD-2-Clause
// What one gateway takes of networks that others use too, in numbers that mean the same to every
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

/// The traffic of one publisher on one resource (a network or gateway, see System::resource_of). It
/// is carried once, however many subscribers are behind it, but once more for each way in.
struct Flow {
  std::size_t publisher = 0;
  std::size_t resource = 0;
  std::size_t from = kOwn;  ///< the resource that it comes from; kOwn: the publisher itself

  static constexpr std::size_t kOwn = 0xffffffff;
  auto operator<=>(const Flow&) const = default;
};

}  // namespace mlcca::core

namespace mlcca::core::cluster {

/// Whose traffic: that of a described publisher, or of the one that an admission has brought. Of a
/// described publisher it is the same traffic whichever gateway has reserved it.
struct Source {
  std::size_t publisher = 0;  ///< index into System::publishers; 0 with an admission
  AdmissionId admission = 0;  ///< of the gateway that has reserved it
  std::size_t from = Flow::kOwn;
  auto operator<=>(const Source&) const = default;
};

/// A message on a CAN bus, with the identifiers of its frames.
struct BusPart {
  can::Message message;  ///< key: 0
  std::uint64_t first_id = 0;
  std::uint64_t last_id = 0;
  bool extended = false;
  Subject subject = 0;
  Source source;
  std::size_t gateway = 0;  ///< that has reserved it; says nothing in a Footprint
  bool operator==(const BusPart&) const = default;
};

/// Payload between two nodes of a mesh, as indices into Mesh::nodes.
struct PathPart {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  Value bytes_per_second = 0;
  Value event_bytes = 0;  ///< 0: not known
  Source source;
  std::size_t gateway = 0;  ///< as above
  bool operator==(const PathPart&) const = default;
};

/// Payload on a network of any kind.
struct RatePart {
  Value bytes_per_second = 0;
  Source source;
  std::size_t gateway = 0;  ///< as above
  bool operator==(const RatePart&) const = default;
};

/// What is taken of one network. Each source has one rate, at most one message, and any number of
/// paths.
struct Part {
  std::size_t network = 0;
  std::vector<RatePart> rates;
  std::vector<BusPart> bus;
  std::vector<PathPart> paths;
  bool operator==(const Part&) const = default;
};

struct Footprint {
  std::vector<Part> parts;            ///< of shared networks, each once, rising
  std::vector<std::size_t> gateways;  ///< on the way, without one's own, rising
  bool operator==(const Footprint&) const = default;
};

/// What others hold of one network.
struct Foreign {
  std::vector<RatePart> rates;
  std::vector<BusPart> bus;
  std::vector<PathPart> paths;
  bool unreadable = false;  ///< there is more, and it is not known what
  [[nodiscard]] bool empty() const {
    return rates.empty() && bus.empty() && paths.empty() && !unreadable;
  }
  bool operator==(const Foreign&) const = default;
};

/// What the description alone promises a flow on a network: all gateways count it, always.
struct Standing {
  Flow flow;
  Value bytes_per_second = 0;
  std::optional<can::Message> message;  ///< on an analysed bus; key: 0
  std::vector<PathPart> paths;          ///< on a mesh
  /// Every delivery that needs it could go over another gateway too.
  bool elected = false;
  bool operator==(const Standing&) const = default;
};

}  // namespace mlcca::core::cluster
