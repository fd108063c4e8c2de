// SPDX-License-Identifier: BSD-2-Clause
// What is written down so that it outlives this daemon: who was admitted, what was granted, and
// what the gates are to hold.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/problem.hpp"
#include "base/result.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/patience.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/gate_driver.hpp"
#include "daemon/store/journal.hpp"

namespace mlcca {

class Recorder {
 public:
  using Granted = DeliveryEvents::Granted;

  /// `pulse` is called after each step of what takes long. All of them must outlive this.
  Recorder(const Scene& scene, const GateDriver& gates, EventLog& log, Patience& patience,
           std::function<void()> pulse)
      : scene_(scene), gates_(gates), log_(log), patience_(patience), pulse_(std::move(pulse)) {}

  /// The journal in a directory. To be called once, before anything else.
  Result<void> open(const std::string& directory, store::Disk& disk);
  [[nodiscard]] const store::Contents& contents() const { return journal_->contents(); }
  /// What was cut off when the journal was opened, in words; nothing if it was whole.
  [[nodiscard]] const std::optional<std::string>& recovered() const {
    return journal_->recovered();
  }
  [[nodiscard]] Granted granted() const;

  // Of changes that clients ask for:

  /// What the next admission gets.
  [[nodiscard]] core::AdmissionId next_id() const {
    return std::max(contents().next_id, beyond_aside_);
  }
  /// The same, for one that others are asked about first: no other one gets it, and none of a later
  /// process. It can be admitted for as long as what is given is kept.
  [[nodiscard]] std::shared_ptr<const core::AdmissionId> set_id_aside();
  /// The same for one that is in the journal of another gateway.
  [[nodiscard]] core::AdmissionId new_id();
  /// Writes down an admission with the next commit(); until then it is one of uncommitted().
  Result<void> admit(const control::Request& request, std::uint32_t user);
  /// It was not granted after all.
  void take_back(core::AdmissionId id);
  [[nodiscard]] const std::vector<core::AdmissionId>& uncommitted() const { return uncommitted_; }
  [[nodiscard]] bool is_uncommitted(core::AdmissionId id) const;
  /// Writes the entries down at once, all of them or none. There must be nothing uncommitted.
  Result<void> write_at_once(const std::vector<store::Entry>& entries);

  // Of what is in force now; it is on disk after the next commit():

  /// What a channel was granted, and what the gates hold of it.
  void note(std::size_t channel);
  void note_granted(std::size_t channel);
  /// As what the gateway is a member of a cluster.
  void note_membership(const store::Membership& membership) { append(membership); }
  /// No later start begins in audit mode.
  void note_introduced() { append(store::Introduced{true}); }
  /// Nothing is granted of a subject that the description does not have any more.
  void note_gone(const std::string& subject);
  /// Which interfaces are gated, for whoever compares them without this daemon.
  void note_ports();
  /// Stated tags that nothing passes by, since FAMOUSO's broker has dealt them otherwise: all of
  /// them now. For a start at which the gates that have received the broker's replies are gone.
  void note_contradicted(std::vector<store::Contradicted> all);
  /// The same as the last time.
  void note_contradicted() { note_contradicted(contradicted_); }
  /// The slots of all subjects, for the same reader: `of_all` is what all gates hold.
  void note_slots(core::GateState of_all);

  /// Something waits for commit().
  [[nodiscard]] bool dirty() const { return journal_ && journal_->dirty(); }
  /// Puts on disk what was noted and admitted. After an error none of it is, and whoever is
  /// uncommitted() was never granted; `lost` is called with them.
  Result<void> commit(const std::function<void(const std::vector<core::AdmissionId>&)>& lost);
  /// Writes the journal again if another program has removed or replaced the file: what was granted
  /// must outlive this daemon. Undoes on disk what could not be undone when it was refused.
  void keep();
  /// Why the journal cannot be written again; empty: it can.
  [[nodiscard]] const std::string& problem() const { return gone_.text(); }

 private:
  void append(const store::Entry& entry);

  const Scene& scene_;
  const GateDriver& gates_;
  EventLog& log_;
  Patience& patience_;
  std::function<void()> pulse_;
  std::optional<store::Journal> journal_;
  core::AdmissionId beyond_aside_ = 0;          ///< behind all that were set aside
  std::vector<core::AdmissionId> uncommitted_;  ///< granted, and not on disk yet
  std::vector<store::Contradicted> contradicted_;
  Problem trouble_;
  Problem gone_;
};

}  // namespace mlcca
