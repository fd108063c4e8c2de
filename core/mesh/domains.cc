// SPDX-License-Identifier: BSD-2-Clause
#include "core/mesh/domains.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <utility>

namespace mlcca::core::mesh {
namespace {

constexpr std::size_t kBits = 64;

/// A set of links as bits; neighbourhoods are unions of such sets.
using LinkSet = std::vector<std::uint64_t>;

void add(LinkSet& set, std::size_t link) {
  set[link / kBits] |= std::uint64_t{1} << (link % kBits);
}

void unite(LinkSet& set, const LinkSet& other) {
  for (std::size_t i = 0; i < set.size(); ++i) set[i] |= other[i];
}

void intersect(LinkSet& set, const LinkSet& other) {
  for (std::size_t i = 0; i < set.size(); ++i) set[i] &= other[i];
}

/// Calls `each` for every link of the set, rising.
void for_each_link(const LinkSet& set, const std::function<void(std::uint32_t)>& each) {
  for (std::size_t i = 0; i < set.size(); ++i)
    for (std::uint64_t bits = set[i]; bits != 0; bits &= bits - 1)
      each(static_cast<std::uint32_t>(i * kBits) +
           static_cast<std::uint32_t>(std::countr_zero(bits)));
}

/// For each node the links with an end at most `hops` links away, in either direction. Links that
/// carry nothing are followed too, because their ends receive each other's signals.
std::vector<LinkSet> links_near(const Graph& graph, std::uint32_t hops) {
  std::vector<LinkSet> near(graph.nodes, LinkSet((graph.links.size() + kBits - 1) / kBits));
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ways;
  for (std::size_t i = 0; i < graph.links.size(); ++i) {
    const Link& link = graph.links[i];
    add(near[link.from], i);
    add(near[link.to], i);
    ways.emplace_back(std::minmax(link.from, link.to));
  }
  for (const UnusableLink& link : graph.unusable)
    ways.emplace_back(std::minmax(link.from, link.to));
  std::ranges::sort(ways);
  const auto doubled = std::ranges::unique(ways);
  ways.erase(doubled.begin(), doubled.end());
  for (std::uint32_t hop = 0; hop < hops; ++hop) {
    std::vector<LinkSet> wider = near;
    for (const auto& [a, b] : ways) {
      unite(wider[a], near[b]);
      unite(wider[b], near[a]);
    }
    if (wider == near) break;
    near = std::move(wider);
  }
  return near;
}

/// For each channel the links that share its medium.
std::map<std::uint32_t, LinkSet> links_by_channel(const Graph& graph) {
  const LinkSet none((graph.links.size() + kBits - 1) / kBits);
  std::map<std::uint32_t, LinkSet> result;
  for (std::size_t i = 0; i < graph.links.size(); ++i)
    add(result.try_emplace(graph.links[i].channel, none).first->second, i);
  const auto any = result.find(kAnyChannel);
  if (any == result.end()) return result;
  const LinkSet everywhere = any->second;
  for (auto& [channel, links] : result) {
    unite(links, everywhere);
    if (channel != kAnyChannel) unite(any->second, links);
  }
  return result;
}

}  // namespace

class Domains::Builder {
 public:
  Builder(const Graph& graph, const Mesh& mesh) : graph_(graph), mesh_(mesh) {}

  void build() {
    switch (mesh_.interference) {
      case Interference::single_domain:
        take({.label = Label::all, .name = {}}, everything());
        break;
      case Interference::channel:
        by_channel();
        break;
      case Interference::explicit_sets:
        described();
        break;
      case Interference::k_hop:
        neighbourhoods();
        break;
    }
  }
  void move_to(Domains& result) {
    result.domains_ = std::move(domains_);
    result.first_.reserve(members_of_.size() + 1);
    for (const auto& members : members_of_) {
      result.first_.push_back(result.membership_.size());
      result.membership_.insert(result.membership_.end(), members.begin(), members.end());
    }
    result.first_.push_back(result.membership_.size());
  }

 private:
  [[nodiscard]] LinkSet nothing() const {
    return LinkSet((graph_.links.size() + kBits - 1) / kBits);
  }
  [[nodiscard]] LinkSet everything() const {
    LinkSet all = nothing();
    for (std::size_t i = 0; i < graph_.links.size(); ++i) add(all, i);
    return all;
  }

  void take(Domain domain, const LinkSet& links) {
    const auto index = static_cast<std::uint32_t>(domains_.size());
    for_each_link(links, [&](std::uint32_t link) {
      members_of_[link].push_back(index);
      domain.busy = std::max(domain.busy, graph_.links[link].busy * (kFullTime / kWhole));
    });
    domains_.push_back(std::move(domain));
  }

  void by_channel() {
    const auto channels = links_by_channel(graph_);
    for (const auto& [channel, links] : channels)
      if (channel != kAnyChannel || channels.size() == 1)
        take({.label = channel == kAnyChannel ? Label::all : Label::channel,
              .channel = channel,
              .name = {}},
             links);
  }

  void described() {
    LinkSet covered = nothing();
    for (const DescribedDomain& domain : mesh_.domains) {
      LinkSet links = nothing();
      const auto enter = [&](std::uint32_t from, std::uint32_t to) {
        const Link* link = graph_.find(from, to);
        if (link != nullptr) add(links, static_cast<std::size_t>(link - graph_.links.data()));
      };
      for (const auto& [a, b] : domain.links) {
        enter(a, b);
        enter(b, a);
      }
      unite(covered, links);
      take({.label = Label::described, .name = domain.name}, links);
    }
    if (const LinkSet all = everything(); covered != all)
      take({.label = Label::all, .name = {}}, all);
  }

  void neighbourhoods() {
    const auto near = links_near(graph_, mesh_.hops);
    const auto channels = links_by_channel(graph_);
    std::map<LinkSet, bool> known;
    for (const Link& link : graph_.links) {
      LinkSet links = near[link.from];
      unite(links, near[link.to]);
      intersect(links, channels.at(link.channel));
      if (known.emplace(links, true).second)
        take({.label = Label::around, .from = link.from, .to = link.to, .name = {}}, links);
    }
  }

  const Graph& graph_;
  const Mesh& mesh_;
  std::vector<Domain> domains_;
  std::vector<std::vector<std::uint32_t>> members_of_{graph_.links.size()};
};

Domains::Domains(const Graph& graph, const Mesh& mesh) {
  Builder builder(graph, mesh);
  builder.build();
  builder.move_to(*this);
}

std::span<const std::uint32_t> Domains::of_link(std::uint32_t link) const {
  return std::span(membership_).subspan(first_[link], first_[link + 1] - first_[link]);
}

std::string Domains::name(std::size_t domain,
                          const std::function<std::string(std::uint32_t)>& node) const {
  const Domain& d = domains_[domain];
  switch (d.label) {
    case Label::all:
      break;
    case Label::channel:
      return "channel " + std::to_string(d.channel);
    case Label::described:
      return d.name;
    case Label::around:
      return "around " + node(d.from) + " > " + node(d.to);
  }
  return "all links";
}

}  // namespace mlcca::core::mesh
