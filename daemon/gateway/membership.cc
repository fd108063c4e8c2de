// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/membership.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <utility>
#include <variant>

#include "core/cluster/lease.hpp"
#include "core/cluster/strange.hpp"
#include "daemon/gateway/stored_octets.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

namespace cc = core::cluster;

constexpr int kMostRounds = 32;                     // rounds of one turn
constexpr Value kWaitStep = 20'000'000;             // ns
constexpr Value kEnforceAgain = 5'000'000'000;      // ns
constexpr Value kProposeAgain = 30'000'000'000;     // ns
constexpr Value kLongestSleep = 3'600'000'000'000;  // ns
constexpr Value kLeaveLimit = 5'000'000'000;        // ns
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

Membership::Membership(Parts parts)
    : parts_(std::move(parts)),
      wishes_({.scene = parts_.scene,
               .recorder = parts_.recorder,
               .log = parts_.log,
               .clock = parts_.clock,
               .session = session_,
               .ask = [this](Reserving::Job job) { ask(std::move(job)); }}),
      waiting_({.scene = parts_.scene,
                .recorder = parts_.recorder,
                .admissions = parts_.admissions,
                .clock = parts_.clock,
                .session = session_,
                .ask = [this](Reserving::Job job) { ask(std::move(job)); },
                .is_drained = [this] { return is_drained_; }}),
      open_until_(parts_.control, parts_.log, parts_.clock),
      lines_(parts_.log),
      store_since_(now()) {
  parts_.link.on_message([this](ClusterMessage message) { take(std::move(message)); });
  if (parts_.loop != nullptr) static_cast<void>(timer_.start(parts_.loop, [] {}));
}

// --- what Adopting needs -------------------------------------------------------------------------

void Membership::remove(const std::vector<core::AdmissionId>& gone) {
  if (decided_) {
    parts_.adopted.remove(gone);
    return;
  }
  for (const core::AdmissionId id : gone) state().remove(id);
}

Result<void> Membership::reserve(Reserving::Job job) {
  const std::size_t gateway = job.gateway.value_or(session_.self);
  if (const auto why = session_.reserving->bar_gateway(gateway, name_of(gateway)); !why.empty())
    return fail(why);
  ask(std::move(job));
  return {};
}

// --- a start, and another description ------------------------------------------------------------

void Membership::begin() {
  const core::System& system = state().system();
  if (session_.reserving)
    session_.reserving->refuse_all(
        "this gateway has loaded a description meanwhile, by a reload or a rollout", ": ask again");
  if (session_.adopting) session_.adopting->forget();
  session_.member.reset();
  parts_.rollout.loaded();
  session_.digest = parts_.scene.digest;
  session_.self = parts_.scene.self;
  session_.system = system.name;
  session_.keys =
      std::make_shared<cc::Keys>(system, "/mlcca/" + cc::encoded(session_.system) + '/');
  session_.codec = std::make_unique<cluster::RecordCodec>(system, session_.digest);
  session_.networks = std::make_unique<SharedNetworks>(system, session_.self);
  parts_.pulse();
  const std::uint64_t session = random_number();
  Adopting::Hands& hands = *this;
  session_.adopting = std::make_unique<Adopting>(*session_.networks, parts_.adopted, hands);
  session_.reserving = std::make_unique<Reserving>(
      Reserving::Parts{
          .networks = *session_.networks,
          .bring_in_line = [this] { return bring_in_line(); },
          .needs = [this](Number number,
                          const Reserving::Held& held) { return wishes_.needs(number, held); },
          .rest = [this](Number number,
                         const Reserving::Held& held) { return wishes_.rest_of(number, held); },
          .withdrawn =
              [this](const auto& admissions, bool ended, const Reserving::Refusal& why) {
                for (const core::AdmissionId id : admissions) {
                  session_.adopting->withdrawn(id, why);
                  waiting_.note_refusal(id, why.why);
                  if (ended) waiting_.withdraw(id, why.why);
                }
              },
          .objected =
              [this](const std::string& channel, std::vector<std::size_t> gateways,
                     const Reserving::Refusal& why) {
                wishes_.note_withdrawal(channel, std::move(gateways), why);
              },
          .ended = [this](Number number) { session_.adopting->close_made_for(number); },
          .in_the_way = [this] { return former_.in_the_way(*session_.member); },
          .log = [this](const std::string& line) { parts_.log.warning(Kind::gateway, line); }},
      session >> 1U);
  session_.member = std::make_unique<cc::Member>(session_.keys, *session_.codec,
                                                 cc::Member::Identity{.gateway = session_.self,
                                                                      .digest = session_.digest,
                                                                      .session = session,
                                                                      .lease = parts_.lease,
                                                                      .was = journalled_before()});
  if (const auto proposed = parts_.rollout.pending()) session_.member->resume_rollout(*proposed);
  session_.failed.assign(system.gateways.size(), true);
  session_.joined = false;
  session_.lapsed_at.reset();
  session_.early.clear();
  wish_anew();
  wishes_.forget_objections();
  former_.forget();
  ++generation_;
  // A gateway that takes no part removes what the store may still have of it.
  is_drained_ = until_restart_ || parts_.recorder.contents().membership.drained;
  if (phase_ != Phase::taking_part || is_drained_) phase_ = Phase::closing;
  parts_.link.introduce(session_.system, system.gateways[session_.self].name);
  parts_.link.follow({session_.keys->prefix()});
  session_.member->on_state(store_, now());
}

/// Meanwhile nothing is closed, and nothing is reported to the store as closed.
void Membership::await(std::uint64_t limit) {
  if (is_leaving()) return;
  const Value end = add_saturating(now(), limit);
  for (bool settled = false; !settled && now() < end;) {
    parts_.link.wait(std::min(kWaitStep, end - now()));
    parts_.pulse();
    session_.member->on_time(now());
    for (cc::Event& event : session_.member->take_events()) {
      settled = settled || std::holds_alternative<cc::Lost>(event) ||
                std::holds_alternative<cc::Joined>(event);
      session_.early.push_back(std::move(event));
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
    if (known.find(id) == nullptr && !session_.adopting->has(id)) orphans.push_back(id);
  for (const core::AdmissionId id : orphans) state().remove(id);
}

/// To the store, a gateway of another name or cluster is another gateway, so its record does not
/// count.
cc::Journalled Membership::journalled_before() const {
  const store::Membership& was = parts_.recorder.contents().membership;
  const std::string& gateway = state().system().gateways[session_.self].name;
  const bool same = (was.cluster.empty() || was.cluster == session_.system) &&
                    (was.gateway.empty() || was.gateway == gateway);
  return same ? journalled_in(was) : cc::Journalled{};
}

store::Membership Membership::record() const {
  store::Membership record = record_of(session_.member->journalled());
  parts_.rollout.put_into(record);
  record.cluster = session_.system;
  record.gateway = session_.member->view().keys().gateway_name(session_.self);
  record.drained = is_drained_ && !until_restart_;
  return record;
}

core::FormerRules Membership::take_up_state(bool is_in_force) {
  core::State& state = this->state();
  if (!session_.member || parts_.scene.digest != session_.digest ||
      parts_.scene.self != session_.self)
    begin();
  state.set_permits(nullptr);
  state.set_permits(&session_.networks->permits());
  state.held_by_others().set_source(this);
  for (const cc::Event& event : std::exchange(session_.early, {})) take_in(event);
  session_.adopting->restore();
  forget_orphans();
  core::FormerRules left = waiting_.follow_agreements(is_in_force);
  session_.networks->touch_all();
  session_.networks->put_foreign(state, session_.member->view());
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
  if (!session_.member) return;
  if (std::holds_alternative<cc::StoreState>(message)) {
    session_.member->on_state(store_, now());
  } else if (const auto* snapshot = std::get_if<ClusterSnapshot>(&message)) {
    session_.member->on_snapshot_begin(snapshot->revision, now());
  } else if (std::holds_alternative<ClusterSynced>(message)) {
    session_.member->on_snapshot_end(now());
  } else if (const auto* batch = std::get_if<cc::Batch>(&message)) {
    session_.member->on_batch(*batch, now());
  } else if (auto* result = std::get_if<cc::TxnResult>(&message)) {
    if (result->id >> kTxnBits != generation_) return;
    result->id &= (std::uint64_t{1} << kTxnBits) - 1;
    session_.member->on_result(*result, now());
  }
}

/// Takes in what an event says about the world. Decisions that follow from it are a separate step.
void Membership::take_in(const cc::Event& event) {
  if (const auto* changed = std::get_if<cc::ForeignChanged>(&event)) {
    session_.networks->touch(changed->network);
  } else if (const auto* failed = std::get_if<cc::Failed>(&event)) {
    session_.failed[failed->gateway] = failed->failed;
    if (failed->failed) wish_anew();
  } else if (const auto* lost = std::get_if<cc::Lost>(&event)) {
    lost_ = true;
    session_.reserving->lost();
    session_.adopting->lost();
    waiting_.note_lost(lost->why);
    if (session_.joined)
      parts_.log.warning(Kind::gateway, "what was reserved is closed: " + lost->why);
  } else if (const auto* found = std::get_if<cc::Found>(&event)) {
    session_.reserving->on(*found, *session_.member, [this](const cluster::StoredRequest& asked) {
      return !is_leaving() && (wishes_.is_known(asked) || (wishes_.has_publishers_of(asked) &&
                                                           session_.adopting->keep_found(asked)));
    });
  } else if (std::holds_alternative<cc::Joined>(event)) {
    session_.joined = true;
    former_.find(*session_.member, parts_.recorder);
    waiting_.forget_pauses();
    session_.lapsed_at.reset();
  } else if (const auto* withdrawn = std::get_if<cc::Withdrawn>(&event)) {
    session_.reserving->on(*withdrawn, *session_.member);
  } else if (const auto* adopt = std::get_if<cc::Adopt>(&event)) {
    session_.adopting->on(*adopt);
  } else if (const auto* opened = std::get_if<cc::Opened>(&event)) {
    session_.adopting->on(*opened);
  } else if (const auto* ended = std::get_if<cc::Ended>(&event)) {
    session_.adopting->on(*ended);
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
    session_.networks->touch_all();
    parts_.rollout.on(*to);
  } else if (std::holds_alternative<cc::Drained>(event)) {
    phase_ = Phase::left;
    if (is_drained_) session_.adopting->lost();
  }
}

/// Handles events that need decisions; false if the event is none of these.
// NOLINTNEXTLINE(readability-make-member-function-const): it changes the session
bool Membership::decide(const cc::Event& event) {
  if (const auto* reserved = std::get_if<cc::Reserved>(&event))
    session_.reserving->on(*reserved, *session_.member);
  else if (const auto* conflict = std::get_if<cc::Conflict>(&event))
    session_.reserving->on(*conflict, *session_.member, now());
  else if (const auto* refused = std::get_if<cc::Refused>(&event))
    session_.reserving->on(*refused, *session_.member);
  else
    return false;
  return true;
}

// --- the turn ------------------------------------------------------------------------------------

void Membership::act() {
  session_.member->on_time(now());
  drain_when_closed();
  session_.adopting->begin_turn();
  bool more = true;
  for (int round = 0; more && round < kMostRounds; ++round) {
    const std::vector<cc::Event> events = session_.member->take_events();
    for (const cc::Event& event : events) take_in(event);
    static_cast<void>(bring_in_line());
    for (const cc::Event& event : events) decide(event);
    waiting_.end_withdrawn();
    more = session_.adopting->step(*session_.member, now()) || !events.empty();
    more = session_.reserving->step(*session_.member, now()) || more;
    more = parts_.rollout.step(*session_.member) || more;
    more = more || wish_some();
  }
  lost_ = !bring_in_line() && lost_;
  propose_first();
  // The store is not informed of a closing that the kernel has refused.
  if (!more && session_.adopting->has_opened() && parts_.turn.in_line())
    session_.member->applied(session_.member->view().revision());
  send();
  report();
  plan();
}

/// Brings gates and state in line with the permits and with what others hold. The kernel gets the
/// end of the lease before gates open, and loses it only after they have closed.
bool Membership::bring_in_line() {
  if (!decided_) return false;
  if (session_.reserving->take_agreements_changed())
    if (const core::FormerRules left = waiting_.follow_agreements(true); !left.empty())
      static_cast<void>(parts_.turn.settle(left));
  note_failed();
  set_permits();
  session_.networks->put_foreign(state(), session_.member->view());
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
  const auto& current = session_.member->view().records().current.value;
  return session_.member->view().complete() && current && current->open &&
         current->digest == session_.digest;
}

Value Membership::leased_end() const {
  return sub_floor(session_.member->valid_until(), parts_.lease / kMarginParts);
}

bool Membership::may_use_leased() const {
  const auto standing = session_.member->standing(now());
  return (standing == cc::Member::Standing::joined || standing == cc::Member::Standing::waiting) &&
         now() < leased_end();
}

void Membership::set_permits() {
  core::Permits& permits = session_.networks->permits();
  if (!session_.joined || is_leaving() || is_unheard() || !is_in_force() || parts_.scene.unchecked)
    permits.close(true);
  else if (!may_use_leased() || open_until_.is_refused())
    permits.close(false);
  else
    permits.open();
}

void Membership::raise_until() {
  if (session_.networks->permits().is_open() && session_.networks->has_leased())
    set_until(session_.member->valid_until());
}

void Membership::lower_until() {
  if (!session_.networks->permits().is_open() || !session_.networks->has_leased()) set_until(0);
}

/// If the kernel refuses, everything that depends on the lease stays closed.
void Membership::set_until(std::uint64_t until) {
  if (!open_until_.set(until, decided_)) session_.networks->permits().close(false);
}

void Membership::note_failed() {
  const bool able = parts_.presence.can_carry();
  for (std::size_t g = 0; g < session_.failed.size(); ++g)
    state().set_failed(g, session_.failed[g] || (g == session_.self && !able));
  session_.member->set_able(able);
}

void Membership::committed(const Result<void>& done) {
  for (const auto& call : std::exchange(waits_, {})) call(done);
}

void Membership::poll() {
  if (!session_.member) return;
  parts_.rollout.poll();
  wishes_invalid_ = true;
  lines_.invalidate();
  wishes_.forget_past_pauses();
  enforce_again();
  session_.reserving->tidy();
  waiting_.give_back_without_place();
}

/// Writes to disk what was taken from the store, before anything is sent that depends on it. False
/// if that failed.
bool Membership::write_down() {
  const store::Membership record = this->record();
  if (parts_.recorder.contents().membership == record) return true;
  parts_.recorder.note_membership(record);
  if (decided_) {
    parts_.forwarding.act();
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
  auto txns = session_.member->take_txns(now());
  const bool written = write_down();
  for (cc::Txn& txn : txns) {
    if (!written) {
      session_.member->on_result({.id = txn.id,
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
  const auto& records = session_.member->view().records();
  if (!session_.joined || is_leaving() || !session_.member->view().complete() ||
      records.current.mod != 0 || records.next.mod != 0 || now() < propose_at_)
    return;
  propose_at_ = add_saturating(now(), kProposeAgain);
  session_.member->stage(parts_.rollout.own());
}

void Membership::plan() {
  if (parts_.loop == nullptr) return;
  const Value at = now();
  Value next = std::min(add_saturating(at, kLongestSleep), session_.member->next_time(at));
  if (leased_end() > at) next = std::min(next, leased_end());
  if (const auto due = session_.reserving->next_time()) next = std::min(next, *due);
  if (session_.adopting->has_due()) next = at;
  if (is_leaving() && leave_until_ > at) next = std::min(next, leave_until_);
  constexpr Value micro = 1000;
  timer_.set((sub_floor(next, at) / micro) + 1);
}

// --- what is wanted ------------------------------------------------------------------------------

bool Membership::waits_for(const std::string& key) const {
  return !key.empty() && session_.reserving && session_.reserving->waits_for(key);
}
// NOLINTNEXTLINE(readability-make-member-function-const): it changes the session
bool Membership::refuse(const std::string& key, const std::string& why) {
  return !key.empty() && session_.reserving && session_.reserving->refuse(key, why);
}

// NOLINTNEXTLINE(readability-make-member-function-const): it changes the session
void Membership::ask(Reserving::Job job) { session_.reserving->ask(std::move(job), now()); }

void Membership::admissions_gone(const std::vector<core::AdmissionId>& gone) {
  if (!session_.member) return;
  waiting_.forget(gone);
  session_.reserving->admissions_gone(gone);
  session_.adopting->publishers_gone();
}

void Membership::session_closed(std::uint64_t session) {
  parts_.rollout.session_closed(session);
  if (session_.reserving) session_.reserving->session_closed(session);
}

/// Asks for a channel that would be given more with a reservation: one that has lost its
/// reservation, or for which others leave more room than the description promises. It waits for its
/// turn while another admission is decided. It takes turns with what other gateways are asked for
/// again, since each of them may take until all patience is over. True if one was asked for.
bool Membership::wish_some() {
  if (!session_.joined || is_leaving() || !wishes_invalid_ || session_.reserving->has_own() ||
      !standing().empty() || !session_.networks->permits().is_open())
    return false;
  const bool wishes_first = std::exchange(waiting_asked_, false);
  if (wishes_first && wishes_.ask_for_one()) return true;
  waiting_asked_ = waiting_.ask_for_one();
  if (waiting_asked_ || (!wishes_first && wishes_.ask_for_one())) return true;
  wishes_invalid_ = false;
  return false;
}

void Membership::wish_anew() {
  wishes_.anew();
  wishes_invalid_ = true;
}

// --- standing
// -------------------------------------------------------------------------------------

std::string Membership::standing() const {
  if (is_leaving()) return leaving_words();
  if (parts_.scene.unchecked)
    return "all networks of this gateway are closed: whether its description takes others off one "
           "is not known before the store has the one in force";
  if (session_.member->standing(now()) == cc::Member::Standing::joined && store_.reachable)
    return {};
  return session_.member->why_not(now());
}

std::string Membership::bar(uid_t user) const {
  const std::string why = standing();
  return why.empty() ? session_.reserving->bar(user) : why;
}

std::string Membership::why_closed() const {
  const std::string why = standing();
  return why.empty() ? "the store has not answered lately" : why;
}

void Membership::expire() {
  if (!session_.member) return;
  // Before that, nobody can have called this gateway off.
  if (now() >= session_.member->valid_until()) session_.lapsed_at = now();
  session_.member->on_time(now());
  static_cast<void>(bring_in_line());
}

/// Whether the store has not confirmed a beat since the gates closed by themselves. Another gateway
/// can have called this one off by then, and another description can be in force.
bool Membership::is_unheard() {
  if (session_.lapsed_at &&
      session_.member->valid_until() >= cc::valid_until(*session_.lapsed_at, parts_.lease))
    session_.lapsed_at.reset();
  return session_.lapsed_at.has_value();
}

std::string Membership::rollout_bar() const {
  using Standing = cc::Member::Standing;
  if (is_leaving()) return leaving_words();
  if (!session_.member) return "this gateway starts";
  const Standing standing = session_.member->standing(now());
  const bool here = standing == Standing::joined || standing == Standing::other_digest ||
                    standing == Standing::waiting;
  return here && store_.reachable ? std::string() : session_.member->why_not(now());
}

std::vector<std::string> Membership::problems() const {
  if (!session_.member) return {};
  std::vector<std::string> out;
  if (const std::string why = standing(); !why.empty())
    out.push_back(fmt::format("cluster {}: {}: {}", session_.system, closed_words(), why));
  add_troubles(out);
  return out;
}

void Membership::report() {
  lines_.troubles(
      [this] {
        std::vector<std::string> troubles;
        add_troubles(troubles);
        return troubles;
      },
      now());
  const std::string why = standing();
  lines_.standing(session_.system, why, cc::Member::is_for_want_of_store(why), now());
}

// --- leaving
// --------------------------------------------------------------------------------------

void Membership::leave() {
  if (!session_.member) return;
  leave_until_ = add_saturating(now(), kLeaveLimit);
  if (!is_leaving()) begin_leaving();
}

void Membership::begin_leaving() {
  phase_ = Phase::closing;
  session_.reserving->refuse_all("this gateway is being drained");
  static_cast<void>(bring_in_line());
  drain_when_closed();
}

void Membership::drain_when_closed() {
  if (phase_ != Phase::closing || !parts_.turn.in_line()) return;
  phase_ = Phase::draining;
  session_.reserving->lost();
  session_.member->drain(now());
}

bool Membership::may_end() const {
  return !session_.member || has_left() || !store_.reachable || now() >= leave_until_;
}

/// Commits what waits to be written first, so that a failure of this entry does not revert it.
Result<void> Membership::write_drained(bool drained) {
  parts_.forwarding.act();
  parts_.turn.commit();
  store::Membership after = record();
  after.drained = drained;
  if (auto done = parts_.recorder.write_at_once({store::Entry(after)}); !done) return done;
  is_drained_ = drained;
  until_restart_ = false;
  return {};
}

Result<void> Membership::drain(bool until_restart) {
  if (until_restart)
    is_drained_ = until_restart_ = true;
  else if (auto written = write_drained(true); !written)
    return written;
  if (!is_leaving()) begin_leaving();
  return {};
}

/// Does what a start does: what the store still has of this gateway stays reserved, the rest is
/// requested again.
Result<void> Membership::join() {
  if (auto written = write_drained(false); !written) return written;
  phase_ = Phase::taking_part;
  session_.adopting->lost();
  state().set_permits(nullptr);
  begin();
  static_cast<void>(parts_.turn.settle(take_up_state(true)));
  return {};
}

std::string Membership::leaving_words() const {
  if (is_drained_ && has_left() && !until_restart_)
    return "this gateway is drained: 'mlccactl cluster join' ends that";
  if (is_drained_ && has_left()) return "this gateway is drained until mlccad is started again";
  return store_.reachable ? "this gateway is being drained"
                          : "this gateway is being drained, and the store does not answer";
}

std::string Membership::closed_words() const {
  if (permits().is_open()) return "nothing new is granted on networks of several gateways";
  return permits().standing_is_open() ? "what is reserved on networks of several gateways is closed"
                                      : "networks of several gateways are closed";
}

/// Problems of the store, which other gateways have as well.
void Membership::add_troubles(std::vector<std::string>& to) const {
  if (store_.no_space)
    to.push_back(
        fmt::format("cluster {}: the store is full, it takes nothing new", session_.system));
  const auto& records = session_.member->view().records();
  if (const auto words = cc::too_many_words(records, *session_.keys); !words.empty()) {
    to.push_back(
        fmt::format("cluster {}: the store has too many entries: nothing more is granted "
                    "on networks of several gateways: {}",
                    session_.system, words));
    return;
  }
  const core::State& now = state();
  for (std::size_t n = 0; n < session_.keys->networks(); ++n) {
    if (const auto words = cc::unreadable_words(records, *session_.keys, n); !words.empty())
      to.push_back(
          fmt::format("cluster {}: what the store has of {} cannot be read: nothing more "
                      "is granted there: {}",
                      session_.system, now.system().networks[n].name, words));
    if (const auto words = now.held_by_others().excess(n); !words.empty())
      to.push_back(fmt::format("cluster {}: {}", session_.system, words));
  }
  if (const auto words = cc::unreadable_words(records, *session_.keys); !words.empty())
    to.push_back(fmt::format("cluster {}: an entry of the store cannot be read: {}",
                             session_.system, words));
}

core::cluster::Foreign Membership::of_others(std::size_t network) const {
  return session_.member && session_.networks
             ? session_.networks->of_others(network, session_.member->view())
             : cc::Foreign{};
}

std::map<std::size_t, core::MadeFor> Membership::made_for(std::size_t network) const {
  return session_.member ? session_.member->view().made_for(network)
                         : std::map<std::size_t, core::MadeFor>{};
}

std::string Membership::unreadable(std::size_t network) const {
  return session_.member
             ? cc::unreadable_words(session_.member->view().records(), *session_.keys, network)
             : std::string();
}

std::string Membership::objection(std::size_t channel,
                                  std::span<const std::size_t> gateways) const {
  if (!session_.member || !permits().is_open()) return {};
  return wishes_.objection(state().system().channels[channel].name, gateways);
}

}  // namespace mlcca
