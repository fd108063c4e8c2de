// SPDX-License-Identifier: BSD-2-Clause
// Measures the load of the CAN buses of this gateway: unaccounted load, and publishers that send
// although they are refused.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/bus_load.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/turn.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca {

/// Polls the counters of the CAN ports in rounds, and passes measured loads to the next decision as
/// conditions (ConditionSource).
class BusMonitor final : public ConditionSource {
 public:
  /// All references must outlive this object.
  BusMonitor(const Scene& scene, GateDriver& gates, EventLog& log, Turn& turn, const Clock& clock)
      : scene_(scene), gates_(gates), log_(log), turn_(turn), clock_(clock) {}

  void add_to(std::vector<core::Condition>& conditions) const override;

  /// Does a part of a round: some channels of a port, and at its end the load of the port. True
  /// while the round has more. At the end of the round changes are settled.
  bool poll_some();

  /// The load of a network that the analysis does not contain.
  struct Load {
    std::uint32_t unaccounted = 0;             ///< 1e-6 of its time, of unadmitted senders
    std::uint32_t reported = 0;                ///< the unaccounted load that was last reported
    std::vector<core::ObservedLoad> observed;  ///< of known publishers that are refused, but send
  };
  using Loads = std::map<std::size_t, Load>;
  /// Prepares for another description and returns what is known, for restore(): unadmitted senders
  /// do not disappear with the former description.
  Loads carry_over(const core::System& former);
  void restore(Loads loads) { loads_ = std::move(loads); }

 private:
  [[nodiscard]] bool is_measured(std::size_t port) const;
  void poll_refused(const core::Decision& decision, std::size_t port);
  bool measure(std::size_t port, std::vector<core::ObservedLoad> senders);
  void report(const std::string& network, std::uint32_t unaccounted);

  const Scene& scene_;
  GateDriver& gates_;
  EventLog& log_;
  Turn& turn_;
  const Clock& clock_;
  std::map<std::string, BusLoad> meters_;                              ///< by network
  std::map<std::pair<std::size_t, std::size_t>, SenderLoad> senders_;  ///< by port and publisher
  Loads loads_;

  /// The progress of the current round.
  struct Round {
    std::uint64_t description = 0;
    std::size_t port = 0;
    std::size_t channel = 0;
    std::set<std::size_t> polled;             ///< already polled on this port
    std::vector<core::ObservedLoad> refused;  ///< on this port
    bool changed = false;                     ///< on any port of this round
    void next_port() {
      ++port;
      channel = 0;
      polled.clear();
      refused.clear();
    }
  };
  Round round_;
};

}  // namespace mlcca
