// SPDX-License-Identifier: BSD-2-Clause
// The rules that a described system must obey beyond the schema. A problem names the place that
// breaks the rule and says what would be right.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

#include "core/mesh/link_table.hpp"
#include "core/model/system.hpp"
#include "description/problems.hpp"

namespace mlcca::description {

inline constexpr std::size_t kMaxChannels = 262144;
inline constexpr std::size_t kMaxUserAttributes = 64;
inline constexpr std::size_t kMaxPairs = 262144;  ///< publishers times subscribers of a channel
inline constexpr std::size_t kMaxNetworks = 1024;
inline constexpr std::size_t kMaxGateways = 256;
inline constexpr std::size_t kMaxMasks = 32;   ///< bindings with a mask on one network
inline constexpr std::size_t kMaxPorts = 256;  ///< for each gateway
/// For each mesh, like the following limits.
inline constexpr std::size_t kMaxMeshNodes = core::mesh::kMaxNodes;
/// Directed links; also the limit of members of domains.
inline constexpr std::size_t kMaxMeshLinks = core::mesh::kMaxLinks;
inline constexpr std::size_t kMaxMeshDomains = 1024;
inline constexpr std::size_t kMaxMeshSources = 16;

/// Checks all rules: for names, subjects, networks with their bindings, gateways with their ports,
/// meshes, publishers and subscribers. All indices in `system` must be valid.
void check_rules(const core::System& system, Problems& problems);

/// Reports a problem if there are more than `most` things.
template <class Things>
void check_count(const Things& things, std::size_t most, std::string_view element,
                 std::string_view words, Problems& problems) {
  if (things.size() > most)
    problems.add(things[most].origin, element,
                 std::to_string(things.size()) + " " + std::string(words) +
                     " are too many: at most " + std::to_string(most),
                 core::FindingId::too_many);
}

/// The parts of check_rules().
void check_channels(const core::System& system, Problems& problems);
void check_networks(const core::System& system, Problems& problems);
void check_gateways(const core::System& system, Problems& problems);
void check_presence(const core::System& system, Problems& problems);
void check_meshes(const core::System& system, Problems& problems);
void check_ends(const core::System& system, Problems& problems);

}  // namespace mlcca::description
