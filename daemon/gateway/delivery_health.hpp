// SPDX-License-Identifier: BSD-2-Clause
// Finds what is wrong with granted deliveries, and remembers which channels have such troubles.
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
#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/can_forwarding.hpp"
#include "daemon/gateway/carriers.hpp"
#include "daemon/gateway/drop_reports.hpp"
#include "daemon/gateway/health.hpp"
#include "daemon/gateway/reported_silences.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/gate_reader.hpp"

namespace mlcca {

class DeliveryHealth {
 public:
  /// All references must outlive this object.
  DeliveryHealth(const Scene& scene, const GateReader& gates, const DropReports& drops,
                 const CanForwarding& forwarding, const Carriers& carriers, const Clock& clock,
                 const ReportedSilences& silences)
      : scene_(scene),
        gates_(gates),
        drops_(drops),
        forwarding_(forwarding),
        carriers_(carriers),
        clock_(clock),
        silences_(silences) {}

  using Shared = std::vector<core::SharedRule>;
  /// The rules of a channel that several of its publishers share, sorted by entry.
  [[nodiscard]] Shared shared_of(std::size_t channel) const;

  // The following concern one granted delivery. `rules` are those of its verdict, `shared` is
  // shared_of() of its channel.

  /// How the silence of its publisher is supervised.
  struct Supervision {
    std::optional<control::Watch> watch;  ///< nullopt: it is not supervised
    std::string lacking;  ///< why nothing reports its silence; empty: it is reported, or no
                          ///< subscriber requires it
  };
  [[nodiscard]] Supervision supervision_of(const core::Verdict& verdict,
                                           const core::GateState& rules,
                                           const Shared& shared) const;
  /// Why the silence of its publisher alone would not be reported because the gate cannot
  /// distinguish it from others; empty if it would be.
  [[nodiscard]] std::string look_alikes_of(const core::GateState& rules,
                                           const Shared& shared) const;
  /// What is wrong with the delivery, one line each.
  [[nodiscard]] std::vector<std::string> troubles_of(const core::Verdict& verdict,
                                                     const core::GateState& rules,
                                                     const Shared& shared,
                                                     const Supervision& supervision) const;

  void judge(const DropReports::Polled& polled);
  /// A carrier has reported that events of a channel were late.
  void note_late(std::size_t channel) { troubled_.insert(channel); }
  /// The kernel has reported that events of a channel are missing.
  void note_missing(std::size_t channel) { troubled_.insert(channel); }
  /// The decision on a channel has changed: what its gates have passed before says nothing about
  /// the present grant.
  void restart(std::size_t channel);
  /// Channel numbers have a new meaning after a reload, and what was granted before may differ.
  /// `pulse` is called after each channel.
  void forget(const std::function<void()>& pulse);
  /// Adds the troubles of all channels to the lines of a report, about as many as a report lists.
  void add_to(std::vector<std::string>& lines) const;
  /// Whether add_to() takes too long for one turn of the loop.
  [[nodiscard]] bool is_large() const;

 private:
  [[nodiscard]] Supervision seen_at_gate(const core::GateState& rules, const Shared& shared) const;
  [[nodiscard]] std::string late_line(const core::Verdict& verdict, const std::string& to) const;

  using Passed = std::map<core::GateEntry, std::uint64_t>;
  /// The latest event that left, by the entries where events come in and where they leave.
  using Leaving = std::map<std::pair<core::GateEntry, core::GateEntry>, LatestLeft>;
  [[nodiscard]] bool lacks_relay(const core::Verdict& v, const core::GateState& rules) const;
  [[nodiscard]] std::uint64_t passed_before(std::size_t channel,
                                            const core::GateEntry& entry) const;

  /// The rule by which the events of a delivery come in; nullptr if they come through no gate of
  /// ours.
  [[nodiscard]] static const core::GateRule* way_in(const core::GateState& rules);
  void note_leaving(std::size_t channel, const core::GateState& rules);
  [[nodiscard]] std::optional<LatestLeft> latest_left(std::size_t channel,
                                                      const core::GateEntry& in,
                                                      const core::GateEntry& out) const;

  const Scene& scene_;
  const GateReader& gates_;
  const DropReports& drops_;
  const CanForwarding& forwarding_;
  const Carriers& carriers_;
  const Clock& clock_;
  const ReportedSilences& silences_;
  std::map<std::size_t, Passed> passed_before_;  ///< counters at the latest restart(), by channel
  std::map<std::size_t, Leaving> leaving_;       ///< by channel
  std::set<std::size_t> troubled_;  ///< channels; each is examined again when a report is made
};

}  // namespace mlcca
