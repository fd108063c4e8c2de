// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/view.hpp"

#include <algorithm>
#include <ranges>
#include <utility>

#include "core/cluster/footprint.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core::cluster {
namespace {

/// Changes of one revision. One transaction makes no more than kMostPuts.
constexpr std::size_t kMostParts = 4096;

}  // namespace

View::View(std::shared_ptr<const Keys> keys, const Codec& codec, std::size_t self)
    : keys_(std::move(keys)),
      codec_(&codec),
      self_(self),
      records_(keys_->gateways(), keys_->networks()),
      timers_(keys_->gateways()) {}

void View::begin_snapshot(std::int64_t revision) {
  if (revision < revision_) {
    went_back_ = true;
    // What is the same number is not the same entry.
    const auto forget = [](Timer& timer) {
      if (timer.mod != 0) timer.mod = timer.fence = -1;
    };
    std::ranges::for_each(timers_, forget);
    std::ranges::for_each(std::views::values(left_timers_), forget);
  }
  coming_ = Records(keys_->gateways(), keys_->networks());
  coming_revision_ = revision;
  parts_.clear();
  snapshot_ = true;
}

void View::apply(const Batch& batch, Value now) {
  if (snapshot_) {
    for (const Entry& entry : batch.entries) coming_.put(*keys_, *codec_, entry);
    return;
  }
  if (!complete_ || batch.revision <= revision_) return;
  parts_.insert(parts_.end(), batch.entries.begin(), batch.entries.end());
  if (parts_.size() > kMostParts) {
    parts_.clear();
    records_.too_many = Exceeded::changes;
    touch_all();
  }
  if (!batch.last) return;
  const Exceeded before = records_.too_many;
  for (const Entry& entry : parts_) take_in(entry, now);
  // Nothing that is known of any network is complete from then on.
  if (records_.too_many != before) touch_all();
  parts_.clear();
  revision_ = batch.revision;
  expire(now);
}

void View::end_snapshot(Value now) {
  if (!snapshot_) return;
  snapshot_ = false;
  touch_all();
  found_.clear();
  records_ = std::exchange(coming_, {});
  revision_ = coming_revision_;
  complete_ = true;
  for (std::size_t g = 0; g < timers_.size(); ++g) {
    time_member(g, now);
    if (records_.members[g].fence != 0) dying_.insert(g);
  }
  std::erase_if(left_timers_, [&](const auto& one) { return !records_.left.contains(one.first); });
  for (const auto& name : std::views::keys(records_.left)) time_left(name, now);
  touch_all();
  expire(now);
}

void View::on_time(Value now) { expire(now); }

void View::touch_reservation(std::size_t network, std::size_t gateway) {
  changed_.insert(network);
  const auto found = found_.find(network);
  if (found != found_.end() && gateway != self_) found->second[gateway] = nullptr;
}

void View::touch_all() {
  for (std::size_t n = 0; n < keys_->networks(); ++n) changed_.insert(n);
  touch_asked();
}

void View::touch_asked() {
  for (std::size_t g = 0; g < timers_.size(); ++g) touch_those_of(g);
}

void View::touch_those_of(std::size_t gateway) {
  for (auto it = records_.asked.lower_bound({gateway, 0});
       it != records_.asked.end() && it->first.first == gateway; ++it)
    touched_.insert(it->first);
}

void View::take_in(const Entry& entry, Value now) {
  const auto key = records_.put(*keys_, *codec_, entry);
  if (!key) {
    if (const auto network = keys_->network_of(entry.key)) changed_.insert(*network);
    if (const auto left = keys_->parse_left(entry.key)) time_left(left->gateway, now);
    return;
  }
  switch (key->kind) {
    case Key::Kind::member:
    case Key::Kind::fence:
      time_member(key->gateway, now);
      break;
    case Key::Kind::reservation:
      touch_reservation(key->network, key->gateway);
      if (entry.mod < records_.members[key->gateway].fence) dying_.insert(key->gateway);
      break;
    case Key::Kind::asked:
      touched_.insert({key->gateway, key->id});
      break;
    default:
      break;
  }
}

/// The entry of a gateway has changed: from now on it counts for its lease. A gateway that states a
/// longer lease than it may have could send for so long, as long as nothing replaces that entry.
/// When a beat does, or it is deleted, it counts for the longest lease that a gateway may have.
void View::time_beat(const MemberRecord& record, Timer& timer, Value now) {
  const bool was_too_long = timer.lease > kMostLease;
  if (record.mod != 0) {
    // What cannot be read does not say that a longer lease has ended.
    timer.lease =
        record.beat ? record.beat->lease : std::max({kMostLease, record.lease, timer.lease});
    timer.drained = record.beat && record.beat->draining;
  } else {
    timer.lease = std::min(timer.lease, kMostLease);
  }
  const Value lawful = was_too_long ? kMostLease : std::min(timer.lease, kMostLease);
  if (record.mod != 0 || !timer.drained)
    timer.lawful_until = std::max(timer.lawful_until, may_fence_at(now, lawful));
  if (timer.lease > kMostLease) {
    timer.counts_until = std::max(timer.counts_until, may_fence_at(now, timer.lease));
  } else {
    timer.counts_until = timer.lawful_until;
    timer.dead_at = std::min(timer.dead_at, timer.lawful_until);
  }
  timer.seen = now;
  timer.mod = record.mod;
}

/// The record of a gateway may have changed. What it had before a fence counts for what was left of
/// its lease. True: the fence is another one.
bool View::time_record(const MemberRecord& record, Timer& timer, Value now) {
  if (record.mod != timer.mod) time_beat(record, timer, now);
  if (record.fence == timer.fence) return false;
  timer.dead_at = std::max(timer.dead_at, timer.counts_until);
  timer.fence = record.fence;
  return true;
}

void View::time_member(std::size_t gateway, Value now) {
  if (!time_record(records_.members[gateway], timers_[gateway], now)) return;
  dying_.insert(gateway);
  touch_those_of(gateway);
}

void View::time_left(std::string_view gateway, Value now) {
  const auto record = records_.left.find(gateway);
  if (record != records_.left.end())
    time_record(record->second.member, left_timers_[record->first], now);
}

/// Whoever was on the way of it is in the description that is open now, or is dead as well.
void View::expire_left(Value now) {
  for (auto& [gateway, left] : records_.left) {
    if (now < left_timers_[gateway].dead_at) continue;
    for (auto it = left.taken.begin(); it != left.taken.end();) {
      if (it->second.mod >= left.member.fence) {
        ++it;
        continue;
      }
      changed_.insert(it->second.network);
      records_.strange.erase(it->first);
      it = left.taken.erase(it);
    }
  }
}

bool View::is_over(const std::string& gateway, Value now) const {
  const auto record = records_.left.find(gateway);
  const auto timer = left_timers_.find(gateway);
  if (record == records_.left.end() || timer == left_timers_.end()) return false;
  const std::int64_t fence = record->second.member.fence;
  return fence != 0 && now >= timer->second.dead_at &&
         std::ranges::all_of(record->second.keys, [fence](const auto& entry) {
           const LeftRecord::Key& key = entry.second;
           return key.kind == Key::Kind::fence || key.voter || key.mod < fence;
         });
}

bool View::is_fenced(std::size_t gateway) const {
  const MemberRecord& record = records_.members[gateway];
  return record.fence > record.mod;
}

std::optional<Value> View::seen_at(std::size_t gateway) const {
  if (records_.members[gateway].mod == 0) return std::nullopt;
  return timers_[gateway].seen;
}

std::optional<Value> View::fence_from(std::size_t gateway) const {
  if (gateway == self_ || is_fenced(gateway) || records_.members[gateway].mod == 0)
    return std::nullopt;
  return timers_[gateway].counts_until;
}

Alive View::alive(std::size_t gateway, Value now) const {
  const MemberRecord& record = records_.members[gateway];
  const Timer& timer = timers_[gateway];
  if (is_fenced(gateway)) return now < timer.dead_at ? Alive::silent : Alive::fenced;
  if (record.mod == 0)
    return !timer.drained && now < timer.counts_until ? Alive::silent : Alive::absent;
  if (!record.beat) return Alive::silent;
  if (record.beat->draining) return Alive::draining;
  if (record.beat->role == Role::standby) return Alive::standby;
  return now < timer.counts_until ? Alive::present : Alive::silent;
}

std::string View::absence(std::size_t gateway, Value now) const {
  const std::string& name = keys_->gateway_name(gateway);
  switch (alive(gateway, now)) {
    case Alive::present:
    case Alive::standby:
      return {};
    case Alive::silent:
      return is_fenced(gateway) ? name + " is not there: it is dead" : name + " does not answer";
    case Alive::fenced:
      return name + " is not there: it is dead";
    case Alive::draining:
      return name + " is not there: it is being drained";
    case Alive::absent:
      break;
  }
  return name + (timers_[gateway].drained ? " is not there: it is drained, or was stopped"
                                          : " is not there");
}

bool View::surely_closed(std::size_t gateway, std::int64_t revision, Value now) const {
  const Alive state = alive(gateway, now);
  if (state == Alive::absent || state == Alive::fenced) return true;
  const auto& beat = records_.members[gateway].beat;
  return !is_fenced(gateway) && beat && beat->applied >= revision;
}

/// It is of a dead gateway, and nobody sends it any more. From when on, if not yet.
bool View::is_over(const Records::ReservationKey& key, ReservationRecord& record, Value now) const {
  const std::int64_t fence = records_.members[key.gateway].fence;
  if (record.mod >= fence || now < timers_[key.gateway].dead_at) return false;
  if (!record.taken || record.taken->through.empty()) return true;
  if (!std::ranges::all_of(record.taken->through,
                           [&](std::size_t gateway) { return surely_closed(gateway, fence, now); }))
    return false;
  record.over_from = std::min(record.over_from, queues_empty_at(now));
  return now >= record.over_from;
}

void View::expire(Value now) {
  expire_left(now);
  if (lawful_end_ < leases_end_ && !with_too_long_lease()) leases_end_ = lawful_end_;
  // What is of this gateway itself it must know, to take it out of the store.
  dying_.erase(self_);
  for (auto it = dying_.begin(); it != dying_.end();) {
    bool more = false;
    for (std::size_t n = 0; n < keys_->networks(); ++n) {
      auto at = records_.reservations.lower_bound({.network = n, .gateway = *it, .id = 0});
      while (at != records_.reservations.end() && at->first.network == n &&
             at->first.gateway == *it) {
        if (is_over(at->first, at->second, now)) {
          touch_reservation(n, *it);
          // Of another description it was not read, and is over as well.
          records_.strange.erase(keys_->reservation(n, *it, at->first.id));
          at = records_.reservations.erase(at);
        } else {
          more = more || at->second.mod < records_.members[*it].fence;
          ++at;
        }
      }
    }
    it = more ? std::next(it) : dying_.erase(it);
  }
}

/// The others that have reserved something there.
std::vector<std::size_t> View::others_on(std::size_t network) const {
  const auto& records = records_.reservations;
  std::vector<std::size_t> all;
  Records::ReservationKey from{.network = network, .gateway = 0, .id = 0};
  for (;;) {
    const auto it = records.lower_bound(from);
    if (it == records.end() || it->first.network != network) return all;
    if (it->first.gateway != self_) all.push_back(it->first.gateway);
    from.gateway = it->first.gateway + 1;
  }
}

void View::collect(Foreign& all, std::size_t network, std::size_t gateway, bool adopted_too) const {
  const auto& records = records_.reservations;
  for (auto it = records.lower_bound({.network = network, .gateway = gateway, .id = 0});
       it != records.end() && it->first.network == network && it->first.gateway == gateway; ++it) {
    if (!adopted_too && adopted_.contains({gateway, it->first.id})) continue;
    if (it->second.taken)
      add(all, it->second.taken->part, gateway);
    else
      all.unreadable = true;
  }
}

const View::OfGateways& View::find_foreign(std::size_t network) const {
  const auto [at, fresh] = found_.try_emplace(network);
  OfGateways& found = at->second;
  if (fresh)
    for (const std::size_t gateway : others_on(network)) found.emplace(gateway, nullptr);
  for (auto& [gateway, of_one] : found) {
    if (of_one) continue;
    Foreign all;
    collect(all, network, gateway, false);
    of_one = std::make_shared<const Foreign>(std::move(all));
  }
  return found;
}

Foreign View::foreign(std::size_t network) const {
  const auto found = std::views::values(find_foreign(network));
  Foreign all;
  all.unreadable = records_.unreadable(network) ||
                   std::ranges::any_of(found, [](const auto& part) { return part->unreadable; });
  const auto join = [&found](auto member, auto& to) {
    std::size_t count = 0;
    for (const auto& part : found) count += ((*part).*member).size();
    to.reserve(count);
    for (const auto& part : found)
      to.insert(to.end(), ((*part).*member).begin(), ((*part).*member).end());
  };
  join(&Foreign::rates, all.rates);
  join(&Foreign::bus, all.bus);
  join(&Foreign::paths, all.paths);
  return all;
}

Foreign View::of_others(std::size_t network) const {
  Foreign all;
  all.unreadable = records_.unreadable(network);
  for (const std::size_t gateway : others_on(network)) collect(all, network, gateway, true);
  return all;
}

/// Of admissions that are not granted yet, others do not hold anything for long.
std::map<std::size_t, MadeFor> View::made_for(std::size_t network) const {
  std::map<std::size_t, MadeFor> all;
  for (const std::size_t gateway : others_on(network)) {
    MadeFor& of_one = all[gateway];
    for (auto it =
             records_.reservations.lower_bound({.network = network, .gateway = gateway, .id = 0});
         it != records_.reservations.end() && it->first.network == network &&
         it->first.gateway == gateway;
         ++it) {
      const auto asked = records_.asked.find({gateway, it->first.id});
      if (asked != records_.asked.end() && asked->second.asked.stage == Stage::prepared) continue;
      const auto other =
          asked == records_.asked.end() ? std::nullopt : asked->second.asked.made_for;
      of_one.all = of_one.all && other;
      if (other) of_one.gateways.insert(*other);
    }
  }
  return all;
}

void View::adopt(std::size_t gateway, std::uint64_t id, bool adopted) {
  if (adopted ? !adopted_.insert({gateway, id}).second : adopted_.erase({gateway, id}) == 0) return;
  for (std::size_t n = 0; n < keys_->networks(); ++n)
    if (records_.reservations.contains({.network = n, .gateway = gateway, .id = id}))
      touch_reservation(n, gateway);
}

Value View::longest_lease(Value own_lease) const {
  Value longest = own_lease;
  for (std::size_t g = 0; g < timers_.size(); ++g)
    if (g != self_ && timers_[g].mod != 0) longest = std::max(longest, timers_[g].lease);
  return longest;
}

Value View::all_leases_end(Value now, Value own_lease) const {
  return may_fence_at(now, longest_lease(own_lease));
}

void View::await_leases(Value now, Value own_lease) {
  leases_end_ = all_leases_end(now, own_lease);
  lawful_end_ = std::min(leases_end_, may_fence_at(now, std::max(own_lease, kMostLease)));
  longest_awaited_ = std::min(longest_lease(own_lease), std::max(own_lease, kMostLease));
}

std::optional<std::size_t> View::with_unread_beat() const {
  for (std::size_t g = 0; g < timers_.size(); ++g)
    if (g != self_ && timers_[g].mod != 0 && !records_.members[g].beat) return g;
  return std::nullopt;
}

std::optional<std::size_t> View::with_too_long_lease() const {
  for (std::size_t g = 0; g < timers_.size(); ++g)
    if (g != self_ && timers_[g].lease > kMostLease) return g;
  return std::nullopt;
}

std::optional<Value> View::next_event(Value now) const {
  std::optional<Value> next;
  const auto at = [&](Value time) {
    if (time > now && (!next || time < *next)) next = time;
  };
  for (std::size_t g = 0; g < timers_.size(); ++g) {
    if (g == self_) continue;
    at(timers_[g].counts_until);
    at(timers_[g].dead_at);
  }
  for (const auto& timer : std::views::values(left_timers_)) at(timer.dead_at);
  if (!dying_.empty()) at(queues_empty_at(now));
  return next;
}

std::vector<std::size_t> View::take_changed() {
  const auto changed = std::exchange(changed_, {});
  return {changed.begin(), changed.end()};
}
std::set<Records::AskedKey> View::take_touched() { return std::exchange(touched_, {}); }

}  // namespace mlcca::core::cluster
