// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/meshes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "base/clock.hpp"
#include "core/model/text.hpp"

namespace mlcca {
namespace {

constexpr std::uint64_t kLinesAtOnce = 10;            // of one source
constexpr std::uint64_t kLineAgain = 10'000'000'000;  // ns after which one more is allowed
constexpr std::uint64_t kStep = 20'000'000;           // ns

bool is_same(const core::mesh::Source& x, const core::mesh::Source& y) {
  return x.kind == y.kind && x.interface == y.interface && x.endpoint == y.endpoint &&
         x.metric == y.metric;
}

/// The index of each former source in the new description; nullopt if it is gone.
std::vector<std::optional<std::size_t>> places_of(const std::vector<core::mesh::Source>& former,
                                                  const std::vector<core::mesh::Source>& sources) {
  std::vector<std::optional<std::size_t>> places(former.size());
  std::vector<bool> taken(sources.size(), false);
  for (std::size_t f = 0; f < former.size(); ++f)
    for (std::size_t s = 0; s < sources.size() && !places[f]; ++s) {
      if (taken[s] || !is_same(former[f], sources[s])) continue;
      places[f] = s;
      taken[s] = true;
    }
  return places;
}

std::optional<std::uint32_t> node_of(const core::mesh::Mesh& mesh, std::size_t gateway) {
  const auto it = std::ranges::find(mesh.nodes, std::optional<std::uint32_t>(gateway),
                                    &core::mesh::Node::gateway);
  if (it == mesh.nodes.end()) return std::nullopt;
  return static_cast<std::uint32_t>(it - mesh.nodes.begin());
}

}  // namespace

/// What a source has said before a reload is known until it says something else. What a source has
/// said that is gone, or what the former description said of links, does not count any more.
void Meshes::hand_over(const Entry& former, Entry& entry) {
  const auto places = places_of(former.mesh.sources, entry.mesh.sources);
  std::vector<core::mesh::Snapshot> known(entry.mesh.sources.size());
  for (const core::mesh::Known& link : former.table.links()) {
    const auto place = places[link.source];
    if (place && !link.stale && !core::mesh::is_description(entry.mesh.sources[*place]))
      known[*place].links.push_back(link.sample);
  }
  for (std::size_t s = 0; s < known.size(); ++s)
    if (!known[s].links.empty()) entry.table.take(s, known[s], monotonic_ns());
}

const core::mesh::LinkTable* Meshes::table(std::size_t network) const {
  const auto it = std::ranges::find(entries_, network, [](const auto& e) { return e->network; });
  return it == entries_.end() ? nullptr : &(*it)->table;
}

const core::mesh::Mesh* Meshes::mesh(std::size_t network) const {
  const auto it = std::ranges::find(entries_, network, [](const auto& e) { return e->network; });
  return it == entries_.end() ? nullptr : &(*it)->mesh;
}

void Meshes::describe(const core::System& system, std::size_t self) {
  auto former = std::exchange(entries_, {});
  for (std::size_t n = 0; n < system.networks.size(); ++n) {
    const core::Network& network = system.networks[n];
    if (!network.mesh) continue;
    const auto here = node_of(*network.mesh, self);
    const auto same = std::ranges::find_if(former, [&](const auto& e) {
      return e != nullptr && e->name == network.name && e->here == here &&
             same_description(e->mesh, *network.mesh);
    });
    if (same != former.end()) {
      (*same)->network = n;
      entries_.push_back(std::move(*same));
      continue;
    }
    entries_.push_back(std::make_unique<Entry>(Entry{network.name,
                                                     n,
                                                     *network.mesh,
                                                     here,
                                                     core::mesh::LinkTable(*network.mesh, here),
                                                     {},
                                                     {},
                                                     {},
                                                     {}}));
    const auto of_name = std::ranges::find_if(
        former, [&](const auto& e) { return e != nullptr && e->name == network.name; });
    if (of_name != former.end()) hand_over(**of_name, *entries_.back());
    open_sources(*entries_.back());
  }
  arm();
}

/// Described links are known at once, before any decision, and never become stale.
void Meshes::take_described(Entry& entry, std::size_t source) {
  const std::uint64_t now = monotonic_ns();
  entry.table.take(source, core::mesh::described_snapshot(entry.mesh, now), now);
  entry.reported.back() = true;
  entry.sources.emplace_back();
  entry.problems.back() = entry.table.problem(source);
  if (const std::string& problem = entry.problems.back(); !problem.empty())
    report_(entry.name, problem_line(entry, source, problem), true);
}

void Meshes::open_sources(Entry& entry) {
  for (std::size_t s = 0; s < entry.mesh.sources.size(); ++s) {
    entry.reported.push_back(false);
    entry.problems.emplace_back();
    entry.lines.emplace_back();
    if (core::mesh::is_description(entry.mesh.sources[s])) {
      take_described(entry, s);
      continue;
    }
    auto source = open_(
        entry.mesh.sources[s], entry.mesh, loop_,
        [this, &entry, s](const core::mesh::Snapshot& snapshot) { take(entry, s, snapshot); });
    if (source) {
      entry.sources.push_back(std::move(*source));
      continue;
    }
    entry.reported.back() = true;
    entry.sources.emplace_back();
    entry.problems.back() = source.error().text;
    report_(entry.name, problem_line(entry, s, source.error().text), true);
  }
}

bool Meshes::Lines::take(std::uint64_t now) {
  const std::uint64_t earliest = now - std::min(now, kLinesAtOnce * kLineAgain);
  paid_until = std::max(paid_until, earliest) + kLineAgain;
  if (paid_until <= now) return true;
  paid_until -= kLineAgain;
  return false;
}

std::string Meshes::problem_line(const Entry& entry, std::size_t source,
                                 const std::string& problem) {
  return fmt::format("{}: {}: {}", entry.name, core::name_of(entry.mesh.sources[source]), problem);
}

void Meshes::take(Entry& entry, std::size_t source, const core::mesh::Snapshot& snapshot) {
  entry.reported[source] = true;
  const bool changed = entry.table.take(source, snapshot, monotonic_ns());
  const std::string& problem = entry.table.problem(source);
  if (problem != entry.problems[source] && entry.lines[source].take(monotonic_ns())) {
    entry.problems[source] = problem;
    if (problem.empty())
      report_(entry.name,
              fmt::format("{}: {} knows its links again", entry.name,
                          core::name_of(entry.mesh.sources[source])),
              false);
    else
      report_(entry.name, problem_line(entry, source, problem), true);
  }
  if (changed) changed_(entry.network);
  arm();
}

std::vector<std::string> Meshes::problems() const {
  std::vector<std::string> out;
  for (const auto& entry : entries_)
    for (std::size_t s = 0; s < entry->mesh.sources.size(); ++s)
      if (const std::string& problem =
              entry->sources[s] == nullptr ? entry->problems[s] : entry->table.problem(s);
          !problem.empty())
        out.push_back(problem_line(*entry, s, problem));
  return out;
}

void Meshes::expire() {
  const std::uint64_t now = monotonic_ns();
  for (const auto& entry : entries_)
    if (entry->table.expire(now)) changed_(entry->network);
  arm();
}

void Meshes::arm() {
  std::uint64_t next = kUnbounded;
  for (const auto& entry : entries_) next = std::min(next, entry->table.next_deadline());
  if (next == kUnbounded) {
    if (timer_) sd_event_source_set_enabled(timer_.get(), SD_EVENT_OFF);
    return;
  }
  const std::uint64_t micros = next / 1000 + 1;
  if (timer_) {
    sd_event_source_set_time(timer_.get(), micros);
    sd_event_source_set_enabled(timer_.get(), SD_EVENT_ONESHOT);
    return;
  }
  sd_event_source* raw = nullptr;
  const auto on_time = [](sd_event_source*, std::uint64_t, void* self) noexcept {
    static_cast<Meshes*>(self)->expire();
    return 0;
  };
  if (sd_event_add_time(loop_, &raw, CLOCK_MONOTONIC, micros, 1000, on_time, this) >= 0)
    timer_.reset(raw);
}

void Meshes::await_first_reports(std::uint64_t limit_ns, const std::function<void()>& step) {
  const std::uint64_t end = monotonic_ns() + limit_ns;
  const auto all_reported = [this] {
    return std::ranges::all_of(entries_, [](const auto& e) {
      return std::ranges::all_of(e->reported, [](bool reported) { return reported; });
    });
  };
  for (std::uint64_t now = monotonic_ns(); now < end && !all_reported(); now = monotonic_ns()) {
    if (sd_event_run(loop_, std::min(end - now, kStep) / 1000) < 0) return;
    step();
  }
}

}  // namespace mlcca
