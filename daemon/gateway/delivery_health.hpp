// SPDX-License-Identifier: BSD-2-Clause
// What is wrong with granted deliveries, and which channels have such troubles now.
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
#include "daemon/outside/gate_driver.hpp"

namespace mlcca {

class DeliveryHealth {
 public:
  /// All of them must outlive this.
  DeliveryHealth(const Scene& scene, const GateDriver& gates, const DropReports& drops,
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
  /// Rules by which events of several publishers of a channel come or leave, sorted by entry.
  [[nodiscard]] Shared shared_of(std::size_t channel) const;

  // Of a granted delivery. `rules` are those of the verdict, `shared` those of its channel.

  /// How its events come, and why nothing reports that they do not.
  struct Supervision {
    std::optional<control::Watch> watch;  ///< nothing: they are not watched
    std::string lacking;                  ///< empty: it is reported, or no subscriber minds
  };
  [[nodiscard]] Supervision supervision_of(const core::Verdict& verdict,
                                           const core::GateState& rules,
                                           const Shared& shared) const;
  /// Why nothing would report the silence of its publisher alone, where others look like it; else
  /// empty.
  [[nodiscard]] std::string look_alikes_of(const core::GateState& rules,
                                           const Shared& shared) const;
  /// What is wrong with it, one line each.
  [[nodiscard]] std::vector<std::string> troubles_of(const core::Verdict& verdict,
                                                     const core::GateState& rules,
                                                     const Shared& shared,
                                                     const Supervision& supervision) const;

  /// The counters of a channel have just been polled.
  void judge(const DropReports::Polled& polled);
  /// A program that carries events of a channel reports that some were late.
  void note_late(std::size_t channel) { troubled_.insert(channel); }
  /// The kernel has reported that events of a channel are missing.
  void note_missing(std::size_t channel) { troubled_.insert(channel); }
  /// A channel has been decided otherwise: what its gates have passed so far says nothing of what
  /// is granted from now on.
  void restart(std::size_t channel);
  /// Numbers of channels mean something else now, and what was granted before may be other.
  /// `pulse` is called after each channel.
  void forget(const std::function<void()>& pulse);
  /// Adds the troubles of all channels to the lines of a report; about as many lines as a report
  /// lists.
  void add_to(std::vector<std::string>& lines) const;
  /// add_to() takes too long for one turn of the loop.
  [[nodiscard]] bool is_large() const;

 private:
  [[nodiscard]] Supervision seen_at_gate(const core::GateState& rules, const Shared& shared) const;
  [[nodiscard]] std::string late_line(const core::Verdict& verdict, const std::string& to) const;

  using Passed = std::map<core::GateEntry, std::uint64_t>;
  /// By where the events come in and where they leave.
  using Leaving = std::map<std::pair<core::GateEntry, core::GateEntry>, LatestLeft>;
  [[nodiscard]] bool lacks_relay(const core::Verdict& v, const core::GateState& rules) const;
  [[nodiscard]] std::uint64_t passed_before(std::size_t channel,
                                            const core::GateEntry& entry) const;

  /// Where the events of a delivery come in; nullptr: not through a gate of ours.
  [[nodiscard]] static const core::GateRule* way_in(const core::GateState& rules);
  void note_leaving(std::size_t channel, const core::GateState& rules);
  [[nodiscard]] std::optional<LatestLeft> latest_left(std::size_t channel,
                                                      const core::GateEntry& in,
                                                      const core::GateEntry& out) const;

  const Scene& scene_;
  const GateDriver& gates_;
  const DropReports& drops_;
  const CanForwarding& forwarding_;
  const Carriers& carriers_;
  const Clock& clock_;
  const ReportedSilences& silences_;
  std::map<std::size_t, Passed> passed_before_;  ///< by channel, see restart()
  std::map<std::size_t, Leaving> leaving_;       ///< by channel
  std::set<std::size_t> troubled_;  ///< channels; each is examined again when it is reported
};

}  // namespace mlcca
