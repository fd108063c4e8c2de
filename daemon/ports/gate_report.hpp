// SPDX-License-Identifier: BSD-2-Clause
// Reports the contents of gates slot by slot: control traffic and channels, limits and counters.
#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gates/slot_spec.hpp"
#include "daemon/net/links.hpp"
#include "daemon/ports/gated_ports.hpp"

namespace mlcca {

/// The slots of a gate that a report lists, in order: all of control traffic, and at most `most` of
/// the others. If there are more, each direction gets half of the places, and what the other one
/// does not need.
[[nodiscard]] std::vector<gates::SlotSpec> listed_slots(
    const std::vector<gates::SlotSpec>& slots, std::size_t most,
    const std::function<bool(const gates::SlotSpec&)>& is_control);
/// `place` is an interface or a network; empty: all.
[[nodiscard]] control::Gates gate_reports(const GatedPorts& ports, const net::InterfaceTable& links,
                                          const core::State& state, const std::string& place);
/// The interfaces and networks that need gates, in words.
[[nodiscard]] std::string gated_places(const GatedPorts& ports, const net::InterfaceTable& links);
/// The number of slots of the gates of all ports.
[[nodiscard]] std::size_t slot_count(const GatedPorts& ports);

}  // namespace mlcca
