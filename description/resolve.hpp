// SPDX-License-Identifier: BSD-2-Clause
// The steps from the draft to the System, and what has been resolved so far.
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

/// The magnitude of user-defined attributes with composition survival: they count in 1e-9, like
/// PacketLoss.
inline constexpr int kSurvivalMagnitude = -9;

/// The user whose program sends at a port; resolved together with the users of publishers.
struct PortSender {
  std::size_t gateway = 0;
  std::size_t port = 0;
  std::string user;
};

/// The System so far, with indices of its names. The indices refer to texts in the draft or the
/// System.
struct Resolved {
  core::System system;
  std::vector<KnownUserAttribute> user_attributes;
  std::vector<PortSender> port_senders;
  Index channels{"channel"};
  Index networks{"network"};
  Index gateways{"gateway"};
  std::map<std::size_t, Index> mesh_nodes;                    ///< for the networks that have a Mesh
  std::unordered_map<core::Subject, std::size_t> by_subject;  ///< built when it is needed for the
                                                              ///< first time

  /// Finds a channel by its name, or by its subject as 0x….
  std::optional<std::size_t> channel_named(std::string_view name, core::Origin origin,
                                           std::string_view element, Problems& problems);
};

/// Adds the meshes of networks; networks and gateways must have been added.
void add_meshes(Draft& draft, Resolved& to, Problems& problems);

/// Adds components, publishers and subscribers, and removes the latter two from the draft.
void add_ends(Draft& draft, Resolved& to, Problems& problems, Users users);

/// Adds declared routes: each place must be known and next to the one before.
void add_routes(const Draft& draft, Resolved& to, Problems& problems);

}  // namespace mlcca::description
