// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/crossings.hpp"

#include <algorithm>
#include <tuple>

namespace mlcca::learn {
namespace {

constexpr std::uint64_t kSpan = 4'000'000'000;  // ns of a span of time, which is kept completely or
                                                // not at all
constexpr std::size_t kLooked = 64;             // records of one content that are compared
constexpr std::size_t kMostPairs = 65'536;
constexpr std::uint64_t kFewest = 3;  // events, and different contents
constexpr double kCopies = 0.9;       // smallest share of the copy's events that must agree
constexpr double kOriginals = 0.8;    // smallest share of the origin's events; others were lost
// From one bus to another, where many contents are alike:
constexpr std::uint64_t kFewestContents = 8;
constexpr std::uint64_t kManyContents = 32;  // different contents that are sufficient evidence
constexpr double kRenumberedCopies = 0.95;
constexpr double kRenumberedOriginals = 0.9;

bool is_share(std::uint64_t part, std::uint64_t all, double share) {
  return static_cast<double>(part) >= share * static_cast<double>(all);
}

bool is_renumbered(const Crossings::Of& from, const Crossings::Of& to) {
  return !from.ethernet && !to.ethernet;
}

/// Whether equal contents of these two flows mean anything.
bool is_comparable(const Crossings::Of& from, const Crossings::Of& to) {
  if (from.interface == to.interface) return false;
  if (is_renumbered(from, to)) return from.changes && to.changes;
  return !from.ethernet || !to.ethernet || from.number == to.number;
}

/// Whether `from` is a direct or indirect copy of `to`.
bool leads_to(std::span<const Crossings::Of> flows, std::uint32_t from, std::uint32_t to) {
  constexpr int most_interfaces = 64;
  std::optional<std::uint32_t> at = from;
  for (int i = 0; at && i < most_interfaces; ++i) {
    if (*at == to) return true;
    at = flows[*at].origin;
  }
  return at.has_value();
}

}  // namespace

void Crossing::add(std::uint64_t ns) {
  ++events;
  longest_ns = std::max(longest_ns, ns);
  shortest_ns = std::min(shortest_ns, ns);
}

unsigned Crossings::Found::percent() const {
  constexpr std::uint64_t most = 99;
  const std::uint64_t least_of = std::max({of, of_origin, std::uint64_t{1}});
  return static_cast<unsigned>(std::min(crossing.events * 100 / least_of, most));
}

// --- what is kept --------------------------------------------------------------------------------

bool Crossings::is_kept(std::uint64_t span) const {
  return ((span * 0x9e3779b97f4a7c15U) >> 32U & mask_) == 0;
}

/// Whether both the possible origins and the possible copies of an event at this time are kept.
bool Crossings::is_inner(std::uint64_t ns) const {
  const std::uint64_t span = ns / kSpan;
  const std::uint64_t within = ns % kSpan;
  return (within >= kWindow || is_kept(span - 1)) &&
         (within < kSpan - kWindow || is_kept(span + 1));
}

void Crossings::add(std::uint32_t flow, std::uint32_t interface, std::uint64_t ns,
                    std::uint64_t content) {
  constexpr std::uint64_t fewest = (std::uint64_t{1} << 24U) - 1;  // no more than one in so many
  if (observed_.size() <= interface) observed_.resize(interface + 1);
  observed_[interface].first = std::min(observed_[interface].first, ns);
  observed_[interface].last = std::max(observed_[interface].last, ns);
  if (!is_kept(ns / kSpan)) return;
  while (records_.size() >= most_ && mask_ < fewest) {
    mask_ = mask_ * 2 + 1;
    std::erase_if(records_, [this](const Record& one) { return !is_kept(one.ns / kSpan); });
  }
  if (records_.size() < most_ && is_kept(ns / kSpan)) records_.push_back({content, ns, flow});
}

// --- comparing -----------------------------------------------------------------------------------

void Crossings::compare(std::span<const Of> flows) {
  std::ranges::sort(records_);
  for (std::size_t first = 0, at = 0; at < records_.size(); ++at) {
    if (records_[at].content != records_[first].content) first = at;
    compare(flows, at, first);
  }
}

/// Compares an event with earlier ones of the same content, the latest first.
void Crossings::compare(std::span<const Of> flows, std::size_t copy, std::size_t first) {
  const Record& record = records_[copy];
  const Of& to = flows[record.flow];
  if (to.origin) return;
  for (std::size_t i = copy; i > first && copy - i < kLooked; --i) {
    const Record& before = records_[i - 1];
    if (record.ns - before.ns > kWindow) return;
    const Of& from = flows[before.flow];
    if (!is_comparable(from, to)) continue;
    if (pairs_.size() >= kMostPairs && !pairs_.contains({record.flow, before.flow})) continue;
    Pair& pair = pairs_[{record.flow, before.flow}];
    // An event has at most one copy in a flow, and a copy has one origin.
    if (i <= pair.used_origin || copy < pair.used_copy) continue;
    pair.used_origin = i;
    pair.used_copy = copy + 1;
    pair.crossing.add(record.ns - before.ns);
    pair.sum_ns += record.ns - before.ns;
    if (pair.contents == 0 || pair.content != record.content) ++pair.contents;
    pair.content = record.content;
  }
}

void Crossings::count_comparable(std::span<const Of> flows) {
  comparable_.assign(flows.size() * observed_.size(), 0);
  for (const Record& record : records_) {
    if (!is_inner(record.ns)) continue;
    for (std::size_t i = 0; i < observed_.size(); ++i)
      if (record.ns + kWindow >= observed_[i].first && record.ns <= observed_[i].last + kWindow)
        ++comparable_[record.flow * observed_.size() + i];
  }
}

/// The number of events of the flow at times when the interface was observed, too.
std::uint64_t Crossings::comparable(std::uint32_t flow, std::uint32_t interface) const {
  return comparable_[flow * observed_.size() + interface];
}

// --- deciding ------------------------------------------------------------------------------------

/// A pair of flows that may be copy and origin.
struct Crossings::Candidate {
  Found found;
  std::uint64_t mean_ns = 0;
  std::uint64_t of_origin = 0;  ///< events of the flow that most are from
};

/// Between buses the contents must be many and not those of a counter: nodes that were switched on
/// together count alike.
bool Crossings::is_sure(const Found& found, const Of& copy) {
  if (copy.local) return true;
  return found.renumbered ? copy.rich && found.contents >= kManyContents
                          : found.contents >= kFewest;
}

std::vector<Crossings::Candidate> Crossings::candidates(std::span<const Of> flows) const {
  struct All {
    Candidate candidate;
    std::uint64_t sum_ns = 0;
  };
  std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint64_t>, All> all;
  for (const auto& [flows_of, pair] : pairs_) {
    const auto [copy, origin] = flows_of;
    const Of& from = flows[origin];
    const std::uint64_t events = pair.crossing.events;
    const bool renumbered = is_renumbered(from, flows[copy]);
    const std::uint64_t of_origin = comparable(origin, flows[copy].interface);
    if (events < kFewest ||
        !is_share(events, of_origin, renumbered ? kRenumberedOriginals : kOriginals))
      continue;
    All& one = all[{copy, from.interface, from.number}];
    Found& found = one.candidate.found;
    found.copy = copy;
    found.renumbered = renumbered;
    found.of_origin += of_origin;
    found.contents += pair.contents;
    if (events > one.candidate.of_origin) {
      one.candidate.of_origin = events;
      found.origin = origin;
    }
    found.crossing.events += events;
    found.crossing.longest_ns = std::max(found.crossing.longest_ns, pair.crossing.longest_ns);
    found.crossing.shortest_ns = std::min(found.crossing.shortest_ns, pair.crossing.shortest_ns);
    one.sum_ns += pair.sum_ns;
  }
  std::vector<Candidate> out;
  for (auto& [key, one] : all) {
    Found& found = one.candidate.found;
    found.of = comparable(found.copy, std::get<1>(key));
    if (found.of < kFewest ||
        !is_share(found.crossing.events, found.of, found.renumbered ? kRenumberedCopies : kCopies))
      continue;
    if (found.renumbered && found.contents < kFewestContents) continue;
    found.sure = is_sure(found, flows[found.copy]);
    one.candidate.mean_ns = one.sum_ns / found.crossing.events;
    out.push_back(one.candidate);
  }
  return out;
}

std::vector<Crossings::Found> Crossings::find(std::vector<Of> flows) {
  compare(flows);
  count_comparable(flows);
  auto all = candidates(flows);
  // The pair with the shortest delay is the most likely.
  std::ranges::stable_sort(all, {}, [](const Candidate& one) {
    return std::tuple(!one.found.sure, one.mean_ns, one.found.copy, one.found.origin);
  });
  std::vector<Found> out;
  for (const Candidate& one : all) {
    const Found& found = one.found;
    if (flows[found.copy].origin || leads_to(flows, found.origin, found.copy)) continue;
    flows[found.copy].origin = found.origin;
    out.push_back(found);
  }
  return out;
}

}  // namespace mlcca::learn
