// SPDX-License-Identifier: BSD-2-Clause
// Writes to the journal what must outlive this daemon: admissions, grants, and what the gates hold.
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
#include "daemon/outside/gate_reader.hpp"
#include "daemon/store/journal.hpp"

namespace mlcca {

/// The daemon's access to its journal. Changes are noted first, and are on disk after commit().
/// Admissions are not granted before that.
class Recorder {
 public:
  using Granted = DeliveryEvents::Granted;

  /// `pulse` is called after each step of long operations, to give a heart-beat. All references
  /// must outlive this object.
  Recorder(const Scene& scene, const GateReader& gates, EventLog& log, Patience& patience,
           std::function<void()> pulse)
      : scene_(scene), gates_(gates), log_(log), patience_(patience), pulse_(std::move(pulse)) {}

  /// Opens the journal in a directory. To be called once, before anything else.
  Result<void> open(const std::string& directory, store::Disk& disk);
  [[nodiscard]] const store::Contents& contents() const { return journal_->contents(); }
  /// What was cut off when the journal was opened, in words; nullopt if it was complete.
  [[nodiscard]] const std::optional<std::string>& recovered() const {
    return journal_->recovered();
  }
  [[nodiscard]] Granted granted() const;

  // Changes that clients ask for:

  /// The id that the next admission gets.
  [[nodiscard]] core::AdmissionId next_id() const {
    return std::max(contents().next_id, beyond_aside_);
  }
  /// Reserves an id for an admission about which other gateways are asked first. No other admission
  /// gets this id, also not in a later process. The id may be used as long as the pointer is kept.
  [[nodiscard]] std::shared_ptr<const core::AdmissionId> set_id_aside();
  /// Whether an id is reserved so.
  [[nodiscard]] bool is_set_aside(core::AdmissionId id) const { return journal_->expects(id); }
  /// An id for an admission that is in the journal of another gateway.
  [[nodiscard]] core::AdmissionId new_id();
  /// No admission gets this id or an earlier one any more.
  void pass_over(core::AdmissionId id);
  /// Notes an admission for the next commit(). Until then it is uncommitted.
  /// `through`: the gateway that has made it for this one; empty: none.
  Result<void> admit(const control::Request& request, std::uint32_t user,
                     const std::string& through = {});
  /// Removes a noted admission that was not granted after all.
  void take_back(core::AdmissionId id);
  [[nodiscard]] bool is_uncommitted(core::AdmissionId id) const;
  /// Writes the entries to disk at once, all of them or none. No admission may be uncommitted.
  Result<void> write_at_once(const std::vector<store::Entry>& entries);

  // The state in force, which is on disk after the next commit():

  /// Notes what a channel is granted, and what the gates hold of it.
  void note(std::size_t channel);
  void note_granted(std::size_t channel);
  /// Notes the membership of a cluster.
  void note_membership(const store::Membership& membership) { append(membership); }
  /// Notes that no later start begins in audit mode.
  void note_introduced() { append(store::Introduced{true}); }
  /// Notes that nothing is granted of a subject that the description does not have any more.
  void note_gone(const std::string& subject);
  /// Notes which interfaces have gates, for tools that compare them without this daemon.
  void note_ports();
  /// Notes all stated tags by which nothing passes now, because FAMOUSO's broker has assigned other
  /// ones. A start needs them if the gates that received the broker's replies are gone.
  void note_contradicted(std::vector<store::Contradicted> all);
  /// Notes the same tags as the last time.
  void note_contradicted() { note_contradicted(contradicted_); }
  /// Notes the slots of all subjects, for tools as above. `of_all` is what all gates hold together.
  void note_slots(core::GateState of_all);

  /// Whether something waits for commit().
  [[nodiscard]] bool dirty() const { return journal_ && journal_->dirty(); }
  /// Writes to disk what was noted and admitted. After an error nothing of it is on disk, and the
  /// uncommitted admissions were never granted; `lost` is called with them.
  Result<void> commit(const std::function<void(const std::vector<core::AdmissionId>&)>& lost);
  /// Writes the journal again if another program has removed or replaced the file, because what was
  /// granted must outlive this daemon. Also undoes on disk a refused batch that could not be undone
  /// before.
  void keep();
  /// Why the journal cannot be written again; empty if it can.
  [[nodiscard]] const std::string& problem() const { return gone_.text(); }

 private:
  void append(const store::Entry& entry);

  const Scene& scene_;
  const GateReader& gates_;
  EventLog& log_;
  Patience& patience_;
  std::function<void()> pulse_;
  std::optional<store::Journal> journal_;
  /// Larger than every id that was reserved by set_id_aside().
  core::AdmissionId beyond_aside_ = 0;
  std::vector<core::AdmissionId> uncommitted_;  ///< granted, but not on disk yet
  std::vector<store::Contradicted> contradicted_;
  Problem trouble_;
  Problem gone_;
};

}  // namespace mlcca
