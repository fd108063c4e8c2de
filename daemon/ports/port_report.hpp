// SPDX-License-Identifier: BSD-2-Clause
// What is reported of the ports: their interfaces, and what their gates have counted in all.
#pragma once
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "daemon/net/links.hpp"
#include "daemon/outside/frames.hpp"
#include "daemon/ports/drift.hpp"
#include "daemon/ports/gated_ports.hpp"

namespace mlcca {

/// Frames of no slot so far. `gate`: none, or of one port.
[[nodiscard]] UnknownFrames unknown_frames(const enforce::PortGate* gate);
/// What was refused for reasons that are of no slot: the gate was closed, a frame malformed.
[[nodiscard]] std::vector<Refusals> refusals(const enforce::PortGate* gate);
/// Of all slots, and whatever else the gate counts for the same reasons.
[[nodiscard]] std::vector<Refusals> misfits(const enforce::PortGate* gate);
/// The latest unknown one that came in: "123", "0x4e6f626f64790000 from 10.0.0.7".
[[nodiscard]] std::string latest_unknown(const enforce::PortGate* gate);
/// Of every port, in their order.
[[nodiscard]] std::vector<control::Interface> port_reports(const GatedPorts& ports,
                                                           const net::Links& links,
                                                           const Drift& drift);

}  // namespace mlcca
