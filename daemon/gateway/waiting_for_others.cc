// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/waiting_for_others.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <variant>

#include "daemon/gateway/requests/elsewhere.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

constexpr Value kEndAgain = 10'000'000'000;      // when the disk has refused
constexpr Value kFirstPause = 5'000'000'000;     // when another gateway does not agree
constexpr Value kLongestPause = 30'000'000'000;  // ns

}  // namespace

/// What another gateway has admitted for this one is in the state as long as it is held. Otherwise
/// it could be granted by what that gateway carries for other subscribers here. `is_in_force`: the
/// state is in force; otherwise all of it is about to be decided. Returns the rules that the gates
/// had for what has to wait; Turn::settle() or Turn::enforce() has to follow.
core::FormerRules WaitingForOthers::follow_agreements(bool is_in_force) {
  const auto& through = parts_.recorder.contents().admissions.through_others();
  if (through.empty()) return {};
  const auto held = parts_.session.reserving->agreed_admissions();
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
void WaitingForOthers::give_back_without_place() {
  if (!without_place_since_) return;
  parts_.session.reserving->follow_agreements();
  if (now() < add_saturating(*without_place_since_, kLongestPause)) return;
  without_place_since_.reset();
  std::vector<core::AdmissionId> gone;
  for (const core::AdmissionId id : parts_.session.reserving->agreed_admissions())
    if (parts_.admissions.waits(id) && !is_taken_in(id)) gone.push_back(id);
  parts_.session.reserving->admissions_gone(gone);
}

std::string WaitingForOthers::why_waits(core::AdmissionId id, const std::string& gateway) const {
  if (parts_.is_drained()) return "this gateway is drained";
  const auto why = why_waits_.find(id);
  if (why == why_waits_.end()) return fmt::format("it waits for gateway {}", gateway);
  const std::string& words = why->second.why;
  if (why->second.here) return words;
  const std::string own = gateway + ": ";
  return fmt::format("it waits for gateway {}: {}", gateway,
                     words.starts_with(own) ? words.substr(own.size()) : words);
}

void WaitingForOthers::note_lost(const std::string& why) {
  for (const auto& [id, gateway] : parts_.recorder.contents().admissions.through_others())
    why_waits_[id] = {.why = why};
}

void WaitingForOthers::forget(const std::vector<core::AdmissionId>& gone) {
  for (const core::AdmissionId id : gone) {
    pauses_.erase(id);
    why_waits_.erase(id);
  }
}

/// What another gateway has not agreed to is asked for again, later each time, unless it had agreed
/// for a while.
void WaitingForOthers::note_refusal(core::AdmissionId id, const std::string& why) {
  const auto& recorded = parts_.recorder.contents().admissions;
  if (recorded.find(id) == nullptr || recorded.through(id).empty()) return;
  pause(id);
  why_waits_[id] = {.why = why};
  if (parts_.admissions.waits(id))
    static_cast<void>(
        parts_.admissions.let_wait({{.id = id, .why = why_waits(id, recorded.through(id))}}));
}

void WaitingForOthers::pause(core::AdmissionId id) {
  Pause& pause = pauses_[id];
  const bool is_recent = now() < add_saturating(pause.until, kLongestPause);
  pause.length = is_recent ? std::clamp(2 * pause.length, kFirstPause, kLongestPause) : kFirstPause;
  pause.until = add_saturating(now(), pause.length);
}

/// Whether the state has what the other gateway has agreed to. There may be no place for it now,
/// for example as long as other channels that are not described take all that there are.
bool WaitingForOthers::is_taken_in(core::AdmissionId id) {
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
bool WaitingForOthers::ask_for_one() {
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
    if (gateway == gateways.end() || index == parts_.session.self) {
      end_without_gateway(id, name);
      continue;
    }
    if ((next && next->since <= since) || !parts_.session.is_there(index, now())) continue;
    next = Due{.since = since, .id = id, .gateway = index};
  }
  if (next) ask_again(next->id, next->gateway);
  return next.has_value();
}

/// The description in force has no such gateway. The next one may have it again.
void WaitingForOthers::end_without_gateway(core::AdmissionId id, const std::string& name) {
  const bool is_rolled_out = parts_.session.member->view().records().next.mod != 0;
  if (is_rolled_out)
    note_refusal(id,
                 "it is no other gateway by the description in force, and another one is being "
                 "rolled out");
  else
    withdrawn_[id].why = fmt::format("{}, where its publisher was, is no other gateway", name);
}

void WaitingForOthers::ask_again(core::AdmissionId id, std::size_t gateway) {
  const auto decide = [this, id, gateway]() -> std::optional<Reserving::Wish> {
    const auto* const there = parts_.recorder.contents().admissions.find(id);
    if (there == nullptr || !parts_.admissions.waits(id)) return std::nullopt;
    const std::string& named = std::get<control::Admit>(there->body).channel;
    const auto channel = state().find_channel(named);
    return requests::wish_elsewhere(channel ? state().system().channels[*channel].name : named,
                                    *there, gateway);
  };
  const auto granted = [this, id] { return is_taken_in(id); };
  const auto refused = [this, id](const Reserving::Refusal& why) { note_refusal(id, why.why); };
  const auto refused_for_good = [this, id](const Reserving::Refusal& why) {
    withdrawn_.try_emplace(id, Withdrawn{.why = why.why});
  };
  parts_.ask({.decide = decide,
              .granted = granted,
              .refused = refused,
              .refused_for_good = refused_for_good});
}

/// Ends what other gateways do not make for this one any more. What cannot be written down is tried
/// again later.
void WaitingForOthers::end_withdrawn() {
  for (auto it = withdrawn_.begin(); it != withdrawn_.end();) {
    auto& [id, one] = *it;
    const bool is_due = now() >= one.at;
    if (is_due) one.at = add_saturating(now(), kEndAgain);
    const bool is_over = is_due && (parts_.recorder.contents().admissions.find(id) == nullptr ||
                                    parts_.admissions.release({id}, one.why));
    it = is_over ? withdrawn_.erase(it) : std::next(it);
  }
}

}  // namespace mlcca
