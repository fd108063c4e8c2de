// SPDX-License-Identifier: BSD-2-Clause
// The ports of a description with their gates, by index of the port.
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "daemon/net/identity.hpp"
#include "daemon/net/links.hpp"
#include "daemon/ports/described_port.hpp"
#include "daemon/ports/gate_set.hpp"
#include "daemon/ports/interface_hold.hpp"
#include "daemon/ports/report_line.hpp"

namespace mlcca {

/// A port, and how its interface is held.
struct GatedPort {
  DescribedPort port;
  InterfaceHold hold;
  bool unwatched = false;  ///< its gate has too few watches, which was reported
};

/// Combines the ports of the description with the set of gates.
class GatedPorts {
 public:
  GatedPorts(GateSet::Load load, InterfaceHold::Close close)
      : gates_(std::move(load)), close_(std::move(close)) {}

  /// Takes a new description. Ports that were described before keep their interface and its gate.
  void describe(const core::System& system, std::size_t gateway);
  /// Makes all gates that this description needs and that do not exist, and begins a change of the
  /// set. `step` is called after each. The error: one could not be made; nothing has changed.
  Result<void> prepare(const core::System& system, std::size_t gateway,
                       const net::InterfaceTable& links, const net::FactsOf& facts_of,
                       const std::function<void()>& step);
  /// Gives a port the gate that it needs. A failure becomes the problem of the port. The error:
  /// that of a change that has to be undone (GateSet::must_go_back()).
  Result<void> attach(GatedPort& gated, const net::Link& link, const ReportLine& report);

  [[nodiscard]] std::size_t size() const { return ports_.size(); }
  [[nodiscard]] const DescribedPort& operator[](std::size_t port) const {
    return ports_[port].port;
  }
  [[nodiscard]] auto begin() { return ports_.begin(); }
  [[nodiscard]] auto end() { return ports_.end(); }

  /// All gates, also those of no port.
  [[nodiscard]] GateSet& gates() { return gates_; }
  [[nodiscard]] const GateSet& gates() const { return gates_; }
  /// The number of slots that an Ethernet gate must have room for.
  [[nodiscard]] std::size_t ether_slots() const { return ether_slots_; }

  /// The gate of a port; nullptr if it needs none, or has none that holds its slots.
  [[nodiscard]] gates::PortGate* gate(std::size_t port) const;
  [[nodiscard]] gates::Gate* can_gate(std::size_t port) const;
  [[nodiscard]] bool has_gate(std::size_t port) const { return held(port) != nullptr; }
  /// The gate of a port that needs none, if a former description had one there that nobody has
  /// removed. It stays closed. Otherwise nullptr.
  [[nodiscard]] gates::PortGate* closed_gate(std::size_t port) const;

  /// Whether the interface is a port that needs a gate.
  [[nodiscard]] bool is_to_be_gated(int ifindex) const;
  /// Whether a port lacks a gate or a queue that it may get now.
  [[nodiscard]] bool wants_gate(const net::InterfaceTable& links) const;
  /// Whether the interface of any port is held by nothing of this daemon.
  [[nodiscard]] bool is_any_lost() const;
  /// Whether any port differs, or may differ, from what was made of it.
  [[nodiscard]] bool is_any_outdated(const net::InterfaceTable& links,
                                     const net::FactsOf& facts_of) const;

 private:
  [[nodiscard]] HeldGate* held(std::size_t port) const;

  std::vector<GatedPort> ports_;
  GateSet gates_;
  InterfaceHold::Close close_;
  std::size_t ether_slots_ = 0;
};

}  // namespace mlcca
