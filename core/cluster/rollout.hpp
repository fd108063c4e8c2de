// SPDX-License-Identifier: BSD-2-Clause
// The rollout of a description: it is proposed, judged by all gateways, and comes into force for
// all in one generation or for none. Between two generations nothing of shared networks is in use,
// so the two are never on a medium together. See docs/explanation/cluster.md, "One description".
// Times are in ns.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/cluster/chain.hpp"
#include "core/cluster/view.hpp"

namespace mlcca::core::cluster {

/// One gateway's part in rollouts: it proposes, votes, and does the next step that is due. It does
/// no I/O: step() and on_done() take input, next_work() returns the next transaction.
class Rollouts {
 public:
  /// How long the proposer waits for votes; others wait twice as long before they end its proposal.
  /// If not all gateways follow within this time, the former description comes back.
  static constexpr Value kPatience = 60'000'000'000;
  /// How long nothing is tried again after the store refused something, so that beats go on.
  static constexpr Value kForbidden = 2'000'000'000;

  /// `own`: digest of the description from which this gateway decides. `patience`: a checker has
  /// a shorter one.
  Rollouts(std::size_t self, const Digest& own, Value patience = kPatience)
      : self_(self), own_(own), patience_(patience) {}

  /// Starts a rollout. Its one result is an event: NotRolledOut, or a Switch to it. If the
  /// description is coming into force already, gateways that have died are called off, so that
  /// nobody waits for them.
  void stage(Rollout rollout);
  /// Continues to wait for a rollout that a former Member of this process staged; it ends as in
  /// stage().
  void resume(const Digest& digest) { pending_ = digest; }
  /// An operator gives up the rollout of that description, whoever proposes it: while gateways vote
  /// on it, or while not all have followed it. What opens already stays.
  void cancel(const Digest& digest, std::string why);
  /// Whether the present proposal gives way to one for the gateways without `without`. If no
  /// description is in force, gateways propose theirs on their own and call nobody off; such a
  /// proposal gives way to one that calls gateways off.
  [[nodiscard]] static bool gives_way(const Records& records,
                                      const std::vector<std::string>& without);
  /// Records this gateway's judgement about the proposed description.
  void vote(const Digest& digest, bool ok, std::string reason);
  /// Reports that the description that comes into force cannot be loaded here, so that the former
  /// one comes back for all.
  void cannot_switch(const View& view, std::string reason);
  /// Whether a gateway has reported in its beat that it follows the description in force.
  [[nodiscard]] static bool is_in(const View& view, std::size_t gateway);
  /// The membership was lost: revisions known before are invalid, and what was staged is dropped.
  void lose() { not_before_ = claimed_ = 0, staged_.reset(); }
  /// Acts on the view. `caught_up`: the view contains all transactions of this gateway.
  void step(const View& view, Value now, bool caught_up, std::vector<Event>& events);
  /// Takes the result of a transaction that next_work() returned.
  void on_done(const Done& done, Value now, std::vector<Event>& events);
  /// The transaction that is due now: an own vote, or the next step of a rollout. Nullopt: none.
  [[nodiscard]] std::optional<Work> next_work(const View& view, const Codec& codec, Value now);
  /// When step() or next_work() must be called because time has passed. Nullopt: never.
  [[nodiscard]] std::optional<Value> next_time(const View& view, Value now) const;

  /// Visits all state that affects its behaviour, for the model checker.
  template <class Visit>
  void visit_state(Visit&& visit) const {
    visit(staged_, stage_, chunk_, claimed_, current_since_, quiet_until_, current_seen_,
          next_seen_, judged_, next_since_, proposed_, why_, ballot_, left_at_, not_before_,
          pending_, trouble_, has_called_off_, cancelled_);
  }

 private:
  /// The result of the votes on a proposal.
  struct Tally {
    bool all = true;
    std::string objection;  ///< the first objection, or who has not voted
    bool refused = false;
  };

  [[nodiscard]] std::optional<Work> propose(const View& view, const Codec& codec) const;
  [[nodiscard]] std::optional<Work> undo(const View& view, const Codec& codec, Value now) const;
  [[nodiscard]] static bool is_among(const std::vector<std::string>& names,
                                     const std::string& name);
  /// Why a gateway cannot be called off.
  [[nodiscard]] static std::string there(const std::string& name);
  /// Whether the gateway is absent, or dead and fenced.
  [[nodiscard]] static bool is_gone(const View& view, std::size_t gateway, Value now);
  /// Whether a gateway that is called off is really gone. Adds a compare to `work`, so that it
  /// fails if the gateway has come back when it is committed.
  [[nodiscard]] static bool is_off(const View& view, std::size_t gateway, Value now, Work& work);
  [[nodiscard]] bool calls_off(const Records& records) const;
  [[nodiscard]] std::optional<Work> call_off(const View& view, const Codec& codec, Value now) const;
  void step_calling_off(const View& view, Value now, std::vector<Event>& events);
  void step_staged(const View& view, Value now, std::vector<Event>& events);
  void step_pending(const View& view, std::vector<Event>& events);
  void give_up(std::string why, std::vector<Event>& events);
  void step_next(const View& view, Value now, std::vector<Event>& events);
  void step_cancelled(const View& view, bool caught_up, std::vector<Event>& events);
  void object(const View& view, std::int64_t to);
  void on_staged(const Done& done, std::vector<Event>& events);
  [[nodiscard]] std::optional<Work> decide(const View& view, const Codec& codec, Value now);
  [[nodiscard]] std::optional<Work> open(const View& view, const Codec& codec, Value now);
  [[nodiscard]] static Current successor(const Records& records, const Next& next);
  [[nodiscard]] bool is_ours(const View& view, const Next& next) const;
  [[nodiscard]] bool is_staged(const Next& next) const;
  /// When the proposal is called off unless something else has ended it.
  [[nodiscard]] Value over_at(const View& view) const;
  /// Whether this gateway has the description in force, and so knows every gateway that must leave
  /// it.
  [[nodiscard]] bool knows_all(const View& view) const;
  [[nodiscard]] static bool all_in(const View& view, Value now);
  [[nodiscard]] static Tally tally(const View& view, const Next& next, Work& work, Value now);
  void judge(const View& view, std::vector<Event>& events);

  std::size_t self_;
  Digest own_;
  Value patience_;
  std::optional<Rollout> staged_;
  std::uint64_t stage_ = 0;        ///< counts the calls of stage()
  std::optional<Digest> pending_;  ///< staged here, and its outcome is unknown yet
  std::string trouble_;            ///< why the store refuses its text
  bool has_called_off_ = false;    ///< nobody waits any more for those that it calls off
  std::size_t chunk_ = 0;          ///< number of the next chunk to be stored
  std::int64_t claimed_ = 0;       ///< revision of the d/next to which the chunks belong; 0: not
                                   ///< proposed yet
  Value current_since_ = 0;        ///< when the present d/current was first seen; 0: it is open
  Value quiet_until_ = 0;  ///< the store has refused something: no transaction before this time
  std::int64_t current_seen_ = 0, next_seen_ = 0, judged_ = 0;
  Value next_since_ = 0;
  std::optional<Digest> proposed_;
  std::string why_;  ///< why it was given up
  /// A rollout that an operator gives up, and why.
  std::optional<std::pair<Digest, std::string>> cancelled_;
  std::optional<RolloutVote> ballot_;
  /// Since when all are known to have left the former description; nullopt: not all have.
  std::optional<Value> left_at_;
  std::int64_t not_before_ = 0;  ///< the view must have reached this revision, because what was
                                 ///< tried before was refuted there
};

}  // namespace mlcca::core::cluster
