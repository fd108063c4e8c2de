// SPDX-License-Identifier: BSD-2-Clause
// What the gates report by themselves: events that are missing or come again, replies of FAMOUSO's
// broker, and unadmitted senders.
#pragma once
#include <string>
#include <utility>

#include "bpf/gate.h"
#include "core/model/verdict.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/silence_reports.hpp"
#include "daemon/gateway/tag_bindings.hpp"
#include "daemon/outside/gate_driver.hpp"
#include "daemon/outside/link_monitor.hpp"

namespace mlcca {

class GateEvents {
 public:
  /// All of them must outlive this.
  struct Parts {
    const Scene& scene;
    const GateDriver& gates;
    const LinkMonitor& links;
    EventLog& log;
    SilenceReports& silences;
    DeliveryHealth& health;
    TagBindings& tags;
  };
  explicit GateEvents(const Parts& parts) : parts_(parts) {}

  void on_event(const gate_event& event);
  /// A sender that was not seen before; the kernel sees to it that there are not too many.
  void on_sample(const gate_sample& sample);
  /// If events of a delivery are missing the kernel reports it once more, when whoever joined it
  /// has its answer.
  void repeat_missing(const core::Verdict& verdict);

 private:
  Parts parts_;
};

}  // namespace mlcca
