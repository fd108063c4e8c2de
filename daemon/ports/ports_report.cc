// SPDX-License-Identifier: BSD-2-Clause
// What is said of the ports: their interfaces, and what their gates have counted.
#include <fmt/core.h>
#include <linux/can.h>

#include <utility>

#include "core/model/progress.hpp"
#include "core/model/text.hpp"
#include "daemon/ports/ports.hpp"

namespace mlcca {
namespace {

control::Traffic traffic_of(const enforce::PortGate& gate, enforce::Direction direction) {
  control::Traffic out;
  const auto reasons = gate.reasons(direction);
  for (std::size_t i = 0; i < reasons.size(); ++i) {
    if (reasons[i] == 0) continue;
    const auto reason = static_cast<gate_reason>(i);
    if (reason == GATE_R_PASSED) out.passed = reasons[i];
    if (reason == GATE_R_UNKNOWN) out.unknown = reasons[i];
    if (enforce::is_drop(reason)) out.dropped += reasons[i];
    out.reasons.push_back({enforce::reason_text(reason), reasons[i]});
  }
  const auto spared = gate.would_drop(direction);
  for (std::size_t i = 0; i < spared.size(); ++i) {
    if (spared[i] == 0) continue;
    out.would_drop += spared[i];
    out.would_drop_reasons.push_back(
        {enforce::reason_text(static_cast<gate_reason>(i)), spared[i]});
  }
  return out;
}

}  // namespace

UnknownFrames Ports::unknown_frames(std::size_t port) const {
  UnknownFrames sum;
  const enforce::PortGate* gate = gate_of(port);
  if (gate == nullptr) return sum;
  for (const auto direction : enforce::kBothDirections) {
    sum.dropped += gate->reasons(direction)[GATE_R_UNKNOWN];
    sum.would_drop += gate->would_drop(direction)[GATE_R_UNKNOWN];
  }
  return sum;
}

std::string Ports::latest_unknown(std::size_t port) const {
  const enforce::PortGate* gate = gate_of(port);
  if (gate == nullptr) return {};
  for (const enforce::UnknownFrame& f : gate->unknown()) {
    if (f.direction != enforce::Direction::ingress) continue;
    if (f.format != 0)
      return (f.can_id & CAN_EFF_FLAG) != 0 ? fmt::format("{:08X}", f.can_id & CAN_EFF_MASK)
                                            : fmt::format("{:03X}", f.can_id & CAN_SFF_MASK);
    return fmt::format("{} from {}", core::format_subject(f.subject),
                       enforce::sender_text(f.station, f.mac));
  }
  return {};
}

std::string Ports::interface_name(std::size_t port) const {
  const net::Link* link = link_of(ports_[port]);
  return link != nullptr ? link->name : net::to_text(ports_[port].port.identity);
}

std::vector<control::Interface> Ports::report() const {
  std::vector<control::Interface> out;
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    const PortState& port = ports_[p];
    control::Interface i;
    i.name = interface_name(p);
    i.network = port.network_name;
    i.identity = net::to_text(port.port.identity);
    i.profile = core::to_text(port.profile);
    i.managed = port.port.managed;
    i.problem = port.problem;
    i.ifindex = static_cast<std::uint32_t>(port.ifindex);
    if (const net::Link* link = link_of(port)) {
      i.up = link->up;
      i.can_state = link->can_state;
      i.bitrate = link->bitrate;
    }
    if (const enforce::PortGate* gate = gate_of(p)) {
      i.attached = gate->attached().value_or(false);
      drift_.report(port.ifindex, *gate, i);
      if (!links_.problem().empty())
        i.drift += (i.drift.empty() ? "" : "; ") + links_.problem() + ": all stays as it was";
      i.drops_early = gate->drops_early();
      i.slots = static_cast<std::uint32_t>(gate->size());
      i.ingress = traffic_of(*gate, enforce::Direction::ingress);
      i.egress = traffic_of(*gate, enforce::Direction::egress);
      for (const enforce::UnknownFrame& f : gate->unknown())
        i.unknown.push_back({f.can_id, f.len, f.format == GATE_FD,
                             f.direction == enforce::Direction::egress, f.count, f.subject,
                             f.format == GATE_XL, enforce::address_text(f.station),
                             enforce::mac_text(f.station, f.mac)});
    }
    out.push_back(std::move(i));
    core::Progress::made();
  }
  return out;
}

}  // namespace mlcca
