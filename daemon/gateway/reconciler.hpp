// SPDX-License-Identifier: BSD-2-Clause
// Brings the gateway in line with the world: with a description that has come into force, with the
// interfaces of the host, and with the links of meshes.
#pragma once
#include <cstddef>
#include <functional>
#include <set>
#include <utility>

#include "base/result.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/gateway_presence.hpp"
#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/meshes.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/tag_bindings.hpp"
#include "daemon/gateway/turn.hpp"
#include "daemon/outside/gate_driver.hpp"
#include "daemon/outside/link_monitor.hpp"

namespace mlcca {

class Reconciler {
 public:
  /// All must outlive the Reconciler.
  struct Parts {
    Scene& scene;
    GateDriver& gates;
    LinkMonitor& links;
    EventLog& log;
    Recorder& recorder;
    TagBindings& tags;
    Turn& turn;
    Meshes& meshes;
    GatewayPresence& presence;
    Membership* membership;  ///< null: this gateway is in no cluster
    std::function<void()> pulse;
  };
  explicit Reconciler(Parts parts) : p_(std::move(parts)) {}

  /// Sets up interfaces, links and gates for a description that has just come into force. What was
  /// granted before is decided first.
  Result<void> put_in_force(const DeliveryEvents::Granted& granted_before,
                            TagBindings::Known known);
  /// Reads what interfaces and networks are now, decides what this changes, and writes all gates.
  void reconcile();
  /// Reads the interfaces again. If they cannot be read, nothing changes, and they are read again
  /// in the next round.
  void links_changed();
  /// To be called when links of this network, an index, have changed.
  void note_links_of(std::size_t network) { changed_.insert(network); }
  /// Gives the links that have changed to the decisions. Turn::settle() has to follow.
  void follow_links_of_meshes();
  /// Gives to the decisions which gateway carries what, if no store says it.
  void note_presence();

 private:
  void put_graphs();

  Parts p_;
  std::set<std::size_t> changed_;  ///< indices of the networks whose links have changed
};

}  // namespace mlcca
