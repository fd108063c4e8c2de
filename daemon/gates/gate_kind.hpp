// SPDX-License-Identifier: BSD-2-Clause
// The interfaces that hide the differences between gates of CAN and of Ethernet-like links from
// PortGate.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/gates/attachment.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/counters.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/silence_timers.hpp"
#include "daemon/gates/table.hpp"

namespace mlcca::gates {

/// What a gate has in the kernel: its programs, their maps, and the maps' contents. The object pins
/// and attaches nothing.
class GateObject {
 public:
  GateObject() = default;
  GateObject(const GateObject&) = delete;
  GateObject& operator=(const GateObject&) = delete;
  GateObject(GateObject&&) = delete;
  GateObject& operator=(GateObject&&) = delete;
  virtual ~GateObject() = default;

  [[nodiscard]] virtual int program_fd(Direction direction) const = 0;
  /// The descriptor of the XDP program; -1 if this kind of link has none.
  [[nodiscard]] virtual int early_fd() const { return -1; }
  /// The maps that outlive a daemon, with the paths of their pins.
  [[nodiscard]] virtual std::vector<Pin> pins(const std::string& directory) const = 0;
  /// Loads further programs for the same memory.
  [[nodiscard]] virtual Result<std::unique_ptr<GateObject>> copy(
      const SharedMaps& shared) const = 0;
  /// See SilenceTimers::of_can().
  [[nodiscard]] virtual Result<SilenceTimers> silence_timers(const SharedMaps& shared,
                                                             const std::string& pin_path,
                                                             bool take_over) const = 0;

  [[nodiscard]] virtual VerdictTable& table() = 0;
  /// Reads the table again, because another object may have changed the same memory.
  virtual Result<void> read_again() = 0;

  /// The words of the table that concern the gate as a complete unit.
  struct Words {
    std::uint32_t& retired;
    std::uint32_t& epoch;
  };
  [[nodiscard]] virtual Words words() const = 0;

  /// Whether all frames that leave are counted. An Ethernet gate counts only those that carry
  /// events.
  [[nodiscard]] virtual bool judges_everything() const = 0;
  [[nodiscard]] virtual const gate_watch& watch(std::uint16_t number) const = 0;
  [[nodiscard]] virtual SlotCounters counters(std::uint32_t slot) const = 0;
  [[nodiscard]] virtual ReasonCounters reasons(Direction direction) const = 0;
  [[nodiscard]] virtual ReasonCounters would_drop(Direction direction) const = 0;
  [[nodiscard]] virtual std::vector<UnknownFrame> unknown() const = 0;
  [[nodiscard]] virtual std::vector<RefusedSender> refused_senders() const = 0;
};

/// Loads the GateObject of an interface.
class GateKind {
 public:
  GateKind() = default;
  GateKind(const GateKind&) = delete;
  GateKind& operator=(const GateKind&) = delete;
  GateKind(GateKind&&) = delete;
  GateKind& operator=(GateKind&&) = delete;
  virtual ~GateKind() = default;

  /// Takes the maps of an attached gate by their pins. False if that gate is not of this kind.
  virtual bool take(const std::string& directory, const MapIds& ids) = 0;
  /// Whether the maps that were taken are as large as required now.
  [[nodiscard]] virtual bool fits() const { return true; }
  /// Loads the programs with the maps that were taken.
  [[nodiscard]] virtual Result<std::unique_ptr<GateObject>> load_over_taken(
      const SharedMaps& shared) const = 0;
  /// Loads the programs with new maps, without slots.
  [[nodiscard]] virtual Result<std::unique_ptr<GateObject>> load_new(
      const SharedMaps& shared) const = 0;
};

}  // namespace mlcca::gates
