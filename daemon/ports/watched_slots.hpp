// SPDX-License-Identifier: BSD-2-Clause
// The slots whose events are expected in time, and what is seen of these events.
#pragma once
#include <optional>

#include "base/result.hpp"
#include "bpf/gate.h"
#include "control/messages.hpp"
#include "core/gates/plan.hpp"
#include "daemon/ports/gated_ports.hpp"

namespace mlcca {

/// How the events of a delivery come to the slot that they enter by; nothing where it is not
/// watched.
[[nodiscard]] std::optional<control::Watch> watch_of(const core::GateState& rules,
                                                     const GatedPorts& ports);
/// If events of a delivery are missing that is reported once more, for a client that has not
/// received it.
[[nodiscard]] Result<void> report_missing_again(const core::GateState& rules,
                                                const GatedPorts& ports);
/// The event is of the slot that one of these rules is held by.
[[nodiscard]] bool is_of(const gate_event& event, const core::GateState& rules,
                         const GatedPorts& ports);
/// A port whose gate has more to watch than it can is reported when that begins and when it ends.
void report_unwatched(GatedPorts& ports, const net::LinkTable& links, const ReportLine& report);

}  // namespace mlcca
