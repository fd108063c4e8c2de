// SPDX-License-Identifier: BSD-2-Clause
// The real implementations of what a gateway sees of the world: interfaces and gates of the kernel,
// clocks and disk of the machine.
#pragma once
#include <systemd/sd-event.h>

#include <optional>

#include "base/clock.hpp"
#include "daemon/cluster/link.hpp"
#include "daemon/description_files.hpp"
#include "daemon/gateway/controller.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/reading.hpp"
#include "daemon/net/can_socket.hpp"
#include "daemon/net/identity.hpp"
#include "daemon/net/links.hpp"
#include "daemon/options.hpp"
#include "daemon/outside/kernel_gate_control.hpp"
#include "daemon/ports/ports.hpp"
#include "daemon/system_log.hpp"

namespace mlcca {

/// Owns these objects, and passes references to the controller as an Outside.
class RealOutside {
 public:
  /// `loop` must outlive this object.
  RealOutside(Options options, SystemLog log, gates::Control control, net::Links links,
              net::FactsOf facts_of, sd_event* loop);

  /// To be called before outside(): connects to the store if this gateway is in a cluster.
  [[nodiscard]] Result<void> start_cluster();
  /// The references for one controller.
  [[nodiscard]] Outside outside();
  [[nodiscard]] EventLog& log() { return log_; }
  /// Descriptors for the loop to watch; reports_fd() is valid after the controller has started.
  [[nodiscard]] int links_fd() const { return links_.fd(); }
  [[nodiscard]] int reports_fd() const { return control_.reports_fd(); }

 private:
  Options options_;
  sd_event* loop_;
  EventLog log_;
  SystemClock clock_;
  KernelGateControl control_;
  net::Links links_;
  net::CanSocket can_;
  Ports ports_;
  Reading reading_;
  std::optional<cluster::SocketLink> cluster_;
  DescriptionFiles texts_;
};

}  // namespace mlcca
