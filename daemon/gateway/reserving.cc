// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/reserving.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "daemon/gateway/quotas.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

constexpr Value kReplaceAgain = 5'000'000'000;  // ns

std::vector<core::AdmissionId> ids_of(const std::vector<control::Request>& requests) {
  std::vector<core::AdmissionId> ids;
  ids.reserve(requests.size());
  for (const control::Request& request : requests) ids.push_back(request.id);
  return ids;
}

/// The footprint that the store has for a reservation of this gateway; nullopt if a part of it
/// cannot be read.
std::optional<core::cluster::Footprint> found_footprint(const core::cluster::View& view,
                                                        std::uint64_t number, std::size_t self) {
  const auto& records = view.records();
  const auto asked = records.asked.find({self, number});
  if (asked == records.asked.end()) return std::nullopt;
  core::cluster::Footprint all{.parts = {}, .gateways = asked->second.asked.gateways};
  for (std::size_t n = 0; n < view.keys().networks(); ++n) {
    const auto it = records.reservations.find({.network = n, .gateway = self, .id = number});
    if (it == records.reservations.end()) continue;
    if (!it->second.taken) return std::nullopt;
    all.parts.push_back(it->second.taken->part);
  }
  return all;
}

/// The gateway for which it is made; nullopt: it is for nobody else.
std::optional<std::size_t> made_for(const cluster::StoredRequest& asked,
                                    const core::cluster::Member& member) {
  if (asked.for_gateway.empty()) return std::nullopt;
  return member.view().keys().gateway(asked.for_gateway);
}

/// With the name of the gateway that has refused, if one has.
Reserving::Refusal refusal_of(const core::cluster::Vote& why, std::optional<std::size_t> by,
                              const core::cluster::Member& member) {
  Reserving::Refusal refusal{
      .why = why.reason, .gateway = why.gateway ? why.gateway : by, .hop = why.hop};
  if (!by) return refusal;
  const std::string name = member.view().keys().gateway_name(*by);
  if (!why.reason.starts_with(name)) refusal.why = name + ": " + why.reason;
  return refusal;
}

}  // namespace

std::string Reserving::bar(uid_t user) const {
  Quotas::Waiting now{.all = jobs_.size()};
  for (const Open& open : jobs_) {
    if (!open.job.user) continue;
    now.of_user += *open.job.user == user ? 1 : 0;
    now.of_others += *open.job.user != 0 ? 1 : 0;
  }
  return Quotas::refuse_waiting(user, now).value_or("");
}

std::unordered_set<core::AdmissionId> Reserving::agreed_admissions() const {
  std::unordered_set<core::AdmissionId> all;
  for (const auto& [number, held] : held_)
    if (held.on_behalf) all.insert(held.admissions.begin(), held.admissions.end());
  return all;
}

std::string Reserving::bar_gateway(std::size_t gateway, const std::string& name) const {
  Quotas::Waiting now;
  for (const Open& open : jobs_) {
    if (!open.job.gateway) continue;
    now.of_user += *open.job.gateway == gateway ? 1 : 0;
    ++now.of_others;
  }
  return Quotas::refuse_waiting_for(name, now).value_or("");
}

bool Reserving::has_own() const {
  return std::ranges::any_of(jobs_, [](const Open& open) { return open.job.is_own(); });
}

bool Reserving::waits_for(const std::string& key) const {
  return std::ranges::any_of(
      jobs_, [&](const Open& open) { return !open.abandoned && open.job.key == key; });
}

bool Reserving::refuse(const std::string& key, const std::string& why) {
  const auto it = std::ranges::find_if(
      jobs_, [&](const Open& open) { return !open.abandoned && open.job.key == key; });
  if (it == jobs_.end()) return false;
  const Job job = it->job;
  it->abandoned = true;
  if (!it->asked) jobs_.erase(it);
  job.refused({.why = why});
  return true;
}

void Reserving::ask(Job job, Value now) {
  jobs_.push_back({.job = std::move(job), .number = next_++, .since = now});
}

Reserving::Jobs::iterator Reserving::find(Number number) {
  return std::ranges::find(jobs_, number, &Open::number);
}

bool Reserving::has(Number number) const {
  return held_.contains(number) || std::ranges::any_of(jobs_, [number](const Open& open) {
           return open.number == number && open.asked && !open.abandoned;
         });
}

void Reserving::forget(Number adopted) {
  for (auto it = jobs_.begin(); it != jobs_.end();) {
    const bool concerned = it->job.gateway && it->job.adopted == adopted;
    it->abandoned = it->abandoned || concerned;
    it = concerned && !it->asked ? jobs_.erase(it) : std::next(it);
  }
}

void Reserving::session_closed(std::uint64_t session) {
  for (auto it = jobs_.begin(); it != jobs_.end();) {
    const bool concerned = it->job.session != 0 && it->job.session == session;
    it->abandoned = it->abandoned || concerned;
    it = concerned && !it->asked ? jobs_.erase(it) : std::next(it);
  }
}

void Reserving::refuse_all(const std::string& why, const std::string& to_do) {
  for (const Open& open : std::exchange(jobs_, {})) {
    parts_.networks.drop(open.number);
    if (!open.abandoned) open.job.refused({.why = open.job.user ? why + to_do : why});
  }
}

/// Ends the use of a reservation. Others have it after the gates have closed and the store says so.
void Reserving::give_back(Number number) {
  held_.erase(number);
  outdated_.erase(number);
  agreements_changed_ = true;
  if (const auto* const there = parts_.networks.footprint(number))
    parts_.networks.count(number, *there, parts_.networks.permits().self());
  to_release_.push_back(number);
  parts_.ended(number);
}

void Reserving::release_closed(core::cluster::Member& member, Value now) {
  if (to_release_.empty() || !parts_.bring_in_line()) return;
  for (const Number number : std::exchange(to_release_, {})) {
    leaving_.push_back(number);
    member.release(number, now);
  }
}

void Reserving::admissions_gone(const std::vector<core::AdmissionId>& gone) {
  // What counted together with their publishers has to be counted separately now.
  parts_.networks.touch_all();
  for (auto& [number, held] : held_) leave(number, held, gone);
  for (Open& open : jobs_)
    if (open.asked) open.gone.insert(open.gone.end(), gone.begin(), gone.end());
}

/// These admissions have ended, which may be named by that reservation.
void Reserving::leave(Number number, Held& held, const std::vector<core::AdmissionId>& gone) {
  for (auto* const ids : {&held.admissions, &held.also})
    if (std::erase_if(*ids, [&](core::AdmissionId id) {
          return std::ranges::find(gone, id) != gone.end();
        }) != 0) {
      outdated_.try_emplace(number);
      unused_ = true;
    }
}

/// `gone`: admissions that have ended since that was asked for.
void Reserving::hold(Number number, const core::cluster::Footprint& footprint,
                     const cluster::StoredRequest& asked,
                     const std::vector<core::AdmissionId>& gone) {
  Held held{.channel = asked.channel,
            .admissions = ids_of(asked.requests),
            .also = ids_of(asked.also),
            .on_behalf = asked.on_behalf,
            .for_gateway = asked.for_gateway,
            .for_number = asked.for_number};
  parts_.networks.hold(number, footprint, held.admissions);
  leave(number, held, gone);
  held_.insert_or_assign(number, std::move(held));
  agreements_changed_ = true;
}

void Reserving::begin(Open& open, core::cluster::Member& member, Value now) {
  open.asked = true;
  open.gone.clear();
  parts_.networks.count(open.number, open.wish.footprint, member.self());
  parts_.networks.leave_out(open.number);
  member.reserve({.id = open.number,
                  .footprint = open.wish.footprint,
                  .channel = open.wish.asked.channel,
                  .publisher = open.wish.publisher,
                  .admission = cluster::text_of(open.wish.asked),
                  .made_for = made_for(open.wish.asked, member)},
                 now);
}

void Reserving::put_in_force(const Open& open) {
  hold(open.number, open.wish.footprint, open.wish.asked, open.gone);
  // The publisher of the channel may have been admitted together with it.
  parts_.networks.leave_out(open.number);
  static_cast<void>(parts_.bring_in_line());
  const bool withdrawn = !open.withdrawn.why.empty();
  const bool used = !withdrawn && !open.abandoned && open.job.granted();
  parts_.networks.leave_out(std::nullopt);
  if (used) return;
  give_back(open.number);
  if (!withdrawn || open.abandoned) return;
  Refusal why = open.withdrawn;
  if (!open.wish.asked.on_behalf) why.why.insert(0, "what was reserved for it was withdrawn: ");
  open.job.refused(why);
}

void Reserving::on(const core::cluster::Reserved& event, const core::cluster::Member& /*member*/) {
  const auto it = find(event.id);
  if (it == jobs_.end()) {
    give_back(event.id);
    return;
  }
  const Open open = std::move(*it);
  jobs_.erase(it);
  parts_.networks.leave_out(std::nullopt);
  put_in_force(open);
}

void Reserving::on(const core::cluster::Conflict& event, core::cluster::Member& member, Value now) {
  const auto it = find(event.id);
  if (it == jobs_.end()) {
    member.release(event.id, now);
    return;
  }
  parts_.networks.leave_out(event.id);
  static_cast<void>(parts_.bring_in_line());
  auto wish = it->abandoned ? std::nullopt : it->job.decide();
  if (wish) {
    it->wish = std::move(*wish);
    begin(*it, member, now);
    return;
  }
  parts_.networks.drop(event.id);
  parts_.networks.leave_out(std::nullopt);
  jobs_.erase(it);
  member.release(event.id, now);
}

void Reserving::on(const core::cluster::Refused& event, const core::cluster::Member& member) {
  leaving_.push_back(event.id);
  const auto it = find(event.id);
  if (it == jobs_.end()) return;
  const Open open = std::move(*it);
  jobs_.erase(it);
  parts_.networks.leave_out(std::nullopt);
  parts_.ended(event.id);
  if (open.abandoned) return;
  const bool for_good = event.by && event.why.final && open.job.refused_for_good;
  const auto& refused = for_good ? open.job.refused_for_good : open.job.refused;
  refused(refusal_of(event.why, event.by, member));
}

void Reserving::on(const core::cluster::Withdrawn& event, const core::cluster::Member& member) {
  const Refusal why = refusal_of(event.why, event.by, member);
  // The reservation was made and withdrawn before this gateway had put it in force.
  if (const auto job = find(event.id); job != jobs_.end()) job->withdrawn = why;
  const auto it = held_.find(event.id);
  if (it == held_.end()) return;
  const Held held = it->second;
  if (!held.on_behalf) {
    parts_.log("what " + held.channel + " had reserved is withdrawn: " + why.why);
    if (const auto* const there = parts_.networks.footprint(event.id); there != nullptr)
      parts_.objected(held.channel, there->gateways, why);
  }
  give_back(event.id);
  parts_.withdrawn(held.admissions, held.on_behalf && event.by && event.why.final, why);
}

void Reserving::on(const core::cluster::Found& event, const core::cluster::Member& member,
                   const std::function<bool(const cluster::StoredRequest&)>& known) {
  if (held_.contains(event.id)) return;
  auto asked = cluster::asked_in(event.admission);
  const auto footprint = found_footprint(member.view(), event.id, member.self());
  if (!asked || !footprint || !known(*asked)) {
    give_back(event.id);
    return;
  }
  hold(event.id, *footprint, *asked, {});
}

void Reserving::lost() {
  agreements_changed_ = true;
  outdated_.clear();
  for (const auto& [number, held] : std::exchange(held_, {})) parts_.networks.drop(number);
  for (const Number number : std::exchange(leaving_, {})) parts_.networks.drop(number);
  for (const Number number : std::exchange(to_release_, {})) parts_.networks.drop(number);
}

bool Reserving::step(core::cluster::Member& member, Value now) {
  if (std::exchange(unused_, false)) tidy();
  release_closed(member, now);
  std::erase_if(leaving_, [&](Number number) {
    if (member.knows(number)) return false;
    parts_.networks.drop(number);
    return true;
  });
  for (auto it = jobs_.begin(); it != jobs_.end();) {
    if (it->asked || it->job.gateway || now < add_saturating(it->since, kPatience)) {
      ++it;
      continue;
    }
    const Open open = std::move(*it);
    it = jobs_.erase(it);
    open.job.refused({.why = why_waiting(member, now)});
  }
  replace_outdated(now);
  const auto next = next_turn();
  if (next == jobs_.end() || !member.why_not(now).empty() || !parts_.in_the_way().empty())
    return false;
  note_turn(next->job);
  parts_.networks.leave_out(std::nullopt);
  static_cast<void>(parts_.bring_in_line());
  auto wish = next->job.decide();
  if (!wish) {
    jobs_.erase(next);
    return true;
  }
  if (wish->asked.size() > cluster::StoredRequest::kMostRequests ||
      cluster::text_of(wish->asked).size() > kMostText) {
    next->job.refused({.why = "what is asked for is too long for the store"});
    jobs_.erase(next);
    return true;
  }
  next->wish = std::move(*wish);
  begin(*next, member, now);
  return true;
}

std::string Reserving::why_waiting(const core::cluster::Member& member, Value now) const {
  if (std::string why = parts_.in_the_way(); !why.empty()) return why;
  if (std::ranges::any_of(jobs_, &Open::asked))
    return "others are decided before it, or the store does not answer";
  const std::string why = member.why_not(now);
  return why.empty() ? "others are decided before it" : why;
}

/// Does nothing while networks are closed: channels that are closed for a time use nothing, but
/// will need their reservations again.
void Reserving::tidy() {
  if (!parts_.networks.permits().is_open()) return;
  std::vector<Number> over;
  for (const auto& [number, held] : held_)
    if (is_over(number, held)) over.push_back(number);
  for (const Number number : over) give_back(number);
}

/// What was made for another gateway ends when that one does not ask for it any more.
bool Reserving::is_over(Number number, const Held& held) const {
  const bool may_be =
      held.admissions.empty() || (outdated_.contains(number) && held.for_gateway.empty());
  return may_be && !parts_.needs(number, held);
}

/// Where an admission has ended, other gateways still know it by a reservation that others use as
/// well. A smaller one is reserved in its place, under a number of its own, and the former one is
/// given back when that is in force: so what is still granted continues. One after the other.
void Reserving::replace_outdated(Value now) {
  const auto next =
      std::ranges::min_element(outdated_, {}, [](const auto& one) { return one.second.again; });
  if (next == outdated_.end() || next->second.again > now || !parts_.networks.permits().is_open() ||
      std::ranges::any_of(jobs_, [](const Open& open) { return open.job.replaces != 0; }))
    return;
  const Number number = next->first;
  next->second.again = add_saturating(now, kReplaceAgain);
  ask({.decide = [this, number]() -> std::optional<Wish> {
         const auto held = held_.find(number);
         return held == held_.end() ? std::nullopt : parts_.rest(number, held->second);
       },
       .granted =
           [this, number] {
             if (held_.contains(number)) give_back(number);
             return true;
           },
       .refused = [this, number](const Refusal& why) { keep_outdated(number, why.why); },
       .replaces = number},
      now);
}

/// It is tried again.
void Reserving::keep_outdated(Number number, const std::string& why) {
  const auto held = held_.find(number);
  const auto outdated = outdated_.find(number);
  if (held == held_.end() || outdated == outdated_.end()) return;
  if (!std::exchange(outdated->second.said, true))
    parts_.log("other gateways still keep open what has ended of " + held->second.channel + ": " +
               why);
}

Reserving::Turn Reserving::turn_of(const Job& job) {
  return {job.gateway.has_value(), job.user.value_or(0)};
}

void Reserving::note_turn(const Job& job) {
  latest_own_ = job.is_own();
  if (!latest_own_) latest_ = turn_of(job);
  if (job.gateway) latest_gateway_ = job.gateway;
}

/// Nobody has to wait for all jobs of another user or gateway. A gateway that asks for a lot takes
/// turns with other gateways, so that all of them together have one turn for one of each user.
/// Those of this gateway itself come next, but never two in a row while others wait.
Reserving::Jobs::iterator Reserving::next_turn() {
  const auto order = [this](const Job& job) {
    const unsigned own_rank = latest_own_ ? 2 : 0;
    const unsigned rank = job.is_own() ? own_rank : 1;
    const Turn turn = turn_of(job);
    return std::tuple(rank, latest_ && turn <= *latest_, turn,
                      latest_gateway_ && job.gateway && *job.gateway <= *latest_gateway_,
                      job.gateway);
  };
  auto next = jobs_.end();
  for (auto it = jobs_.begin(); it != jobs_.end(); ++it)
    if (!it->asked && (next == jobs_.end() || order(it->job) < order(next->job))) next = it;
  return next;
}

std::optional<Value> Reserving::next_time() const {
  std::optional<Value> next;
  for (const Open& open : jobs_) {
    if (open.asked || open.job.gateway) continue;
    const Value end = add_saturating(open.since, kPatience);
    if (!next || end < *next) next = end;
  }
  return next;
}

}  // namespace mlcca
