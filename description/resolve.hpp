// SPDX-License-Identifier: BSD-2-Clause
// From the draft to the System, step by step: what has been resolved so far.
#pragma once
#include <cstddef>
#include <map>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "core/model/system.hpp"
#include "description/attributes.hpp"
#include "description/draft.hpp"
#include "description/names.hpp"
#include "description/problems.hpp"

namespace mlcca::description {

/// A user-defined attribute with composition survival counts in 1e-9, as PacketLoss does.
inline constexpr int kSurvivalMagnitude = -9;

/// Whose program sends at a port; users are looked up with those of publishers.
struct PortSender {
  std::size_t gateway = 0;
  std::size_t port = 0;
  std::string user;
};

/// The System with an index of its names. The indices refer to names in the draft or the System.
struct Resolved {
  core::System system;
  std::vector<KnownUserAttribute> user_attributes;
  std::vector<PortSender> port_senders;
  Index channels{"channel"};
  Index networks{"network"};
  Index gateways{"gateway"};
  std::map<std::size_t, Index> mesh_nodes;                    ///< of the networks that have a Mesh
  std::unordered_map<core::Subject, std::size_t> by_subject;  ///< filled when first asked

  /// By name, or by subject as 0x….
  std::optional<std::size_t> channel_named(std::string_view name, core::Origin origin,
                                           std::string_view element, Problems& problems);
};

/// The meshes of the networks that have one. Networks and gateways are known.
void add_meshes(Draft& draft, Resolved& to, Problems& problems);

/// Components, then publishers and subscribers, which are taken out of the draft.
void add_ends(Draft& draft, Resolved& to, Problems& problems, Users users);

/// Declared routes: known places that are next to each other.
void add_routes(const Draft& draft, Resolved& to, Problems& problems);

}  // namespace mlcca::description
