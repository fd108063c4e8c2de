// SPDX-License-Identifier: BSD-2-Clause
#include "core/mesh/link_table.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "core/mesh/roles.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core::mesh {
namespace {

const std::string& address_of(const Node& node) {
  return node.address.empty() ? node.name : node.address;
}

int rank(RateKind kind) {
  switch (kind) {
    case RateKind::effective:
      return 2;
    case RateKind::derived:
      return 1;
    case RateKind::phy:
      break;
  }
  return 0;
}

std::string ignored() {
  return "links or next hops are ignored: there are more than " + std::to_string(kMaxNodes) +
         " nodes or " + std::to_string(kMaxLinks) + " links";
}

}  // namespace

LinkTable::LinkTable(const Mesh& mesh, std::optional<std::uint32_t> here)
    : mesh_(mesh), here_(here), sources_(mesh.sources.size()) {
  for (const Node& node : mesh.nodes) {
    nodes_.emplace(address_of(node), static_cast<std::uint32_t>(addresses_.size()));
    addresses_.push_back(address_of(node));
  }
  graph_.nodes = addresses_.size();
}

bool LinkTable::is_description(std::size_t source) const {
  return source < mesh_.sources.size() && mesh::is_description(mesh_.sources[source]);
}

std::uint64_t LinkTable::fresh_until(const Report& report) const {
  if (is_description(report.source)) return kUnbounded;
  const Value age = std::min(mesh_.stale_after, report.sample.valid.value_or(kUnbounded));
  return add_saturating(report.sample.taken, age);
}

std::uint64_t LinkTable::routes_fresh_until(std::size_t source) const {
  return is_description(source) ? kUnbounded
                                : add_saturating(sources_[source].reported, mesh_.stale_after);
}

std::optional<std::uint32_t> LinkTable::node(const std::string& address) const {
  const auto it = nodes_.find(address);
  return it == nodes_.end() ? std::nullopt : std::optional(it->second);
}

std::optional<std::uint32_t> LinkTable::node_for(const std::string& address) {
  if (const auto known = node(address)) return known;
  if (addresses_.size() >= kMaxNodes) return std::nullopt;
  const auto index = static_cast<std::uint32_t>(addresses_.size());
  nodes_.emplace(address, index);
  addresses_.push_back(address);
  return index;
}

/// Removes nodes that no report mentions any more. Described nodes stay.
void LinkTable::forget_unused_nodes() {
  std::vector<bool> used(addresses_.size(), false);
  for (std::uint32_t n = 0; n < used.size() && is_described(n); ++n) used[n] = true;
  for (const auto& [ends, entry] : entries_) used[ends.first] = used[ends.second] = true;
  for (const SourceState& source : sources_)
    for (const NextHopIndex& hop : source.next_hops)
      used[hop.from] = used[hop.to] = used[hop.via] = true;
  std::vector<std::uint32_t> moved(addresses_.size());
  std::vector<std::string> kept;
  for (std::size_t n = 0; n < addresses_.size(); ++n) {
    moved[n] = static_cast<std::uint32_t>(kept.size());
    if (used[n]) kept.push_back(std::move(addresses_[n]));
  }
  addresses_ = std::move(kept);
  nodes_.clear();
  for (std::uint32_t n = 0; n < addresses_.size(); ++n) nodes_.emplace(addresses_[n], n);
  std::map<Ends, Entry> entries;
  for (auto& [ends, entry] : entries_)
    entries.emplace(Ends(moved[ends.first], moved[ends.second]), std::move(entry));
  entries_ = std::move(entries);
  for (SourceState& source : sources_)
    for (NextHopIndex& hop : source.next_hops)
      hop = {moved[hop.from], moved[hop.to], moved[hop.via]};
}

/// Makes room for links between described nodes.
void LinkTable::forget_links_of_undescribed_nodes() {
  std::erase_if(entries_, [&](const auto& known) {
    return !is_described(known.first.first) || !is_described(known.first.second);
  });
}

/// Enters a sample; returns false if there is no room for it.
bool LinkTable::enter(std::size_t source, const Sample& sample) {
  const auto from = node_for(sample.from);
  const auto to = node_for(sample.to);
  if (!from || !to) return false;
  if (from == to) return true;
  const Ends ends(*from, *to);
  auto it = entries_.find(ends);
  if (it == entries_.end()) {
    if (entries_.size() >= kMaxLinks && is_described(*from) && is_described(*to))
      forget_links_of_undescribed_nodes();
    if (entries_.size() >= kMaxLinks) return false;
    it = entries_.emplace(ends, Entry{}).first;
  }
  auto& reports = it->second.reports;
  auto report = std::ranges::find(reports, source, &Report::source);
  if (report == reports.end())
    report = reports.insert(reports.end(), Report{.source = source, .sample = {}});
  const std::uint64_t round = sources_[source].rounds;
  // Of two reports for one direction the slower one counts.
  if (report->round == round && report->sample.rate <= sample.rate) return true;
  report->round = round;
  report->withdrawn = false;
  report->sample = sample;
  report->sample.taken = std::min(sample.taken, now_);
  return true;
}

bool LinkTable::enter_next_hop(SourceState& state, const NextHop& hop) {
  const auto from = node_for(hop.from);
  const auto to = node_for(hop.to);
  const auto via = node_for(hop.via);
  if (!from || !to || !via) return false;
  state.next_hops.push_back({*from, *to, *via});
  return true;
}

/// Withdraws what a source did not report again. While the source has a problem, the loss and busy
/// time it reported last still count: otherwise an attacker could make a link seem better by
/// stopping the source that knows its losses.
void LinkTable::drop_old_rounds(std::size_t source) {
  const SourceState& state = sources_[source];
  const auto is_old = [&](const Report& report) {
    return report.source == source && report.round != state.rounds;
  };
  for (auto& [ends, entry] : entries_) {
    if (!state.problem.empty())
      for (Report& report : entry.reports) {
        const bool warns = report.sample.loss || report.sample.busy;
        if (!is_old(report) || !warns) continue;
        report.round = state.rounds;
        report.withdrawn = true;
        report.sample.rate = 0;
        report.sample.weight.reset();
        report.sample.valid = 0;
      }
    std::erase_if(entry.reports, is_old);
  }
}

bool LinkTable::take(std::size_t source, const Snapshot& snapshot, std::uint64_t now) {
  now_ = std::max(now_, now);
  if (source >= sources_.size()) sources_.resize(source + 1);
  SourceState& state = sources_[source];
  ++state.rounds;
  state.reported = now_;
  state.problem = snapshot.problem;
  state.next_hops.clear();
  const std::size_t named = 2 * snapshot.links.size() + 3 * snapshot.next_hops.size();
  if (addresses_.size() + named > kMaxNodes) forget_unused_nodes();
  bool room = true;
  for (const Sample& sample : snapshot.links) room &= enter(source, sample);
  for (const NextHop& hop : snapshot.next_hops) room &= enter_next_hop(state, hop);
  drop_old_rounds(source);
  if (!room) state.problem += (state.problem.empty() ? "" : "; ") + ignored();
  return update_beliefs();
}

bool LinkTable::expire(std::uint64_t now) {
  now_ = std::max(now_, now);
  return now_ >= deadline_ && update_beliefs();
}

const std::string& LinkTable::problem(std::size_t source) const {
  static const std::string none;
  return source < sources_.size() ? sources_[source].problem : none;
}

std::vector<Known> LinkTable::links() const {
  std::vector<Known> result;
  for (const auto& [ends, entry] : entries_) {
    const bool usable = entry.belief.usable(now_);
    for (const Report& report : entry.reports)
      result.push_back({.sample = report.sample,
                        .believed_rate = usable ? entry.belief.link().quality.rate : 0,
                        .lack = lack_of(ends, entry),
                        .stale = !is_fresh(report),
                        .source = report.source});
  }
  return result;
}

std::size_t LinkTable::size() const {
  std::size_t reports = 0;
  for (const auto& [ends, entry] : entries_) reports += entry.reports.size();
  return reports;
}

/// Whether the rate of report a takes precedence over that of b.
bool LinkTable::is_preferred(const Report& a, const Report& b) const {
  const auto key = [&](const Report& r) {
    return std::tuple(!is_description(r.source), rank(r.sample.kind), r.sample.taken);
  };
  return key(a) > key(b);
}

/// Whether the sources that would know do not report the link as present.
bool LinkTable::is_absent(const Ends& ends, const Entry& entry) const {
  Presence asked = Presence::stated;
  bool there = true;
  for (std::size_t source = 0; source < mesh_.sources.size(); ++source) {
    const SourceKind kind = mesh_.sources[source].kind;
    const Presence presence = role_of(kind).presence;
    if (presence < asked || !would_know(kind, ends.first, ends.second, here_)) continue;
    const auto said = std::ranges::find(entry.reports, source, &Report::source);
    const bool says = said != entry.reports.end() && is_there(*said);
    there = presence == asked ? there || says : says;
    asked = presence;
  }
  return !there;
}

/// Why a link that does not count carries nothing.
Lack LinkTable::lack_of(const Ends& ends, const Entry& entry) const {
  if (entry.belief.known()) return Lack::time;
  if (is_absent(ends, entry)) return Lack::absent;
  const auto there = [&](const Report& report) { return is_there(report); };
  return std::ranges::any_of(entry.reports, there) ? Lack::rate : Lack::gone;
}

/// Combines all reports about one direction of a link, as the class comment states. Nullopt if the
/// link is not present or its rate is unknown.
std::optional<Observation> LinkTable::observe(const Ends& ends, const Entry& entry) const {
  if (is_absent(ends, entry)) return std::nullopt;
  const Report* rated = nullptr;
  Observation seen;
  for (const Report& report : entry.reports) {
    const Sample& sample = report.sample;
    const bool fresh = is_fresh(report);
    if (fresh && sample.rate != 0 && (rated == nullptr || is_preferred(report, *rated)))
      rated = &report;
    if (sample.loss) seen.quality.loss_known = true;
    seen.quality.loss =
        std::max(seen.quality.loss, std::min(sample.loss.value_or(0), kCertainLoss));
    seen.busy = std::max<Value>(seen.busy, std::min(sample.busy.value_or(0), kWhole));
    if (fresh && seen.channel == kAnyChannel) seen.channel = sample.channel.value_or(kAnyChannel);
  }
  if (rated == nullptr) return std::nullopt;
  seen.quality.rate = rated->sample.rate;
  seen.quality.kind = rated->sample.kind;
  seen.channel = rated->sample.channel.value_or(seen.channel);
  return seen;
}

/// The source from which all weights are taken; nullopt if none reports any.
std::optional<std::size_t> LinkTable::weighing_source() const {
  std::optional<std::size_t> first;
  for (const auto& [ends, entry] : entries_)
    for (const Report& report : entry.reports)
      if (report.sample.weight && is_fresh(report) && (!first || report.source < *first))
        first = report.source;
  return first;
}

/// The fresh next hops of all sources; for one (from, to) that of the first source.
std::vector<NextHopIndex> LinkTable::next_hops() const {
  std::vector<NextHopIndex> result;
  for (std::size_t source = 0; source < sources_.size(); ++source)
    if (now_ <= routes_fresh_until(source))
      std::ranges::copy(sources_[source].next_hops, std::back_inserter(result));
  const auto ends = [](const NextHopIndex& hop) { return Ends(hop.from, hop.to); };
  std::ranges::stable_sort(result, {}, ends);
  const auto others = std::ranges::unique(result, {}, ends);
  result.erase(others.begin(), others.end());
  return result;
}

Graph LinkTable::believed() const {
  Graph graph;
  graph.nodes = addresses_.size();
  const auto weighing = weighing_source();
  for (const auto& [ends, entry] : entries_) {
    std::optional<std::uint64_t> weight;
    for (const Report& report : entry.reports)
      if (report.source == weighing && is_fresh(report)) weight = report.sample.weight;
    if (!entry.belief.usable(now_)) {
      graph.unusable.push_back({ends.first, ends.second, weight, lack_of(ends, entry)});
      continue;
    }
    Link& link = graph.links.emplace_back(entry.belief.link());
    link.from = ends.first;
    link.to = ends.second;
    link.weight = weight;
  }
  graph.next_hops = next_hops();
  return graph;
}

std::uint64_t LinkTable::earliest_deadline() const {
  std::uint64_t earliest = kUnbounded;
  const auto after = [&](std::uint64_t fresh_until) {
    if (now_ <= fresh_until) earliest = std::min(earliest, add_saturating(fresh_until, 1));
  };
  for (const auto& [ends, entry] : entries_) {
    earliest = std::min(earliest, entry.belief.deadline(now_, mesh_));
    for (const Report& report : entry.reports) after(fresh_until(report));
  }
  for (std::size_t source = 0; source < sources_.size(); ++source)
    if (!sources_[source].next_hops.empty()) after(routes_fresh_until(source));
  return earliest;
}

/// Updates beliefs, deadline and graph after a report or some time; returns whether the graph has
/// changed.
bool LinkTable::update_beliefs() {
  for (auto& [ends, entry] : entries_) entry.belief.observe(observe(ends, entry), now_, mesh_);
  std::erase_if(entries_, [&](const auto& known) {
    return known.second.reports.empty() && known.second.belief.forgotten(now_, mesh_);
  });
  deadline_ = earliest_deadline();
  Graph graph = believed();
  const bool changed = graph != graph_;
  graph_ = std::move(graph);
  return changed;
}

Snapshot described_snapshot(const Mesh& mesh, std::uint64_t now) {
  Snapshot snapshot;
  for (const DescribedLink& link : mesh.links)
    snapshot.links.push_back({.from = address_of(mesh.nodes[link.from]),
                              .to = address_of(mesh.nodes[link.to]),
                              .rate = link.rate,
                              .kind = link.kind,
                              .loss = link.loss,
                              .channel = link.channel,
                              .busy = std::nullopt,
                              .weight = std::nullopt,
                              .taken = now,
                              .valid = std::nullopt});
  return snapshot;
}

}  // namespace mlcca::core::mesh
