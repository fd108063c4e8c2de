// SPDX-License-Identifier: BSD-2-Clause
// Any octets as a description: read, or refused with problems that can be printed; never a crash,
// and nothing but a problem without a System. What is read means the same in both forms of its
// attributes (mlccactl format), and a text in a form is left as it is.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "description/read.hpp"
#include "tools/design/format/rewrite.hpp"

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

template <class WithSets>
void check_same(const std::vector<WithSets>& a, const std::vector<WithSets>& b) {
  check(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    check(a[i].attributes == b[i].attributes && a[i].user == b[i].user);
    check(a[i].lower.size() == b[i].lower.size());
    for (std::size_t set = 0; set < a[i].lower.size(); ++set)
      check(a[i].lower[set].attributes == b[i].lower[set].attributes &&
            a[i].lower[set].priority == b[i].lower[set].priority);
  }
}

void check_same(const mlcca::core::System& a, const mlcca::core::System& b) {
  check_same(a.channels, b.channels);
  check_same(a.publishers, b.publishers);
  check_same(a.subscribers, b.subscribers);
  check(a.networks.size() == b.networks.size() && a.gateways.size() == b.gateways.size());
  for (std::size_t i = 0; i < a.networks.size(); ++i) {
    check(a.networks[i].provision == b.networks[i].provision);
    check(a.networks[i].user == b.networks[i].user);
    if (a.networks[i].mesh) check(a.networks[i].mesh->per_hop == b.networks[i].mesh->per_hop);
  }
  for (std::size_t i = 0; i < a.gateways.size(); ++i)
    check(a.gateways[i].provision == b.gateways[i].provision);
}

void check_forms(const mlcca::core::System& system, std::string_view xml) {
  using mlcca::tools::design::Form;
  std::string text(xml);
  // From the paper's to the short form, and back.
  for (const Form form : {Form::paper, Form::brief, Form::paper}) {
    text = mlcca::tools::design::rewritten(text, form).text;
    check(mlcca::tools::design::rewritten(text, form).text == text);
    const auto again = mlcca::description::read_memory(text, "fuzz.xml");
    check(again.has_value());
    check_same(system, *again);
  }
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
    check_forms(*result, xml);
    return 0;
  }
  check(!result.error().empty());
  for (const auto& problem : result.error())
    for (const char c : to_string(problem))
      check(static_cast<unsigned char>(c) >= 0x20 && c != 0x7f);
  return 0;
}
