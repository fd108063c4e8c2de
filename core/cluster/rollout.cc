// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/rollout.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/cluster/lease.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core::cluster {
namespace {

/// The most chunks of former descriptions that one transaction deletes.
constexpr std::size_t kMostOldChunks = 64;
constexpr const char* kOther = "another description is being rolled out";
constexpr const char* kOthersOff = "it is being rolled out already, with other gateways called off";
constexpr const char* kElsewhere =
    "only a gateway that has the description in force can roll out another one";
constexpr const char* kUnreadable = "what is proposed in the store cannot be read";
constexpr const char* kGone = "what was proposed is not in the store any more";
constexpr const char* kChanged =
    "its text cannot be put into the store: what is proposed there was ended or changed meanwhile";
constexpr const char* kIncomplete = "its text is not complete in the store";
/// Value of Work::number for a work that only makes room.
constexpr std::uint64_t kNoChunk = ~std::uint64_t{0};

/// The text of the proposed description; nullopt if chunks are missing.
std::optional<std::string> content_of(const Records& records, const Next& next) {
  std::string all;
  const std::string digest = hex_of(next.digest);
  for (std::uint32_t n = 0; n < next.chunks; ++n) {
    const auto it = records.blobs.find({digest, n});
    if (it == records.blobs.end()) return std::nullopt;
    all += it->second;
  }
  return all;
}

/// Whether all chunks are in the store.
bool is_complete(const Records& records, const Next& next) {
  const std::string digest = hex_of(next.digest);
  for (std::uint32_t n = 0; n < next.chunks; ++n)
    if (!records.blobs.contains({digest, n})) return false;
  return true;
}

bool is_in_force(const Records& records, const std::optional<Digest>& digest) {
  return records.current.value && digest && records.current.value->digest == *digest;
}

bool has_all(const std::vector<std::string>& names, const std::vector<std::string>& others) {
  return std::ranges::all_of(
      others, [&](const auto& name) { return std::ranges::find(names, name) != names.end(); });
}

constexpr const char* kNotWaitedFor =
    "it comes into force already, and waits for none of the gateways that are called off";

}  // namespace

void Rollouts::stage(Rollout rollout) {
  pending_ = rollout.digest;
  staged_ = std::move(rollout);
  ++stage_;
  chunk_ = 0;
  claimed_ = 0;
  has_called_off_ = false;
  cancelled_.reset();
  trouble_.clear();
}

/// Ends what was staged here, with an event.
void Rollouts::give_up(std::string why, std::vector<Event>& events) {
  staged_.reset();
  pending_.reset();
  claimed_ = 0;
  events.emplace_back(NotRolledOut{.why = std::move(why)});
}

void Rollouts::vote(const Digest& digest, bool ok, std::string reason) {
  if (cancelled_ && cancelled_->first == digest) return;
  if (proposed_ == digest && judged_ == next_seen_ && judged_ != 0)
    ballot_ = RolloutVote{.next = judged_, .ok = ok, .reason = std::move(reason)};
}

void Rollouts::cannot_switch(const View& view, std::string reason) {
  const auto& current = view.records().current;
  if (current.mod != 0)
    ballot_ = RolloutVote{.next = current.mod, .ok = false, .reason = std::move(reason)};
}

void Rollouts::cancel(const Digest& digest, std::string why) {
  cancelled_.emplace(digest, std::move(why));
}

/// Votes against the entry with that revision, unless that was done.
void Rollouts::object(const View& view, std::int64_t to) {
  const auto& vote = view.records().rollout_votes[self_].value;
  const auto is_objection = [to](const auto& one) { return one && one->next == to && !one->ok; };
  if (!is_objection(vote) && !is_objection(ballot_))
    ballot_ = RolloutVote{.next = to, .ok = false, .reason = cancelled_->second};
}

/// The vote of this gateway ends a proposal, or brings the former description back. What was not
/// sent to the store yet is dropped.
void Rollouts::step_cancelled(const View& view, bool caught_up, std::vector<Event>& events) {
  if (!cancelled_ || !caught_up) return;
  const auto& [digest, why] = *cancelled_;
  const auto& next = view.records().next;
  const auto& current = view.records().current;
  if (next.value && next.value->digest == digest) {
    object(view, next.mod);
  } else if (current.value && current.value->digest == digest && !current.value->open &&
             !current.value->undone) {
    object(view, current.mod);
  } else {
    if (staged_ && claimed_ == 0 && staged_->digest == digest) give_up(why, events);
    cancelled_.reset();
  }
}

/// Reports a new proposal, once its text is complete in the store, so that it is judged.
void Rollouts::judge(const View& view, std::vector<Event>& events) {
  const auto& next = view.records().next;
  if (!next.value || judged_ == next.mod || !is_complete(view.records(), *next.value)) return;
  auto content = content_of(view.records(), *next.value);
  if (!content) return;
  judged_ = next.mod;
  events.emplace_back(Judge{
      .digest = next.value->digest, .content = std::move(*content), .force = next.value->force});
}

/// Notices that the proposal d/next has changed or ended, and reports the end of the former one.
void Rollouts::step_next(const View& view, Value now, std::vector<Event>& events) {
  const Records& records = view.records();
  if (records.next.mod == next_seen_) return;
  // What is staged here may have replaced another proposal of the same description.
  const bool replaced = staged_ && records.next.value && is_ours(view, *records.next.value) &&
                        is_staged(*records.next.value);
  const bool ours = pending_ && proposed_ == pending_ && !replaced;
  std::string why = std::exchange(why_, {});
  if (why.empty() && records.next.mod != 0) why = kOther;
  if (next_seen_ != 0 && !is_in_force(records, proposed_)) {
    if (ours)
      give_up(std::move(why), events);
    else if (!replaced)
      events.emplace_back(NotRolledOut{.why = std::move(why)});
  }
  if (ours) staged_.reset();
  if (ballot_ && ballot_->next == next_seen_) ballot_.reset();
  next_seen_ = records.next.mod;
  next_since_ = now;
  proposed_ = records.next.value ? std::optional(records.next.value->digest) : std::nullopt;
}

bool Rollouts::knows_all(const View& view) const {
  const auto& current = view.records().current;
  return current.mod == 0 || (current.value && current.value->digest == own_);
}

bool Rollouts::gives_way(const Records& records, const std::vector<std::string>& without) {
  const auto& next = records.next.value;
  return records.current.mod == 0 && next && next->without.empty() && !without.empty();
}

/// Whether it is the staged description, with the same gateways called off.
bool Rollouts::is_staged(const Next& next) const {
  return next.digest == staged_->digest && has_all(next.without, staged_->without) &&
         has_all(staged_->without, next.without);
}

/// Drops the staged description if another proposal bars it, or if this gateway may not roll out.
void Rollouts::step_staged(const View& view, Value now, std::vector<Event>& events) {
  const auto& next = view.records().next;
  if (!staged_ || claimed_ != 0) return;
  if (!knows_all(view)) {
    give_up(kElsewhere, events);
    return;
  }
  if (const auto& current = view.records().current.value;
      current && current->digest == staged_->digest) {
    if (current->open)
      staged_.reset();
    else
      step_calling_off(view, now, events);
    return;
  }
  if (next.mod == 0) return;
  const bool same = next.value && is_staged(*next.value);
  if (same && is_ours(view, *next.value)) {
    claimed_ = next.mod;
    return;
  }
  if (same)
    staged_.reset();
  else if (!next.value)
    give_up(kUnreadable, events);
  else if (!gives_way(view.records(), staged_->without))
    give_up(next.value->digest == staged_->digest ? kOthersOff : kOther, events);
}

/// Ends a rollout whose proposal has ended while this gateway saw nothing, or under a former
/// Member.
void Rollouts::step_pending(const View& view, std::vector<Event>& events) {
  const auto& next = view.records().next;
  const bool waits = staged_ && claimed_ == 0;
  if (!pending_ || waits || (next.value && next.value->digest == *pending_)) return;
  if (is_in_force(view.records(), pending_))
    pending_.reset();
  else
    give_up(kGone, events);
}

void Rollouts::step(const View& view, Value now, bool caught_up, std::vector<Event>& events) {
  const Records& records = view.records();
  step_next(view, now, events);
  step_cancelled(view, caught_up, events);
  step_staged(view, now, events);
  if (caught_up) step_pending(view, events);
  if (records.current.mod != current_seen_) {
    current_seen_ = records.current.mod;
    current_since_ = records.current.value && !records.current.value->open ? now : 0;
    if (const auto& current = records.current.value)
      events.emplace_back(Switch{.digest = current->digest,
                                 .former = current->former,
                                 .generation = current->generation,
                                 .open = current->open,
                                 .undone = current->undone});
  }
  judge(view, events);
  const auto& current = records.current.value;
  if (!current || current->open || !all_in(view, now))
    left_at_.reset();
  else if (!left_at_)
    left_at_ = now;
}

/// The entry d/next is written first, so that no other rollout is staged at the same time. Then
/// come the chunks; those of former descriptions are deleted to make room.
std::optional<Work> Rollouts::propose(const View& view, const Codec& codec) const {
  const Keys& keys = view.keys();
  const Records& records = view.records();
  if (!staged_ || calls_off(records)) return std::nullopt;
  const std::string digest = hex_of(staged_->digest);
  const auto& current = records.current.value;
  if (claimed_ == 0) {
    if (cancelled_ && cancelled_->first == staged_->digest) return std::nullopt;
    if (records.next.mod != 0 && !gives_way(records, staged_->without)) return std::nullopt;
    return Work{.kind = Work::Kind::propose,
                .stage = stage_,
                .compares = {{.key = keys.next(), .revision = records.next.mod},
                             {.key = keys.current(), .revision = records.current.mod}},
                .puts = {{.key = keys.next(),
                          .value = codec.write(
                              Next{.generation = (current ? current->generation : 0) + 1,
                                   .digest = staged_->digest,
                                   .chunks = static_cast<std::uint32_t>(staged_->chunks.size()),
                                   .by = keys.gateway_name(self_),
                                   .without = staged_->without,
                                   .patience = patience_,
                                   .force = staged_->force})}}};
  }
  Work work{.kind = Work::Kind::chunk,
            .number = chunk_,
            .stage = stage_,
            .compares = {{.key = keys.next(), .revision = claimed_}}};
  for (const auto& [key, chunk] : records.blobs)
    if (key.first != digest &&
        !(current &&
          (key.first == hex_of(current->digest) || key.first == hex_of(current->former))) &&
        work.deletes.size() < kMostOldChunks)
      work.deletes.push_back(keys.blob(key.first, key.second));
  if (!work.deletes.empty()) {
    work.number = kNoChunk;
    return work;
  }
  if (chunk_ >= staged_->chunks.size()) return std::nullopt;
  work.puts = {{.key = keys.blob(digest, chunk_), .value = staged_->chunks[chunk_]}};
  return work;
}

/// Counts the votes of all gateways of the description in force, except for those that are off.
Rollouts::Tally Rollouts::tally(const View& view, const Next& next, Work& work, Value now) {
  Tally tally;
  const Records& records = view.records();
  for (std::size_t g = 0; g < view.keys().gateways(); ++g) {
    const std::string& name = view.keys().gateway_name(g);
    if (is_among(next.without, name)) {
      if (is_off(view, g, now, work)) continue;
      tally.all = false;
      tally.refused = true;
      tally.objection = there(name);
      continue;
    }
    const auto& vote = records.rollout_votes[g];
    const bool counts = vote.value && vote.value->next == records.next.mod;
    if (counts && vote.value->ok) {
      work.compares.push_back({.key = view.keys().rollout_vote(g), .revision = vote.mod});
      continue;
    }
    tally.all = false;
    if (tally.refused) continue;
    tally.refused = counts;
    if (counts || tally.objection.empty())
      tally.objection = name + ": " + (counts ? vote.value->reason : "it has not answered");
  }
  return tally;
}

bool Rollouts::is_ours(const View& view, const Next& next) const {
  return next.by == view.keys().gateway_name(self_);
}

/// An own proposal ends after the patience that it states, at most kPatience; that of another
/// gateway after twice kPatience, whatever it states.
Value Rollouts::over_at(const View& view) const {
  const auto& next = view.records().next.value;
  const bool ours = next && is_ours(view, *next);
  return add_saturating(next_since_, ours ? std::min(next->patience, patience_) : 2 * patience_);
}

/// The entry d/current with which the proposal comes into force. The one before it is the one that
/// was in force last: one that all were only changing to is not.
Current Rollouts::successor(const Records& records, const Next& next) {
  Current current{.generation = next.generation,
                  .digest = next.digest,
                  .former = {},
                  .open = false,
                  .waits = {}};
  const auto& was = records.current.value;
  if (!was) return current;
  const bool same = was->digest == next.digest;
  const bool comes = !was->open && !was->undone;
  const bool returns = comes ? was->former == next.digest : same && !was->open;
  current.former = same || (comes && !returns) ? was->former : was->digest;
  current.undone = returns;
  return current;
}

/// Puts the proposal in force if all agree, or ends it if one objects or time is up.
std::optional<Work> Rollouts::decide(const View& view, const Codec& codec, Value now) {
  const Keys& keys = view.keys();
  const Records& records = view.records();
  if (records.next.mod == 0) return std::nullopt;
  Work work{.kind = Work::Kind::decide,
            .compares = {{.key = keys.next(), .revision = records.next.mod},
                         {.key = keys.current(), .revision = records.current.mod}},
            .deletes = {keys.next()}};
  if (!records.next.value) {
    if (now < over_at(view)) return std::nullopt;
    why_ = kUnreadable;
    work.compares.resize(1);
    return work;
  }
  const Next& next = *records.next.value;
  const bool ours = is_ours(view, next);
  Tally votes = tally(view, next, work, now);
  if (!knows_all(view)) votes = {.all = false, .objection = kElsewhere, .refused = true};
  // Nobody will store the missing chunks.
  if (ours && !staged_ && !is_complete(records, next))
    votes = {.all = false, .objection = kIncomplete, .refused = true};
  if (ours && staged_ && !votes.refused && !trouble_.empty())
    votes.objection = "the store does not take its text: " + trouble_;
  if (!votes.all || !ours) {
    if (now < over_at(view) && !(ours && votes.refused)) return std::nullopt;
    why_ = votes.objection.empty() ? "the gateway that proposed it has gone" : votes.objection;
    work.compares.resize(1);
    return work;
  }
  Current current = successor(records, next);
  for (std::size_t g = 0; g < keys.gateways(); ++g)
    if (!is_among(next.without, keys.gateway_name(g)))
      current.waits.push_back(keys.gateway_name(g));
  work.puts.push_back({.key = keys.current(), .value = codec.write(current)});
  return work;
}

bool Rollouts::is_in(const View& view, std::size_t gateway) {
  const auto& record = view.records().current;
  const auto& beat = view.records().members[gateway].beat;
  return record.value && beat && beat->digest == record.value->digest &&
         beat->generation == record.value->generation && beat->applied >= record.mod;
}

/// Whether all gateways have left the former description: those that must follow, and all others
/// that are present.
bool Rollouts::all_in(const View& view, Value now) {
  if (!std::ranges::all_of(view.records().current.value->waits, [&](const std::string& name) {
        const auto g = view.keys().gateway(name);
        return g && is_in(view, *g);
      }))
    return false;
  for (std::size_t g = 0; g < view.keys().gateways(); ++g) {
    if (!is_gone(view, g, now) && !is_in(view, g)) return false;
  }
  return true;
}

/// Takes the rollout back if a gateway cannot follow, or has not for too long. That is done once
/// only, because a gateway that follows neither description is away.
std::optional<Work> Rollouts::undo(const View& view, const Codec& codec, Value now) const {
  const auto& record = view.records().current;
  if (!record.value || record.value->open || record.value->undone || left_at_ ||
      record.value->former == Digest{})
    return std::nullopt;
  const bool cannot = std::ranges::any_of(record.value->waits, [&](const std::string& name) {
    const auto g = view.keys().gateway(name);
    if (!g) return false;
    const auto& vote = view.records().rollout_votes[*g].value;
    return vote && vote->next == record.mod && !vote->ok;
  });
  if (!cannot && now < add_saturating(current_since_, patience_)) return std::nullopt;
  Current current = *record.value;
  std::swap(current.digest, current.former);
  ++current.generation;
  current.undone = true;
  return Work{.kind = Work::Kind::decide,
              .compares = {{.key = view.keys().current(), .revision = record.mod}},
              .puts = {{.key = view.keys().current(), .value = codec.write(current)}}};
}

/// Opens shared networks when no frame of the former description is in a queue any more.
std::optional<Work> Rollouts::open(const View& view, const Codec& codec, Value now) {
  if (!left_at_ || !knows_all(view) || now < queues_empty_at(*left_at_)) return std::nullopt;
  const auto& record = view.records().current;
  Current current = *record.value;
  current.open = true;
  return Work{.kind = Work::Kind::decide,
              .compares = {{.key = view.keys().current(), .revision = record.mod}},
              .puts = {{.key = view.keys().current(), .value = codec.write(current)}}};
}

std::optional<Work> Rollouts::next_work(const View& view, const Codec& codec, Value now) {
  if (now < quiet_until_) return std::nullopt;
  if (ballot_)
    return Work{
        .kind = Work::Kind::judge,
        .compares = {{.key = ballot_->next == view.records().current.mod ? view.keys().current()
                                                                         : view.keys().next(),
                      .revision = ballot_->next}},
        .puts = {{.key = view.keys().rollout_vote(self_), .value = codec.write(*ballot_)}}};
  if (view.revision() < not_before_) return std::nullopt;
  // decide() also ends a rollout whose text the store refuses, so it comes first.
  if (auto work = decide(view, codec, now)) return work;
  if (auto work = call_off(view, codec, now)) return work;
  if (auto work = propose(view, codec)) return work;
  if (auto work = undo(view, codec, now)) return work;
  return open(view, codec, now);
}

/// Handles the result of a transaction for what is proposed here.
void Rollouts::on_staged(const Done& done, std::vector<Event>& events) {
  if (done.work.stage != stage_) return;
  const bool is_done = done.fate == Done::Fate::done;
  const bool refused = done.fate == Done::Fate::refused;
  const bool proposes = done.work.kind == Work::Kind::propose;
  if (is_done && proposes) claimed_ = done.revision;
  if (is_done && !proposes && done.work.number != kNoChunk) chunk_ = done.work.number + 1;
  if (!staged_) return;
  if (is_done && claimed_ != 0 && chunk_ >= staged_->chunks.size()) staged_.reset();
  if (refused && !proposes) trouble_ = done.why;
  if (refused && proposes) give_up("the store does not take it: " + done.why, events);
  if (done.fate == Done::Fate::conflict) give_up(proposes ? kOther : kChanged, events);
}

void Rollouts::on_done(const Done& done, Value now, std::vector<Event>& events) {
  const bool settled = done.fate == Done::Fate::done || done.fate == Done::Fate::conflict;
  const bool refuted = done.fate == Done::Fate::conflict;
  const bool forbidden = done.fate == Done::Fate::refused;
  switch (done.work.kind) {
    case Work::Kind::chunk:
    case Work::Kind::propose:
      on_staged(done, events);
      break;
    case Work::Kind::decide:
      break;
    case Work::Kind::call_off:
      if (done.work.stage == stage_ && staged_) {
        has_called_off_ = has_called_off_ || done.fate == Done::Fate::done;
        if (forbidden) give_up("the store does not take it: " + done.why, events);
      }
      break;
    case Work::Kind::judge:
      if (settled && ballot_ && ballot_->next == done.work.compares.front().revision)
        ballot_.reset();
      break;
    default:
      return;
  }
  if (refuted && done.work.kind != Work::Kind::judge) not_before_ = done.revision;
  // Other gateways may do it; meanwhile this one goes on sending beats.
  if (forbidden) quiet_until_ = add_saturating(now, kForbidden);
}

std::optional<Value> Rollouts::next_time(const View& view, Value now) const {
  if (quiet_until_ > now) return quiet_until_;
  std::optional<Value> next;
  const auto at = [&](Value time) {
    if (time > now && (!next || time < *next)) next = time;
  };
  if (left_at_) at(queues_empty_at(*left_at_));
  const auto& current = view.records().current.value;
  if (current && !current->open && !current->undone) at(add_saturating(current_since_, patience_));
  if (view.records().next.mod != 0) at(over_at(view));
  return next;
}

// --- gateways that are called off ----------------------------------------------------------------

bool Rollouts::is_among(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

std::string Rollouts::there(const std::string& name) {
  return name + ": it was called off, and is there";
}

bool Rollouts::is_gone(const View& view, std::size_t gateway, Value now) {
  const Alive alive = view.alive(gateway, now);
  return alive == Alive::absent || alive == Alive::fenced;
}

bool Rollouts::is_off(const View& view, std::size_t gateway, Value now, Work& work) {
  // If no description is in force, nobody has anything to leave.
  if (view.records().current.mod == 0) return true;
  if (!is_gone(view, gateway, now)) return false;
  work.compares.push_back(
      {.key = view.keys().member(gateway), .revision = view.records().members[gateway].mod});
  return true;
}

/// Whether the staged description is the one that is coming into force. Then it is not proposed:
/// all have agreed to it, and gateways are only called off.
bool Rollouts::calls_off(const Records& records) const {
  const auto& current = records.current.value;
  return staged_ && claimed_ == 0 && current && !current->open &&
         current->digest == staged_->digest;
}

/// Ends a calling off when nobody waits for these gateways any more, or if one of them is there.
void Rollouts::step_calling_off(const View& view, Value now, std::vector<Event>& events) {
  const auto& waits = view.records().current.value->waits;
  bool waited_for = false;
  for (const std::string& name : staged_->without) {
    if (!is_among(waits, name)) continue;
    waited_for = true;
    const auto gateway = view.keys().gateway(name);
    // The lease of one that is fenced ends soon.
    if (gateway && (view.is_fenced(*gateway) || is_gone(view, *gateway, now))) continue;
    give_up(there(name), events);
    return;
  }
  if (waited_for) return;
  if (has_called_off_)
    staged_.reset();
  else
    give_up(kNotWaitedFor, events);
}

/// Has nobody wait any more for the gateways that are called off. It fails if one of them has come
/// back since.
std::optional<Work> Rollouts::call_off(const View& view, const Codec& codec, Value now) const {
  if (!calls_off(view.records())) return std::nullopt;
  const auto& record = view.records().current;
  Current current = *record.value;
  Work work{.kind = Work::Kind::call_off,
            .stage = stage_,
            .compares = {{.key = view.keys().current(), .revision = record.mod}}};
  for (const std::string& name : staged_->without) {
    const auto gateway = view.keys().gateway(name);
    if (!is_among(current.waits, name)) continue;
    if (!gateway || !is_off(view, *gateway, now, work)) return std::nullopt;
    std::erase(current.waits, name);
  }
  work.puts.push_back({.key = view.keys().current(), .value = codec.write(current)});
  return work;
}

}  // namespace mlcca::core::cluster
