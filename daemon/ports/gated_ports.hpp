// SPDX-License-Identifier: BSD-2-Clause
// The ports of a description with their gates, by the number of the port.
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

struct GatedPort {
  DescribedPort port;
  InterfaceHold hold;
  bool unwatched = false;  ///< its gate has more to watch than it can, and that was reported
};

class GatedPorts {
 public:
  GatedPorts(GateSet::Load load, InterfaceHold::Close close)
      : gates_(std::move(load)), close_(std::move(close)) {}

  /// Ports that were described before keep their interface and its gate.
  void describe(const core::System& system, std::size_t gateway);
  /// Makes all gates that this description needs and that are not there, and begins a change of the
  /// set. `step` is called behind each. Error: one could not be made; nothing was changed.
  Result<void> prepare(const core::System& system, std::size_t gateway, const net::LinkTable& links,
                       const net::FactsOf& facts_of, const std::function<void()>& step);
  /// Gives a port the gate that it needs. What stands in its way becomes the problem of the port.
  void attach(GatedPort& gated, const net::Link& link, const ReportLine& report);

  [[nodiscard]] std::size_t size() const { return ports_.size(); }
  [[nodiscard]] const DescribedPort& operator[](std::size_t port) const {
    return ports_[port].port;
  }
  [[nodiscard]] auto begin() { return ports_.begin(); }
  [[nodiscard]] auto end() { return ports_.end(); }

  /// All gates, those of no port too.
  [[nodiscard]] GateSet& gates() { return gates_; }
  [[nodiscard]] const GateSet& gates() const { return gates_; }
  /// Room for slots that an Ethernet gate must have.
  [[nodiscard]] std::size_t ether_slots() const { return ether_slots_; }

  /// The gate of a port; none where it needs none, or has none that holds its slots.
  [[nodiscard]] enforce::PortGate* gate(std::size_t port) const;
  [[nodiscard]] enforce::Gate* can_gate(std::size_t port) const;
  [[nodiscard]] bool has_gate(std::size_t port) const { return held(port) != nullptr; }
  /// A former description had a gate there, which nobody has taken off: it stays closed. nullptr:
  /// there is none, or the port needs one.
  [[nodiscard]] enforce::PortGate* closed_gate(std::size_t port) const;

  /// The interface is a port that needs a gate.
  [[nodiscard]] bool is_to_be_gated(int ifindex) const;
  /// A port has no gate, or no queue, and may get one now.
  [[nodiscard]] bool wants_gate(const net::LinkTable& links) const;
  /// Nothing of this daemon holds the interface of a port.
  [[nodiscard]] bool is_any_lost() const;
  /// One differs from what was made of it, or that may be.
  [[nodiscard]] bool is_any_outdated(const net::LinkTable& links,
                                     const net::FactsOf& facts_of) const;

 private:
  [[nodiscard]] HeldGate* held(std::size_t port) const;

  std::vector<GatedPort> ports_;
  GateSet gates_;
  InterfaceHold::Close close_;
  std::size_t ether_slots_ = 0;
};

}  // namespace mlcca
