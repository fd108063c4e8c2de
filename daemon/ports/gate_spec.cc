// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/gate_spec.hpp"

namespace mlcca {

GateSpec gate_spec(const net::Link& link, core::NetworkKind kind, core::Profile profile,
                   core::Refused refused, std::size_t slots) {
  const bool silent = refused == core::Refused::silent;
  if (kind == core::NetworkKind::can && !link.is_ethernet && !link.is_wpan)
    return gates::GateConfig{.ifindex = static_cast<std::uint32_t>(link.ifindex),
                             .name = link.name,
                             .profile = profile,
                             .echo_by_mark = link.kind == "can",
                             .hook = {},
                             .silent = silent};
  return gates::EtherConfig{.ifindex = static_cast<std::uint32_t>(link.ifindex),
                            .name = link.name,
                            .slots = slots,
                            .hook = {},
                            .silent = silent,
                            .framing = {}};
}

GateSpec closed_gate_spec(const net::Link& link, std::size_t slots) {
  return gate_spec(link, core::NetworkKind::can, core::Profile::none, core::Refused::error, slots);
}

int ifindex_of(const GateSpec& spec) {
  return std::visit([](const auto& config) { return static_cast<int>(config.ifindex); }, spec);
}

}  // namespace mlcca
