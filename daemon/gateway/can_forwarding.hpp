// SPDX-License-Identifier: BSD-2-Clause
// What was granted from one CAN bus to another is carried there by rules of can-gw.
#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/forwarder.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/net/can_routes.hpp"
#include "daemon/outside/gate_driver.hpp"
#include "daemon/outside/link_monitor.hpp"

namespace mlcca {

class CanForwarding {
 public:
  /// `pulse` is called after each step of what takes long. All of them must outlive this.
  CanForwarding(const Scene& scene, const GateDriver& gates, const LinkMonitor& links,
                EventLog& log, std::unique_ptr<net::CanRules> kernel, std::function<void()> pulse);

  /// What a channel needs as it is decided now; act() brings it about.
  void want(std::size_t channel);
  /// The same of all channels, and what the kernel has is read again.
  void want_all();
  /// Once a turn, before answers go out: makes the changes.
  void act() { forwarder_.act(); }
  /// Once a second: what another program has removed or added, and what failed before.
  void poll() { forwarder_.poll(); }
  /// No rule of ours is left.
  void stop() { forwarder_.stop(); }

  /// Why a granted channel is not carried; null: nothing is in its way.
  [[nodiscard]] const std::string* obstacle(std::size_t channel) const;
  /// What is wrong as a whole; empty: nothing.
  [[nodiscard]] const std::string& problem() const { return forwarder_.problem(); }
  /// Rules that are wanted, and those that the kernel was last seen to have.
  [[nodiscard]] std::size_t rules() const { return forwarder_.rules(); }
  /// For `mlccactl routes`: the rules `there`, and what is wrong with them.
  void add_to(control::Routes& routes, const Result<std::vector<net::CanRuleThere>>& there) const;
  /// What the kernel has now, ours and those of others.
  [[nodiscard]] Result<std::vector<net::CanRuleThere>> read() { return forwarder_.read(); }

 private:
  const Scene& scene_;
  const GateDriver& gates_;
  const LinkMonitor& links_;
  EventLog& log_;
  Forwarder forwarder_;
  std::function<void()> pulse_;
  std::map<std::size_t, std::string> obstacles_;  ///< by channel
};

}  // namespace mlcca
