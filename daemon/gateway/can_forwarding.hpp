// SPDX-License-Identifier: BSD-2-Clause
// Lets can-gw carry channels that are granted from one CAN bus to another.
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
#include "daemon/outside/link_monitor.hpp"
#include "daemon/outside/port_facts.hpp"

namespace mlcca {

/// Derives the rules of can-gw from the decisions, channel by channel, and passes them to
/// Forwarder, which brings the kernel in line.
class CanForwarding {
 public:
  /// `pulse` is called after each step of long work, for the heart-beat. All references must
  /// outlive this object.
  CanForwarding(const Scene& scene, const PortFacts& gates, const LinkMonitor& links, EventLog& log,
                std::unique_ptr<net::CanRules> kernel, std::function<void()> pulse);

  /// Takes the rules that a channel needs by its current decision. act() makes them effective.
  void want(std::size_t channel);
  /// The same for all channels; also makes act() read the rules of the kernel again.
  void want_all();
  /// To be called once a turn, before answers are sent: makes the changes in the kernel.
  void act() { forwarder_.act(); }
  /// To be called once a second: corrects what another program has changed, and retries what
  /// failed.
  void poll() { forwarder_.poll(); }
  /// Removes all our rules from the kernel.
  void stop() { forwarder_.stop(); }

  /// Why a granted channel is not carried; nullptr if nothing hinders it.
  [[nodiscard]] const std::string* obstacle(std::size_t channel) const;
  /// The current problem with can-gw that concerns all channels; empty if there is none.
  [[nodiscard]] const std::string& problem() const { return forwarder_.problem(); }
  /// The number of wanted rules plus the number of rules that the kernel was last seen to have.
  [[nodiscard]] std::size_t rules() const { return forwarder_.rules(); }
  /// Adds the rules `there` and what is wrong with them to the reply for `mlccactl routes`.
  void add_to(control::Routes& routes, const Result<std::vector<net::CanRuleThere>>& there) const;
  /// The rules that the kernel has now, ours and those of other programs.
  [[nodiscard]] Result<std::vector<net::CanRuleThere>> read() { return forwarder_.read(); }

 private:
  const Scene& scene_;
  const PortFacts& gates_;
  const LinkMonitor& links_;
  EventLog& log_;
  Forwarder forwarder_;
  std::function<void()> pulse_;
  std::map<std::size_t, std::string> obstacles_;  ///< by channel
};

}  // namespace mlcca
