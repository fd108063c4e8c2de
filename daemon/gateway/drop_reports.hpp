// SPDX-License-Identifier: BSD-2-Clause
// Polls the counters of the gates for dropped frames, and reports new ones to the operator and to
// the applications that they concern.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/drop_watch.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/audit_log.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/drops.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/misfit_causes.hpp"
#include "daemon/gateway/misfit_senders.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/gate_reader.hpp"

namespace mlcca {

/// The kinds of dropped frames of an entry that are counted separately. `excess` was dropped, or
/// passed because the port says so; `would_exceed` and `would_be_misfit` passed in audit mode.
enum class Drop : std::uint8_t { misfit, would_be_misfit, excess, would_exceed };

/// Polls channels and ports in rounds, a part per turn. Feeds the audit log, the event log and
/// whoever on_polled() has named.
class DropReports {
 public:
  /// The verdicts of a channel, granted ones first, and the rules of each.
  struct Polled {
    std::vector<const core::Verdict*> verdicts;
    std::vector<core::GateState> rules;
  };
  using OnPolled = std::function<void(const Polled&)>;

  /// `pulse` is called after each step of long work, for the heart-beat. All references must
  /// outlive this object.
  DropReports(const Scene& scene, const GateReader& gates, EventLog& log,
              DeliveryEvents& deliveries, AuditLog& audit, const Clock& clock,
              std::function<void()> pulse)
      : scene_(scene),
        gates_(gates),
        log_(log),
        deliveries_(deliveries),
        audit_(audit),
        clock_(clock),
        pulse_(std::move(pulse)),
        causes_(gates),
        senders_(gates) {}

  /// Sets the function that is called with each channel whose counters have just been polled.
  void on_polled(OnPolled polled) { on_polled_ = std::move(polled); }

  // Each call does a part of a round, and returns true while the round has more.
  bool poll_some_channels();
  bool poll_some_ports();
  bool tidy() { return of_entries_.tidy(); }

  /// The verdicts of a channel have changed. Drops of deliveries that were refused and are granted
  /// now say nothing about the grant.
  void verdicts_changed(const core::DecisionChange& change);
  /// Reports everything that was not reported yet, because the meaning of the counters is about to
  /// change.
  void report_all();
  /// Forgets the state of all counters: it was reported, or its names may have a new meaning.
  void forget();

  /// The frames of an entry that were recently dropped for this reason.
  [[nodiscard]] RecentDrops recent(const core::GateEntry& entry, Drop reason) const {
    return of_entries_.recent({entry, reason}, clock_.monotonic_s());
  }
  /// The frames without a slot that recently came to a port, dropped or passed.
  [[nodiscard]] RecentDrops recent_unknown(std::size_t port) const {
    const RecentDrops dropped = of_ports_.recent({port, Fate::dropped}, clock_.monotonic_s());
    const RecentDrops passed = of_ports_.recent({port, Fate::passed}, clock_.monotonic_s());
    return {dropped.frames + passed.frames, std::max(dropped.seconds, passed.seconds)};
  }

 private:
  enum class Reporting : bool { no, yes };
  void poll_all(Reporting reporting);
  /// Frames of the entries of a verdict, without excess.
  struct Dropped {
    std::uint64_t dropped = 0;
    std::uint64_t would_drop = 0;
  };
  void sample_entry(const core::GateRule& rule, const std::vector<const core::Verdict*>& users,
                    Reporting reporting, Dropped& sum);
  /// Returns the frames that are to be reported now, nullopt if none. The growth goes to the audit
  /// log, by cause.
  std::optional<std::uint64_t> sample(const core::GateEntry& entry, Drop reason,
                                      const core::Verdict& user, const Frames& frames);
  /// Notes frames that differ from what the entry admits: by sender where it is known, by cause
  /// otherwise.
  void note_misfits(const core::GateEntry& entry, const core::Verdict& user, Fate fate,
                    std::uint64_t frames, std::optional<core::FrameReason> latest);
  void begin_round();
  /// The verdicts whose events come or leave by an entry.
  using Users = std::map<core::GateEntry, std::vector<const core::Verdict*>>;
  Dropped pass_over(const core::GateRule& rule);
  void pass_over_elsewhere(const Polled& polled, const Users& users);
  [[nodiscard]] bool goes_elsewhere(const core::Verdict& verdict) const;
  void poll(const core::Decision& decision, Reporting reporting);
  void poll_unknown(std::size_t port, Reporting reporting);

  const Scene& scene_;
  const GateReader& gates_;
  EventLog& log_;
  DeliveryEvents& deliveries_;
  AuditLog& audit_;
  const Clock& clock_;
  std::function<void()> pulse_;
  MisfitCauses causes_;
  MisfitSenders senders_;
  std::uint64_t round_began_ = 0;  ///< monotonic ns
  std::uint64_t span_ = 0;         ///< ns from the beginning of the last round to that of this one
  OnPolled on_polled_ = [](const Polled&) {};
  DropWatch<std::pair<core::GateEntry, Drop>> of_entries_;
  DropWatch<std::pair<std::size_t, Fate>> of_ports_;
  std::size_t next_channel_ = 0;
  std::size_t next_port_ = 0;
};

}  // namespace mlcca
