// SPDX-License-Identifier: BSD-2-Clause
// What each kind of source is trusted for: the presence of links, and their rates.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/mesh/mesh.hpp"

namespace mlcca::core::mesh {

/// How well a kind of source knows whether a link is present. If several sources would know of a
/// link, only those of the highest kind decide, and one of them must report it.
enum class Presence : std::uint8_t {
  stated,    ///< stated by a person: counts as long as no other source would know
  device,    ///< an interface of this machine
  protocol,  ///< the mesh's own protocol: a link that it has lost carries nothing
};

/// Which present links a source always reports.
enum class Scope : std::uint8_t {
  none,
  of_here,  ///< those with one end at this machine
  of_mesh,  ///< all links of the mesh
};

/// The role of one kind of source.
struct Role {
  SourceKind kind;
  Presence presence;
  Scope scope;
  bool rates;  ///< it may report rates
};

inline constexpr auto kRoles = std::to_array<Role>({
    {SourceKind::description, Presence::stated, Scope::none, true},
    {SourceKind::file, Presence::stated, Scope::none, true},
    {SourceKind::nl80211, Presence::device, Scope::of_here, true},
    {SourceKind::batman, Presence::protocol, Scope::of_here, true},
    {SourceKind::awds, Presence::protocol, Scope::of_mesh, true},
    {SourceKind::babel, Presence::protocol, Scope::of_here, false},
    {SourceKind::olsr, Presence::protocol, Scope::of_here, true},
    {SourceKind::wire, Presence::device, Scope::of_here, true},
});

namespace detail {
constexpr bool roles_are_dense() {
  for (std::size_t i = 0; i < kRoles.size(); ++i)
    if (static_cast<std::size_t>(kRoles[i].kind) != i) return false;
  return true;
}
static_assert(roles_are_dense());
}  // namespace detail

[[nodiscard]] constexpr const Role& role_of(SourceKind kind) {
  return kRoles[static_cast<std::size_t>(kind)];
}

/// Whether the source may know the rates of links.
[[nodiscard]] constexpr bool knows_rates(const Source& source) {
  if (source.kind == SourceKind::awds)
    return source.metric == AwdsMetric::packet_pair ||
           source.metric == AwdsMetric::transmission_time;
  return role_of(source.kind).rates;
}

/// Whether any source other than the description may know the links at run time.
[[nodiscard]] inline bool is_measured(const Mesh& mesh) {
  return !std::ranges::all_of(mesh.sources, is_description);
}

/// Whether a source of that kind reports the link whenever it is present. `here`: the node of this
/// machine.
[[nodiscard]] constexpr bool would_know(SourceKind kind, std::uint32_t from, std::uint32_t to,
                                        std::optional<std::uint32_t> here) {
  switch (role_of(kind).scope) {
    case Scope::of_mesh:
      return true;
    case Scope::of_here:
      return here == from || here == to;
    case Scope::none:
      break;
  }
  return false;
}

}  // namespace mlcca::core::mesh
