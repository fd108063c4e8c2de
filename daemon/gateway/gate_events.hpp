// SPDX-License-Identifier: BSD-2-Clause
// Handles what the gates report by themselves: events that are missing or have come again, replies
// of the FAMOUSO broker, and unadmitted senders.
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
#include "daemon/outside/gate_reader.hpp"
#include "daemon/outside/link_monitor.hpp"

namespace mlcca {

class GateEvents {
 public:
  /// All references must outlive the object.
  struct Parts {
    const Scene& scene;
    const GateReader& gates;
    const LinkMonitor& links;
    EventLog& log;
    SilenceReports& silences;
    DeliveryHealth& health;
    TagBindings& tags;
  };
  explicit GateEvents(const Parts& parts) : parts_(parts) {}

  void on_event(const gate_event& event);
  /// A sender that was not seen before. The kernel limits the number of these reports.
  void on_sample(const gate_sample& sample);
  /// If events of a delivery are missing, makes the kernel report it once more, after an
  /// application that has joined the delivery has its answer.
  void repeat_missing(const core::Verdict& verdict);

 private:
  Parts parts_;
};

}  // namespace mlcca
