// SPDX-License-Identifier: BSD-2-Clause
#include "core/state.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

namespace mlcca::core {
namespace {

void add_to(Members& members, const Admission& admission) {
  if (admission.publisher) members.add(*admission.publisher, admission.id);
  if (admission.subscriber) members.add(*admission.subscriber, admission.id);
}

System sorted(System system) {
  system.sort_bindings();
  return system;
}

bool same_delivery(const Verdict& a, const Verdict& b) {
  return a.publisher == b.publisher && a.to == b.to;
}

}  // namespace

Proposal::Proposal(State& state, const Admission& admission)
    : state_(&state), admission_(admission) {
  const std::size_t channel = admission.channel;
  const Members& members = state.members_;
  const auto& before = state.decision_.channels[channel];
  add_to(state.members_, admission);
  next_ = core::decide(state.situation(), channel,
                       state.decision_.ledger.balance_without(members.publishers_of(channel)));

  const auto is_own = [&](const Verdict& v) {
    return members.admission_of_publisher(v.publisher) == admission.id ||
           std::ranges::any_of(v.subscribers, [&](std::size_t s) {
             return members.admission_of_subscriber(s) == admission.id;
           });
  };
  fit_ = true;
  for (std::size_t i = 0; i < next_.verdicts.size(); ++i) {
    const Verdict& v = next_.verdicts[i];
    const auto old =
        std::ranges::find_if(before, [&](const Verdict& o) { return same_delivery(o, v); });
    const bool lost = old != before.end() && old->granted && !v.granted;
    const bool own = is_own(v);
    if (own) own_.push_back(i);
    if (lost || (own && !v.granted)) fit_ = false;
  }
  fit_ = fit_ && !own_.empty();
}

Proposal::Proposal(Proposal&& other) noexcept
    : state_(std::exchange(other.state_, nullptr)),
      admission_(std::move(other.admission_)),
      next_(std::move(other.next_)),
      own_(std::move(other.own_)),
      fit_(other.fit_) {}

Proposal::~Proposal() {
  if (state_ != nullptr) state_->members_.remove(admission_.id);
}

std::vector<const Verdict*> Proposal::verdicts() const {
  std::vector<const Verdict*> own;
  own.reserve(own_.size());
  for (const std::size_t i : own_) own.push_back(&next_.verdicts[i]);
  return own;
}

GateChanges Proposal::changes(std::size_t gateway) const {
  const std::size_t c = admission_.channel;
  // The rules as they are come from the verdicts as they are; a newcomer has none among them, but
  // its publisher would be listed as known: leave it out.
  const Members& members = state_->members_;
  const GateState now = core::gate_state(state_->system_, members, c, state_->decision_.channels[c],
                                         gateway, admission_.id);
  return difference(now, core::gate_state(state_->system_, members, c, next_.verdicts, gateway));
}

void Proposal::accept() && {
  const std::size_t c = admission_.channel;
  Decision& decision = state_->decision_;
  decision.ledger =
      std::move(decision.ledger).replaced(state_->members_.publishers_of(c), next_.ledger);
  decision.channels[c] = std::move(next_.verdicts);
  state_->admissions_.push_back(std::move(admission_));
  state_ = nullptr;
}

State::State(System system)
    : system_(sorted(std::move(system))),
      topology_(system_),
      members_(system_),
      conditions_(system_.networks.size()),
      released_(system_.channels.size(), false) {
  decide();
}

bool State::set_conditions(std::vector<Condition> conditions) {
  if (conditions == conditions_) return false;
  conditions_ = std::move(conditions);
  return true;
}

void State::set_released(std::size_t channel, bool released) { released_[channel] = released; }

void State::decide() { decision_ = decide_all(situation()); }

void State::restore(const Admission& admission) {
  add_to(members_, admission);
  admissions_.push_back(admission);
}

bool State::remove(AdmissionId id) {
  members_.remove(id);
  return std::erase_if(admissions_, [id](const Admission& a) { return a.id == id; }) != 0;
}

std::optional<std::size_t> State::find_channel(const std::string& name_or_subject) const {
  const auto subject = parse_subject(name_or_subject);
  for (std::size_t c = 0; c < system_.channels.size(); ++c) {
    const EventChannel& channel = system_.channels[c];
    if (subject ? channel.subject == *subject : channel.name == name_or_subject) return c;
  }
  return std::nullopt;
}

std::optional<Place> State::find_place(const std::string& name) const {
  for (std::size_t n = 0; n < system_.networks.size(); ++n)
    if (system_.networks[n].name == name) return Place{Place::Kind::network, n};
  for (std::size_t g = 0; g < system_.gateways.size(); ++g)
    if (system_.gateways[g].name == name) return Place{Place::Kind::gateway, g};
  return std::nullopt;
}

std::optional<Subject> parse_subject(const std::string& text) {
  if (!text.starts_with("0x") && !text.starts_with("0X")) return std::nullopt;
  Subject subject = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data() + 2, end, subject, 16);
  if (error != std::errc{} || rest != end) return std::nullopt;
  return subject;
}

}  // namespace mlcca::core
