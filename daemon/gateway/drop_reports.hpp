// SPDX-License-Identifier: BSD-2-Clause
// What the gates drop: their counters are polled, and what is new is reported to the operator and
// to the applications that it concerns.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
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
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca {

/// Why frames of an entry are dropped, as far as that is counted apart. Excess: dropped, or passed
/// because the port says so; would_exceed: passed in audit mode.
enum class Drop : std::uint8_t { misfit, would_be_misfit, excess, would_exceed };

class DropReports {
 public:
  /// The verdicts of a channel, granted ones first, and the rules of each.
  struct Polled {
    std::vector<const core::Verdict*> verdicts;
    std::vector<core::GateState> rules;
  };
  using OnPolled = std::function<void(const Polled&)>;

  /// `pulse` is called after each step of what takes long. All of them must outlive this.
  DropReports(const Scene& scene, const GateDriver& gates, EventLog& log,
              DeliveryEvents& deliveries, AuditLog& audit, const Clock& clock,
              std::function<void()> pulse)
      : scene_(scene),
        gates_(gates),
        log_(log),
        deliveries_(deliveries),
        audit_(audit),
        clock_(clock),
        pulse_(std::move(pulse)),
        causes_(gates) {}

  /// Called with each channel whose counters have just been polled.
  void on_polled(OnPolled polled) { on_polled_ = std::move(polled); }

  // In rounds: each polls a bit, and is true while the round has more.
  bool poll_some_channels();
  bool poll_some_ports();
  bool tidy() { return of_entries_.tidy(); }

  /// Other verdicts about a channel are in force. What was dropped of deliveries that are granted
  /// now, and were refused, says nothing about the grant.
  void verdicts_changed(const core::Change& change);
  /// Everything that was not reported yet is, now: what the counters mean is about to change.
  void report_all();
  /// What is counted now was reported, or has a name that may mean something else.
  void forget();

  /// Frames of an entry that were dropped for a reason lately.
  [[nodiscard]] RecentDrops recent(const core::GateEntry& entry, Drop reason) const {
    return of_entries_.recent({entry, reason}, clock_.monotonic_s());
  }
  /// Frames of no slot that came to a port lately, whatever became of them.
  [[nodiscard]] RecentDrops recent_unknown(std::size_t port) const {
    const RecentDrops dropped = of_ports_.recent({port, Fate::dropped}, clock_.monotonic_s());
    const RecentDrops passed = of_ports_.recent({port, Fate::let_through}, clock_.monotonic_s());
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
  /// Frames that are to be reported now, if any; the growth goes to the audit log, by cause.
  std::optional<std::uint64_t> sample(const core::GateEntry& entry, Drop reason,
                                      const core::Verdict& user, const Frames& frames);
  void poll(const core::Decision& decision, Reporting reporting);
  void poll_unknown(std::size_t port, Reporting reporting);

  const Scene& scene_;
  const GateDriver& gates_;
  EventLog& log_;
  DeliveryEvents& deliveries_;
  AuditLog& audit_;
  const Clock& clock_;
  std::function<void()> pulse_;
  MisfitCauses causes_;
  OnPolled on_polled_ = [](const Polled&) {};
  DropWatch<std::pair<core::GateEntry, Drop>> of_entries_;
  DropWatch<std::pair<std::size_t, Fate>> of_ports_;
  std::size_t next_channel_ = 0;
  std::size_t next_port_ = 0;
};

}  // namespace mlcca
