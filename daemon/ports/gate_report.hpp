// SPDX-License-Identifier: BSD-2-Clause
// Reports the contents of gates slot by slot: control traffic and channels, limits and counters.
#pragma once
#include <cstddef>
#include <string>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/net/links.hpp"
#include "daemon/ports/gated_ports.hpp"

namespace mlcca {

/// `place` is an interface or a network; empty: all.
[[nodiscard]] control::Gates gate_reports(const GatedPorts& ports, const net::LinkTable& links,
                                          const core::State& state, const std::string& place);
/// The interfaces and networks that need gates, in words.
[[nodiscard]] std::string gated_places(const GatedPorts& ports, const net::LinkTable& links);
/// The number of slots of the gates of all ports.
[[nodiscard]] std::size_t slot_count(const GatedPorts& ports);

}  // namespace mlcca
