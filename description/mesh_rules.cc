// SPDX-License-Identifier: BSD-2-Clause
// The rules for meshes: uniqueness, membership and limits.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "description/names.hpp"
#include "description/rules.hpp"

namespace mlcca::description {
namespace {

using core::FindingId;
using core::mesh::DescribedLink;
using core::mesh::Mesh;
using core::mesh::Node;
using core::mesh::Source;

/// Calls `say(first, again)` for things with equal keys, after sorting them by key.
template <class Thing, class Key, class Say>
void for_each_equal(const std::vector<Thing>& things, const Key& key, const Say& say) {
  std::vector<const Thing*> sorted;
  sorted.reserve(things.size());
  for (const auto& thing : things) sorted.push_back(&thing);
  const auto key_of = [&](const Thing* thing) { return key(*thing); };
  std::ranges::stable_sort(sorted, {}, key_of);
  for (std::size_t first = 0, i = 1; i < sorted.size(); ++i) {
    if (key_of(sorted[first]) == key_of(sorted[i]))
      say(*sorted[first], *sorted[i]);
    else
      first = i;
  }
}

class MeshRules {
 public:
  MeshRules(const core::System& system, std::size_t network, Problems& problems)
      : system_(system),
        network_(network),
        mesh_(*system.networks[network].mesh),
        problems_(problems) {}

  void check() {
    check_counts();
    check_nodes();
    check_gateways();
    check_links();
    for_each_twice(mesh_.domains, [&](std::size_t first, std::size_t again) {
      say_twice(mesh_.domains[again].origin, "Domain", mesh_.domains[first].origin,
                fmt::format("the name {} is already taken", mesh_.domains[again].name),
                "names are unique");
    });
    check_sources();
  }

 private:
  void say(core::Origin at, std::string_view element, std::string_view text,
           FindingId id = FindingId::rule) {
    problems_.add(at, element, text, id);
  }

  void say_twice(core::Origin at, std::string_view element, core::Origin first,
                 std::string_view what, std::string_view right) {
    say(at, element, fmt::format("{} in {}: {}", what, line_words(system_, at, first), right),
        FindingId::name_twice);
  }

  void check_counts() {
    const auto words = [&](std::string_view what) {
      return fmt::format("{} of mesh {}", what, name());
    };
    check_count(mesh_.nodes, kMaxMeshNodes, "Node", words("nodes"), problems_);
    check_count(mesh_.links, kMaxMeshLinks, "Link", words("links"), problems_);
    check_count(mesh_.domains, kMaxMeshDomains, "Domain", words("domains"), problems_);
    check_count(mesh_.sources, kMaxMeshSources, "Source", words("sources"), problems_);
    std::size_t members = 0;
    for (const auto& domain : mesh_.domains) members += domain.links.size();
    if (members > kMaxMeshLinks)
      say(mesh_.origin, "Mesh",
          fmt::format("{} members of its domains are too many: at most {}", members, kMaxMeshLinks),
          FindingId::too_many);
  }

  void check_nodes() {
    for_each_twice(mesh_.nodes, [&](std::size_t first, std::size_t again) {
      say_twice(mesh_.nodes[again].origin, "Node", mesh_.nodes[first].origin,
                fmt::format("the name {} is already taken", mesh_.nodes[again].name),
                "names are unique");
    });
    for_each_equal(
        mesh_.nodes, [](const Node& n) -> const std::string& { return n.address; },
        [&](const Node& first, const Node& again) {
          if (again.address.empty()) return;  // no address, or reported already
          say_twice(again.origin, "Node", first.origin,
                    fmt::format("address {} is already {}'s", again.address, first.name),
                    "addresses are unique");
        });
  }

  void check_gateways() {
    std::vector<const Node*> node_of(system_.gateways.size(), nullptr);
    for (const auto& node : mesh_.nodes) {
      if (!node.gateway) continue;
      const auto& gateway = system_.gateways[*node.gateway];
      if (gateway.port_on(network_) == nullptr)
        say(node.origin, "Node",
            fmt::format("gateway {} has no port on {}: add one to it, or remove it here",
                        gateway.name, name()),
            FindingId::wrong_place);
      const auto*& known = node_of[*node.gateway];
      if (known != nullptr)
        say_twice(node.origin, "Node", known->origin,
                  fmt::format("gateway {} is already node {},", gateway.name, known->name),
                  "it is one node of a mesh");
      else
        known = &node;
    }
    if (mesh_.nodes.empty()) return;
    for (std::size_t g = 0; g < node_of.size(); ++g) {
      const auto* port = system_.gateways[g].port_on(network_);
      if (port == nullptr || node_of[g] != nullptr) continue;
      say(port->origin, "Port",
          fmt::format("gateway {} is none of the nodes of mesh {}: add gateway=\"{}\" to one, {}",
                      system_.gateways[g].name, name(), system_.gateways[g].name,
                      line_words(system_, port->origin, mesh_.origin)));
    }
  }

  void check_links() {
    for_each_equal(
        mesh_.links, [](const DescribedLink& l) { return std::pair(l.from, l.to); },
        [&](const DescribedLink& first, const DescribedLink& again) {
          say_twice(again.origin, "Link", first.origin,
                    fmt::format("the link from {} to {} is already described",
                                mesh_.nodes[again.from].name, mesh_.nodes[again.to].name),
                    "each direction once (both-ways is true unless stated)");
        });
  }

  void check_sources() {
    for_each_equal(
        mesh_.sources, [](const Source& s) { return std::tie(s.kind, s.interface, s.endpoint); },
        [&](const Source& first, const Source& again) {
          say_twice(again.origin, "Source", first.origin, "the same source is already stated",
                    "state it once");
        });
    const auto is_description = [](const Source& s) {
      return s.kind == core::mesh::SourceKind::description;
    };
    const bool described = std::ranges::any_of(mesh_.sources, is_description);
    if (!mesh_.links.empty() && !described)
      say(mesh_.links.front().origin, "Link",
          "links are described, but no source uses them: add <Source kind=\"description\"/> or "
          "remove them");
    const auto found = std::ranges::find_if(mesh_.sources, is_description);
    if (mesh_.links.empty() && described)
      say(found->origin, "Source", "kind description needs links, and none is described");
  }

  [[nodiscard]] const std::string& name() const { return system_.networks[network_].name; }

  const core::System& system_;
  std::size_t network_;
  const Mesh& mesh_;
  Problems& problems_;
};

}  // namespace

void check_meshes(const core::System& system, Problems& problems) {
  for (std::size_t i = 0; i < system.networks.size(); ++i)
    if (system.networks[i].mesh) MeshRules(system, i, problems).check();
}

}  // namespace mlcca::description
