// SPDX-License-Identifier: BSD-2-Clause
// Keeps what the daemon knows about admissions made at run time beside the decisions: their keys,
// their leases, the connections that hold them, and how they end.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/keys.hpp"
#include "daemon/gateway/leases.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/tag_bindings.hpp"
#include "daemon/gateway/turn.hpp"

namespace mlcca {

/// The line of the log for an admission that is left out, for example "admission 7 of camera is
/// left out: there is no network lan".
[[nodiscard]] std::string words_of(const control::LeftOutAdmission& left_out);

/// The bookkeeping of run-time admissions: key, lease and holders of each. An admission is either
/// held by at least one connection (then no lease runs) or has a lease. Some are "left out": they
/// are recorded in the journal, but the description in force has no place for them, or they wait
/// until another gateway agrees to them.
class Admissions {
 public:
  /// Admissions that are left out, with the reason.
  using LeftOut = std::map<core::AdmissionId, control::LeftOutAdmission>;

  /// All references must outlive this object.
  Admissions(Scene& scene, Recorder& recorder, EventLog& log, Turn& turn, TagBindings& tags,
             const Clock& clock)
      : scene_(scene), recorder_(recorder), log_(log), turn_(turn), tags_(tags), clock_(clock) {}

  /// Called once after the start: takes keys and leases from the journal. No client is connected
  /// yet, so every lease starts again with its full length.
  void remember();
  /// From now on, what another gateway makes for this one waits until that gateway agrees to it.
  void need_agreements() { needs_agreements_ = true; }
  /// Adds the recorded admissions to `state`, the state of a description that is not in force yet:
  /// first those that are in force, so that no other one takes their place. Returns those for which
  /// that description has no place, and those that wait for another gateway.
  [[nodiscard]] LeftOut restore_into(core::State& state) const;

  [[nodiscard]] const LeftOut& left_out() const { return left_out_; }
  /// What restore_into() has returned, when that state is in force. Of these, those that need the
  /// agreement of another gateway wait.
  void set_left_out(LeftOut left_out);
  /// Logs a warning for each left-out admission whose reason was not reported before.
  void report_left_out();
  /// The left-out admissions of a channel that a client names by `channel` (name or subject). The
  /// description in force need not have this channel.
  [[nodiscard]] std::vector<core::AdmissionId> left_out_of(const std::string& channel) const;

  /// The left-out admissions in the form of a report: all of them, or those of one channel.
  [[nodiscard]] std::vector<control::LeftOutAdmission> left_out_report() const;
  [[nodiscard]] std::vector<control::LeftOutAdmission> left_out_report(
      const std::string& channel) const;

  /// Finds an admission, also one that is left out: by `key`, or by `id` if the key is empty. The
  /// error says which key or number is unknown.
  [[nodiscard]] Result<core::AdmissionId> named(core::AdmissionId id, const std::string& key) const;
  [[nodiscard]] std::optional<core::AdmissionId> with_key(const std::string& key) const {
    return keys_.find(key);
  }
  /// The number of admissions whose keys begin with `prefix`.
  [[nodiscard]] std::size_t count_of_keys(const std::string& prefix) const {
    return keys_.count_with_prefix(prefix);
  }

  /// An admission that has to wait for another gateway.
  struct Waiting {
    core::AdmissionId id = 0;
    std::string why;
    bool log = true;
  };
  /// Takes these admissions out of the state. They stay in the journal. A reason is logged when an
  /// admission begins to wait, and later at most once a minute, if it is another one. Returns the
  /// rules that the gates had for their channels; Turn::settle() has to follow.
  [[nodiscard]] core::FormerRules let_wait(const std::vector<Waiting>& all);
  /// Takes them into the state again; Turn::settle() has to follow if the state is in force,
  /// otherwise TagBindings::take_up() and a decision of everything. Those for which there is no
  /// place now go on waiting, with that reason. True if there are none of these.
  bool end_wait(const std::vector<core::AdmissionId>& all, bool is_in_force);
  /// It does not wait any more: the state of another description has it.
  void forget_wait(core::AdmissionId id) {
    if (waiting_.erase(id) != 0) left_out_.erase(id);
  }
  [[nodiscard]] bool waits(core::AdmissionId id) const { return waiting_.contains(id); }
  /// Whether the log has why it waits.
  [[nodiscard]] bool has_said(core::AdmissionId id) const {
    const auto said = waiting_.find(id);
    return said != waiting_.end() && !said->second.why.empty();
  }

  /// Whether a peer on a network made this admission by a subscription.
  [[nodiscard]] bool came_over_a_network(core::AdmissionId id) const;

  /// Remembers key, lease and holder of an admission that was just granted to a connection.
  void add(core::AdmissionId id, const control::Admit& request, std::uint64_t session);
  /// A connection has asked for this admission. If the request says that the connection holds it,
  /// its lease stops and its events go to that connection, and the result is true. Otherwise its
  /// lease starts again.
  bool own(core::AdmissionId id, const control::Admit& request, std::uint64_t session);
  /// A connection has ended: the leases of the admissions that only it held begin to run.
  void session_closed(std::uint64_t session);

  [[nodiscard]] bool is_held(core::AdmissionId id) const { return held_.contains(id); }
  /// Nanoseconds until the lease ends; nullopt if no lease runs.
  [[nodiscard]] std::optional<std::uint64_t> remaining(core::AdmissionId id) const {
    return leases_.remaining(id, clock_.monotonic_ns());
  }
  void renew(core::AdmissionId id) { leases_.renew(id, clock_.monotonic_ns()); }

  /// Sets the function that is called with admissions that have ended, after their gates are
  /// closed.
  void on_gone(std::function<void(const std::vector<core::AdmissionId>&)> gone) {
    gone_ = std::move(gone);
  }
  /// Ends admissions, also left-out ones: first on disk, then in the kernel. `why` goes to the log.
  /// After an error nothing has changed.
  Result<void> release(const std::vector<core::AdmissionId>& gone, const std::string& why);
  /// Ends admissions that could not be written to disk. No client has been answered that they were
  /// granted.
  void take_back(const std::vector<core::AdmissionId>& lost);
  /// To be called once a second: ends at most 64 admissions whose lease has ended. True if there
  /// may be more.
  bool end_some();

 private:
  /// The channel of an admission, also of one that is left out, for the log.
  [[nodiscard]] Note about(core::AdmissionId id) const;
  /// Removes admissions from everything except the disk. Returns the rules that the gates had for
  /// their channels.
  core::FormerRules forget(const std::vector<core::AdmissionId>& gone);
  void note_wait(core::AdmissionId id, const std::string& channel, const std::string& why, bool log,
                 Note about);
  void remove_from_state(core::AdmissionId id, core::FormerRules& left) const;
  [[nodiscard]] std::optional<control::LeftOutAdmission> restore_one(core::State& state,
                                                                     core::AdmissionId id) const;
  [[nodiscard]] bool needs_agreement(core::AdmissionId id) const;
  [[nodiscard]] control::LeftOutAdmission waits_for_agreement(core::AdmissionId id,
                                                              const std::string& channel) const;

  Scene& scene_;
  Recorder& recorder_;
  EventLog& log_;
  Turn& turn_;
  TagBindings& tags_;
  const Clock& clock_;
  Keys keys_;
  Leases leases_;
  LeftOut left_out_;
  bool needs_agreements_ = false;
  LeftOut reported_;  ///< as of the latest report_left_out()
  struct Said {
    std::string why;
    std::uint64_t at = 0;  ///< CLOCK_MONOTONIC ns
  };
  std::map<core::AdmissionId, Said> waiting_;  ///< with the reason that was last logged
  std::function<void(const std::vector<core::AdmissionId>&)> gone_ = [](const auto&) {};
  std::map<core::AdmissionId, std::set<std::uint64_t>> held_;  ///< the connections that hold it
};

}  // namespace mlcca
