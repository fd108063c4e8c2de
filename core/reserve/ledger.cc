// SPDX-License-Identifier: BSD-2-Clause
#include "core/reserve/ledger.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "core/can/cover.hpp"
#include "core/model/progress.hpp"

namespace mlcca::core {
namespace {

constexpr std::size_t kNever = ~std::size_t{0};

void add_shares(std::vector<mesh::Share>& to, std::span<const mesh::Share> shares) {
  for (const mesh::Share& share : shares) {
    const auto it = std::ranges::find(to, share.domain, &mesh::Share::domain);
    if (it != to.end())
      it->time += share.time;
    else
      to.push_back(share);
  }
}

bool same_holding(const Holding& a, const Holding& b) {
  if (a.resource != b.resource || a.from != b.from || a.bytes_per_second != b.bytes_per_second ||
      a.scheduled != b.scheduled || !a.mesh != !b.mesh)
    return false;
  if (!a.mesh) return true;
  const auto links_of = [](const Holding& h) {
    auto links = h.mesh->links;
    std::ranges::sort(links);
    return links;
  };
  return links_of(a) == links_of(b);
}

}  // namespace

Ledger::Ledger(const System& system)
    : networks_(system.networks.size()),
      reserved_(system.resources(), 0),
      domains_(system.networks.size()),
      schedules_(system.networks.size()),
      kept_(system.networks.size(), kNever),
      holdings_(system.publishers.size()) {}

std::uint64_t Ledger::key_of(const Flow& flow) {
  constexpr std::uint64_t mask = (std::uint64_t{1} << kFromBits) - 1;
  return static_cast<std::uint64_t>(flow.publisher) << kFromBits | (flow.from & mask);
}

std::size_t Ledger::index_of(const Flow& flow) const {
  const auto held = holdings_of(flow.publisher);
  for (std::size_t i = 0; i < held.size(); ++i)
    if (held[i].resource == flow.resource && held[i].from == flow.from) return i;
  return kNowhere;
}

const Holding* Ledger::find(const Flow& flow) const {
  const std::size_t i = index_of(flow);
  return i == kNowhere ? nullptr : &holdings_[flow.publisher][i];
}

// --- marks --------------------------------------------------------------------------------------

Ledger::Mark Ledger::mark() {
  marked_ = true;
  last_mark_ = steps_.size();
  return last_mark_;
}

void Ledger::roll_back(Mark mark) {
  while (steps_.size() > mark) {
    Step step = std::move(steps_.back());
    steps_.pop_back();
    std::visit([this](auto& s) { undo(s); }, step);
    Progress::step();
  }
  last_mark_ = mark;
  // What was kept before the mark may belong to an older mark, so it is kept again.
  forget_kept(steps_.size());
}

void Ledger::commit() {
  steps_.clear();
  marked_ = false;
  last_mark_ = 0;
  forget_kept(0);
}

/// Forgets the schedules that were kept at that step or later.
void Ledger::forget_kept(std::size_t from) {
  while (!kept_networks_.empty() && kept_[kept_networks_.back()] >= from) {
    kept_[kept_networks_.back()] = kNever;
    kept_networks_.pop_back();
  }
}

void Ledger::keep_schedule(std::size_t network) {
  if (!marked_) return;
  if (kept_[network] != kNever && kept_[network] >= last_mark_) return;
  kept_[network] = steps_.size();
  kept_networks_.push_back(network);
  auto bus = std::make_unique<Bus>(Bus{.schedule = *schedules_[network], .asked = {}});
  if (!others_.empty()) bus->asked = others_[network].asked;
  steps_.emplace_back(Kept{network, std::move(bus)});
}

void Ledger::undo(Added& step) {
  auto& held = holdings_[step.publisher];
  const Holding& last = held.back();
  reserved_[last.resource] -= last.bytes_per_second;
  if (step.lifted) count(*placeholder({step.publisher, last.resource, last.from}), true);
  held.pop_back();
}

void Ledger::undo(Occupied& step) {
  Holding& holding = holdings_[step.publisher][step.index];
  if (step.links == 0) {
    for (const mesh::Share& share : holding.mesh->shares)
      domains_[holding.resource][share.domain] -= share.time;
    holding.mesh.reset();
    return;
  }
  for (const mesh::Share& share : step.shares) {
    domains_[holding.resource][share.domain] -= share.time;
    const auto it = std::ranges::find(holding.mesh->shares, share.domain, &mesh::Share::domain);
    it->time -= share.time;
    if (it->time == 0) holding.mesh->shares.erase(it);
  }
  holding.mesh->links.resize(step.links);
}

void Ledger::undo(Scheduled& step) { holdings_[step.publisher][step.index].scheduled = false; }

void Ledger::undo(Removed& step) {
  if (step.placed)
    for (const Flow& flow : *step.placed) count(*placeholder(flow), false);
  for (const Holding& holding : step.holdings) count(holding, true);
  holdings_[step.publisher] = std::move(step.holdings);
}

void Ledger::undo(std::unique_ptr<Raised>& step) {
  for (const Flow& flow : step->placed) count(*placeholder(flow), false);
  reserved_[step->network] -= step->bytes_per_second;
  count_shares(step->network, step->shares, false);
}

void Ledger::undo(Kept& step) {
  *schedules_[step.network] = std::move(step.bus->schedule);
  if (!others_.empty()) others_[step.network].asked = std::move(step.bus->asked);
}

// --- changes ------------------------------------------------------------------------------------

bool Ledger::add(const Flow& flow, Value bytes_per_second) {
  if (carries(flow)) return false;
  Placed* const known = placeholder(flow);
  const bool lifted = known != nullptr && known->counts;
  if (known != nullptr) known->in_full = lifted || raised_ || known->what.by_others;
  if (lifted) lift(*known);
  if (known != nullptr && known->in_full)
    bytes_per_second = std::min(std::max(bytes_per_second, known->what.bytes_per_second),
                                kUnbounded - reserved_[flow.resource]);
  if (flow.publisher >= holdings_.size()) holdings_.resize(flow.publisher + 1);
  Holding& holding = holdings_[flow.publisher].emplace_back();
  holding.resource = static_cast<std::uint32_t>(flow.resource);
  holding.from = static_cast<std::uint32_t>(flow.from);
  holding.bytes_per_second = bytes_per_second;
  assert(bytes_per_second <= kUnbounded - reserved_[flow.resource]);
  reserved_[flow.resource] += bytes_per_second;
  if (marked_) steps_.emplace_back(Added{flow.publisher, lifted});
  return true;
}

void Ledger::occupy(const Flow& flow, std::span<const std::uint32_t> links,
                    std::vector<mesh::Share> shares) {
  const std::size_t index = index_of(flow);
  assert(index != kNowhere);
  Holding& holding = holdings_[flow.publisher][index];
  if (!holding.mesh) holding.mesh = std::make_unique<MeshHolding>();
  const bool first = holding.mesh->links.empty();
  if (marked_)
    steps_.emplace_back(Occupied{flow.publisher, index, holding.mesh->links.size(),
                                 first ? std::vector<mesh::Share>() : shares});
  holding.mesh->links.insert(holding.mesh->links.end(), links.begin(), links.end());
  for (const mesh::Share& share : shares) domains_[flow.resource][share.domain] += share.time;
  if (first)
    holding.mesh->shares = std::move(shares);
  else
    add_shares(holding.mesh->shares, shares);
}

std::optional<can::Schedule::Late> Ledger::schedule(const Flow& flow, can::Message message) {
  const std::size_t index = index_of(flow);
  assert(index != kNowhere && schedules_[flow.resource]);
  Holding& holding = holdings_[flow.publisher][index];
  keep_schedule(flow.resource);
  can::Schedule& bus = *schedules_[flow.resource];
  message.key = key_of(flow);
  const can::Message asked = message;
  const Placed* const known = placeholder(flow);
  if (known != nullptr && known->in_full && known->what.message)
    message = can::strictest(message, *known->what.message);
  std::optional<can::Message> replaced;
  if (holding.scheduled) {
    replaced = *bus.find(message.key);
    bus.remove(message.key);
  }
  if (auto late = bus.add(message)) {
    // The message it replaces fits, since it was there among the same messages.
    if (replaced) static_cast<void>(bus.add(*replaced));
    return late;
  }
  if (known != nullptr) note_asked(flow.resource, asked, message);
  if (!holding.scheduled && marked_) steps_.emplace_back(Scheduled{flow.publisher, index});
  holding.scheduled = true;
  return std::nullopt;
}

void Ledger::assume(std::size_t network, can::Assumptions bus) {
  if (bus == schedules_[network]->assumptions()) return;
  keep_schedule(network);
  schedules_[network]->set_assumptions(std::move(bus));
}

void Ledger::count(const Holding& holding, bool in) {
  const auto change = [in](Value& sum, Value by) { sum = in ? sum + by : sum - by; };
  change(reserved_[holding.resource], holding.bytes_per_second);
  if (holding.mesh)
    for (const mesh::Share& share : holding.mesh->shares)
      change(domains_[holding.resource][share.domain], share.time);
}

void Ledger::remove(std::size_t publisher) {
  if (publisher >= holdings_.size() || holdings_[publisher].empty()) return;
  for (const Holding& holding : holdings_[publisher]) {
    count(holding, false);
    if (!holding.scheduled) continue;
    keep_schedule(holding.resource);
    const std::uint64_t key = key_of({publisher, holding.resource, holding.from});
    schedules_[holding.resource]->remove(key);
    if (!others_.empty()) others_[holding.resource].asked.erase(key);
  }
  std::vector<Holding> gone = std::exchange(holdings_[publisher], {});
  auto placed = others_.empty() ? nullptr : place_after(publisher, gone);
  if (marked_) steps_.emplace_back(Removed{publisher, std::move(gone), std::move(placed)});
}

void Ledger::set_bus(std::size_t network, std::optional<can::Assumptions> bus) {
  assert(!marked_);
  schedules_[network].reset();
  forget_others(network);
  if (bus) schedules_[network].emplace(std::move(*bus));
}

void Ledger::set_domains(std::size_t network, std::size_t count) {
  forget_others(network);
  domains_[network].assign(count, 0);
}

bool Ledger::same_promises(const Ledger& other) const {
  if (reserved_ != other.reserved_ || domains_ != other.domains_ || schedules_ != other.schedules_)
    return false;
  const std::size_t publishers = std::max(holdings_.size(), other.holdings_.size());
  for (std::size_t p = 0; p < publishers; ++p)
    if (!std::ranges::is_permutation(holdings_of(p), other.holdings_of(p), same_holding))
      return false;
  return true;
}

}  // namespace mlcca::core
