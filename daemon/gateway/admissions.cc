// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/admissions.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "daemon/gateway/requests/elsewhere.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"

namespace mlcca {
namespace {

constexpr std::uint64_t kTryAgain = 10'000'000'000;  // ns
constexpr std::size_t kEndedTogether = 64;           // leases that are ended together
constexpr std::uint64_t kSayAgain = 60'000'000'000;  // ns, why an admission waits

/// Whether a peer on a network made this admission by a subscription.
bool is_subscription(const control::Admit& admit) {
  return admit.key.starts_with(subscription_keys(admit.to));
}

/// Why a subscription that came over a network does not count in this description; nullopt if it
/// counts, or if the admission is no such subscription. A subscription without attributes has no
/// lease.
std::optional<std::string> refuses_subscription(const core::State& state,
                                                const control::Admit& admit) {
  if (!is_subscription(admit)) return std::nullopt;
  const auto& networks = state.system().networks;
  const auto network = std::ranges::find(networks, admit.to, &core::Network::name);
  if (network == networks.end()) return std::nullopt;
  const core::Subscribing least =
      admit.lease_ns != 0 ? core::Subscribing::with_attributes : core::Subscribing::all;
  if (network->subscriptions.accept >= least) return std::nullopt;
  return admit.to + " accepts no such subscription";
}

/// nullptr if the journal has no such admission.
const control::Admit* recorded(const Recorder& recorder, core::AdmissionId id) {
  const control::Request* request = recorder.contents().admissions.find(id);
  return request != nullptr ? std::get_if<control::Admit>(&request->body) : nullptr;
}

}  // namespace

std::string words_of(const control::LeftOutAdmission& left_out) {
  return fmt::format("admission {} of {} is left out: {}", left_out.admission, left_out.channel,
                     left_out.reason);
}

void Admissions::remember() {
  for (const control::Request& request : recorder_.contents().admissions) {
    const auto* admit = std::get_if<control::Admit>(&request.body);
    if (admit == nullptr) continue;
    keys_.put(admit->key, request.id);
    const std::uint64_t length = lease_of(*admit);
    if (length != 0) leases_.set(request.id, length, clock_.monotonic_ns());
  }
}

/// Adds it to the state, or returns why it is left out.
std::optional<control::LeftOutAdmission> Admissions::restore_one(core::State& state,
                                                                 core::AdmissionId id) const {
  const control::Admit* const admit = recorded(recorder_, id);
  if (admit == nullptr) return std::nullopt;
  const auto listed = list(state, *admit);
  const bool alone = recorder_.contents().admissions.through_others().contains(id);
  const control::Admit understandable = alone ? requests::subscriber_alone(*admit, id) : *admit;
  auto asked = listed ? understand(state, understandable, id) : std::unexpected(listed.error());
  if (auto why = refuses_subscription(state, *admit)) asked = fail(std::move(*why));
  if (asked && asked->admission) {
    state.restore(*asked->admission);
    return std::nullopt;
  }
  return control::LeftOutAdmission{
      .admission = id,
      .channel = admit->channel,
      .reason = asked ? "the description has it now" : asked.error().text};
}

bool Admissions::needs_agreement(core::AdmissionId id) const {
  return needs_agreements_ && recorder_.contents().admissions.through_others().contains(id);
}

control::LeftOutAdmission Admissions::waits_for_agreement(core::AdmissionId id,
                                                          const std::string& channel) const {
  const auto before = left_out_.find(id);
  if (before != left_out_.end() && waits(id)) return before->second;
  return {.admission = id,
          .channel = channel,
          .reason =
              fmt::format("it waits for gateway {}", recorder_.contents().admissions.through(id))};
}

/// Without an agreement, nothing takes the place of what is granted: after a start it is not known
/// yet what other gateways agree to.
Admissions::LeftOut Admissions::restore_into(core::State& state) const {
  LeftOut left_out;
  const auto is_in_force = [this](core::AdmissionId id) {
    return scene_.state && scene_.state->admissions().contains(id);
  };
  for (const bool in_force : {true, false})
    for (const control::Request& request : recorder_.contents().admissions) {
      if (is_in_force(request.id) != in_force) continue;
      const auto* const admit = std::get_if<control::Admit>(&request.body);
      if (!in_force && admit != nullptr && needs_agreement(request.id))
        left_out.emplace(request.id, waits_for_agreement(request.id, admit->channel));
      else if (auto why = restore_one(state, request.id))
        left_out.emplace(request.id, std::move(*why));
    }
  for (const std::string& subject : recorder_.contents().released)
    if (const auto channel = state.find_channel(subject)) state.set_withdrawn(*channel, true);
  return left_out;
}

/// Others may have begun or ended to wait since restore_into().
void Admissions::set_left_out(LeftOut left_out) {
  std::erase_if(left_out,
                [this](const auto& one) { return scene_.state->admissions().contains(one.first); });
  for (const auto& [id, why] : left_out)
    if (needs_agreement(id)) waiting_.try_emplace(id);
  for (const auto& [id, said] : waiting_)
    if (const auto why = left_out_.find(id); why != left_out_.end())
      left_out.insert_or_assign(id, why->second);
  left_out_ = std::move(left_out);
}

void Admissions::report_left_out() {
  for (const auto& [id, why] : left_out_)
    if (const auto before = reported_.find(id);
        !waits(id) && (before == reported_.end() || before->second != why))
      log_.warning(Kind::problem, words_of(why), about(id));
  reported_ = left_out_;
}

/// The reason for which it waits, which is logged unless another one was shortly before.
void Admissions::note_wait(core::AdmissionId id, const std::string& channel, const std::string& why,
                           bool log, Note about) {
  const std::uint64_t now = clock_.monotonic_ns();
  Said& said = waiting_[id];
  control::LeftOutAdmission& entry = left_out_[id];
  entry = {.admission = id, .channel = channel, .reason = why};
  const bool is_due = said.why.empty() || now >= said.at + kSayAgain;
  if (!log || said.why == why || !is_due) return;
  said = {.why = why, .at = now};
  log_.warning(Kind::withdrawn, words_of(entry), std::move(about));
}

core::FormerRules Admissions::let_wait(const std::vector<Waiting>& all) {
  core::FormerRules left;
  for (const auto& [id, why, log] : all) {
    const control::Admit* const admit = recorded(recorder_, id);
    if (admit == nullptr) continue;
    Note about = this->about(id);
    remove_from_state(id, left);
    note_wait(id, admit->channel, why, log, std::move(about));
  }
  tags_.leave_unused();
  return left;
}

bool Admissions::end_wait(const std::vector<core::AdmissionId>& all, bool is_in_force) {
  bool complete = true;
  for (const core::AdmissionId id : all) {
    const control::Admit* const admit = recorded(recorder_, id);
    std::optional<control::LeftOutAdmission> why;
    if (admit != nullptr) {
      const bool has_tags = admit->unlisted && is_in_force;
      if (has_tags) tags_.claim();
      why = restore_one(*scene_.state, id);
      if (has_tags) tags_.leave_unused();
    }
    complete = complete && !why;
    if (why)
      note_wait(id, why->channel, why->reason, true, about(id));
    else
      forget_wait(id);
  }
  return complete;
}

std::vector<core::AdmissionId> Admissions::left_out_of(const std::string& channel) const {
  const auto subject = core::parse_subject(channel);
  const auto described = scene_.state->find_channel(channel);
  const auto is_it = [&](const std::string& name) {
    return name == channel || (subject && core::parse_subject(name) == subject) ||
           (described && scene_.state->find_channel(name) == described);
  };
  std::vector<core::AdmissionId> found;
  for (const auto& [id, why] : left_out_)
    if (const auto* admit = recorded(recorder_, id); admit != nullptr && is_it(admit->channel))
      found.push_back(id);
  return found;
}

std::vector<control::LeftOutAdmission> Admissions::left_out_report() const {
  std::vector<control::LeftOutAdmission> out;
  for (const auto& [id, why] : left_out_) out.push_back(why);
  return out;
}

std::vector<control::LeftOutAdmission> Admissions::left_out_report(
    const std::string& channel) const {
  std::vector<control::LeftOutAdmission> out;
  for (const core::AdmissionId id : left_out_of(channel)) out.push_back(left_out_.at(id));
  return out;
}

Note Admissions::about(core::AdmissionId id) const {
  const core::State& state = *scene_.state;
  const auto* admit = recorded(recorder_, id);
  const auto in_force = state.admissions().find(id);
  std::optional<std::size_t> channel;
  if (in_force != state.admissions().end())
    channel = in_force->second;
  else if (admit != nullptr)
    channel = state.find_channel(admit->channel);
  if (channel)
    return {.subject = state.system().channels[*channel].subject,
            .channel = state.system().channels[*channel].name,
            .admissions = {id}};
  if (admit == nullptr) return {.admissions = {id}};
  return {.subject = core::parse_subject(admit->channel).value_or(0),
          .channel = admit->channel,
          .admissions = {id}};
}

Result<core::AdmissionId> Admissions::named(core::AdmissionId id, const std::string& key) const {
  if (!key.empty()) {
    if (const auto known = keys_.find(key)) return *known;
    return fail(fmt::format("there is no admission with the key '{}'", key));
  }
  if (recorder_.contents().admissions.find(id) == nullptr)
    return fail(fmt::format("there is no admission {}", id));
  return id;
}

bool Admissions::came_over_a_network(core::AdmissionId id) const {
  const auto* admit = recorded(recorder_, id);
  return admit != nullptr && is_subscription(*admit);
}

void Admissions::add(core::AdmissionId id, const control::Admit& request, std::uint64_t session) {
  keys_.put(request.key, id);
  own(id, request, session);
  if (lease_of(request) != 0) log_.add_rows(1);  // the row that is written when the lease ends
}

bool Admissions::own(core::AdmissionId id, const control::Admit& request, std::uint64_t session) {
  if (request.hold) {
    held_[id].insert(session);
    leases_.forget(id);
  } else if (request.lease_ns != 0) {
    leases_.set(id, request.lease_ns, clock_.monotonic_ns());
  }
  return request.hold;
}

void Admissions::session_closed(std::uint64_t session) {
  for (auto it = held_.begin(); it != held_.end();) {
    if (it->second.erase(session) == 0 || !it->second.empty()) {
      ++it;
      continue;
    }
    const control::Request* request = recorder_.contents().admissions.find(it->first);
    if (request != nullptr)
      leases_.set(it->first, lease_of(std::get<control::Admit>(request->body)),
                  clock_.monotonic_ns());
    it = held_.erase(it);
  }
}

Result<void> Admissions::release(const std::vector<core::AdmissionId>& gone,
                                 const std::string& why) {
  turn_.commit();
  std::vector<store::Entry> entries;
  std::vector<Note> released;
  entries.reserve(gone.size());
  released.reserve(gone.size());
  for (const core::AdmissionId id : gone) {
    entries.emplace_back(store::Removed{id});
    released.push_back(about(id));
  }
  if (auto done = recorder_.write_at_once(entries); !done) return done;
  for (Note& one : released) {
    const std::string of = one.channel.empty() ? "" : " of " + one.channel;
    const core::AdmissionId id = one.admissions.front();
    log_.notice(Kind::released, fmt::format("admission {}{}: {}", id, of, why), std::move(one));
  }
  // A gate that the kernel refuses to change denies everything, and the log says so. The admissions
  // are released nevertheless.
  static_cast<void>(turn_.settle(forget(gone)));
  gone_(gone);
  tags_.leave_unused();
  return {};
}

void Admissions::take_back(const std::vector<core::AdmissionId>& lost) {
  for (const core::AdmissionId id : lost)
    log_.warning(Kind::refused,
                 fmt::format("admission {} is refused: it could not be written down", id),
                 {.admissions = {id}});
  static_cast<void>(turn_.settle(forget(lost)));
  gone_(lost);
  tags_.leave_unused();
}

bool Admissions::end_some() {
  const std::vector<core::AdmissionId> expired =
      leases_.expired(clock_.monotonic_ns(), kEndedTogether);
  if (expired.empty()) return false;
  const auto done = release(expired, "its lease ended and was not renewed");
  if (done) return true;
  log_.error(Kind::problem, done.error().text);
  // What could not be written to disk stays reserved, and is tried again.
  for (const core::AdmissionId id : expired) leases_.postpone(id, kTryAgain, clock_.monotonic_ns());
  return true;
}

core::FormerRules Admissions::forget(const std::vector<core::AdmissionId>& gone) {
  core::FormerRules left;
  for (const core::AdmissionId id : gone) {
    remove_from_state(id, left);
    leases_.forget(id);
    held_.erase(id);
    keys_.forget(id);
    left_out_.erase(id);
    waiting_.erase(id);
  }
  return left;
}

void Admissions::remove_from_state(core::AdmissionId id, core::FormerRules& left) const {
  const auto known = scene_.state->admissions().find(id);
  if (known == scene_.state->admissions().end()) return;
  const std::size_t channel = known->second;
  if (!left.contains(channel))
    left.emplace(channel, scene_.state->gate_state(scene_.self, channel));
  scene_.state->remove(id);
}

}  // namespace mlcca
