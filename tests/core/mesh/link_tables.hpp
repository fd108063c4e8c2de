// SPDX-License-Identifier: BSD-2-Clause
// A mesh of three nodes and three sources, and what they say of its links.
#pragma once
#include <cstdint>

#include "core/mesh/link_table.hpp"
#include "tests/core/mesh/meshes.hpp"

namespace mlcca::core::mesh::testing {

inline constexpr std::uint64_t kSecond = 1'000'000'000;
inline constexpr Value kHold = 5 * kSecond;
inline constexpr Value kStale = 3 * kSecond;

/// Three described nodes, three sources: one that is live, another, and the description.
inline Mesh mesh_of_three() {
  Mesh mesh = bare_mesh();
  mesh.hold_up = kHold;
  mesh.stale_after = kStale;
  mesh.tolerance = 100'000;
  mesh.nodes = {
      {"a", "02:00:00:00:00:01", {}, {}}, {"b", "02:00:00:00:00:02", {}, {}}, {"c", "", {}, {}}};
  mesh.sources.resize(3);
  mesh.sources[0].kind = SourceKind::nl80211;
  mesh.sources[1].kind = SourceKind::babel;
  mesh.sources[2].kind = SourceKind::description;
  return mesh;
}

inline constexpr const char* kA = "02:00:00:00:00:01";
inline constexpr const char* kB = "02:00:00:00:00:02";

inline Sample sample(Value rate, std::uint64_t taken, const char* from = kA, const char* to = kB) {
  Sample result;
  result.from = from;
  result.to = to;
  result.rate = rate;
  result.taken = taken;
  return result;
}

}  // namespace mlcca::core::mesh::testing
