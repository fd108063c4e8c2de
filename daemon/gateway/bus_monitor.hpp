// SPDX-License-Identifier: BSD-2-Clause
// What the CAN buses of this gateway really carry, against what was analysed: unaccounted load, and
// refused publishers that send all the same.
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

class BusMonitor final : public ConditionSource {
 public:
  /// All of them must outlive this.
  BusMonitor(const Scene& scene, GateDriver& gates, EventLog& log, Turn& turn, const Clock& clock)
      : scene_(scene), gates_(gates), log_(log), turn_(turn), clock_(clock) {}

  void add_to(std::vector<core::Condition>& conditions) const override;

  /// Some channels of one port after the other, then its load; true while the round has more. What
  /// has changed is settled at its end.
  bool poll_some();

  /// The load of each network that the analysis does not have, by network.
  struct Load {
    std::uint32_t unaccounted = 0;  ///< 1e-6 of its time, of senders that are not described
    std::uint32_t reported = 0;     ///< of that, when it was last reported
    std::vector<core::ObservedLoad> observed;  ///< of known publishers that are refused
  };
  using Loads = std::map<std::size_t, Load>;
  /// For another description: an unadmitted sender does not go away with the former one. Gives what
  /// was known, for restore().
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

  /// How far the round is.
  struct Round {
    std::uint64_t description = 0;
    std::size_t port = 0;
    std::size_t channel = 0;
    std::set<std::size_t> polled;             ///< publishers
    std::vector<core::ObservedLoad> refused;  ///< on this port
    bool changed = false;                     ///< on any
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
