// SPDX-License-Identifier: BSD-2-Clause
// Reports of the ports: their interfaces, and the total counts of their gates.
#pragma once
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "daemon/net/links.hpp"
#include "daemon/outside/frames.hpp"
#include "daemon/ports/drift.hpp"
#include "daemon/ports/gated_ports.hpp"

namespace mlcca {

/// The frames without a slot so far. `gate` may be nullptr.
[[nodiscard]] UnknownFrames unknown_frames(const gates::PortGate* gate);
/// The frames that were refused for reasons that concern no slot: a closed gate, a malformed frame.
[[nodiscard]] std::vector<Refusals> refusals(const gates::PortGate* gate);
/// The frames of both directions that were refused and belong to no slot.
[[nodiscard]] std::vector<WithoutSlot> without_slot(const gates::PortGate* gate);
/// The refused frames of all slots, and others that the gate counts for the same reasons.
[[nodiscard]] std::vector<Refusals> misfits(const gates::PortGate* gate);
/// The latest frame without a slot that came in, for example "123" or "0x4e6f626f64790000 from
/// 10.0.0.7".
[[nodiscard]] std::string latest_unknown(const gates::PortGate* gate);
/// The report of each port, in their order.
[[nodiscard]] std::vector<control::Interface> port_reports(const GatedPorts& ports,
                                                           const net::Links& links,
                                                           const Drift& drift);

}  // namespace mlcca
