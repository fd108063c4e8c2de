// SPDX-License-Identifier: BSD-2-Clause
#include "core/mesh/graph.hpp"

namespace mlcca::core::mesh {

Graph described_graph(const Mesh& mesh) {
  Graph graph;
  graph.nodes = mesh.nodes.size();
  for (const DescribedLink& described : mesh.links) {
    Link link;
    link.from = described.from;
    link.to = described.to;
    link.quality = {described.rate, described.kind, described.loss, true};
    link.channel = described.channel;
    graph.links.push_back(link);
  }
  const auto ends = [](const Link& link) { return std::pair(link.from, link.to); };
  std::ranges::stable_sort(graph.links, {}, ends);
  const auto doubled = std::ranges::unique(graph.links, {}, ends);
  graph.links.erase(doubled.begin(), doubled.end());
  std::erase_if(graph.links, [](const Link& l) { return l.quality.rate == 0 || l.from == l.to; });
  return graph;
}

}  // namespace mlcca::core::mesh
