// SPDX-License-Identifier: BSD-2-Clause
// What is promised of a network beside what is held here: to other gateways, and to flows that are
// not carried just now.
#include <algorithm>
#include <cassert>
#include <tuple>
#include <utility>

#include "core/can/cover.hpp"
#include "core/model/progress.hpp"
#include "core/reserve/ledger.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core {
namespace {

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
