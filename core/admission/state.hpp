// SPDX-License-Identifier: BSD-2-Clause
// All that one gateway has decided: the description, who takes part, the verdicts and the ledger.
// Changes are proposed first; a proposal that is not accepted leaves no trace.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/admission/held_by_others.hpp"
#include "core/admission/permit_watch.hpp"
#include "core/admission/permits.hpp"
#include "core/admission/promised.hpp"
#include "core/admission/unlisted_channels.hpp"
#include "core/admission/usage.hpp"
#include "core/admission/world.hpp"
#include "core/gates/plan.hpp"
#include "core/model/members.hpp"
#include "core/model/names.hpp"
#include "core/model/system.hpp"
#include "core/model/topology.hpp"
#include "core/reserve/ledger.hpp"

namespace mlcca::core {

/// What a run-time request brings in: a publisher, a subscriber, or both, of one channel.
struct Admission {
  AdmissionId id = 0;
  std::size_t channel = 0;
  std::optional<Publisher> publisher;
  std::optional<Subscriber> subscriber;
};

class State;

/// An admission tried out. While it lives the newcomer is among the members of the state, what it
/// would reserve is in the ledger, and nothing else may be asked of the state.
class Proposal {
 public:
  Proposal(Proposal&& other) noexcept;
  Proposal(const Proposal&) = delete;
  Proposal& operator=(const Proposal&) = delete;
  Proposal& operator=(Proposal&&) = delete;
  ~Proposal();

  /// Every delivery that the newcomer takes part in is granted, none that was granted is lost, and
  /// the channel is in no lower attribute set than before. Without anyone on the other side there
  /// is nothing to grant: not fit.
  [[nodiscard]] bool fit() const { return fit_; }
  /// The newcomer's verdicts.
  [[nodiscard]] std::vector<const Verdict*> verdicts() const;
  /// What the gates of a gateway would have to change.
  [[nodiscard]] GateChanges changes(std::size_t gateway) const;
  /// All of the channel, as it would be decided with the newcomer.
  [[nodiscard]] const Decision& decision() const { return next_; }
  /// With the newcomer, and with what it would reserve.
  [[nodiscard]] const State& state() const { return *state_; }
  [[nodiscard]] std::size_t channel() const { return channel_; }
  /// False: it is one of State::wish(channel).
  [[nodiscard]] bool has_newcomer() const { return id_ != 0; }
  /// See core::exceeds_capacity(), with the newcomer.
  [[nodiscard]] std::optional<std::string> exceeds_capacity(std::size_t gateway) const;

  void accept() &&;

 private:
  friend class State;
  enum class Kind : std::uint8_t { admission, wish };
  Proposal(State& state, Admission admission, Kind kind);
  void decide(const Wish* wish);
  [[nodiscard]] bool is_better() const;

  State* state_;
  AdmissionId id_;
  std::size_t channel_;
  Ledger::Mark before_;
  Decision next_;
  std::vector<std::size_t> own_;  // indices into the verdicts
  bool fit_ = false;
  Kind kind_ = Kind::admission;
};

/// A delivery in words that outlive the state: numbers of ends change with a description.
struct Delivery {
  std::string publisher;
  AdmissionId admission = 0;  ///< that brought the publisher in; 0: it is described
  std::string to;
  auto operator<=>(const Delivery&) const = default;
};

/// What is granted of a channel.
struct Grants {
  std::size_t set = 0;
  std::vector<Delivery> deliveries;  ///< none: nothing is granted
  bool operator==(const Grants&) const = default;
};

/// Of channels: the rules that the gates of one gateway had.
using FormerRules = std::map<std::size_t, GateState>;

/// A channel whose decision is another one now.
struct DecisionChange {
  std::size_t channel = 0;
  Decision before;
};

class State {
 public:
  explicit State(System system);
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  State(State&&) = delete;
  State& operator=(State&&) = delete;
  ~State() = default;

  [[nodiscard]] const System& system() const { return system_; }
  [[nodiscard]] const Members& members() const { return members_; }
  [[nodiscard]] const Topology& topology() const { return topology_; }
  /// Of each channel.
  [[nodiscard]] const std::vector<Decision>& decisions() const { return decisions_; }
  /// Of all channels: what is granted, and what is not.
  [[nodiscard]] std::size_t granted() const { return usage_.granted(); }
  [[nodiscard]] std::size_t refused() const { return usage_.refused(); }
  [[nodiscard]] const Ledger& ledger() const { return ledger_; }
  [[nodiscard]] const World& world() const { return world_; }
  /// The channels of the admissions, in the order of their ids.
  [[nodiscard]] const std::map<AdmissionId, std::size_t>& admissions() const { return admissions_; }
  /// Of one that is there.
  [[nodiscard]] Admission admission(AdmissionId id) const;
  [[nodiscard]] bool withdrawn(std::size_t channel) const { return withdrawn_[channel]; }

  // What changes from here on counts after the next settle().

  void set_condition(std::size_t network, Condition condition);
  /// The links of a mesh as they are believed to be; nothing: nothing is known of it.
  /// `addresses`: of its nodes, for people.
  void set_graph(std::size_t network, std::optional<mesh::Graph> graph,
                 std::vector<std::string> addresses = {});
  void set_withdrawn(std::size_t channel, bool withdrawn);
  /// See World::failed.
  void set_failed(std::size_t gateway, bool failed) {
    new_.failed.erase(gateway);
    if (failed != world_.failed[gateway]) new_.failed.emplace(gateway, failed);
  }

  // Where many gateways share networks and reserve in one store.

  /// What others hold of a network. What this gateway has given up and the store still has counts
  /// there too: it is nobody's to give away.
  void set_foreign(std::size_t network, cluster::Foreign foreign);
  /// What may be held of shared networks from now on, which is polled in each settle(); it must
  /// outlive this. It counts there whether or not it is held. Null: all that fits, as if this were
  /// the only gateway.
  void set_permits(const Permits* permits);
  [[nodiscard]] const Permits* permits() const { return permits_; }
  /// Who holds what of shared networks, for texts.
  [[nodiscard]] HeldByOthers& held_by_others() { return held_; }
  [[nodiscard]] const HeldByOthers& held_by_others() const { return held_; }

  /// Others may be on all networks of that gateway: before anything is decided.
  void share_all(std::size_t gateway);

  /// The tag that the broker has dealt to a channel of which nothing is granted on the network now;
  /// 0: none that is known. Its binding there is dynamic.
  void set_tag(std::size_t network, std::size_t channel, std::uint32_t tag);
  /// The same of kSubscribeSubject. Counts at once: only control_rules() reads it.
  void set_subscribe_tag(std::size_t network, std::uint32_t tag) {
    system_.networks[network].subscribe_tag = tag;
  }
  /// False if there is none of that id.
  bool remove(AdmissionId id);
  /// As if everything had changed.
  void invalidate_all();

  /// Decides what these changes touch, and nothing else: what was granted is kept as far as it can
  /// be, then waiting channels are admitted, then attribute sets are upgraded
  /// (core/admission/allocation.hpp).
  std::vector<DecisionChange> settle();

  /// Decides everything again, with described ends and admissions, whether they fit or not, as
  /// after a start. `before`: what was granted, by channel; that is granted first, before any other
  /// channel.
  void decide(const std::map<std::size_t, Grants>& before = {});
  [[nodiscard]] Grants grants(std::size_t channel) const;
  [[nodiscard]] Delivery delivery_of(const Verdict& verdict) const;

  [[nodiscard]] Proposal propose(Admission admission) {
    return {*this, std::move(admission), Proposal::Kind::admission};
  }
  /// An admission as it could be if the gateway reserved what it needs (cluster::footprint_of()):
  /// everything may be asked that fits beside all that is promised to anyone. It is not to be
  /// accepted. Nothing may be waiting for settle().
  [[nodiscard]] Proposal wish(Admission admission) {
    return {*this, std::move(admission), Proposal::Kind::wish};
  }
  /// The same of a channel with the ends that it has: fit, if it could be given more than it has.
  [[nodiscard]] Proposal wish(std::size_t channel) {
    return {*this, Admission{0, channel, {}, {}}, Proposal::Kind::wish};
  }
  /// Whether a delivery of a proposal may be used with what is reserved and agreed to now.
  [[nodiscard]] bool is_permitted(const Verdict& verdict) const { return permitted(verdict, {}); }
  /// The same as if that reservation were not there.
  [[nodiscard]] bool is_permitted_without(const Verdict& verdict, std::uint64_t reservation) const {
    return permitted(verdict, reservation);
  }
  /// Channels that this gateway has to do with, and that are given less than what would fit,
  /// because it is not reserved, or other gateways have not agreed to it.
  [[nodiscard]] std::vector<std::size_t> wishes() const;
  /// The channel of a subject that the description does not have, so that an admission can name it:
  /// the one that is there, or one that is not used any more. Without an admission it is nothing.
  /// Errors: the subject is described; a network does not allow it, or has as many as it allows; an
  /// identifier is taken, or another one is in use.
  [[nodiscard]] Result<std::size_t> list(const UnlistedChannel& wanted);
  /// Forgets the channels of list() that no member uses, with their identifiers; list() does, too.
  /// True: there were some.
  bool unlist_unused();
  /// Takes an admission in without asking: one that was granted before a restart, or before it had
  /// to wait. The next decide() or settle() says what it is given.
  void restore(Admission admission);

  [[nodiscard]] GateState gate_state(std::size_t gateway) const {
    return core::gate_state(system_, members_, decisions_, gateway);
  }
  [[nodiscard]] std::vector<Transit> transits(std::size_t gateway, std::size_t channel) const {
    return core::transits(system_, members_, channel, decisions_[channel].verdicts, gateway);
  }
  /// See core::exceeds_capacity(): a channel for which there is none, and why.
  [[nodiscard]] std::optional<std::string> exceeds_capacity(std::size_t gateway) const;
  [[nodiscard]] GateState gate_state(std::size_t gateway, std::size_t channel) const {
    return core::gate_state(system_, members_, channel, decisions_[channel].verdicts, gateway);
  }
  /// What the gates of a gateway have to change after settle(). `left`: what they had of the
  /// channels that a member has left since; of the others that follows from the changes.
  [[nodiscard]] GateChanges gate_changes(const std::vector<DecisionChange>& changes,
                                         std::size_t gateway, const FormerRules& left = {}) const;

  /// What each hop of a granted delivery provides now. Nothing may be waiting for settle(). The
  /// ledger is as it was afterwards.
  [[nodiscard]] std::vector<Hop> hops_of_granted(const Verdict& verdict);

  /// See NameIndex.
  [[nodiscard]] std::optional<std::size_t> find_channel(const std::string& name_or_subject) const {
    return names_.find_channel(name_or_subject);
  }
  [[nodiscard]] std::optional<std::size_t> channel_of(Subject subject) const {
    return names_.channel_of(subject);
  }
  [[nodiscard]] std::optional<Place> find_place(const std::string& name) const {
    return names_.find_place(name);
  }

 private:
  friend class Proposal;
  friend std::vector<DecisionChange> settle_news(State& state);
  class Settlement;  // core/admission/settlement.cc
  [[nodiscard]] Situation situation() const {
    Situation s{system_, topology_, members_, world_, withdrawn_};
    s.permits = permits_;
    s.wished = &wished_;
    return s;
  }
  [[nodiscard]] bool permitted(const Verdict& verdict, std::optional<std::uint64_t> without) const;
  [[nodiscard]] Others others_on(std::size_t network, const MeshView* view) const {
    return promised_beside(situation(), network, view);
  }
  [[nodiscard]] bool has_others(std::size_t network) const {
    return permits_ != nullptr || !world_.foreign[network].empty() || ledger_.has_others(network);
  }
  [[nodiscard]] std::map<std::size_t, Obstacle> barred_to_wishes(std::size_t channel);
  void note_reservations(AdmissionId id);
  void note_own_there(std::size_t network);
  void note_permits();
  [[nodiscard]] bool is_best(std::size_t channel) const;
  void touch_ended(std::size_t network, std::uint64_t shrunk);
  void touch_disagreed(std::uint64_t less_agreed);
  void touch_detours(std::size_t network);
  [[nodiscard]] Decision known(std::size_t channel, const Grants& grants) const;
  bool keep_after_restart(std::size_t channel, const Decision& old);
  void note_age(std::size_t channel);
  [[nodiscard]] bool is_used(std::size_t channel) const;
  void forget_deliveries(std::size_t channel, AdmissionId leaving);

  System system_;
  Topology topology_;
  Members members_;
  World world_;
  std::vector<bool> withdrawn_;
  Ledger ledger_;
  std::vector<Decision> decisions_;
  std::vector<std::uint64_t> ages_;  // of each channel: id of its oldest admission, 0: described
  Usage usage_;
  std::map<AdmissionId, std::size_t> admissions_;
  NameIndex names_{system_};
  UnlistedChannels unlisted_{system_, names_};

  struct NewGraph {
    std::optional<mesh::Graph> graph;
    std::vector<std::string> addresses;
  };
  /// What has been set since the last settle().
  struct News {
    std::map<std::size_t, Condition> conditions;  ///< by network
    std::map<std::size_t, NewGraph> graphs;       ///< by network
    std::map<std::size_t, bool> failed;           ///< by gateway
    [[nodiscard]] bool empty() const {
      return conditions.empty() && graphs.empty() && failed.empty();
    }
  };
  News new_;

  HeldByOthers held_{system_, world_, ledger_};
  const Permits* permits_ = nullptr;
  PermitWatch seen_permits_;
  std::vector<bool> own_there_;         // by network: among what others hold is this gateway's own
  std::set<std::size_t> others_stale_;  // networks of which others hold something else now
  std::vector<bool> others_complete_;   // by network: all is known that others hold
  mutable std::set<std::size_t>
      wished_;  // channels that something was refused for want of a permit

  std::set<std::size_t> touched_;   // channels that must be decided again
  std::set<std::size_t> relieved_;  // resources that carry less now
};

}  // namespace mlcca::core
