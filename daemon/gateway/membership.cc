// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/membership.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <utility>
#include <variant>

#include "daemon/gateway/stored_octets.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

namespace cc = core::cluster;

constexpr int kMostRounds = 32;                     // rounds of one turn
constexpr Value kWaitStep = 20'000'000;             // ns
constexpr Value kUntilAgain = 1'000'000'000;        // ns
constexpr Value kEnforceAgain = 5'000'000'000;      // ns
constexpr Value kProposeAgain = 30'000'000'000;     // ns
constexpr Value kLongestSleep = 3'600'000'000'000;  // ns
constexpr Value kMarginParts = 16;                  // of a lease: closes this part before its end
constexpr unsigned kTxnBits = 40;                   // of a transaction's number, below the member's
constexpr unsigned kHalf = 32;

std::uint64_t random_number() {
  std::random_device device;
  return (std::uint64_t{device()} << kHalf) | device();
}

store::Membership record_of(const cc::Journalled& journalled) {
  return {.epoch = octets_of(journalled.epoch),
          .epoch_revision = static_cast<std::uint64_t>(journalled.epoch_revision),
          .incarnation = static_cast<std::uint64_t>(journalled.incarnation),
          .seen_revision = static_cast<std::uint64_t>(journalled.seen_revision),
          .voted_digest = octets_of(journalled.voted_digest),
          .gone_back = journalled.gone_back,
          .waits = journalled.waits};
}
cc::Journalled journalled_in(const store::Membership& record) {
  return {.epoch = array_of<std::tuple_size_v<cc::Epoch>>(record.epoch),
          .epoch_revision = static_cast<std::int64_t>(record.epoch_revision),
          .incarnation = static_cast<std::int64_t>(record.incarnation),
          .seen_revision = static_cast<std::int64_t>(record.seen_revision),
          .voted_digest = array_of<std::tuple_size_v<cc::Digest>>(record.voted_digest),
          .gone_back = record.gone_back,
          .waits = record.waits};
}

}  // namespace

Membership::Membership(Parts parts) : parts_(std::move(parts)), store_since_(now()) {
  parts_.hands.ask = [this](Reserving::Job job) -> Result<void> {
    const std::size_t gateway = job.gateway.value_or(self_);
    if (const auto why = reserving_->bar_gateway(gateway, parts_.hands.name_of(gateway));
        !why.empty())
      return fail(why);
    ask(std::move(job));
    return {};
  };
  parts_.hands.remove = [this, remove = std::move(parts_.hands.remove)](const auto& gone) {
    if (decided_)
      remove(gone);
    else
      for (const core::AdmissionId id : gone) state().remove(id);
  };
  parts_.hands.forget = [this](Number adopted) { reserving_->forget(adopted); };
  parts_.hands.wants = [this](Number number) { return reserving_->has(number); };
  parts_.hands.give_back = [this](const auto& gone) { reserving_->admissions_gone(gone); };
  parts_.hands.name_of = [this](std::size_t g) { return state().system().gateways[g].name; };
  parts_.hands.new_id = [this] { return parts_.recorder.new_id(); };
  parts_.hands.new_number = [this] { return reserving_->new_number(); };
  parts_.hands.bring_in_line = [this] { static_cast<void>(bring_in_line()); };
  parts_.link.on_message([this](ClusterMessage message) { take(std::move(message)); });
  if (parts_.loop != nullptr) static_cast<void>(timer_.start(parts_.loop, [] {}));
}

// --- a start, and another description ------------------------------------------------------------

void Membership::begin() {
  const core::System& system = state().system();
  if (reserving_)
    reserving_->refuse_all(
        "this gateway has loaded a description meanwhile, by a reload or a rollout", ": ask again");
  if (adopting_) adopting_->forget();
  member_.reset();
  parts_.rollout.loaded();
  digest_ = parts_.scene.digest;
  self_ = parts_.scene.self;
  system_ = system.name;
  keys_ = std::make_shared<cc::Keys>(system, "/mlcca/" + cc::encoded(system_) + '/');
  codec_ = std::make_unique<cluster::Codec>(system, digest_);
  networks_ = std::make_unique<SharedNetworks>(system, self_);
  parts_.pulse();
  const std::uint64_t session = random_number();
  adopting_ = std::make_unique<Adopting>(*networks_, parts_.hands);
  reserving_ = std::make_unique<Reserving>(
      Reserving::Parts{
          .networks = *networks_,
          .bring_in_line = [this] { return bring_in_line(); },
          .needs = [this](const std::string& channel,
                          Number number) { return needs(channel, number); },
          .withdrawn =
              [this](const auto& admissions, bool ended, const std::string& why) {
                for (const core::AdmissionId id : admissions) {
                  adopting_->withdrawn(id, why);
                  note_refusal(id, why);
                  if (ended) withdrawn_.try_emplace(id, Withdrawn{.why = why});
                }
              },
          .ended = [this](Number number) { adopting_->close_made_for(number); },
          .in_the_way = [this] { return former_in_the_way(); },
          .log = [this](const std::string& line) { parts_.log.warning(Kind::gateway, line); }},
      session >> 1U);
  member_ = std::make_unique<cc::Member>(keys_, *codec_,
                                         cc::Member::Identity{.gateway = self_,
                                                              .digest = digest_,
                                                              .session = session,
                                                              .lease = parts_.lease,
                                                              .was = journalled_before()});
  if (const auto proposed = parts_.rollout.pending()) member_->resume_rollout(*proposed);
  failed_.assign(system.gateways.size(), true);
  joined_ = false;
  lapsed_at_.reset();
  early_.clear();
  wish_anew();
  former_.clear();
  ++generation_;
  // A gateway that takes no part removes what the store may still have of it.
  draining_ = left_ = false;
  drained_ = until_restart_ || parts_.recorder.contents().membership.drained;
  leaving_ = leaving_ || drained_;
  parts_.link.introduce(system_, system.gateways[self_].name);
  parts_.link.follow({keys_->prefix()});
  member_->on_state(store_, now());
}

/// Meanwhile nothing is closed, and nothing is reported to the store as closed.
void Membership::await(std::uint64_t limit) {
  if (leaving_) return;
  const Value end = add_saturating(now(), limit);
  for (bool settled = false; !settled && now() < end;) {
    parts_.link.wait(std::min(kWaitStep, end - now()));
    parts_.pulse();
    member_->on_time(now());
    for (cc::Event& event : member_->take_events()) {
      settled = settled || std::holds_alternative<cc::Lost>(event) ||
                std::holds_alternative<cc::Joined>(event);
      early_.push_back(std::move(event));
    }
    if (!settled) send();
  }
}

/// Removes admissions of other gateways that are no longer known here. They occur in a state that
/// was restored because another one could not be put in force.
void Membership::forget_orphans() {
  const auto& known = parts_.recorder.contents().admissions;
  std::vector<core::AdmissionId> orphans;
  for (const auto& [id, channel] : state().admissions())
    if (known.find(id) == nullptr && !adopting_->has(id)) orphans.push_back(id);
  for (const core::AdmissionId id : orphans) state().remove(id);
}

/// To the store, a gateway of another name or cluster is another gateway, so its record does not
/// count.
cc::Journalled Membership::journalled_before() const {
  const store::Membership& was = parts_.recorder.contents().membership;
  const std::string& gateway = state().system().gateways[self_].name;
  const bool same = (was.cluster.empty() || was.cluster == system_) &&
                    (was.gateway.empty() || was.gateway == gateway);
  return same ? journalled_in(was) : cc::Journalled{};
}

store::Membership Membership::record() const {
  store::Membership record = record_of(member_->journalled());
  parts_.rollout.put_into(record);
  record.cluster = system_;
  record.gateway = member_->view().keys().gateway_name(self_);
  record.drained = drained_ && !until_restart_;
  return record;
}

core::FormerRules Membership::take_up_state(bool is_in_force) {
  core::State& state = this->state();
  if (!member_ || parts_.scene.digest != digest_ || parts_.scene.self != self_) begin();
  state.set_permits(nullptr);
  state.set_permits(&networks_->permits());
  state.held_by_others().set_source(this);
  for (const cc::Event& event : std::exchange(early_, {})) take_in(event);
  adopting_->restore();
  forget_orphans();
  core::FormerRules left = follow_agreements(is_in_force);
  networks_->touch_all();
  networks_->put_foreign(state, member_->view());
  note_failed();
  set_permits();
  raise_until();
  return left;
}

// --- what the store says -------------------------------------------------------------------------

void Membership::take(ClusterMessage message) {
  if (const auto* said = std::get_if<cc::StoreState>(&message)) {
    if (said->reachable != store_.reachable) store_since_ = now();
    store_ = *said;
  }
  if (!member_) return;
  if (std::holds_alternative<cc::StoreState>(message)) {
    member_->on_state(store_, now());
  } else if (const auto* snapshot = std::get_if<ClusterSnapshot>(&message)) {
    member_->on_snapshot_begin(snapshot->revision, now());
  } else if (std::holds_alternative<ClusterSynced>(message)) {
    member_->on_snapshot_end(now());
  } else if (const auto* batch = std::get_if<cc::Batch>(&message)) {
    member_->on_batch(*batch, now());
  } else if (auto* result = std::get_if<cc::TxnResult>(&message)) {
    if (result->id >> kTxnBits != generation_) return;
    result->id &= (std::uint64_t{1} << kTxnBits) - 1;
    member_->on_result(*result, now());
  }
}

/// Takes in what an event says about the world. Decisions that follow from it are a separate step.
void Membership::take_in(const cc::Event& event) {
  if (const auto* changed = std::get_if<cc::ForeignChanged>(&event)) {
    networks_->touch(changed->network);
  } else if (const auto* failed = std::get_if<cc::Failed>(&event)) {
    failed_[failed->gateway] = failed->failed;
    if (failed->failed) wish_anew();
  } else if (const auto* lost = std::get_if<cc::Lost>(&event)) {
    lost_ = true;
    reserving_->lost();
    adopting_->lost();
    note_lost(lost->why);
    if (joined_) parts_.log.warning(Kind::gateway, "what was reserved is closed: " + lost->why);
  } else if (const auto* found = std::get_if<cc::Found>(&event)) {
    reserving_->on(*found, *member_, [this](const cluster::StoredRequest& asked) {
      return !leaving_ && (is_known(asked) || adopting_->keep_found(asked));
    });
  } else if (std::holds_alternative<cc::Joined>(event)) {
    joined_ = true;
    take_former_numbers();
    pauses_.clear();
    lapsed_at_.reset();
  } else if (const auto* withdrawn = std::get_if<cc::Withdrawn>(&event)) {
    reserving_->on(*withdrawn, *member_);
  } else if (const auto* adopt = std::get_if<cc::Adopt>(&event)) {
    adopting_->on(*adopt);
  } else if (const auto* opened = std::get_if<cc::Opened>(&event)) {
    adopting_->on(*opened);
  } else if (const auto* ended = std::get_if<cc::Ended>(&event)) {
    adopting_->on(*ended);
  } else {
    take_in_description(event);
  }
}

void Membership::take_in_description(const cc::Event& event) {
  if (const auto* judge = std::get_if<cc::Judge>(&event)) {
    parts_.rollout.on(*judge);
  } else if (const auto* ended = std::get_if<cc::NotRolledOut>(&event)) {
    propose_at_ = add_saturating(now(), kProposeAgain);
    if (!ended->why.empty())
      parts_.log.warning(Kind::rollout, "no description came into force: " + ended->why);
    parts_.rollout.on(*ended);
  } else if (const auto* to = std::get_if<cc::Switch>(&event)) {
    networks_->touch_all();
    parts_.rollout.on(*to);
  } else if (std::holds_alternative<cc::Drained>(event)) {
    left_ = true;
    if (drained_) adopting_->lost();
  }
}

/// Handles events that need decisions; false if the event is none of these.
bool Membership::decide(const cc::Event& event) {
  if (const auto* reserved = std::get_if<cc::Reserved>(&event))
    reserving_->on(*reserved, *member_);
  else if (const auto* conflict = std::get_if<cc::Conflict>(&event))
    reserving_->on(*conflict, *member_, now());
  else if (const auto* refused = std::get_if<cc::Refused>(&event))
    reserving_->on(*refused, *member_);
  else
    return false;
  return true;
}

// --- the turn ------------------------------------------------------------------------------------

void Membership::act() {
  member_->on_time(now());
  drain_when_closed();
  adopting_->begin_turn();
  bool more = true;
  for (int round = 0; more && round < kMostRounds; ++round) {
    const std::vector<cc::Event> events = member_->take_events();
    for (const cc::Event& event : events) take_in(event);
    static_cast<void>(bring_in_line());
    for (const cc::Event& event : events) decide(event);
    end_withdrawn();
    more = adopting_->step(*member_, now()) || !events.empty();
    more = reserving_->step(*member_, now()) || more;
    more = parts_.rollout.step(*member_) || more;
    more = more || wish_some();
  }
  lost_ = !bring_in_line() && lost_;
  propose_first();
  // The store is not informed of a closing that the kernel has refused.
  if (!more && adopting_->has_opened() && parts_.turn.in_line())
    member_->applied(member_->view().revision());
  send();
  report();
  plan();
}

/// Brings gates and state in line with the permits and with what others hold. The kernel gets the
/// end of the lease before gates open, and loses it only after they have closed.
bool Membership::bring_in_line() {
  if (!decided_) return false;
  if (reserving_->take_agreements_changed())
    if (const core::FormerRules left = follow_agreements(true); !left.empty())
      static_cast<void>(parts_.turn.settle(left));
  note_failed();
  set_permits();
  networks_->put_foreign(state(), member_->view());
  raise_until();
  static_cast<void>(parts_.turn.settle());
  lower_until();
  return parts_.turn.in_line();
}

/// As long as the kernel refuses to close something, nothing is given back.
void Membership::enforce_again() {
  if (parts_.turn.in_line() || now() < enforce_at_) return;
  enforce_at_ = add_saturating(now(), kEnforceAgain);
  static_cast<void>(parts_.turn.enforce());
}

bool Membership::is_in_force() const {
  const auto& current = member_->view().records().current.value;
  return member_->view().complete() && current && current->open && current->digest == digest_;
}

Value Membership::leased_end() const {
  return sub_floor(member_->valid_until(), parts_.lease / kMarginParts);
}

bool Membership::may_use_leased() const {
  const auto standing = member_->standing(now());
  return (standing == cc::Member::Standing::joined || standing == cc::Member::Standing::waiting) &&
         now() < leased_end();
}

void Membership::set_permits() {
  core::Permits& permits = networks_->permits();
  if (!joined_ || leaving_ || is_unheard() || !is_in_force() || parts_.scene.unchecked)
    permits.close(true);
  else if (!may_use_leased() || now() < until_retry_)
    permits.close(false);
  else
    permits.open();
}

void Membership::raise_until() {
  if (networks_->permits().is_open() && networks_->has_leased()) set_until(member_->valid_until());
}

void Membership::lower_until() {
  if (!networks_->permits().is_open() || !networks_->has_leased()) set_until(0);
}

/// If the kernel refuses, everything that depends on the lease stays closed.
void Membership::set_until(std::uint64_t until) {
  if (until_ == until || now() < until_retry_) return;
  const auto set = parts_.control.set_until(until);
  if (!set) {
    if (until_trouble_.is_new("until when the gates may be open cannot be set: " +
                              set.error().text))
      parts_.log.error(Kind::trouble, until_trouble_.text());
    until_retry_ = add_saturating(now(), kUntilAgain);
    networks_->permits().close(false);
    until_.reset();
    return;
  }
  until_ = until;
  until_retry_ = 0;
  static_cast<void>(until_trouble_.is_new(""));
  // Makes a later time effective now; otherwise the next heart-beat would.
  if (decided_ && !parts_.control.lapsed()) static_cast<void>(parts_.control.beat(now()));
}

void Membership::note_failed() {
  const bool able = parts_.able();
  for (std::size_t g = 0; g < failed_.size(); ++g)
    state().set_failed(g, failed_[g] || (g == self_ && !able));
  member_->set_able(able);
}

void Membership::committed(const Result<void>& done) {
  for (const auto& call : std::exchange(waits_, {})) call(done);
}

void Membership::poll() {
  if (!member_) return;
  parts_.rollout.poll();
  looks_for_wishes_ = looks_for_troubles_ = true;
  forget_past_pauses();
  enforce_again();
  reserving_->tidy();
  give_back_without_place();
}

/// Writes to disk what was taken from the store, before anything is sent that depends on it. False
/// if that failed.
bool Membership::write_down() {
  const store::Membership record = this->record();
  if (parts_.recorder.contents().membership == record) return true;
  parts_.recorder.note_membership(record);
  if (decided_) {
    parts_.before_commit();
    parts_.turn.commit();
  } else {
    static_cast<void>(parts_.recorder.commit([](const auto&) {}));
  }
  return parts_.recorder.contents().membership == record;
}

void Membership::send() {
  if (!write_down()) return;
  // Nothing is sent while a closing after a lost lease is not complete: others could take it as
  // closed.
  if (lost_ && decided_) return;
  auto txns = member_->take_txns(now());
  const bool written = write_down();
  for (cc::Txn& txn : txns) {
    if (!written) {
      member_->on_result({.id = txn.id,
                          .outcome = cc::Outcome::unavailable,
                          .revision = 0,
                          .read = {},
                          .why = "the journal cannot be written"},
                         now());
      continue;
    }
    txn.id |= generation_ << kTxnBits;
    parts_.link.send(txn);
  }
}

/// If the store has no description in force, proposes that of this gateway to all gateways.
void Membership::propose_first() {
  const auto& records = member_->view().records();
  if (!joined_ || leaving_ || !member_->view().complete() || records.current.mod != 0 ||
      records.next.mod != 0 || now() < propose_at_)
    return;
  propose_at_ = add_saturating(now(), kProposeAgain);
  member_->stage(parts_.rollout.own());
}

void Membership::plan() {
  if (parts_.loop == nullptr) return;
  const Value at = now();
  Value next = std::min(add_saturating(at, kLongestSleep), member_->next_time(at));
  if (leased_end() > at) next = std::min(next, leased_end());
  if (const auto due = reserving_->next_time()) next = std::min(next, *due);
  if (adopting_->has_due()) next = at;
  if (leaving_ && leave_until_ > at) next = std::min(next, leave_until_);
  constexpr Value micro = 1000;
  timer_.set((sub_floor(next, at) / micro) + 1);
}

// --- what is wanted ------------------------------------------------------------------------------

bool Membership::waits_for(const std::string& key) const {
  return !key.empty() && reserving_ && reserving_->waits_for(key);
}
bool Membership::refuse(const std::string& key, const std::string& why) {
  return !key.empty() && reserving_ && reserving_->refuse(key, why);
}

void Membership::ask(Reserving::Job job) { reserving_->ask(std::move(job), now()); }

void Membership::admissions_gone(const std::vector<core::AdmissionId>& gone) {
  if (!member_) return;
  forget_waits(gone);
  reserving_->admissions_gone(gone);
  adopting_->publishers_gone();
}

void Membership::session_closed(std::uint64_t session) {
  parts_.rollout.session_closed(session);
  if (reserving_) reserving_->session_closed(session);
}

}  // namespace mlcca
