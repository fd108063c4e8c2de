// SPDX-License-Identifier: BSD-2-Clause
// One description for all gateways: it is proposed, judged by all, and comes into force for all in
// one generation or for none. Between two generations nothing of shared networks is in use, so the
// sum of both is never on a medium. Times in ns.
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

class Rollouts {
 public:
  /// Who proposes waits for so long for the votes; if it has gone, others wait twice as long.
  /// If not all are in it after as long, the former one comes back.
  static constexpr Value kPatience = 60'000'000'000;
  /// What the store has refused is not tried again before, so that beats go on.
  static constexpr Value kForbidden = 2'000'000'000;

  /// `own`: of the description that this gateway decides from.
  Rollouts(std::size_t self, const Digest& own) : self_(self), own_(own) {}

  /// It has one end, as an event: NotRolledOut, or a Switch to it.
  void stage(Rollout rollout);
  /// One that a member before this one has staged ends as one of this member does.
  void resume(const Digest& digest) { pending_ = digest; }
  [[nodiscard]] bool stages() const { return staged_.has_value(); }
  /// What gateways propose by themselves where none is in force calls nobody off. It gives way to a
  /// proposal that does.
  [[nodiscard]] static bool gives_way(const Records& records,
                                      const std::vector<std::string>& without);
  void vote(const Digest& digest, bool ok, std::string reason);
  /// One that is taken back cannot be put in force here: the former one is to come back.
  void cannot_switch(const View& view, std::string reason);
  /// Of the one that is taken back: not all are in it.
  [[nodiscard]] static bool is_in(const View& view, std::size_t gateway);
  /// Revisions of before mean nothing any more. What was staged is not staged again.
  void lose() { not_before_ = claimed_ = 0, staged_.reset(); }
  /// `caught_up`: the view has everything that was committed here.
  void step(const View& view, Value now, bool caught_up, std::vector<Event>& events);
  void on_done(const Done& done, Value now, std::vector<Event>& events);
  [[nodiscard]] std::optional<Work> next_work(const View& view, const Codec& codec, Value now);
  [[nodiscard]] std::optional<Value> next_time(const View& view, Value now) const;

  /// All that it acts on, for a checker.
  template <class Visit>
  void visit_state(Visit&& visit) const {
    visit(staged_, stage_, chunk_, claimed_, current_since_, quiet_until_, current_seen_,
          next_seen_, judged_, next_since_, proposed_, why_, ballot_, left_at_, not_before_,
          pending_, trouble_);
  }

 private:
  /// What the votes make of the proposal.
  struct Tally {
    bool all = true;
    std::string objection;  ///< or who has not voted
    bool refused = false;
  };

  [[nodiscard]] std::optional<Work> propose(const View& view, const Codec& codec) const;
  [[nodiscard]] std::optional<Work> undo(const View& view, const Codec& codec, Value now) const;
  void step_staged(const View& view, std::vector<Event>& events);
  void step_pending(const View& view, std::vector<Event>& events);
  void give_up(std::string why, std::vector<Event>& events);
  void step_next(const View& view, Value now, std::vector<Event>& events);
  void on_staged(const Done& done, std::vector<Event>& events);
  [[nodiscard]] std::optional<Work> decide(const View& view, const Codec& codec, Value now);
  [[nodiscard]] std::optional<Work> open(const View& view, const Codec& codec, Value now);
  [[nodiscard]] bool is_ours(const View& view, const Next& next) const;
  [[nodiscard]] bool is_staged(const Next& next) const;
  /// The proposal is called off then, if nothing else has ended it.
  [[nodiscard]] Value over_at(const View& view) const;
  /// Who has the description in force knows every gateway that has something to leave.
  [[nodiscard]] bool knows_all(const View& view) const;
  [[nodiscard]] static bool all_in(const View& view, Value now);
  [[nodiscard]] static Tally tally(const View& view, const Next& next, Work& work, Value now);
  void judge(const View& view, std::vector<Event>& events);

  std::size_t self_;
  Digest own_;
  std::optional<Rollout> staged_;
  std::uint64_t stage_ = 0;        ///< counts them
  std::optional<Digest> pending_;  ///< was staged: what became of it is not known yet
  std::string trouble_;            ///< why the store does not take its text
  std::size_t chunk_ = 0;          ///< the next one that is to be put into the store
  std::int64_t claimed_ = 0;       ///< revision of the d/next that they belong to; 0: none yet
  Value current_since_ = 0;        ///< when one that is taken back was seen
  Value quiet_until_ = 0;          ///< the store has refused something
  std::int64_t current_seen_ = 0, next_seen_ = 0, judged_ = 0;
  Value next_since_ = 0;
  std::optional<Digest> proposed_;
  std::string why_;  ///< it was given up
  std::optional<RolloutVote> ballot_;
  /// Since when all are known to have left the former description; nothing: not all.
  std::optional<Value> left_at_;
  std::int64_t not_before_ = 0;  ///< the view must be as new: what was tried was refuted there
};

}  // namespace mlcca::core::cluster
