// SPDX-License-Identifier: BSD-2-Clause
// All that one gateway has decided: the description, who takes part, the verdicts and the ledger.
// Changes are proposed first; a proposal that is not accepted leaves no trace.
#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/admission.hpp"
#include "core/members.hpp"
#include "core/plan.hpp"
#include "core/system.hpp"
#include "core/topology.hpp"

namespace mlcca::core {

/// What a run-time request brings in: a publisher, a subscriber, or both, of one channel.
struct Admission {
  AdmissionId id = 0;
  std::size_t channel = 0;
  std::optional<Publisher> publisher;
  std::optional<Subscriber> subscriber;
};

class State;

/// An admission tried out. While it lives the newcomer is among the members of the state.
class Proposal {
 public:
  Proposal(Proposal&& other) noexcept;
  Proposal(const Proposal&) = delete;
  Proposal& operator=(const Proposal&) = delete;
  Proposal& operator=(Proposal&&) = delete;
  ~Proposal();

  /// Every delivery that the newcomer takes part in is granted and none that was granted is lost.
  /// Without anybody on the other side there is nothing to grant: not fit.
  [[nodiscard]] bool fit() const { return fit_; }
  /// The newcomer's verdicts.
  [[nodiscard]] std::vector<const Verdict*> verdicts() const;
  /// What the gates of a gateway would have to change.
  [[nodiscard]] GateChanges changes(std::size_t gateway) const;

  void accept() &&;

 private:
  friend class State;
  Proposal(State& state, const Admission& admission);

  State* state_;
  Admission admission_;
  ChannelDecision next_;
  std::vector<std::size_t> own_;  // indices into the verdicts
  bool fit_ = false;
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
  [[nodiscard]] const Decision& decision() const { return decision_; }
  [[nodiscard]] const std::vector<Condition>& conditions() const { return conditions_; }
  [[nodiscard]] const std::vector<Admission>& admissions() const { return admissions_; }
  [[nodiscard]] bool released(std::size_t channel) const { return released_[channel]; }

  /// True if it differs from what was known; decide() then.
  bool set_conditions(std::vector<Condition> conditions);
  void set_released(std::size_t channel, bool released);

  /// Decides everything anew: described ends and accepted admissions, whether they fit or not.
  void decide();

  [[nodiscard]] Proposal propose(const Admission& admission) { return {*this, admission}; }
  /// Takes an admission in without asking: one that was granted before a restart.
  void restore(const Admission& admission);
  /// False if there is none of that id. Call decide() afterwards.
  bool remove(AdmissionId id);

  [[nodiscard]] GateState gate_state(std::size_t gateway) const {
    return core::gate_state(system_, members_, decision_, gateway);
  }

  [[nodiscard]] std::optional<std::size_t> find_channel(const std::string& name_or_subject) const;
  [[nodiscard]] std::optional<Place> find_place(const std::string& name) const;

 private:
  friend class Proposal;
  [[nodiscard]] Situation situation() const {
    return {system_, topology_, members_, conditions_, released_};
  }

  System system_;
  Topology topology_;
  Members members_;
  std::vector<Condition> conditions_;
  std::vector<bool> released_;
  Decision decision_;
  std::vector<Admission> admissions_;
};

/// 64-bit subject of "0x…" with up to 16 hex digits; nothing otherwise.
[[nodiscard]] std::optional<Subject> parse_subject(const std::string& text);

}  // namespace mlcca::core
