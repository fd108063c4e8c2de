// SPDX-License-Identifier: BSD-2-Clause
// One gateway in a cluster: what it asks of the store, and what it concludes from the answers. No
// I/O and no clock: `now` is CLOCK_MONOTONIC of the caller, in ns, never going back.
//
// The caller hands in what comes, takes the events and acts on them, takes the transactions, writes
// journalled() if that has changed, and only then sends them: before a transaction says that
// something is closed, it is. docs/explanation/cluster.md says why this is safe.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/cluster/admissions.hpp"
#include "core/cluster/adoptions.hpp"
#include "core/cluster/chain.hpp"
#include "core/cluster/election.hpp"
#include "core/cluster/rollout.hpp"
#include "core/cluster/view.hpp"

namespace mlcca::core::cluster {

class Member {
 public:
  struct Identity {
    std::size_t gateway = 0;    ///< of the description
    Digest digest = {};         ///< of that description
    std::uint64_t session = 0;  ///< random, another one in each process
    Value lease = 0;
    Journalled was = {};  ///< of the process before
    Value first_wait = Admissions::kFirstWait;
  };
  enum class Standing : std::uint8_t {
    off,  ///< it has left, or has not heard from the store yet
    joining,
    joined,        ///< all is well
    silent,        ///< the store does not answer: what is leased is closed
    gone_back,     ///< an operator must say that the store is right
    waiting,       ///< nothing new yet: leases from before the store was restored may last
    other_digest,  ///< the description in force is another one, or is not open yet
    draining,
  };

  Member(std::shared_ptr<const Keys> keys, const Codec& codec, const Identity& identity);

  // What comes in.
  void on_state(const StoreState& state, Value now);
  void on_snapshot_begin(std::int64_t revision, Value now);
  void on_batch(const Batch& batch, Value now);
  void on_snapshot_end(Value now);
  void on_result(const TxnResult& result, Value now);
  void on_time(Value now);

  // What the gateway wants.
  /// Empty: reserve() will be tried. One at a time.
  [[nodiscard]] std::string why_not(Value now) const;
  /// Decided from the view of now. It has one answer: Reserved, Refused, or Conflict, after which
  /// it is decided and reserved again, or released.
  void reserve(Wanted wanted, Value now);
  /// It is closed here, and has no answer any more.
  void release(std::uint64_t id, Value now);
  void vote(const Origin& origin, Vote vote, Value now);
  /// Everything is in force that events up to this revision ask for.
  void applied(std::int64_t revision);
  /// It can carry what others could carry as well. Closed before it is said that it cannot.
  void set_able(bool able) { election_.set_able(able); }
  /// What is leased, and what others could carry, is closed.
  void drain(Value now);
  void stage(Rollout rollout) { rollouts_.stage(std::move(rollout)); }
  /// A member before this one has staged it.
  void resume_rollout(const Digest& digest) { rollouts_.resume(digest); }
  void vote_rollout(const Digest& digest, bool ok, std::string reason);
  /// The description that comes into force cannot be put in force here, and is to be undone.
  void cannot_switch(std::string reason) { rollouts_.cannot_switch(view_, std::move(reason)); }
  [[nodiscard]] const Rollouts& rollouts() const { return rollouts_; }

  // What is to be done. Events first.
  [[nodiscard]] std::vector<Event> take_events();
  [[nodiscard]] std::vector<Txn> take_txns(Value now);
  /// Until then what is leased may be sent.
  [[nodiscard]] Value valid_until() const { return chain_.valid_until(); }
  /// on_time() is due; take_txns() after it.
  [[nodiscard]] Value next_time(Value now) const;
  [[nodiscard]] const View& view() const { return view_; }
  [[nodiscard]] std::size_t self() const { return identity_.gateway; }
  [[nodiscard]] Standing standing(Value now) const;
  [[nodiscard]] const std::string& problem() const { return problem_; }
  [[nodiscard]] const Journalled& journalled() const { return journal_; }
  [[nodiscard]] Role role() const { return election_.role(); }
  /// It is granted and open on the whole way.
  [[nodiscard]] bool holds(std::uint64_t id) const { return admissions_.granted(id); }
  /// The store has something of it, may have, or is to have.
  [[nodiscard]] bool knows(std::uint64_t id) const { return admissions_.knows(id); }

  /// All that it acts on, for a checker.
  template <class Visit>
  void visit_state(Visit&& visit) const {
    visit(journal_, view_, chain_, admissions_, adoptions_, election_, rollouts_, phase_,
          reachable_, draining_, goes_on_, found_, wait_for_, take_from_, applied_, said_applied_,
          ask_applied_, said_draining_);
  }

 private:
  enum class Phase : std::uint8_t { off, joining, joined, gone_back, left };
  /// What nobody uses any more, by who may delete it.
  enum class Unused : std::uint8_t {
    own,      ///< of removed networks, and votes for removed gateways: their own
    ballots,  ///< of removed gateways: whoever may roll out
    fences,   ///< the last key of such a gateway: any
    left,     ///< all else of it: nobody else, where the roles are as they should be
  };
  static constexpr std::size_t kUnused = 4;

  /// Whether `id` can be reserved.
  [[nodiscard]] std::string why_not(std::uint64_t id, Value now) const;
  void step(Value now);
  void begin(Value now);
  void lose(const std::string& why, Value now);
  void go_back(Value now);
  void check_standing(Value now);
  void settle(const std::vector<Done>& all, Value now);
  void on_joined(std::int64_t revision);
  void on_cleaned(const Done& done, Value now);
  [[nodiscard]] bool has_gone_back() const;
  [[nodiscard]] bool same_epoch() const;
  [[nodiscard]] bool digest_in_force() const;
  [[nodiscard]] bool other_is_open() const;
  [[nodiscard]] std::string why_no_description() const;
  [[nodiscard]] bool caught_up() const { return view_.revision() >= chain_.base(); }
  [[nodiscard]] Beat beat(Value now) const;
  [[nodiscard]] bool beat_wanted(Value now) const;
  [[nodiscard]] std::optional<Work> next_work(Value now);
  [[nodiscard]] std::optional<Work> fence(Value now) const;
  [[nodiscard]] std::optional<Work> clean_up(Value now) const;
  void add_unused(Unused kind, Value now, Work& clean) const;
  void add_left(const std::string& gateway, const LeftRecord& left, Value now, Work& clean) const;
  [[nodiscard]] Value fence_time(std::size_t gateway, Value from) const;

  std::shared_ptr<const Keys> keys_;
  const Codec* codec_;
  Identity identity_;
  Journalled journal_;
  View view_;
  Chain chain_;
  Admissions admissions_;
  Adoptions adoptions_;
  Election election_;
  Rollouts rollouts_;
  Phase phase_ = Phase::off;
  bool reachable_ = false, draining_ = false, goes_on_ = false, found_ = false;
  std::string problem_;
  std::int64_t wait_for_ = 0;  ///< the view must have this revision before anything but a beat
  Value take_from_ = 0;        ///< nothing is taken before
  /// The store has refused to delete that: not before.
  std::array<Value, kUnused> clean_from_{};
  std::int64_t applied_ = 0, said_applied_ = 0;
  std::int64_t ask_applied_ = 0;  ///< others wait to hear that this revision is applied
  Role said_role_ = Role::standby;
  bool said_draining_ = false;
  std::vector<Event> events_;
};

}  // namespace mlcca::core::cluster
