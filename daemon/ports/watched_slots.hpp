// SPDX-License-Identifier: BSD-2-Clause
// The slots whose events are supervised, and what was seen of these events.
#pragma once
#include <optional>

#include "base/result.hpp"
#include "bpf/gate.h"
#include "control/messages.hpp"
#include "core/gates/plan.hpp"
#include "daemon/ports/gated_ports.hpp"

namespace mlcca {

/// How the events of a delivery come to the slot by which they enter; nullopt if they are not
/// watched.
[[nodiscard]] std::optional<control::Watch> watch_of(const core::GateState& rules,
                                                     const GatedPorts& ports);
/// If events of a delivery are missing, makes the kernel report it once more, for a client that has
/// not received the report.
[[nodiscard]] Result<void> report_missing_again(const core::GateState& rules,
                                                const GatedPorts& ports);
/// Whether the event is of the slot of one of these rules.
[[nodiscard]] bool is_of(const gate_event& event, const core::GateState& rules,
                         const GatedPorts& ports);
/// Reports when a port's gate begins and ends to have too few watches.
void report_unwatched(GatedPorts& ports, const net::InterfaceTable& links,
                      const ReportLine& report);

}  // namespace mlcca
