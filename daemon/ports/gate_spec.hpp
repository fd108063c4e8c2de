// SPDX-License-Identifier: BSD-2-Clause
// What the gate of an interface must be: its kind, profile and number of slots, and what senders
// get for dropped frames.
#pragma once
#include <cstddef>
#include <variant>

#include "core/model/system.hpp"
#include "daemon/gates/ether_gate.hpp"
#include "daemon/gates/gate.hpp"
#include "daemon/net/links.hpp"

namespace mlcca {

using GateSpec = std::variant<gates::GateConfig, gates::EtherConfig>;

/// For an interface that is a port on a network of that kind and profile. An Ethernet gate must
/// have room for `slots`.
[[nodiscard]] GateSpec gate_spec(const net::Link& link, core::NetworkKind kind,
                                 core::Profile profile, core::Refused refused, std::size_t slots);
/// For an interface that is not described. A CAN gate without a profile starts without slots.
[[nodiscard]] GateSpec closed_gate_spec(const net::Link& link, std::size_t slots);

[[nodiscard]] int ifindex_of(const GateSpec& spec);

}  // namespace mlcca
