// SPDX-License-Identifier: BSD-2-Clause
#include "core/reserve/ledger.hpp"

#include <algorithm>
#include <cassert>
#include <tuple>
#include <utility>

#include "core/can/cover.hpp"
#include "core/model/progress.hpp"
#include "mlcca/arithmetic.hpp"

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

/// The same message of the same gateway, whatever number it has.
bool same_message(const can::Message& numbered, can::Message wanted) {
  constexpr std::uint64_t number = 0xffffffff;
  wanted.key |= numbered.key & number;
  return numbered == wanted;
}

/// An order in which the same messages are beside each other.
auto order_of_others(const can::Message& m) {
  return std::tuple(Ledger::gateway_of(m.key), m.priority, m.period, m.deadline, m.jitter,
                    m.transmission);
}

/// What `more` has of each domain beyond `held`.
std::vector<mesh::Share> beyond(std::span<const mesh::Share> more,
                                std::span<const mesh::Share> held) {
  std::vector<mesh::Share> rest;
  for (const mesh::Share& share : more) {
    const auto it = std::ranges::find(held, share.domain, &mesh::Share::domain);
    const Value time = it == held.end() ? share.time : sub_floor(share.time, it->time);
    if (time != 0) rest.push_back({share.domain, time});
  }
  return rest;
}

/// Placeholders are sorted by their flows.
constexpr auto kFlowOfPlaced = [](const auto& placed) { return placed.what.flow; };

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

// --- what others hold, and placeholders ----------------------------------------------------------

Ledger::Placed* Ledger::placeholder(const Flow& flow) {
  if (others_.empty() || flow.resource >= networks_) return nullptr;
  auto& all = others_[flow.resource].standing;
  const auto it = std::ranges::lower_bound(all, flow, {}, kFlowOfPlaced);
  return it != all.end() && it->what.flow == flow ? &*it : nullptr;
}

void Ledger::note_asked(std::size_t network, const can::Message& asked,
                        const can::Message& counted) {
  auto& all = others_[network].asked;
  if (asked == counted)
    all.erase(asked.key);
  else
    all.insert_or_assign(asked.key, asked);
}

const can::Message* Ledger::message_of(const Flow& flow) const {
  if (!schedules_[flow.resource]) return nullptr;
  const std::uint64_t key = key_of(flow);
  if (!others_.empty()) {
    const auto& asked = others_[flow.resource].asked;
    const auto found = asked.find(key);
    if (found != asked.end()) return &found->second;
  }
  return schedules_[flow.resource]->find(key);
}

void Ledger::count_shares(std::size_t network, std::span<const mesh::Share> shares, bool in) {
  for (const mesh::Share& share : shares) {
    Value& sum = domains_[network][share.domain];
    sum = in ? sum + share.time : sum - share.time;
  }
}

/// In the sums; its message is not touched.
void Ledger::count(Placed& placed, bool in) {
  Value& sum = reserved_[placed.what.flow.resource];
  sum = in ? sum + placed.what.bytes_per_second : sum - placed.what.bytes_per_second;
  count_shares(placed.what.flow.resource, placed.what.shares, in);
  placed.counts = in;
}

void Ledger::lift(Placed& placed) {
  const Flow& flow = placed.what.flow;
  if (placed.what.message && schedules_[flow.resource]) {
    keep_schedule(flow.resource);
    schedules_[flow.resource]->remove(key_of(flow));
  }
  count(placed, false);
}

bool Ledger::has_room(std::size_t network, Value bytes_per_second,
                      std::span<const mesh::Share> shares) const {
  const OfOthers& here = others_[network];
  if (add_saturating(reserved_[network], bytes_per_second) > here.most_bytes) return false;
  return std::ranges::all_of(shares, [&](const mesh::Share& share) {
    return add_saturating(domains_[network][share.domain], share.time) <= here.most_time;
  });
}

/// False, and nothing has changed: it does not fit.
bool Ledger::place(Placed& placed) {
  const Flow& flow = placed.what.flow;
  if (!has_room(flow.resource, placed.what.bytes_per_second, placed.what.shares)) return false;
  if (placed.what.message && schedules_[flow.resource]) {
    keep_schedule(flow.resource);
    can::Message message = *placed.what.message;
    message.key = key_of(flow);
    if (schedules_[flow.resource]->add(message)) return false;
  }
  count(placed, true);
  return true;
}

/// In the place of what a publisher has held: the flows whose placeholders count now.
std::unique_ptr<std::vector<Flow>> Ledger::place_after(std::size_t publisher,
                                                       std::span<const Holding> gone) {
  auto flows = std::make_unique<std::vector<Flow>>();
  for (const Holding& holding : gone) {
    const Flow flow{publisher, holding.resource, holding.from};
    Placed* const known = placeholder(flow);
    if (known == nullptr || known->counts) continue;
    if (place(*known))
      flows->push_back(flow);
    else
      unplaced_ = true;
  }
  return flows;
}

/// Before the schedule or the domains are others.
void Ledger::forget_others(std::size_t network) {
  if (others_.empty()) return;
  OfOthers& here = others_[network];
  for (Placed& placed : here.standing)
    if (placed.counts) lift(placed);
  if (schedules_[network])
    for (const can::Message& m : here.messages) schedules_[network]->remove(m.key);
  reserved_[network] -= here.bytes_per_second;
  count_shares(network, here.shares, false);
  here = {};
}

bool Ledger::change_messages(std::size_t network, std::vector<can::Message> messages,
                             bool& relieved) {
  OfOthers& here = others_[network];
  if (!schedules_[network]) return true;
  can::Schedule& bus = *schedules_[network];
  std::ranges::sort(messages, {}, order_of_others);
  std::vector<bool> found(messages.size(), false);
  const auto is_left = [&](const can::Message& there) {
    const auto [first, last] =
        std::ranges::equal_range(messages, order_of_others(there), {}, order_of_others);
    for (auto it = first; it != last; ++it) {
      const auto at = static_cast<std::size_t>(it - messages.begin());
      if (found[at] || !same_message(there, *it)) continue;
      found[at] = true;
      return true;
    }
    return false;
  };
  std::erase_if(here.messages, [&](const can::Message& there) {
    if (is_left(there)) return false;
    bus.remove(there.key);
    relieved = true;
    return true;
  });
  if (relieved) bus.review();
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (found[i]) continue;
    can::Message& m = messages[i];
    m.key |= here.numbered++;
    if (bus.add(m)) return false;
    here.messages.push_back(m);
  }
  return true;
}

bool Ledger::change_sums(std::size_t network, const Others& others, bool& relieved) {
  OfOthers& here = others_[network];
  relieved = relieved || others.bytes_per_second < here.bytes_per_second ||
             !beyond(here.shares, others.shares).empty();
  reserved_[network] -= std::exchange(here.bytes_per_second, 0);
  count_shares(network, std::exchange(here.shares, {}), false);
  const bool fits = has_room(network, others.bytes_per_second, others.shares);
  here.bytes_per_second = std::min(others.bytes_per_second, kUnbounded - reserved_[network]);
  here.shares = others.shares;
  reserved_[network] += here.bytes_per_second;
  count_shares(network, here.shares, true);
  return fits;
}

/// Takes out what is not among `next`, and notes there what stays. Returns whether anything that
/// counted was taken out.
bool Ledger::lift_changed(std::vector<Placed>& before, std::vector<Placed>& next) {
  bool any = false;
  for (Placed& old : before) {
    const auto now = std::ranges::lower_bound(next, old.what.flow, {}, kFlowOfPlaced);
    if (now != next.end() && now->what == old.what) {
      now->counts = old.counts;
      now->in_full = old.in_full;
    } else if (old.counts) {
      lift(old);
      any = true;
    }
  }
  return any;
}

bool Ledger::change_standing(std::size_t network, std::vector<Placeholder> standing,
                             Change& change) {
  OfOthers& here = others_[network];
  std::vector<Placed> next;
  next.reserve(standing.size());
  for (Placeholder& p : standing) next.push_back({std::move(p), false});
  if (lift_changed(here.standing, next)) change.relieved = true;
  const std::vector<Placed> before = std::exchange(here.standing, std::move(next));
  std::vector<Placed*> fresh;  // of flows that are held
  bool fits = true;
  for (Placed& p : here.standing) {
    const auto old = std::ranges::lower_bound(before, p.what.flow, {}, kFlowOfPlaced);
    const bool known = old != before.end() && old->what.flow == p.what.flow;
    const bool same = known && old->what == p.what;
    if (carries(p.what.flow)) {
      // It counts with what is held of the flow.
      if (!known) fresh.push_back(&p);
      fits = fits && (same || !known);
      continue;
    }
    if (p.counts || place(p)) continue;
    // One that has not changed did not fit before either.
    fits = fits && same;
    unplaced_ = true;
  }
  const bool left = std::ranges::any_of(before, [&](const Placed& old) {
    return carries(old.what.flow) && placeholder(old.what.flow) == nullptr;
  });
  change.held = !fresh.empty();
  return fits && !left && count_held(network, fresh);
}

/// Whether the flow holds as much as the placeholder has.
bool Ledger::holds_in_full(const Placed& placed) const {
  const Flow& flow = placed.what.flow;
  const Holding& held = *find(flow);
  if (held.bytes_per_second < placed.what.bytes_per_second ||
      std::ranges::any_of(
          placed.what.shares,
          [&](const mesh::Share& share) {
            return domains_[flow.resource][share.domain] > others_[flow.resource].most_time;
          }))
    return false;
  if (!beyond(placed.what.shares, held.mesh ? std::span<const mesh::Share>(held.mesh->shares)
                                            : std::span<const mesh::Share>())
           .empty())
    return false;
  if (!placed.what.message || !schedules_[flow.resource]) return true;
  const can::Message* const now = schedules_[flow.resource]->find(key_of(flow));
  return now != nullptr && can::strictest(*now, *placed.what.message) == *now;
}

bool Ledger::counts_all(std::size_t network) const {
  if (schedules_[network] && schedules_[network]->spares_any()) return false;
  if (others_.empty()) return true;
  return has_room(network, 0, {}) &&
         std::ranges::all_of(others_[network].standing, [this](const Placed& placed) {
           return placed.counts ||
                  (carries(placed.what.flow) && placed.in_full && holds_in_full(placed));
         });
}

/// Placeholders of flows that are held without one: each counts in full from now on, if the flow
/// holds as much. False if it may be otherwise when all of the network is decided again.
bool Ledger::count_held(std::size_t network, std::span<Placed* const> fresh) const {
  if (fresh.empty()) return true;
  for (Placed* const placed : fresh) placed->in_full = true;
  return counts_all(network);
}

/// Whether a domain has more than its limit beside what is measured as busy, and more than before.
/// What does not fit for that reason counts all the same: all other gateways count it, too.
bool Ledger::is_fuller(std::size_t network, std::span<const Value> before,
                       std::span<const Value> busy) const {
  const std::vector<Value>& now = domains_[network];
  for (std::size_t d = 0; d < now.size(); ++d) {
    const Value taken = add_saturating(now[d], d < busy.size() ? busy[d] : 0);
    if (now[d] > before[d] && taken > others_[network].most_time) return true;
  }
  return false;
}

Ledger::Change Ledger::set_others(std::size_t network, Others others) {
  assert(!marked_);
  if (others_.empty()) {
    if (others.empty()) return {};
    others_.resize(networks_);
  }
  const std::vector<Value> before = domains_[network];
  others_[network].most_bytes = others.most_bytes;
  others_[network].most_time = others.most_time;
  Change change;
  change.fits = change_sums(network, others, change.relieved);
  change.fits =
      change_messages(network, std::move(others.messages), change.relieved) && change.fits;
  change.fits = change_standing(network, std::move(others.standing), change) && change.fits;
  if (is_fuller(network, before, others.busy)) change.fits = false;
  return change;
}

void Ledger::rebuild_others(std::size_t network, Others others) {
  assert(!marked_);
  forget_others(network);
  if (others_.empty()) {
    if (others.empty()) return;
    others_.resize(networks_);
  }
  OfOthers& here = others_[network];
  here.most_bytes = others.most_bytes;
  here.most_time = others.most_time;
  bool relieved = false;
  static_cast<void>(change_sums(network, others, relieved));
  std::vector<can::Message> all;
  if (schedules_[network]) {
    for (can::Message& m : others.messages) {
      m.key |= here.numbered++;
      here.messages.push_back(m);
    }
    all = here.messages;
  }
  here.standing.reserve(others.standing.size());
  for (Placeholder& p : others.standing) {
    Placed& placed = here.standing.emplace_back(Placed{std::move(p), false});
    if (carries(placed.what.flow)) continue;
    if (placed.what.message && schedules_[network]) {
      all.push_back(*placed.what.message);
      all.back().key = key_of(placed.what.flow);
      count(placed, true);
    } else if (!place(placed)) {
      unplaced_ = true;
    }
    Progress::step();
  }
  if (schedules_[network]) schedules_[network]->put(all);
}

Value Ledger::reserved_without(const Flow& flow) const {
  const Placed* const known = placeholder(flow);
  const Value all = reserved_[flow.resource];
  return known != nullptr && known->counts ? all - known->what.bytes_per_second : all;
}

void Ledger::relax(std::size_t publisher) {
  assert(!marked_);
  for (OfOthers& here : others_) {
    const auto mine = std::ranges::equal_range(
        here.standing, publisher, {}, [](const Placed& p) { return p.what.flow.publisher; });
    for (Placed& placed : mine) {
      if (!placed.counts) continue;
      lift(placed);
      unplaced_ = true;
    }
  }
}

void Ledger::place_rest() {
  if (!std::exchange(unplaced_, false)) return;
  for (OfOthers& here : others_)
    for (Placed& placed : here.standing)
      if (!placed.counts && !carries(placed.what.flow) && !place(placed)) unplaced_ = true;
}

void Ledger::forget_placeholders(std::size_t publisher) {
  relax(publisher);
  for (OfOthers& here : others_)
    std::erase_if(here.standing,
                  [publisher](const Placed& p) { return p.what.flow.publisher == publisher; });
}

bool Ledger::raise(Placed& placed, Raised& step) {
  const Flow& flow = placed.what.flow;
  const std::size_t at = index_of(flow);
  if (at == kNowhere) {
    if (placed.counts) return true;
    if (!place(placed)) return false;
    step.placed.push_back(flow);
    return true;
  }
  const Holding& held = holdings_[flow.publisher][at];
  const Value bytes = sub_floor(placed.what.bytes_per_second, held.bytes_per_second);
  const auto shares =
      beyond(placed.what.shares, held.mesh ? std::span<const mesh::Share>(held.mesh->shares)
                                           : std::span<const mesh::Share>());
  if (!has_room(flow.resource, bytes, shares)) return false;
  reserved_[flow.resource] += bytes;
  step.bytes_per_second += bytes;
  count_shares(flow.resource, shares, true);
  step.shares.insert(step.shares.end(), shares.begin(), shares.end());
  if (!placed.what.message || !schedules_[flow.resource]) return true;
  can::Schedule& bus = *schedules_[flow.resource];
  const can::Message* const now = bus.find(key_of(flow));
  can::Message both = *placed.what.message;
  if (now != nullptr) both = can::strictest(*now, both);
  both.key = key_of(flow);
  if (now != nullptr && *now == both) return true;
  bus.remove(both.key);
  return !bus.add(both);
}

bool Ledger::raise(std::size_t network) {
  assert(marked_);
  if (others_.empty()) return true;
  if (schedules_[network]) {
    if (schedules_[network]->spares_any()) return false;
    keep_schedule(network);
  }
  Raised step{.network = network, .bytes_per_second = 0, .shares = {}, .placed = {}};
  const bool fits = std::ranges::all_of(others_[network].standing,
                                        [&](Placed& placed) { return raise(placed, step); });
  steps_.emplace_back(std::make_unique<Raised>(std::move(step)));
  return fits && has_room(network, 0, {});
}

}  // namespace mlcca::core
