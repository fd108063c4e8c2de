// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/port_report.hpp"

#include <fmt/core.h>
#include <linux/can.h>

#include <algorithm>
#include <utility>

#include "core/model/progress.hpp"
#include "core/model/text.hpp"

namespace mlcca {
namespace {

using Of = core::FrameReasonKind;

control::Traffic traffic_of(const gates::PortGate& gate, gates::Direction direction) {
  control::Traffic out;
  const auto reasons = gate.reasons(direction);
  for (std::size_t i = 0; i < reasons.size(); ++i) {
    if (reasons[i] == 0) continue;
    const core::FrameReason reason = gates::reason_of(i);
    if (reason == core::FrameReason::passed) out.passed = reasons[i];
    if (reason == core::FrameReason::unknown) out.unknown = reasons[i];
    const bool drops = core::is_drop(reason);
    if (drops) out.dropped += reasons[i];
    out.reasons.push_back({std::string(core::to_text(reason)), reasons[i], !drops});
  }
  const auto spared = gate.would_drop(direction);
  for (std::size_t i = 0; i < spared.size(); ++i) {
    if (spared[i] == 0) continue;
    out.would_drop += spared[i];
    out.would_drop_reasons.push_back(
        {std::string(core::to_text(gates::reason_of(i))), spared[i], false});
  }
  return out;
}

control::Interface report_of(const DescribedPort& port, const net::InterfaceTable& links) {
  control::Interface i;
  i.name = port.interface_name(links);
  i.network = port.network();
  i.identity = net::to_text(port.described().identity);
  i.profile = core::to_text(port.profile());
  i.managed = port.described().managed;
  i.problem = port.problem();
  i.ifindex = static_cast<std::uint32_t>(port.ifindex());
  if (const net::Link* link = port.link(links)) {
    i.up = link->running;
    i.can_state = link->can_state;
    i.bitrate = link->bitrate;
  }
  return i;
}

void add_gate(const gates::PortGate& gate, control::Interface& to) {
  to.attached = gate.attached().value_or(false);
  to.drops_early = gate.drops_early();
  to.slots = static_cast<std::uint32_t>(gate.size());
  to.ingress = traffic_of(gate, gates::Direction::ingress);
  to.egress = traffic_of(gate, gates::Direction::egress);
  for (const gates::UnknownFrame& f : gate.unknown())
    to.unknown.push_back({f.can_id, f.len, f.format == GATE_FD,
                          f.direction == gates::Direction::egress, f.count, f.subject,
                          f.format == GATE_XL, gates::address_text(f.station),
                          gates::mac_text(f.station, f.mac)});
}

}  // namespace

UnknownFrames unknown_frames(const gates::PortGate* gate) {
  UnknownFrames sum;
  if (gate == nullptr) return sum;
  for (const auto direction : gates::kBothDirections) {
    sum.dropped += gate->reasons(direction)[GATE_R_UNKNOWN];
    sum.would_drop += gate->would_drop(direction)[GATE_R_UNKNOWN];
  }
  return sum;
}

namespace {

/// The frames of the reasons whose kind fulfils `is_meant`, in both directions.
std::vector<Refusals> counted_for(const gates::PortGate* gate,
                                  bool (*is_meant)(core::FrameReasonKind)) {
  if (gate == nullptr) return {};
  std::vector<Refusals> out;
  for (const auto direction : gates::kBothDirections) {
    const gates::ReasonCounters dropped = gate->reasons(direction);
    const gates::ReasonCounters passed = gate->would_drop(direction);
    for (std::size_t i = 0; i < core::kFrameReasons.size(); ++i)
      if (is_meant(core::kFrameReasons.at(i).kind))
        out.push_back({.reason = core::kFrameReasons.at(i).reason,
                       .egress = direction == gates::Direction::egress,
                       .frames = {dropped.at(i), passed.at(i)}});
  }
  return out;
}

}  // namespace

std::vector<Refusals> refusals(const gates::PortGate* gate) {
  return counted_for(gate, [](Of kind) { return kind == Of::any; });
}

/// The gate counts a frame with its slot first: so that slot is read first here.
std::vector<WithoutSlot> without_slot(const gates::PortGate* gate) {
  if (gate == nullptr) return {};
  std::vector<WithoutSlot> out;
  for (const auto direction : gates::kBothDirections) {
    const gates::SlotCounters all = gate->without_slot(direction);
    const gates::ReasonCounters dropped = gate->reasons(direction);
    const gates::ReasonCounters passed = gate->would_drop(direction);
    UnknownFrames others;
    for (std::size_t i = 0; i < core::kFrameReasons.size(); ++i) {
      const Of kind = core::kFrameReasons.at(i).kind;
      if (kind != Of::subject && kind != Of::any) continue;
      others.dropped += dropped.at(i);
      others.would_drop += passed.at(i);
    }
    out.push_back({.egress = direction == gates::Direction::egress,
                   .all = {all.dropped, all.would_drop},
                   .parts = {all.dropped - std::min(all.dropped, others.dropped),
                             all.would_drop - std::min(all.would_drop, others.would_drop)}});
  }
  return out;
}

std::vector<Refusals> misfits(const gates::PortGate* gate) {
  return counted_for(gate, [](Of kind) {
    return kind != Of::passes && kind != Of::subject && kind != Of::excess;
  });
}

std::string latest_unknown(const gates::PortGate* gate) {
  if (gate == nullptr) return {};
  for (const gates::UnknownFrame& f : gate->unknown()) {
    if (f.direction != gates::Direction::ingress) continue;
    if (f.format != 0)
      return (f.can_id & CAN_EFF_FLAG) != 0 ? fmt::format("{:08X}", f.can_id & CAN_EFF_MASK)
                                            : fmt::format("{:03X}", f.can_id & CAN_SFF_MASK);
    return fmt::format("{} from {}", core::format_subject(f.subject),
                       gates::sender_text(f.station, f.mac));
  }
  return {};
}

std::vector<control::Interface> port_reports(const GatedPorts& ports, const net::Links& links,
                                             const Drift& drift) {
  std::vector<control::Interface> out;
  for (std::size_t p = 0; p < ports.size(); ++p) {
    control::Interface i = report_of(ports[p], links.table());
    if (const gates::PortGate* gate = ports.gate(p)) {
      add_gate(*gate, i);
      drift.report(ports[p].ifindex(), *gate, i);
      if (!links.problem().empty())
        i.drift += (i.drift.empty() ? "" : "; ") + links.problem() + ": all stays as it was";
    }
    if (const gates::PortGate* gate = ports.closed_gate(p)) add_gate(*gate, i);
    out.push_back(std::move(i));
    core::Progress::made();
  }
  return out;
}

}  // namespace mlcca
