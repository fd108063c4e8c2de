// SPDX-License-Identifier: BSD-2-Clause
// What differs between the gates of CAN and of Ethernet-like links. What they have in common, how a
// gate comes into its place and stays there, is PortGate.
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

namespace mlcca::enforce {

/// What a gate has in the kernel: its programs, the maps that they read, and what these hold.
/// Nothing of it is pinned or attached by this object.
class GateObject {
 public:
  GateObject() = default;
  GateObject(const GateObject&) = delete;
  GateObject& operator=(const GateObject&) = delete;
  GateObject(GateObject&&) = delete;
  GateObject& operator=(GateObject&&) = delete;
  virtual ~GateObject() = default;

  [[nodiscard]] virtual int program_fd(Direction direction) const = 0;
  /// Of the program for the driver; -1: there is none of this kind of link.
  [[nodiscard]] virtual int early_fd() const { return -1; }
  /// Of the maps that outlive a daemon.
  [[nodiscard]] virtual std::vector<Pin> pins(const std::string& directory) const = 0;
  /// Other programs over the same memory.
  [[nodiscard]] virtual Result<std::unique_ptr<GateObject>> copy(
      const SharedMaps& shared) const = 0;
  /// See SilenceTimers::of_can().
  [[nodiscard]] virtual Result<SilenceTimers> silence_timers(const SharedMaps& shared,
                                                             const std::string& pin_path,
                                                             bool take_over) const = 0;

  [[nodiscard]] virtual Table& table() = 0;
  /// Another object may have changed the same memory.
  virtual Result<void> read_again() = 0;

  /// Words of the table that are of the gate as a whole.
  struct Words {
    std::uint32_t& retired;
    std::uint32_t& epoch;
  };
  [[nodiscard]] virtual Words words() const = 0;

  /// Whatever leaves is counted; of Ethernet only what carries events is.
  [[nodiscard]] virtual bool judges_everything() const = 0;
  [[nodiscard]] virtual const gate_watch& watch(std::uint16_t number) const = 0;
  [[nodiscard]] virtual SlotCounters counters(std::uint32_t slot) const = 0;
  [[nodiscard]] virtual ReasonCounters reasons(Direction direction) const = 0;
  [[nodiscard]] virtual ReasonCounters would_drop(Direction direction) const = 0;
  [[nodiscard]] virtual std::vector<UnknownFrame> unknown() const = 0;
};

/// Loads the object of an interface.
class GateKind {
 public:
  GateKind() = default;
  GateKind(const GateKind&) = delete;
  GateKind& operator=(const GateKind&) = delete;
  GateKind(GateKind&&) = delete;
  GateKind& operator=(GateKind&&) = delete;
  virtual ~GateKind() = default;

  /// Takes the maps of a gate that is attached, by their pins. False: it is none of this kind.
  virtual bool take(const std::string& directory, const MapIds& ids) = 0;
  /// What was taken is as large as is wanted now.
  [[nodiscard]] virtual bool fits() const { return true; }
  /// Over what was taken.
  [[nodiscard]] virtual Result<std::unique_ptr<GateObject>> load_over_taken(
      const SharedMaps& shared) const = 0;
  /// Over maps of its own, without slots.
  [[nodiscard]] virtual Result<std::unique_ptr<GateObject>> load_new(
      const SharedMaps& shared) const = 0;
};

}  // namespace mlcca::enforce
