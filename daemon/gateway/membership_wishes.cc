// SPDX-License-Identifier: BSD-2-Clause
// The wishes of this gateway: reservations on shared networks for channels that exist already.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <set>
#include <utility>
#include <variant>
#include <vector>

#include "control/protobuf.hpp"
#include "core/admission/permit_check.hpp"
#include "core/cluster/footprint.hpp"
#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/requests/elsewhere.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

constexpr Value kWishAgain = 2'000'000'000;          // when it may fit
constexpr Value kRefusedWishAgain = 5'000'000'000;   // ns
constexpr Value kEndAgain = 10'000'000'000;          // when the disk has refused
constexpr Value kFirstPause = 5'000'000'000;         // when another gateway does not agree
constexpr Value kLongestPause = 30'000'000'000;      // ns
constexpr Value kGrantedWishAgain = 60'000'000'000;  // after a grant with which it should fit
constexpr std::size_t kRequestOctets = 16;           // of a request in a text, beside its own
constexpr core::AdmissionId kMostNumber = std::uint64_t{1} << 53U;  // no gateway makes as many

/// Other gateways agree to described deliveries by the description.
bool is_asked_for(const core::cluster::Footprint& footprint, const cluster::StoredRequest& asked) {
  return !footprint.parts.empty() || (!footprint.gateways.empty() && !asked.requests.empty());
}

}  // namespace

/// Asks for a channel that would be given more with a reservation: one that has lost its
/// reservation, or for which others leave more room than the description promises. It waits for its
/// turn while another admission is decided. It takes turns with what other gateways are asked for
/// again, since each of them may take until all patience is over. True if one was asked for.
bool Membership::wish_some() {
  if (!joined_ || leaving_ || !looks_for_wishes_ || reserving_->has_own() || !standing().empty() ||
      !networks_->permits().is_open())
    return false;
  const bool wishes_first = std::exchange(asked_again_, false);
  if (wishes_first && wish_one()) return true;
  asked_again_ = ask_again_some();
  if (asked_again_ || (!wishes_first && wish_one())) return true;
  looks_for_wishes_ = false;
  return false;
}

bool Membership::wish_one() {
  const std::vector<std::size_t> wishes = state().wishes();
  const auto due = std::ranges::find_if(wishes, [this](std::size_t channel) {
    const auto again = wish_again_.find(state().system().channels[channel].name);
    return again == wish_again_.end() || again->second <= now();
  });
  if (due == wishes.end()) return false;
  wish(*due);
  return true;
}

/// Even what was tried a short time ago: a gateway has failed, for example, and what it carried is
/// to be reserved now.
void Membership::wish_anew() {
  wish_again_.clear();
  want_again_.clear();
  looks_for_wishes_ = true;
}

void Membership::forget_past_pauses() {
  const auto is_past = [this](const auto& entry) { return entry.second <= now(); };
  std::erase_if(wish_again_, is_past);
  std::erase_if(want_again_, is_past);
}

/// Asks for one want of the channel at a time.
void Membership::wish(std::size_t channel) {
  const std::string name = state().system().channels[channel].name;
  wish_again_[name] = add_saturating(now(), kWishAgain);
  const auto wished = std::make_shared<Wished>();
  const auto again_in = [this, name, wished](Value time) {
    want_again_[{name, wished->gateways}] = add_saturating(now(), time);
    wish_again_.erase(name);
  };
  ask({.decide = [this, name, wished] { return wish_next(name, *wished); },
       .granted =
           [this, name, wished, again_in] {
             again_in(wished->all ? kGrantedWishAgain : 0);
             return is_granted(name, *wished);
           },
       .refused =
           [this, name, again_in](const std::string& why) {
             again_in(kRefusedWishAgain);
             parts_.log.info(Kind::gateway, name + " waits: " + why);
           }});
}

/// Those of which a gateway on the way is not there wait, and the others take turns.
std::optional<Reserving::Wish> Membership::wish_next(const std::string& channel, Wished& wished) {
  const auto there = state().find_channel(channel);
  if (!there) return std::nullopt;
  const core::Proposal proposal = state().wish(*there);
  if (!proposal.fit()) return std::nullopt;
  for (core::cluster::Want& want : core::cluster::wants_of(proposal, self_)) {
    const auto again = want_again_.find({channel, want.gateways});
    const bool is_due = again == want_again_.end() || again->second <= now();
    if (!is_due || !are_there(want.gateways)) continue;
    const std::size_t wanted = want.deliveries.size();
    auto wish = wish_of(channel, proposal, want);
    if (!wish) continue;
    wished = {.gateways = want.gateways, .deliveries = {}, .all = want.deliveries.size() == wanted};
    for (const core::Verdict* const v : want.deliveries)
      wished.deliveries.push_back(state().delivery_of(*v));
    return wish;
  }
  wish_again_[channel] = add_saturating(now(), kRefusedWishAgain);
  return std::nullopt;
}

bool Membership::is_granted(const std::string& channel, const Wished& wished) const {
  const auto there = state().find_channel(channel);
  return there &&
         std::ranges::any_of(state().decisions()[*there].verdicts, [&](const core::Verdict& v) {
           return v.granted && std::ranges::find(wished.deliveries, state().delivery_of(v)) !=
                                   wished.deliveries.end();
         });
}

/// nullopt: there is nothing to reserve, and nobody to ask.
std::optional<Reserving::Wish> Membership::wish_of(const std::string& channel,
                                                   const core::Proposal& proposal,
                                                   core::cluster::Want& want) const {
  cluster::StoredRequest asked = asked_of(channel, want);
  auto footprint = core::cluster::footprint_of(proposal, want.deliveries, baseline(), self_);
  if (!is_asked_for(footprint, asked)) return std::nullopt;
  add_publishers(footprint, asked);
  return Reserving::Wish{
      .footprint = std::move(footprint), .publisher = {}, .asked = std::move(asked)};
}

/// What another gateway has admitted for this one is in the state as long as it is held. Otherwise
/// it could be granted by what that gateway carries for other subscribers here. `is_in_force`: the
/// state is in force; otherwise all of it is about to be decided. Returns the rules that the gates
/// had for what has to wait; Turn::settle() or Turn::enforce() has to follow.
core::FormerRules Membership::follow_agreements(bool is_in_force) {
  const auto& through = parts_.recorder.contents().admissions.through_others();
  if (through.empty()) return {};
  const auto held = reserving_->agreed_admissions();
  std::vector<Admissions::Waiting> lost;
  std::vector<core::AdmissionId> agreed;
  for (const auto& [id, gateway] : through) {
    const bool is_held = held.contains(id);
    const bool is_there = state().admissions().contains(id);
    const bool waits = parts_.admissions.waits(id);
    if (is_held) why_waits_.erase(id);
    if (is_held && is_there)
      parts_.admissions.forget_wait(id);
    else if (is_held && (waits || !is_in_force))
      agreed.push_back(id);
    else if (!is_held && (is_there || waits))
      lost.push_back(
          {.id = id,
           .why = why_waits(id, gateway),
           .log = (is_there || !parts_.admissions.has_said(id)) && !withdrawn_.contains(id)});
  }
  if (parts_.admissions.end_wait(agreed, is_in_force))
    without_place_since_.reset();
  else if (!without_place_since_)
    without_place_since_ = now();
  return lost.empty() ? core::FormerRules() : parts_.admissions.let_wait(lost);
}

/// What was agreed to has had no place for a while. It may have one again, but until then other
/// gateways may use what is held for it: it is asked for again later.
void Membership::give_back_without_place() {
  if (!without_place_since_) return;
  reserving_->follow_agreements();
  if (now() < add_saturating(*without_place_since_, kLongestPause)) return;
  without_place_since_.reset();
  std::vector<core::AdmissionId> gone;
  for (const core::AdmissionId id : reserving_->agreed_admissions())
    if (parts_.admissions.waits(id) && !is_taken_in(id)) gone.push_back(id);
  reserving_->admissions_gone(gone);
}

std::string Membership::why_waits(core::AdmissionId id, const std::string& gateway) const {
  if (drained_) return "this gateway is drained";
  const auto why = why_waits_.find(id);
  if (why == why_waits_.end()) return fmt::format("it waits for gateway {}", gateway);
  const std::string& words = why->second.why;
  if (why->second.here) return words;
  const std::string own = gateway + ": ";
  return fmt::format("it waits for gateway {}: {}", gateway,
                     words.starts_with(own) ? words.substr(own.size()) : words);
}

void Membership::note_lost(const std::string& why) {
  for (const auto& [id, gateway] : parts_.recorder.contents().admissions.through_others())
    why_waits_[id] = {.why = why};
}

void Membership::forget_waits(const std::vector<core::AdmissionId>& gone) {
  for (const core::AdmissionId id : gone) {
    pauses_.erase(id);
    why_waits_.erase(id);
  }
}

/// What another gateway has not agreed to is asked for again, later each time, unless it had agreed
/// for a while.
void Membership::note_refusal(core::AdmissionId id, const std::string& why) {
  const auto& recorded = parts_.recorder.contents().admissions;
  if (recorded.find(id) == nullptr || recorded.through(id).empty()) return;
  pause(id);
  why_waits_[id] = {.why = why};
  if (parts_.admissions.waits(id))
    static_cast<void>(
        parts_.admissions.let_wait({{.id = id, .why = why_waits(id, recorded.through(id))}}));
}

void Membership::pause(core::AdmissionId id) {
  Pause& pause = pauses_[id];
  const bool is_recent = now() < add_saturating(pause.until, kLongestPause);
  pause.length = is_recent ? std::clamp(2 * pause.length, kFirstPause, kLongestPause) : kFirstPause;
  pause.until = add_saturating(now(), pause.length);
}

/// Whether the state has what the other gateway has agreed to. There may be no place for it now,
/// for example as long as other channels that are not described take all that there are.
bool Membership::is_taken_in(core::AdmissionId id) {
  if (state().admissions().contains(id)) return true;
  const auto& left_out = parts_.admissions.left_out();
  if (const auto why = left_out.find(id); why != left_out.end()) {
    pause(id);
    why_waits_[id] = {.why = why->second.reason, .here = true};
  }
  return false;
}

/// Asks for an admission that another gateway has to make for this one again: this gateway was not
/// there, or that one does not agree for a while. The one that has waited for its turn longest is
/// the next. True if one was asked for.
bool Membership::ask_again_some() {
  const auto& gateways = state().system().gateways;
  struct Due {
    Value since = 0;
    core::AdmissionId id = 0;
    std::size_t gateway = 0;
  };
  std::optional<Due> next;
  for (const auto& [id, name] : parts_.recorder.contents().admissions.through_others()) {
    if (!parts_.admissions.waits(id) || withdrawn_.contains(id)) continue;
    const auto gateway = std::ranges::find(gateways, name, &core::Gateway::name);
    const auto index = static_cast<std::size_t>(gateway - gateways.begin());
    const auto pause = pauses_.find(id);
    const Value since = pause == pauses_.end() ? 0 : pause->second.until;
    if (since > now()) continue;
    if (gateway == gateways.end() || index == self_) {
      end_without_gateway(id, name);
      continue;
    }
    if ((next && next->since <= since) || !is_there(index)) continue;
    next = Due{.since = since, .id = id, .gateway = index};
  }
  if (next) ask_again(next->id, next->gateway);
  return next.has_value();
}

/// The description in force has no such gateway. The next one may have it again.
void Membership::end_without_gateway(core::AdmissionId id, const std::string& name) {
  const bool is_rolled_out = member_->view().records().next.mod != 0;
  if (is_rolled_out)
    note_refusal(id,
                 "it is no other gateway by the description in force, and another one is being "
                 "rolled out");
  else
    withdrawn_[id].why = fmt::format("{}, where its publisher was, is no other gateway", name);
}

bool Membership::are_there(const std::vector<std::size_t>& gateways) const {
  return std::ranges::all_of(gateways, [this](std::size_t g) { return is_there(g); });
}

/// Also one that leaves to others what they can carry: it decides all the same.
bool Membership::is_there(std::size_t gateway) const {
  using core::cluster::Alive;
  const Alive alive = member_->view().alive(gateway, now());
  return alive == Alive::present || alive == Alive::standby;
}

void Membership::ask_again(core::AdmissionId id, std::size_t gateway) {
  const auto decide = [this, id, gateway]() -> std::optional<Reserving::Wish> {
    const auto* const there = parts_.recorder.contents().admissions.find(id);
    if (there == nullptr || !parts_.admissions.waits(id)) return std::nullopt;
    const std::string& named = std::get<control::Admit>(there->body).channel;
    const auto channel = state().find_channel(named);
    return requests::wish_elsewhere(channel ? state().system().channels[*channel].name : named,
                                    *there, gateway);
  };
  const auto granted = [this, id] { return is_taken_in(id); };
  const auto refused = [this, id](const std::string& why) { note_refusal(id, why); };
  const auto refused_for_good = [this, id](const std::string& why) {
    withdrawn_.try_emplace(id, Withdrawn{.why = why});
  };
  ask({.decide = decide,
       .granted = granted,
       .refused = refused,
       .refused_for_good = refused_for_good});
}

/// Ends what other gateways do not make for this one any more. What cannot be written down is tried
/// again later.
void Membership::end_withdrawn() {
  for (auto it = withdrawn_.begin(); it != withdrawn_.end();) {
    auto& [id, one] = *it;
    const bool is_due = now() >= one.at;
    if (is_due) one.at = add_saturating(now(), kEndAgain);
    const bool is_over = is_due && (parts_.recorder.contents().admissions.find(id) == nullptr ||
                                    parts_.release({id}, one.why));
    it = is_over ? withdrawn_.erase(it) : std::next(it);
  }
}

/// The admissions to which other gateways have to agree, or those of the publishers where none has
/// to. What another gateway has admitted for this
/// one is not asked for here. Deliveries for which there is no room leave the want.
cluster::StoredRequest Membership::asked_of(const std::string& channel,
                                            core::cluster::Want& want) const {
  cluster::StoredRequest asked{.channel = channel, .requests = {}};
  const auto& recorded = parts_.recorder.contents().admissions;
  const core::Members& members = state().members();
  std::set<core::AdmissionId> counted;
  std::set<core::AdmissionId> agreeing;
  std::size_t octets = 0;
  for (auto it = want.deliveries.begin(); it != want.deliveries.end(); ++it) {
    std::vector<control::Request> further;
    const auto add = [&](core::AdmissionId id, bool is_asked) {
      const control::Request* const request = id == 0 ? nullptr : recorded.find(id);
      if (request == nullptr || !recorded.through(id).empty()) return;
      if (counted.insert(id).second) octets += control::bytes_of(*request).size() + kRequestOctets;
      if (is_asked && agreeing.insert(id).second) further.push_back(*request);
    };
    const bool crosses_others = !want.gateways.empty();
    if (crosses_others)
      for (const core::AdmissionId id : core::admissions_to_agree(members, **it)) add(id, true);
    // Where others have to agree, add_publishers() adds it.
    add(members.admission_of_publisher((*it)->publisher), !crosses_others);
    const bool has_room =
        counted.size() <= cluster::StoredRequest::kMostRequests && octets <= Reserving::kMostText;
    if (!has_room && it != want.deliveries.begin()) {
      want.deliveries.erase(it, want.deliveries.end());
      break;
    }
    std::ranges::move(further, std::back_inserter(asked.requests));
  }
  return asked;
}

void Membership::add_publishers(const core::cluster::Footprint& footprint,
                                cluster::StoredRequest& to) const {
  const auto has = [](const std::vector<control::Request>& all, core::AdmissionId id) {
    return std::ranges::find(all, id, &control::Request::id) != all.end();
  };
  for (const core::cluster::Part& part : footprint.parts)
    for (const core::cluster::RatePart& rate : part.rates) {
      const core::AdmissionId id = rate.source.admission;
      if (id == 0 || has(to.requests, id) || has(to.also, id)) continue;
      const auto* const request = parts_.recorder.contents().admissions.find(id);
      if (request != nullptr) to.also.push_back(*request);
    }
}

bool Membership::is_known(const cluster::StoredRequest& asked) const {
  const auto known = [&](const control::Request& request) {
    // Another gateway was asked for the subscriber alone.
    if (asked.on_behalf) return !parts_.recorder.contents().admissions.through(request.id).empty();
    const auto* const there = parts_.recorder.contents().admissions.find(request.id);
    return there != nullptr && *there == request;
  };
  // What another gateway was asked for is not in the state yet, and so is its channel if it is not
  // described.
  return (asked.on_behalf || state().find_channel(asked.channel)) &&
         std::ranges::all_of(asked.requests, known) && std::ranges::all_of(asked.also, known);
}

/// Without its former journal, this gateway would give numbers again that the store still has for
/// other admissions of it. The store would count both as the same traffic. Where it has given one
/// again before it knew the store, nothing more is reserved until the former one has left.
void Membership::take_former_numbers() {
  former_.clear();
  const auto& recorded = parts_.recorder.contents().admissions;
  const auto& asked = member_->view().records().asked;
  for (auto it = asked.lower_bound({self_, 0}); it != asked.end() && it->first.first == self_;
       ++it) {
    const auto former = cluster::asked_in(it->second.asked.admission);
    if (!former) continue;
    bool is_given_again = false;
    for (const auto* all : {&former->requests, &former->also})
      for (const control::Request& request : *all) {
        const control::Request* const now = recorded.find(request.id);
        is_given_again = is_given_again || (now != nullptr && *now != request) ||
                         parts_.recorder.is_set_aside(request.id);
        if (request.id <= kMostNumber) parts_.recorder.pass_over(request.id);
      }
    if (is_given_again && !former->on_behalf) former_.push_back(it->first.second);
  }
}

std::string Membership::former_in_the_way() {
  std::erase_if(former_, [this](Number number) {
    return !member_->view().records().asked.contains({self_, number});
  });
  if (former_.empty()) return {};
  return "the store still has admissions of this gateway from before its journal was lost, with "
         "the same numbers: ask again in a few seconds";
}

/// Whether the channel uses something that only this reservation allows.
bool Membership::needs(const std::string& channel, Number number) const {
  const auto there = state().find_channel(channel);
  if (!there) return false;
  const auto used = core::cluster::footprint_of(state(), *there, baseline(), self_);
  return std::ranges::any_of(used.parts, [&](const core::cluster::Part& part) {
    return std::ranges::any_of(part.rates, [&](const core::cluster::RatePart& rate) {
      const auto bus = std::ranges::find(part.bus, rate.source, &core::cluster::BusPart::source);
      std::vector<core::cluster::PathPart> paths;
      for (const auto& path : part.paths)
        if (path.source == rate.source) paths.push_back(path);
      return !networks_->permits().allow(
          {.network = part.network,
           .source = rate.source,
           .bytes_per_second = rate.bytes_per_second,
           .message = bus == part.bus.end() ? nullptr : &bus->message,
           .paths = paths},
          number);
    });
  });
}

}  // namespace mlcca
