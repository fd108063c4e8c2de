// SPDX-License-Identifier: BSD-2-Clause
#include "core/mesh/route.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <tuple>
#include <utility>

#include "mlcca/arithmetic.hpp"

namespace mlcca::core::mesh {
namespace {

/// Stands for the index of a link that carries nothing.
constexpr std::uint32_t kUnusable = std::numeric_limits<std::uint32_t>::max();

bool every_link_weighed(const Graph& graph) {
  return std::ranges::all_of(graph.links, [](const Link& link) { return link.weight.has_value(); });
}

/// Marks and returns all nodes not reached before to which `next` leads from those in `open`.
std::vector<std::uint32_t> reach_more(const std::vector<std::vector<std::uint32_t>>& next,
                                      std::vector<std::uint32_t> open, std::vector<bool>& reached) {
  std::vector<std::uint32_t> fresh;
  while (!open.empty()) {
    const std::uint32_t node = open.back();
    open.pop_back();
    for (const std::uint32_t to : next[node]) {
      if (reached[to]) continue;
      reached[to] = true;
      fresh.push_back(to);
      open.push_back(to);
    }
  }
  return fresh;
}

}  // namespace

Paths::Paths(const Graph& graph, const Mesh& mesh) : graph_(graph) {
  const bool by_weight = every_link_weighed(graph);
  std::vector<std::pair<std::uint32_t, Edge>> all;
  all.reserve(graph.links.size());
  for (std::uint32_t i = 0; i < graph.links.size(); ++i) {
    const Link& link = graph.links[i];
    const Value cost =
        by_weight ? *link.weight : packet_time(link.quality, mesh, mesh.packet_bytes);
    all.emplace_back(link.from, Edge{link.to, i, cost});
  }
  if (by_weight)
    for (const UnusableLink& link : graph.unusable)
      if (link.weight) all.emplace_back(link.from, Edge{link.to, kUnusable, *link.weight});
  std::ranges::stable_sort(all, {}, [](const auto& edge) { return edge.first; });
  first_edge_.assign(graph.nodes + 1, 0);
  edges_.reserve(all.size());
  for (const auto& [from, edge] : all) {
    edges_.push_back(edge);
    ++first_edge_[from + 1];
  }
  for (std::size_t node = 0; node < graph.nodes; ++node) first_edge_[node + 1] += first_edge_[node];
}

std::span<const Paths::Edge> Paths::edges_of(std::uint32_t node) const {
  return std::span(edges_).subspan(first_edge_[node], first_edge_[node + 1] - first_edge_[node]);
}

const std::vector<Paths::Reached>& Paths::tree_of(std::uint32_t from) {
  const auto [it, fresh] = trees_.try_emplace(from);
  auto& tree = it->second;
  if (!fresh) return tree;
  tree.resize(graph_.nodes);
  using Step = std::tuple<Value, std::uint32_t, std::uint32_t>;  // cost, links, node
  std::priority_queue<Step, std::vector<Step>, std::greater<>> open;
  tree[from] = {0, 0, from, kUnusable};
  open.emplace(0, 0, from);
  while (!open.empty()) {
    const auto [cost, links, node] = open.top();
    open.pop();
    if (std::pair(cost, links) != std::pair(tree[node].cost, tree[node].links)) continue;
    for (const Edge& edge : edges_of(node)) {
      Reached& next = tree[edge.to];
      const Value sum = add_saturating(cost, edge.cost);
      if (std::tuple(sum, links + 1) >= std::tuple(next.cost, next.links)) continue;
      next = {sum, links + 1, node, edge.link};
      open.emplace(sum, links + 1, edge.to);
    }
  }
  return tree;
}

std::vector<std::uint32_t> Paths::find(std::uint32_t from, std::uint32_t to) {
  if (from == to || from >= graph_.nodes || to >= graph_.nodes) return {};
  std::vector<std::uint32_t> result;
  std::uint32_t node = from;
  for (; node != to; node = graph_.links[result.back()].to) {
    const auto hop =
        std::ranges::lower_bound(graph_.next_hops, std::pair(node, to), {},
                                 [](const NextHopIndex& h) { return std::pair(h.from, h.to); });
    if (hop == graph_.next_hops.end() || hop->from != node || hop->to != to) break;
    const Link* link = graph_.find(node, hop->via);
    if (link == nullptr || result.size() == kMaxPath) return {};
    result.push_back(static_cast<std::uint32_t>(link - graph_.links.data()));
  }
  if (node == to) return result;
  const std::size_t decided = result.size();
  const auto& tree = tree_of(node);
  if (tree[to].cost == kUnbounded || decided + tree[to].links > kMaxPath) return {};
  for (std::uint32_t at = to; at != node; at = tree[at].before) {
    if (tree[at].link == kUnusable) return {};
    result.push_back(tree[at].link);
  }
  std::ranges::reverse(std::span(result).subspan(decided));
  return meets_itself(result) ? std::vector<std::uint32_t>{} : result;
}

/// Whether the path visits a node twice. That can happen because the next hops of the protocol need
/// not agree with the computed remainder.
bool Paths::meets_itself(std::span<const std::uint32_t> links) const {
  for (std::size_t i = 0; i < links.size(); ++i)
    for (std::size_t j = i; j < links.size(); ++j)
      if (graph_.links[links[j]].to == graph_.links[links[i]].from) return true;
  return false;
}

const std::vector<std::uint32_t>& Paths::between(std::uint32_t from, std::uint32_t to) {
  const std::uint64_t key = std::uint64_t{from} << 32U | to;
  if (const auto known = paths_.find(key); known != paths_.end()) return known->second;
  return paths_.emplace(key, find(from, to)).first->second;
}

std::vector<std::optional<Lack>> lacking_from(const Graph& graph, std::uint32_t from) {
  std::vector<std::optional<Lack>> lacking(graph.nodes);
  if (from >= graph.nodes) return lacking;
  std::vector<std::vector<std::uint32_t>> next(graph.nodes);
  for (const Link& link : graph.links) next[link.from].push_back(link.to);
  std::vector<bool> reached(graph.nodes, false);
  reach_more(next, {from}, reached);
  for (const Lack lack : {Lack::rate, Lack::time, Lack::absent}) {
    for (const UnusableLink& link : graph.unusable)
      if (link.lack == lack) next[link.from].push_back(link.to);
    std::vector<std::uint32_t> open{from};
    for (std::uint32_t n = 0; n < graph.nodes; ++n)
      if (reached[n]) open.push_back(n);
    const std::vector<std::uint32_t> fresh = reach_more(next, open, reached);
    for (const std::uint32_t node : fresh) lacking[node] = lack;
  }
  return lacking;
}

std::vector<std::uint32_t> path(const Graph& graph, const Mesh& mesh, std::uint32_t from,
                                std::uint32_t to) {
  return Paths(graph, mesh).between(from, to);
}

}  // namespace mlcca::core::mesh
