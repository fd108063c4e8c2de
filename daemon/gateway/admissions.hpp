// SPDX-License-Identifier: BSD-2-Clause
// The admissions that applications have made at run time: under which key, on what lease, held by
// which connection; and how they end.
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

/// "admission 7 of camera is left out: there is no network lan"
[[nodiscard]] std::string words_of(const control::LeftOutAdmission& left_out);

class Admissions {
 public:
  /// Admissions that have no place in the description, and why.
  using LeftOut = std::map<core::AdmissionId, control::LeftOutAdmission>;

  /// All of them must outlive this.
  Admissions(Scene& scene, Recorder& recorder, EventLog& log, Turn& turn, TagBindings& tags,
             const Clock& clock)
      : scene_(scene), recorder_(recorder), log_(log), turn_(turn), tags_(tags), clock_(clock) {}

  /// After a start: keys and leases of what is recorded. No client is connected, so each lease
  /// starts again.
  void remember();
  /// Takes what is recorded into a description that is not in force yet. Gives what has no place in
  /// it.
  [[nodiscard]] LeftOut restore_into(core::State& state) const;

  /// Those that have no place in the description that is in force.
  [[nodiscard]] const LeftOut& left_out() const { return left_out_; }
  void set_left_out(LeftOut left_out) { left_out_ = std::move(left_out); }
  /// Warns of each of them that was not reported so at the latest time.
  void report_left_out();
  /// Those of a channel that a client calls so. The description need not have it any more.
  [[nodiscard]] std::vector<core::AdmissionId> left_out_of(const std::string& channel) const;

  /// As a report has them: all, or those of a channel as above.
  [[nodiscard]] std::vector<control::LeftOutAdmission> left_out_report() const;
  [[nodiscard]] std::vector<control::LeftOutAdmission> left_out_report(
      const std::string& channel) const;

  /// By its key, or else by its number; also one that is left out. The error says what is missing.
  [[nodiscard]] Result<core::AdmissionId> named(core::AdmissionId id, const std::string& key) const;
  [[nodiscard]] std::optional<core::AdmissionId> with_key(const std::string& key) const {
    return keys_.find(key);
  }
  /// Admissions whose keys begin so.
  [[nodiscard]] std::size_t count_of_keys(const std::string& prefix) const {
    return keys_.count_with_prefix(prefix);
  }

  /// It is the subscription of a peer on a network.
  [[nodiscard]] bool came_over_a_network(core::AdmissionId id) const;

  /// One that was just granted to a connection.
  void add(core::AdmissionId id, const control::Admit& request, std::uint64_t session);
  /// A connection has asked for one: if it holds it, its lease does not run, and its events go to
  /// that connection; otherwise the lease starts again. True: it is held.
  bool own(core::AdmissionId id, const control::Admit& request, std::uint64_t session);
  /// A connection has ended: the leases of what it held begin to run.
  void session_closed(std::uint64_t session);

  [[nodiscard]] bool is_held(core::AdmissionId id) const { return held_.contains(id); }
  /// ns until its lease ends; nothing: it has none that runs.
  [[nodiscard]] std::optional<std::uint64_t> remaining(core::AdmissionId id) const {
    return leases_.remaining(id, clock_.monotonic_ns());
  }
  void renew(core::AdmissionId id) { leases_.renew(id, clock_.monotonic_ns()); }

  /// Called with admissions that are over, once their gates are closed.
  void on_gone(std::function<void(const std::vector<core::AdmissionId>&)> gone) {
    gone_ = std::move(gone);
  }
  /// Takes admissions back, also those that are left out: on disk first, then in the kernel. After
  /// an error nothing has changed.
  Result<void> release(const std::vector<core::AdmissionId>& gone, const std::string& why);
  /// The disk has refused what was admitted: no client has been granted it.
  void take_back(const std::vector<core::AdmissionId>& lost);
  /// Once a second: some of those whose lease has ended; true while there are more.
  bool end_some();

 private:
  /// Which channel it is of; also one that is left out.
  [[nodiscard]] About about(core::AdmissionId id) const;
  /// Takes them out of everything but the disk. Gives what the gates had of their channels.
  core::FormerRules forget(const std::vector<core::AdmissionId>& gone);

  Scene& scene_;
  Recorder& recorder_;
  EventLog& log_;
  Turn& turn_;
  TagBindings& tags_;
  const Clock& clock_;
  Keys keys_;
  Leases leases_;
  LeftOut left_out_;
  LeftOut reported_;  ///< as of the latest report_left_out()
  std::function<void(const std::vector<core::AdmissionId>&)> gone_ = [](const auto&) {};
  std::map<core::AdmissionId, std::set<std::uint64_t>> held_;  ///< by which connections
};

}  // namespace mlcca
