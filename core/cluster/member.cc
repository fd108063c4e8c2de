// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/member.hpp"

#include <algorithm>
#include <ranges>
#include <utility>

#include "core/cluster/lease.hpp"
#include "core/model/text.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core::cluster {
namespace {

/// Gateways do not fence at the same time. Each has its own time within 1 / kFenceSpread of a
/// lease.
constexpr Value kFenceSpread = 8;
/// When the store has refused a fence. Meanwhile other transactions do not wait behind it.
constexpr Value kFenceAgain = 2'000'000'000;

/// The most transactions while the view lacks the latest one of this gateway. Then the view is
/// waited for, but not for longer than until the next beat.
constexpr std::size_t kMostPassedOver = 4;

/// The store revision that the view must reach before it shows the entries that caused a conflict.
std::int64_t newest_of(const std::vector<Entry>& entries) {
  std::int64_t newest = 0;
  for (const Entry& entry : entries) newest = std::max(newest, entry.gone ? 0 : entry.mod);
  return newest;
}

/// The most keys that one transaction deletes, and the time after which a refused one is tried
/// again.
constexpr std::size_t kMostCleaned = 64;
constexpr Value kCleanAgain = 60'000'000'000;

/// Whether only the fence and votes of the gateway are left.
bool has_nothing_itself(const LeftRecord& left) {
  return std::ranges::all_of(std::views::values(left.keys), [](const LeftRecord::Key& key) {
    return key.voter || key.kind == Key::Kind::fence || key.kind == Key::Kind::rollout_vote;
  });
}

}  // namespace

Member::Member(std::shared_ptr<const Keys> keys, const Codec& codec, const Identity& identity)
    : keys_(std::move(keys)),
      codec_(&codec),
      identity_(identity),
      journal_(identity_.was),
      view_(keys_, codec, identity_.gateway),
      chain_(keys_, codec, identity_.gateway, identity_.session, identity_.lease),
      admissions_(identity_.gateway, identity_.session, identity_.first_wait),
      adoptions_(identity_.gateway),
      election_(identity_.gateway, keys_->gateways()),
      rollouts_(identity_.gateway, identity_.digest, identity_.rollout_patience) {}

void Member::on_state(const StoreState& state, Value now) {
  reachable_ = state.reachable;
  problem_ = state.problem;
  on_time(now);
}

void Member::on_snapshot_begin(std::int64_t revision, Value now) {
  view_.begin_snapshot(revision);
  step(now);
}

void Member::on_batch(const Batch& batch, Value now) {
  view_.apply(batch, now);
  step(now);
}

void Member::on_snapshot_end(Value now) {
  view_.end_snapshot(now);
  step(now);
}

void Member::on_time(Value now) {
  view_.on_time(now);
  settle(chain_.on_time(now), now);
  step(now);
}

void Member::on_result(const TxnResult& result, Value now) {
  if (!result.why.empty()) problem_ = result.why;
  full_ = result.outcome == Outcome::full;
  settle(chain_.on_result(result, now), now);
  step(now);
}

void Member::settle(const std::vector<Done>& all, Value now) {
  for (const Done& done : all) {
    const bool is_done = done.fate == Done::Fate::done;
    if (is_done) {
      on_joined(done.revision, now);
      election_.on_committed(done.work.role, done.revision);
    }
    if (!done.read.empty()) wait_for_ = newest_of(done.read);
    if (done.work.kind == Work::Kind::vote)
      adoptions_.on_done(done, view_);
    else
      admissions_.on_done(done, view_, now, events_);
    rollouts_.on_done(done, now, events_);
    on_cleaned(done, now);
    if (done.work.kind == Work::Kind::fence && done.fate == Done::Fate::refused)
      not_before_.fence = add_saturating(now, kFenceAgain);
    if (is_done && done.work.kind == Work::Kind::reserve) journal_.seen_revision = done.revision;
    if (is_done && done.work.kind == Work::Kind::leave) {
      chain_.end(now);
      phase_ = Phase::left;
      events_.emplace_back(Drained{});
    }
  }
  heed_trouble(now);
}

/// What the store has refused may mean that nothing of this gateway counts any more.
void Member::heed_trouble(Value now) {
  if (phase_ != Phase::joined && phase_ != Phase::joining) return;
  switch (chain_.trouble()) {
    case Chain::Trouble::none:
      break;
    case Chain::Trouble::fenced:
      lose("another gateway has taken this one for dead", now);
      break;
    case Chain::Trouble::new_epoch:
      lose("the store was restored", now);
      break;
    case Chain::Trouble::gone_back:
      go_back(now);
      break;
  }
}

void Member::on_joined(std::int64_t revision, Value now) {
  if (phase_ != Phase::joining) return;
  phase_ = Phase::joined;
  found_ = false;
  if (chain_.incarnation() == journal_.incarnation) return;
  journal_.incarnation = chain_.incarnation();
  journal_.epoch = view_.records().epoch.value.value_or(Epoch{});
  journal_.epoch_revision = chain_.epoch();
  journal_.seen_revision = revision;
  journal_.gone_back = false;
  journal_.waits = now < view_.leases_end();
}

void Member::lose(const std::string& why, Value now) {
  chain_.end(now);
  events_.emplace_back(Lost{.why = why});
  admissions_.lose(why, events_);
  adoptions_.lose(view_);
  election_.lose();
  rollouts_.lose();
  // Revisions from before are meaningless in a store that was restored.
  applied_ = said_.applied = ask_applied_ = 0;
  found_ = false;
  phase_ = Phase::off;
}

void Member::go_back(Value now) {
  if (phase_ == Phase::gone_back || phase_ == Phase::left) return;
  lose("the store has gone back: it was restored, or its entries were changed", now);
  phase_ = Phase::gone_back;
  journal_.gone_back = true;
  wait_for_ = 0;
}

bool Member::same_epoch() const {
  const auto& epoch = view_.records().epoch;
  return epoch.mod == journal_.epoch_revision && epoch.value.value_or(Epoch{}) == journal_.epoch;
}

/// Whether the store lacks something that this gateway knows it had.
bool Member::has_gone_back() const {
  const auto& own = view_.records().members[identity_.gateway];
  const bool lacks =
      journal_.incarnation != 0 && (view_.went_back() || own.mod < journal_.incarnation ||
                                    view_.revision() < journal_.seen_revision);
  return same_epoch() && (journal_.gone_back || lacks);
}

void Member::begin(Value now) {
  if (has_gone_back()) {
    go_back(now);
    return;
  }
  const auto& own = view_.records().members[identity_.gateway];
  const auto& beat = own.beat;
  const std::int64_t incarnation = beat && beat->incarnation != 0 ? beat->incarnation : own.mod;
  goes_on_ = journal_.incarnation != 0 && same_epoch() && beat &&
             incarnation == journal_.incarnation && own.fence < incarnation;
  // The time V applies to all gates, so what an earlier incarnation opened is closed before
  // there is a V.
  if (!goes_on_) events_.emplace_back(Lost{.why = "this gateway joins again"});
  // Members from before the store was restored may send until their leases have ended.
  if (!same_epoch() || journal_.waits) view_.await_leases(now, identity_.lease);
  if (view_.went_back()) wait_for_ = 0;
  view_.forget_going_back();
  chain_.begin(own.mod, goes_on_ ? incarnation : 0, view_.records().epoch.mod,
               beat ? beat->lease : 0);
  election_.begin(goes_on_ ? beat->role : Role::standby);
  phase_ = Phase::joining;
}

/// Acts on what the view says about this gateway.
void Member::check_standing(Value now) {
  if (!view_.complete() || phase_ == Phase::left) return;
  if (phase_ == Phase::gone_back) {
    if (same_epoch()) return;
    phase_ = Phase::off;
  }
  if (phase_ == Phase::joined || phase_ == Phase::joining) {
    const auto& own = view_.records().members[identity_.gateway];
    const bool fenced = chain_.incarnation() != 0 && own.fence >= chain_.incarnation();
    if (view_.went_back()) {
      go_back(now);
      check_standing(now);
      return;
    }
    if (view_.records().epoch.mod != chain_.epoch())
      lose("the store was restored", now);
    else if (fenced)
      lose("another gateway has taken this one for dead", now);
  }
  if (phase_ == Phase::off && (view_.went_back() || view_.revision() >= wait_for_)) begin(now);
}

void Member::step(Value now) {
  check_standing(now);
  const bool joined = phase_ == Phase::joined;
  if (joined && now >= view_.leases_end()) journal_.waits = false;
  if (joined && !found_ && caught_up()) {
    found_ = true;
    // What an earlier incarnation had may still be there if this one has been started twice since.
    admissions_.find(view_, journal_.incarnation, now, events_);
    events_.emplace_back(Joined{.goes_on = goes_on_});
  }
  const std::size_t before = events_.size();
  for (const std::size_t network : view_.take_changed())
    events_.emplace_back(ForeignChanged{.network = network});
  adoptions_.step(view_, joined && found_, events_);
  for (const std::size_t network : view_.take_changed())
    events_.emplace_back(ForeignChanged{.network = network});
  // The other gateways use another description now, and this one has closed what it had of the
  // former description.
  if (joined && found_ && other_is_open())
    admissions_.withdraw_all("another description is in force", now, events_);
  admissions_.step(view_, now, events_);
  election_.step(view_, now, joined, events_);
  rollouts_.step(view_, now, joined && found_ && caught_up(), events_);
  const auto others_wait = [](const Event& event) {
    return !std::holds_alternative<ForeignChanged>(event);
  };
  if (std::any_of(events_.begin() + static_cast<std::ptrdiff_t>(before), events_.end(),
                  others_wait))
    ask_applied_ = view_.revision();
}

bool Member::digest_in_force() const {
  const auto& current = view_.records().current.value;
  return current && current->open && current->digest == identity_.digest;
}

bool Member::other_is_open() const {
  const auto& current = view_.records().current.value;
  return current && current->open && current->digest != identity_.digest;
}

Member::Standing Member::standing(Value now) const {
  switch (phase_) {
    case Phase::off:
    case Phase::left:
      return Standing::off;
    case Phase::joining:
      return Standing::joining;
    case Phase::gone_back:
      return Standing::gone_back;
    case Phase::joined:
      break;
  }
  if (now >= chain_.valid_until()) return Standing::silent;
  if (draining_) return Standing::draining;
  if (!digest_in_force()) return Standing::other_digest;
  return now < view_.leases_end() ? Standing::waiting : Standing::joined;
}

/// Which lease may last longest, and how long it may.
std::string Member::why_leases_last() const {
  if (const auto longest = view_.with_too_long_lease())
    return ", and " + keys_->gateway_name(*longest) + " states one of " +
           format_span(view_.lease(*longest));
  const std::string most =
      ": that takes at most " + format_span(view_.longest_awaited()) + " and a second";
  const auto unread = view_.with_unread_beat();
  return unread
             ? most + ", because the entry of " + keys_->gateway_name(*unread) + " cannot be read"
             : most;
}

std::string Member::why_no_description() const {
  const auto& current = view_.records().current;
  if (current.mod == 0) return "no description is in force yet";
  if (!current.value) return "the description in force cannot be read in the store (d/current)";
  if (current.value && current.value->digest == identity_.digest)
    return "the description is not in force before all gateways are in it";
  return "the description in force is another one: 'mlccactl rollout' puts that of this gateway in "
         "force for all, or takes up the other one (--accept)";
}

std::string Member::why_not(std::uint64_t id, Value now) const {
  switch (standing(now)) {
    case Standing::off:
    case Standing::silent:
      return no_answer();
    case Standing::joining:
      return "this gateway is joining the cluster";
    case Standing::gone_back:
      return "the store has gone back, or somebody has changed the entry of this gateway (" +
             keys_->member(identity_.gateway) +
             "): it needs another epoch (docs/how-to/shared-closed.md)";
    case Standing::waiting:
      return "the store was restored: leases from before have not ended yet" + why_leases_last();
    case Standing::other_digest:
      return why_no_description();
    case Standing::draining:
      return "this gateway is being drained";
    case Standing::joined:
      break;
  }
  if (!reachable_) return no_answer();
  if (!found_ || admissions_.deciding(id)) return "another admission is being decided";
  return {};
}

void Member::reserve(Wanted wanted, Value now) {
  const std::uint64_t id = wanted.id;
  if (std::string why = why_not(id, now); !why.empty()) {
    admissions_.release(id, now);
    events_.emplace_back(Refused{
        .id = id, .why = {.ok = false, .hop = {}, .reason = std::move(why)}, .by = std::nullopt});
    return;
  }
  admissions_.reserve(std::move(wanted), view_, now, events_);
}

void Member::release(std::uint64_t id, Value now) {
  admissions_.release(id, now);
  step(now);
}

void Member::vote(const Origin& origin, Vote vote, Value now) {
  adoptions_.vote(origin, std::move(vote), view_, events_);
  step(now);
}

void Member::applied(std::int64_t revision) {
  // Until it has joined, gates that the previous process opened may still be open.
  if (found_) applied_ = std::max(applied_, std::min(revision, view_.revision()));
}

void Member::drain(Value now) {
  draining_ = true;
  admissions_.release_all("this gateway is being drained", now, events_);
  step(now);
}

void Member::vote_rollout(const Digest& digest, bool ok, std::string reason) {
  if (ok) journal_.voted_digest = digest;
  rollouts_.vote(digest, ok, std::move(reason));
}

std::vector<Event> Member::take_events() { return std::exchange(events_, {}); }

Beat Member::beat(Value now) const {
  const auto& current = view_.records().current.value;
  return {.digest = identity_.digest,
          .generation = current && current->digest == identity_.digest ? current->generation : 0,
          .applied = applied_,
          .role = election_.wanted(view_, now, draining_),
          .draining = draining_};
}

bool Member::beat_wanted(Value now) const {
  const bool says_more = applied_ >= ask_applied_ && ask_applied_ > said_.applied;
  return says_more || draining_ != said_.draining ||
         election_.wanted(view_, now, draining_) != election_.role() || now >= chain_.beat_due();
}

Value Member::fence_time(std::size_t gateway, Value from) const {
  const auto& beat = view_.records().members[gateway].beat;
  const Value lease = beat ? beat->lease : kMostLease;  // only a part of it is added to `from`
  const Value place = lease / kFenceSpread * identity_.gateway / keys_->gateways();
  return add_saturating(from, place);
}

std::optional<Work> Member::fence(Value now) const {
  if (now < not_before_.fence) return std::nullopt;
  for (std::size_t g = 0; g < keys_->gateways(); ++g) {
    const auto from = view_.fence_from(g);
    if (!from || now < fence_time(g, *from)) continue;
    return Work{.kind = Work::Kind::fence,
                .gateway = g,
                .compares = {{.key = keys_->member(g), .revision = view_.records().members[g].mod}},
                .puts = {{.key = keys_->fence(g), .value = keys_->gateway_name(identity_.gateway)}},
                .reads = {keys_->member(g)}};
  }
  return std::nullopt;
}

std::optional<Work> Member::work_for(For whom, Value now) {
  const bool may_take = now >= view_.leases_end() && !draining_ && digest_in_force();
  switch (whom) {
    case For::own:
      return admissions_.next_work(view_, *codec_, may_take, now);
    case For::others:
      return adoptions_.next_work(view_, *codec_);
    case For::all:
      return caught_up() ? work_for_all(now) : std::nullopt;
  }
  return std::nullopt;
}

std::optional<Work> Member::work_for_all(Value now) {
  if (auto work = adoptions_.clean_up(view_)) return work;
  if (auto work = clean_up(now)) return work;
  if (auto work = fence(now)) return work;
  if (draining_ && said_.draining && admissions_.empty())
    return Work{.kind = Work::Kind::leave, .deletes = {keys_->member(identity_.gateway)}};
  return rollouts_.next_work(view_, *codec_, now);
}

/// A gateway that has much to do for some is there for the others too.
std::optional<Work> Member::next_work(Value now) {
  if (!found_ || view_.revision() < wait_for_) return std::nullopt;
  if (caught_up() || now >= chain_.beat_due()) turn_.passed_over = 0;
  if (turn_.passed_over >= kMostPassedOver) return std::nullopt;
  for (std::size_t n = 1; n <= kFor; ++n) {
    const auto whom = static_cast<For>((static_cast<std::size_t>(turn_.latest) + n) % kFor);
    auto work = work_for(whom, now);
    if (!work) continue;
    turn_.latest = whom;
    if (!caught_up()) ++turn_.passed_over;
    return work;
  }
  return std::nullopt;
}

std::vector<Txn> Member::take_txns(Value now) {
  std::vector<Txn> txns;
  const bool here = phase_ == Phase::joining || phase_ == Phase::joined;
  if (!here || !reachable_ || chain_.busy(now)) return txns;
  std::optional<Work> work;
  if (phase_ == Phase::joining)
    work = Work{.kind = Work::Kind::join};
  else if (!chain_.unsure())
    work = next_work(now);
  if (!work && beat_wanted(now)) work = Work{};
  if (!work) return txns;
  // A process that starts again finds no entry of this gateway, which is not an error then.
  if (work->kind == Work::Kind::leave) journal_.incarnation = 0;
  const Beat says = beat(now);
  work->role = says.role;
  said_ = {.applied = says.applied, .draining = says.draining};
  txns.push_back(chain_.send(std::move(*work), says, view_.revision(), now));
  return txns;
}

Value Member::next_time(Value now) const {
  Value next = kUnbounded;
  const auto at = [&](std::optional<Value> time) {
    if (time && *time > now) next = std::min(next, *time);
  };
  at(chain_.next_time(now));
  at(view_.next_event(now));
  at(admissions_.next_time(now));
  at(rollouts_.next_time(view_, now));
  at(view_.leases_end());
  if (phase_ != Phase::joined) return next;
  at(chain_.valid_until());
  at(chain_.beat_due());
  at(not_before_.fence);
  for (std::size_t g = 0; g < keys_->gateways(); ++g)
    if (const auto from = view_.fence_from(g)) at(fence_time(g, *from));
  return next;
}

// --- what has to leave the store -----------------------------------------------------------------

/// If the store refuses to delete entries, the role of this user in etcd may lack the right.
void Member::on_cleaned(const Done& done, Value now) {
  if (done.work.kind == Work::Kind::clean && done.fate != Done::Fate::done)
    not_before_.clean.at(done.work.number) = add_saturating(now, kCleanAgain);
}

/// Entries are deleted only after all gateways have left the former description.
std::optional<Work> Member::clean_up(Value now) const {
  if (!digest_in_force()) return std::nullopt;
  for (std::size_t kind = 0; kind < kUnused; ++kind) {
    if (now < not_before_.clean[kind]) continue;
    Work clean{.kind = Work::Kind::clean,
               .number = kind,
               .compares = {{.key = keys_->current(), .revision = view_.records().current.mod}}};
    add_unused(static_cast<Unused>(kind), now, clean);
    if (clean.deletes.size() > kMostCleaned) clean.deletes.resize(kMostCleaned);
    if (!clean.deletes.empty()) return clean;
  }
  return std::nullopt;
}

void Member::add_unused(Unused kind, Value now, Work& clean) const {
  if (kind == Unused::own)
    for (const auto& key : std::views::keys(view_.records().strange))
      if (keys_->is_of_removed_network(key, identity_.gateway)) clean.deletes.push_back(key);
  for (const auto& [gateway, left] : view_.records().left) {
    // One gateway at a time, because the compares of the transaction are about that gateway.
    if (kind == Unused::left && clean.deletes.empty()) add_left(gateway, left, now, clean);
    const bool gone = left.member.mod == 0 || view_.is_over(gateway, now);
    for (const auto& [name, key] : left.keys) {
      const bool own = key.kind == Key::Kind::vote && key.voter == identity_.gateway;
      const bool ballot = key.kind == Key::Kind::rollout_vote && gone;
      const bool last = key.kind == Key::Kind::fence && has_nothing_itself(left);
      if ((kind == Unused::own && own) || (kind == Unused::ballots && ballot) ||
          (kind == Unused::fences && last))
        clean.deletes.push_back(name);
    }
  }
}

/// Deletes the beat after all other entries, because beat and fence say that the gateway is dead.
/// The fence is deleted after the beat.
void Member::add_left(const std::string& gateway, const LeftRecord& left, Value now,
                      Work& clean) const {
  if (!view_.is_over(gateway, now)) return;
  std::vector<std::string> others;
  std::vector<std::string> beat;
  std::vector<Compare> compares;
  for (const auto& [name, key] : left.keys) {
    if (key.voter || key.kind == Key::Kind::rollout_vote) continue;
    const bool is_beat = key.kind == Key::Kind::member;
    if (is_beat || key.kind == Key::Kind::fence)
      compares.push_back({.key = name, .revision = key.mod});
    else
      others.push_back(name);
    if (is_beat) beat.push_back(name);
  }
  clean.deletes = others.empty() ? std::move(beat) : std::move(others);
  if (!clean.deletes.empty())
    clean.compares.insert(clean.compares.end(), compares.begin(), compares.end());
}

}  // namespace mlcca::core::cluster
