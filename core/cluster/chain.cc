// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/chain.hpp"

#include <algorithm>
#include <utility>

#include "core/cluster/lease.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core::cluster {
namespace {

/// The most beats without an answer that are remembered. An older one that was committed after all
/// is recognised, but does not extend the lease.
constexpr std::size_t kMostUnsure = 8;
/// Fractions of a lease: between two beats; until an answer is given up; until a retry.
constexpr Value kBeats = 4, kPatience = 8, kRetries = 16;

std::int64_t revision_in(const std::vector<Entry>& entries, const std::string& key) {
  const auto it = std::ranges::find(entries, key, &Entry::key);
  return it == entries.end() || it->gone ? 0 : it->mod;
}

}  // namespace

Chain::Chain(std::shared_ptr<const Keys> keys, const Codec& codec, std::size_t self,
             std::uint64_t session, Value lease)
    : keys_(std::move(keys)),
      codec_(&codec),
      self_(self),
      session_(session),
      own_lease_(lease),
      lease_(lease) {}

void Chain::begin(std::int64_t base, std::int64_t incarnation, std::int64_t epoch,
                  Value former_lease) {
  base_ = base;
  incarnation_ = incarnation;
  epoch_ = epoch;
  lease_ = std::max(own_lease_, former_lease);
  joined_ = false;
  trouble_ = Trouble::none;
}

void Chain::end(Value now) {
  joined_ = false;
  flight_.reset();
  unsure_.clear();
  valid_until_ = std::min(valid_until_, now);
  // The view may be as old as at the time when the connection was lost.
  retry_at_ = now + (lease_ / kRetries);
}

Value Chain::patience() const { return lease_ / kPatience; }
Value Chain::beat_due() const {
  return unsure() ? retry_at_ : std::max(last_beat_ + (lease_ / kBeats), retry_at_);
}

bool Chain::has(Work::Kind kind, std::uint64_t id) const {
  const auto is = [&](const Sent& sent) { return sent.work.kind == kind && sent.work.id == id; };
  return (flight_ && is(*flight_)) || std::ranges::any_of(unsure_, is);
}

std::optional<Value> Chain::next_time(Value now) const {
  if (flight_) return flight_->at + (2 * patience());
  return retry_at_ > now ? std::optional(retry_at_) : std::nullopt;
}

Txn Chain::send(Work work, Beat beat, std::int64_t seen, Value now) {
  beat.incarnation = incarnation_;
  beat.session = session_;
  beat.seq = ++seq_;
  beat.lease = lease_;
  const std::string member = keys_->member(self_);
  const std::string fence = keys_->fence(self_);
  Txn txn{
      .id = seq_,
      .compares = {{.key = member, .revision = base_}, {.key = keys_->epoch(), .revision = epoch_}},
      .puts = {},
      .deletes = work.deletes,
      .else_get = {member, fence, keys_->epoch()},
      .patience_ns = patience()};
  if (incarnation_ != 0)
    txn.compares.push_back({.is = Compare::Is::less, .key = fence, .revision = incarnation_});
  if (work.kind != Work::Kind::leave)
    txn.puts.push_back({.key = member, .value = codec_->write(beat)});
  txn.compares.insert(txn.compares.end(), work.compares.begin(), work.compares.end());
  txn.puts.insert(txn.puts.end(), work.puts.begin(), work.puts.end());
  txn.else_get.insert(txn.else_get.end(), work.reads.begin(), work.reads.end());
  flight_ = Sent{.seq = seq_,
                 .at = now,
                 .lease = lease_,
                 .base = base_,
                 .seen = seen,
                 .work = std::move(work)};
  return txn;
}

/// Removes a sent transaction by its number; nullopt if it is not waited for.
std::optional<Chain::Sent> Chain::take(std::uint64_t seq) {
  std::optional<Sent> sent;
  if (flight_ && flight_->seq == seq) {
    sent = std::move(flight_);
    flight_.reset();
    return sent;
  }
  const auto it = std::ranges::find(unsure_, seq, &Sent::seq);
  if (it == unsure_.end()) return sent;
  sent = std::move(*it);
  unsure_.erase(it);
  return sent;
}

/// Takes note that a transaction was committed: it is a beat, so the lease is extended from when it
/// was sent.
void Chain::commit(Sent sent, std::int64_t revision, std::vector<Done>& done) {
  base_ = revision;
  joined_ = true;
  if (incarnation_ == 0) incarnation_ = revision;
  valid_until_ = std::max(valid_until_, cluster::valid_until(sent.at, sent.lease));
  last_beat_ = std::max(last_beat_, sent.at);
  lease_ = own_lease_;
  done.push_back({.work = std::move(sent.work), .fate = Done::Fate::done, .revision = revision});
  drop_unsure(done);
}

/// Finds out why a transaction was not done: a new epoch, a fence, another own entry, or one of its
/// own compares.
void Chain::conflict(Sent sent, const TxnResult& result, std::vector<Done>& done) {
  Done failed{.work = std::move(sent.work),
              .fate = Done::Fate::not_done,
              .revision = result.revision,
              .read = result.read};
  if (sent.base != base_) {
    done.push_back(std::move(failed));
    return;
  }
  const std::int64_t own = revision_in(result.read, keys_->member(self_));
  if (revision_in(result.read, keys_->epoch()) != epoch_) {
    trouble_ = Trouble::new_epoch;
  } else if (incarnation_ != 0 && revision_in(result.read, keys_->fence(self_)) >= incarnation_) {
    trouble_ = Trouble::fenced;
  } else if (own == base_) {
    failed.fate = Done::Fate::conflict;
  } else {
    follow(own, result, done);
  }
  done.push_back(std::move(failed));
}

/// The own entry was changed by an earlier transaction of this chain, or of a former process.
void Chain::follow(std::int64_t own, const TxnResult& result, std::vector<Done>& done) {
  if (own == 0) {
    const auto leave = std::ranges::find(unsure_, Work::Kind::leave,
                                         [](const Sent& sent) { return sent.work.kind; });
    if (leave == unsure_.end())
      trouble_ = Trouble::gone_back;
    else
      commit(*take(leave->seq), result.revision, done);
    return;
  }
  // A restored store may have an entry that this chain wrote before the latest one.
  if (own < base_) {
    trouble_ = Trouble::gone_back;
    return;
  }
  const auto entry = std::ranges::find(result.read, keys_->member(self_), &Entry::key);
  const auto beat = codec_->beat(entry->value);
  const bool ours = beat && beat->session == session_ && beat->seq <= seq_;
  if (auto earlier = ours ? take(beat->seq) : std::nullopt) {
    commit(std::move(*earlier), own, done);
  } else if (ours || !joined_) {
    base_ = own;
    drop_unsure(done);
  } else {
    trouble_ = Trouble::gone_back;
  }
}

/// These transactions demanded the own entry as it was before, so they will never be done.
void Chain::drop_unsure(std::vector<Done>& done) {
  for (Sent& other : std::exchange(unsure_, {}))
    done.push_back({.work = std::move(other.work), .fate = Done::Fate::not_done});
}

/// Moves the transaction under way to those whose outcome is unknown.
void Chain::make_unsure(Value now, std::vector<Done>& done) {
  done.push_back({.work = flight_->work, .fate = Done::Fate::unsure});
  unsure_.push_back(std::move(*flight_));
  flight_.reset();
  retry_at_ = now + (lease_ / kRetries);
  const auto beat = [](const Sent& sent) { return sent.work.kind == Work::Kind::beat; };
  const auto oldest = std::ranges::find_if(unsure_, beat);
  if (unsure_.size() > kMostUnsure && oldest != unsure_.end()) unsure_.erase(oldest);
}

std::vector<Done> Chain::on_result(const TxnResult& result, Value now) {
  std::vector<Done> done;
  if (result.outcome == Outcome::unsure) {
    if (flight_ && flight_->seq == result.id) make_unsure(now, done);
    return done;
  }
  auto sent = take(result.id);
  if (!sent) return done;
  const bool answered = result.outcome == Outcome::committed || result.outcome == Outcome::conflict;
  if (answered && result.revision < sent->seen) {
    // The answer may be older than what was seen since it was sent, but not than what was seen
    // before.
    trouble_ = Trouble::gone_back;
    return done;
  }
  if (result.outcome == Outcome::committed) {
    commit(std::move(*sent), result.revision, done);
  } else if (result.outcome == Outcome::conflict) {
    conflict(std::move(*sent), result, done);
  } else {
    retry_at_ = now + (lease_ / kRetries);
    done.push_back({.work = std::move(sent->work), .fate = Done::Fate::refused, .why = result.why});
  }
  return done;
}

std::vector<Done> Chain::on_time(Value now) {
  std::vector<Done> done;
  if (flight_ && now >= flight_->at + (2 * patience())) make_unsure(now, done);
  return done;
}

}  // namespace mlcca::core::cluster
