// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "core/model/system.hpp"

namespace mlcca {

/// What the description and the kernel say about the ports of a gateway. A port is identified by
/// its index in the description of the gateway.
class PortFacts {
 public:
  PortFacts() = default;
  PortFacts(const PortFacts&) = delete;
  PortFacts& operator=(const PortFacts&) = delete;
  PortFacts(PortFacts&&) = delete;
  PortFacts& operator=(PortFacts&&) = delete;
  virtual ~PortFacts() = default;

  [[nodiscard]] virtual std::size_t size() const = 0;
  [[nodiscard]] virtual const core::Port& described(std::size_t port) const = 0;
  [[nodiscard]] virtual core::Profile profile(std::size_t port) const = 0;
  [[nodiscard]] virtual const std::string& network_of(std::size_t port) const = 0;
  /// The present name of the interface, or else the property by which it is recognised.
  [[nodiscard]] virtual std::string interface_name(std::size_t port) const = 0;
  /// The index of the interface that has a gate; 0 if there is none.
  [[nodiscard]] virtual int gated_interface(std::size_t port) const = 0;
  /// Why a port cannot be used; empty if it can.
  [[nodiscard]] virtual const std::string& problem(std::size_t port) const = 0;
  /// For each network of the system, whether it can be used, or why not.
  [[nodiscard]] virtual std::vector<core::Condition> conditions(std::size_t networks) const = 0;
  /// The report of each port, for `mlccactl status`.
  [[nodiscard]] virtual std::vector<control::Interface> report() const = 0;

  [[nodiscard]] std::size_t network_number(std::size_t port) const {
    return described(port).network;
  }
  [[nodiscard]] bool is_gated(std::size_t port) const { return gated_interface(port) != 0; }
  /// Whether the port queues by priority and can be used.
  [[nodiscard]] bool queues_by_priority(std::size_t port) const {
    return described(port).queueing == core::Queueing::priority && problem(port).empty();
  }
};

}  // namespace mlcca
