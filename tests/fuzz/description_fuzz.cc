// SPDX-License-Identifier: BSD-2-Clause
// Any octets as a description: read, or refused with problems that can be printed; never a crash,
// and nothing but a problem without a System.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "description/read.hpp"

namespace {

void check(bool holds) {
  if (!holds) std::abort();
}

template <class End>
void check_end(const mlcca::core::System& system, const End& end) {
  check(end.channel < system.channels.size());
  if (!end.mesh_node) return;
  check(end.place.kind == mlcca::core::Place::Kind::network);
  const auto& mesh = system.networks[end.place.index].mesh;
  check(mesh && *end.mesh_node < mesh->nodes.size());
}

void check_mesh(const mlcca::core::System& system, const mlcca::core::mesh::Mesh& mesh) {
  for (const auto& node : mesh.nodes)
    check(!node.address.empty() && (!node.gateway || *node.gateway < system.gateways.size()));
  const auto check_pair = [&](std::uint32_t from, std::uint32_t to) {
    check(from != to && from < mesh.nodes.size() && to < mesh.nodes.size());
  };
  for (const auto& link : mesh.links) check_pair(link.from, link.to);
  for (const auto& domain : mesh.domains)
    for (const auto& [from, to] : domain.links) check_pair(from, to);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view xml(reinterpret_cast<const char*>(data), size);
  const auto result = mlcca::description::read_memory(xml, "fuzz.xml");
  if (result) {
    for (const auto& p : result->publishers) check_end(*result, p);
    for (const auto& s : result->subscribers) check_end(*result, s);
    for (const auto& n : result->networks)
      if (n.mesh) check_mesh(*result, *n.mesh);
    return 0;
  }
  check(!result.error().empty());
  for (const auto& problem : result.error())
    for (const char c : to_string(problem))
      check(static_cast<unsigned char>(c) >= 0x20 && c != 0x7f);
  return 0;
}
