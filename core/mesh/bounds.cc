// SPDX-License-Identifier: BSD-2-Clause
#include "core/mesh/bounds.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/text.hpp"

namespace mlcca::core::mesh {
namespace {

constexpr Value kAll = 1'000'000'000;  // of the packets, 1e-9

bool is_right(const Sample& s) { return is_address(s.from) && is_address(s.to); }
bool is_right(const NextHop& h) {
  return is_address(h.from) && is_address(h.to) && is_address(h.via);
}

/// 0: between described nodes, … 2: between nodes that are not described.
int undescribed_ends(const Sample& s, const DescribedNodes& described) {
  return int{!described.contains(s.from)} + int{!described.contains(s.to)};
}
int undescribed_ends(const NextHop& h, const DescribedNodes& described) {
  return int{!described.contains(h.from)} + int{!described.contains(h.to)};
}

/// False if facts were removed.
template <class Fact>
bool keep_within_bounds(std::vector<Fact>& facts, const DescribedNodes& described) {
  if (facts.size() <= kMaxFacts) return true;
  std::ranges::stable_sort(facts, {},
                           [&](const Fact& f) { return undescribed_ends(f, described); });
  facts.resize(kMaxFacts);
  return false;
}

/// Corrects numbers out of range; false if there were any.
bool correct(Sample& s, std::uint64_t now) {
  bool right = true;
  const auto limit = [&right](auto& field, auto most, auto otherwise) {
    if (!field || *field <= most) return;
    field = otherwise;
    right = false;
  };
  if (s.rate > kMaxRate) {
    s.rate = 0;
    right = false;
  }
  limit(s.loss, kAll, kAll);
  limit(s.busy, kWhole, kWhole);
  limit(s.weight, kMaxWeight, kMaxWeight);
  if (s.valid) s.valid = std::min(*s.valid, kMaxValidity);
  s.taken = std::min(s.taken, now);
  return right;
}

void add_problem(std::string& problem, std::string_view text) {
  if (!problem.empty()) problem += "; ";
  problem += text;
}

}  // namespace

DescribedNodes described_nodes(const Mesh& mesh) {
  DescribedNodes out;
  for (const auto& node : mesh.nodes) out.insert(node.address.empty() ? node.name : node.address);
  return out;
}

bool is_address(std::string_view text) {
  return !text.empty() && text.size() <= kMaxAddress &&
         std::ranges::all_of(text, [](char c) { return c > 0x20 && c < 0x7f; });
}

std::string bounded_text(std::string_view text) { return printable(text, kMaxProblem); }

Snapshot bounded(Snapshot snapshot, const DescribedNodes& described, std::uint64_t now) {
  snapshot.problem = bounded_text(snapshot.problem);
  const auto wrong = [](const auto& fact) { return !is_right(fact); };
  const auto unnamed =
      std::erase_if(snapshot.links, wrong) + std::erase_if(snapshot.next_hops, wrong);
  if (unnamed != 0) add_problem(snapshot.problem, "some of its links have no address: ignored");
  const bool links = keep_within_bounds(snapshot.links, described);
  const bool hops = keep_within_bounds(snapshot.next_hops, described);
  if (!links || !hops)
    add_problem(snapshot.problem, "it knows more than " + std::to_string(kMaxFacts) +
                                      (links ? " next hops" : " links") +
                                      ": those of nodes that are not described are ignored first");
  bool in_range = true;
  for (Sample& sample : snapshot.links) in_range &= correct(sample, now);
  if (!in_range) add_problem(snapshot.problem, "some of its numbers are out of range");
  return snapshot;
}

}  // namespace mlcca::core::mesh
