// SPDX-License-Identifier: BSD-2-Clause
// A proposal: an admission that is tried out and then accepted or dropped.
#include <algorithm>
#include <cassert>
#include <utility>

#include "core/admission/state.hpp"

namespace mlcca::core {

Proposal::Proposal(State& state, Admission admission, Kind kind)
    : state_(&state),
      id_(admission.id),
      channel_(admission.channel),
      before_(state.ledger_.mark()),
      kind_(kind) {
  const Members& members = state.members_;
  for (const std::size_t p : members.publishers_of(channel_)) state.ledger_.remove(p);
  state.members_.add(admission.id, std::move(admission.publisher), std::move(admission.subscriber));
  if (kind == Kind::wish) {
    const Wish wish{state.barred_to_wishes(channel_)};
    state.ledger_.set_raised(true);
    decide(&wish);
    state.ledger_.set_raised(false);
  } else {
    decide(nullptr);
  }
  if (id_ == 0) {
    fit_ = is_better();
    return;
  }

  const auto is_own = [&](const Verdict& v) {
    return members.admission_of_publisher(v.publisher) == id_ ||
           std::ranges::any_of(v.subscribers, [&](std::size_t s) {
             return members.admission_of_subscriber(s) == id_;
           });
  };
  for (std::size_t i = 0; i < next_.verdicts.size(); ++i)
    if (is_own(next_.verdicts[i])) own_.push_back(i);
  fit_ = !own_.empty() && keeps_grants(state.decisions_[channel_], next_) &&
         std::ranges::all_of(own_, [&](std::size_t i) { return next_.verdicts[i].granted; });
}

/// Decides the channel in the best attribute set in which everything is granted, if that is not
/// lower than the present one; otherwise in the set with the most grants.
void Proposal::decide(const Wish* wish) {
  const std::size_t channel = channel_;
  const Decision& before = state_->decisions_[channel];
  const std::size_t sets = before.granted != 0 ? before.set + 1 : sets_of(state_->system_, channel);
  Situation situation = state_->situation();
  if (wish != nullptr) {
    situation.permits = nullptr;
    situation.wish = wish;
  }
  std::size_t best = 0;
  for (std::size_t set = 0; set < sets; ++set) {
    const Ledger::Mark mark = state_->ledger_.mark();
    Decision decision = decide_in(situation, channel, set, state_->ledger_);
    const bool done = decision.all_granted();
    if (set == 0 || done || decision.granted > next_.granted) {
      next_ = std::move(decision);
      best = set;
    }
    if (done) return;
    state_->ledger_.roll_back(mark);
  }
  next_ = decide_in(situation, channel, best, state_->ledger_);
}

/// Whether the channel is granted more than without the newcomer.
bool Proposal::is_better() const {
  const Decision& before = state_->decisions_[channel_];
  if (!keeps_grants(before, next_) || next_.granted < before.granted) return false;
  return next_.granted > before.granted || (next_.granted != 0 && next_.set < before.set);
}

Proposal::Proposal(Proposal&& other) noexcept
    : state_(std::exchange(other.state_, nullptr)),
      id_(other.id_),
      channel_(other.channel_),
      before_(other.before_),
      next_(std::move(other.next_)),
      own_(std::move(other.own_)),
      fit_(other.fit_),
      kind_(other.kind_) {}

Proposal::~Proposal() {
  if (state_ == nullptr) return;
  state_->ledger_.roll_back(before_);
  state_->ledger_.commit();
  state_->members_.remove(id_);
}

std::vector<const Verdict*> Proposal::verdicts() const {
  std::vector<const Verdict*> own;
  own.reserve(own_.size());
  for (const std::size_t i : own_) own.push_back(&next_.verdicts[i]);
  return own;
}

GateChanges Proposal::changes(std::size_t gateway) const {
  const std::size_t c = channel_;
  // The present rules follow from the present verdicts. The newcomer is a member already, so its
  // publisher would be listed as known without having rules: it is left out.
  const Members& members = state_->members_;
  const GateState now =
      core::gate_state(state_->system_, members, c, state_->decisions_[c].verdicts, gateway, id_);
  return gate_changes_between(
      now, core::gate_state(state_->system_, members, c, next_.verdicts, gateway));
}

std::optional<std::string> Proposal::exceeds_capacity(std::size_t gateway) const {
  return core::exceeds_capacity(state_->system_, state_->members_, channel_, next_.verdicts,
                                gateway);
}

void Proposal::accept() && {
  assert(kind_ == Kind::admission);
  const std::size_t c = channel_;
  state_->ledger_.commit();
  // A better set or another route may have released resources that the channel held.
  for (const std::size_t r : state_->usage_.resources_of(c)) state_->relieved_.insert(r);
  state_->decisions_[c] = std::move(next_);
  state_->admissions_.emplace(id_, c);
  state_->note_age(c);
  state_->note_reservations(id_);
  state_->usage_.set(state_->situation(), c, state_->decisions_[c]);
  state_ = nullptr;
}

}  // namespace mlcca::core
