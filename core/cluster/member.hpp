// SPDX-License-Identifier: BSD-2-Clause
// One gateway as a member of a cluster (docs/explanation/cluster.md says why this is safe).
// | The caller passes in what comes from the store, takes the events and acts on them, takes the
// transactions, writes journalled() to disk if it has changed, and only then sends the
// transactions. So whatever a transaction says to be closed is closed before it is sent.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/cluster/admissions.hpp"
#include "core/cluster/adoptions.hpp"
#include "core/cluster/chain.hpp"
#include "core/cluster/election.hpp"
#include "core/cluster/rollout.hpp"
#include "core/cluster/view.hpp"

namespace mlcca::core::cluster {

/// The decisions of one gateway as a member of a cluster: whether it belongs to it, what it may
/// reserve, and which transactions it sends. It does no I/O and has no clock. `now` is always the
/// caller's CLOCK_MONOTONIC in ns and never goes back. Its parts decide about admissions,
/// adoptions, the choice of the active gateway and rollouts.
class Member {
 public:
  struct Identity {
    std::size_t gateway = 0;    ///< index of this gateway in the description
    Digest digest = {};         ///< digest of that description
    std::uint64_t session = 0;  ///< a random number, different in each process
    Value lease = 0;            ///< duration of the lease in ns
    Journalled was = {};        ///< what the previous process had written to the journal
    /// Longest wait after a first conflict, ns; see Admissions.
    Value first_wait = Admissions::kFirstWait;
    /// How long a rollout waits, ns; see Rollouts.
    Value rollout_patience = Rollouts::kPatience;
  };
  /// Begins the text of why_not() if the store does not answer.
  static constexpr std::string_view kNoAnswer = "the store does not answer";
  /// Begins it if the store answers that it is full: a beat needs room, too.
  static constexpr std::string_view kFull =
      "the store is full, so it takes no sign of life of this gateway either";
  /// Whether a text of why_not() begins with one of these.
  [[nodiscard]] static bool is_for_want_of_store(std::string_view why) {
    return why.starts_with(kNoAnswer) || why.starts_with(kFull);
  }
  enum class Standing : std::uint8_t {
    off,  ///< it has left, or has no state of the store yet
    joining,
    joined,     ///< it may reserve
    silent,     ///< the store does not answer, so the leased traffic is closed
    gone_back,  ///< the store lost entries; an operator must write another epoch. It lasts over a
                ///< restart, by Journalled
    waiting,    ///< it may not reserve yet, because leases from before the store was restored may
                ///< last
    other_digest,  ///< the description in force is another one, or is not open yet
    draining,
  };

  Member(std::shared_ptr<const Keys> keys, const Codec& codec, const Identity& identity);

  // Input.
  void on_state(const StoreState& state, Value now);
  void on_snapshot_begin(std::int64_t revision, Value now);
  void on_batch(const Batch& batch, Value now);
  void on_snapshot_end(Value now);
  void on_result(const TxnResult& result, Value now);
  void on_time(Value now);

  // Requests of this gateway.
  /// Why nothing can be reserved now; empty if reserve() would be tried. Only one reservation is
  /// decided at a time.
  [[nodiscard]] std::string why_not(Value now) const { return why_not(0, now); }
  /// Starts a reservation that was decided from the present view. It gets one answer: the event
  /// Reserved, Refused or Conflict. After Conflict the caller decides again, and calls reserve() or
  /// release().
  void reserve(Wanted wanted, Value now);
  /// Gives back a reservation. The caller has closed its gates before; no answer follows.
  void release(std::uint64_t id, Value now);
  void vote(const Origin& origin, Vote vote, Value now);
  /// The caller has put in force everything that the events up to this store revision asked for.
  void applied(std::int64_t revision);
  /// Whether this gateway can carry traffic that other gateways could carry as well. The caller
  /// closes this traffic before it sets false.
  void set_able(bool able) { election_.set_able(able); }
  /// Leaves the cluster. The caller has closed everything leased and everything that other gateways
  /// could carry.
  void drain(Value now);
  void stage(Rollout rollout) { rollouts_.stage(std::move(rollout)); }
  /// Continues a rollout that the previous process had staged.
  void resume_rollout(const Digest& digest) { rollouts_.resume(digest); }
  /// See Rollouts::cancel().
  void cancel_rollout(const Digest& digest, std::string why) {
    rollouts_.cancel(digest, std::move(why));
  }
  void vote_rollout(const Digest& digest, bool ok, std::string reason);
  /// The description that is coming into force cannot be put in force here, so the rollout is to be
  /// undone.
  void cannot_switch(std::string reason) { rollouts_.cannot_switch(view_, std::move(reason)); }

  // Output. The caller takes and handles the events before it takes transactions.
  [[nodiscard]] std::vector<Event> take_events();
  [[nodiscard]] std::vector<Txn> take_txns(Value now);
  /// The time until which leased traffic may be sent.
  [[nodiscard]] Value valid_until() const { return chain_.valid_until(); }
  /// The time at which on_time() must be called, followed by take_txns().
  [[nodiscard]] Value next_time(Value now) const;
  [[nodiscard]] const View& view() const { return view_; }
  [[nodiscard]] std::size_t self() const { return identity_.gateway; }
  [[nodiscard]] Standing standing(Value now) const;
  [[nodiscard]] const std::string& problem() const { return problem_; }
  [[nodiscard]] const Journalled& journalled() const { return journal_; }
  [[nodiscard]] Role role() const { return election_.role(); }
  /// Whether the reservation is granted and open on the complete route.
  [[nodiscard]] bool holds(std::uint64_t id) const { return admissions_.granted(id); }
  /// Whether the store has an entry of the reservation, may have one, or is to get one.
  [[nodiscard]] bool knows(std::uint64_t id) const { return admissions_.knows(id); }

  /// Passes all state on which decisions depend to `visit`, for a model checker.
  template <class Visit>
  void visit_state(Visit&& visit) const {
    visit(journal_, view_, chain_, admissions_, adoptions_, election_, rollouts_, phase_,
          reachable_, draining_, goes_on_, found_, wait_for_, applied_, said_.applied, ask_applied_,
          said_.draining, turn_.latest, turn_.passed_over, not_before_.fence);
  }

 private:
  enum class Phase : std::uint8_t { off, joining, joined, gone_back, left };
  /// Entries that no gateway uses any more, by the gateway that may delete them.
  enum class Unused : std::uint8_t {
    own,  ///< entries for removed networks and votes for removed gateways: the gateway that wrote
          ///< them
    ballots,  ///< rollout votes of removed gateways: any gateway that may roll out
    fences,   ///< fences of removed gateways, their last key: any gateway
    left,  ///< all other entries of removed gateways; nobody else, if the roles of the store are as
           ///< they should be
  };
  static constexpr std::size_t kUnused = 4;
  /// What the transactions are for. Each kind has its turn.
  enum class For : std::uint8_t {
    own,     ///< the admissions of this gateway
    others,  ///< votes on those of other gateways
    all,     ///< fences, rollouts, and entries that nobody uses: the view must be up to date
  };
  static constexpr std::size_t kFor = 3;

  /// What the store has refused is not tried again before this time.
  struct NotBefore {
    Value fence = 0;
    std::array<Value, kUnused> clean{};  ///< to delete unused entries of each kind
  };
  /// What the latest beat has said.
  struct Said {
    std::int64_t applied = 0;
    bool draining = false;
  };
  /// Whose turn it is.
  struct Turn {
    For latest = For::all;        ///< of the latest transaction
    std::size_t passed_over = 0;  ///< transactions since For::all could have its turn
  };

  /// As the public function, but `id` itself may be the reservation that is being decided.
  [[nodiscard]] std::string why_not(std::uint64_t id, Value now) const;
  void step(Value now);
  void begin(Value now);
  void lose(const std::string& why, Value now);
  void go_back(Value now);
  void check_standing(Value now);
  void settle(const std::vector<Done>& all, Value now);
  void heed_trouble(Value now);
  void on_joined(std::int64_t revision, Value now);
  void on_cleaned(const Done& done, Value now);
  [[nodiscard]] bool has_gone_back() const;
  [[nodiscard]] bool same_epoch() const;
  [[nodiscard]] bool digest_in_force() const;
  [[nodiscard]] bool other_is_open() const;
  [[nodiscard]] std::string why_leases_last() const;
  [[nodiscard]] std::string why_no_description() const;
  [[nodiscard]] std::string no_answer() const {
    return std::string(full_ ? kFull : kNoAnswer) + (problem_.empty() ? "" : ": " + problem_);
  }
  [[nodiscard]] bool caught_up() const { return view_.revision() >= chain_.base(); }
  [[nodiscard]] Beat beat(Value now) const;
  [[nodiscard]] bool beat_wanted(Value now) const;
  [[nodiscard]] std::optional<Work> next_work(Value now);
  [[nodiscard]] std::optional<Work> work_for(For whom, Value now);
  [[nodiscard]] std::optional<Work> work_for_all(Value now);
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
  bool full_ = false;  ///< that was the latest answer of the store
  std::int64_t wait_for_ =
      0;  ///< the view must have this revision before anything except a beat is sent
  NotBefore not_before_;
  std::int64_t applied_ = 0;
  /// Other gateways wait until this revision is reported as applied.
  std::int64_t ask_applied_ = 0;
  Said said_;
  Turn turn_;
  std::vector<Event> events_;
};

}  // namespace mlcca::core::cluster
