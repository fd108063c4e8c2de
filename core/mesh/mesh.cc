// SPDX-License-Identifier: BSD-2-Clause
#include "core/mesh/mesh.hpp"

namespace mlcca::core::mesh {
namespace {

Mesh without_origins(Mesh mesh) {
  mesh.origin = {};
  for (auto& node : mesh.nodes) node.origin = {};
  for (auto& link : mesh.links) link.origin = {};
  for (auto& domain : mesh.domains) domain.origin = {};
  for (auto& source : mesh.sources) source.origin = {};
  return mesh;
}

}  // namespace

bool same_description(const Mesh& a, const Mesh& b) {
  return without_origins(a) == without_origins(b);
}

}  // namespace mlcca::core::mesh
