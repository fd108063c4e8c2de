// SPDX-License-Identifier: BSD-2-Clause
// The ports of a gateway and their gates, as an interface: Ports, on the kernel, or a fake. A port
// is named by its number in the description of the gateway.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "bpf/gate.h"
#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "core/gates/plan.hpp"
#include "core/model/system.hpp"
#include "daemon/gates/bindings.hpp"
#include "daemon/gates/counters.hpp"
#include "daemon/gates/slot_spec.hpp"
#include "daemon/outside/frames.hpp"

namespace mlcca {

/// What the log and the health say of an interface that GateDriver::undescribed() names.
[[nodiscard]] inline std::string undescribed_line(const std::string& interface) {
  return interface + " is not described, or without a profile: its gate stays closed";
}

class GateDriver {
 public:
  GateDriver() = default;
  GateDriver(const GateDriver&) = delete;
  GateDriver& operator=(const GateDriver&) = delete;
  GateDriver(GateDriver&&) = delete;
  GateDriver& operator=(GateDriver&&) = delete;
  virtual ~GateDriver() = default;

  /// The ports of a new description. Gates that are there stay as they are until follow() and
  /// sync(); an interface that is not described any more is closed by follow().
  virtual void describe(const core::System& system, std::size_t gateway) = 0;
  /// Before describe(): makes all gates that this description needs and that are not there, without
  /// putting any in place. Until end_change() the gates that they displace are kept as well, for
  /// the way back. Error: there is no memory for one, or no right; nothing was changed.
  virtual Result<void> prepare(const core::System& system, std::size_t gateway) = 0;
  /// Why a gate could not be put in place since prepare(): describe() what was before, and
  /// follow(). The one that was in its place is there, with its slots.
  [[nodiscard]] virtual const Result<void>& change() const = 0;
  /// From now on follow() and sync() go back to what was before.
  virtual void go_back() = 0;
  virtual void end_change() = 0;
  /// Called between the steps of what takes long, a gate at a time.
  virtual void on_step(std::function<void()> step) = 0;
  /// An interface has changed, come or gone, or udev knows more of one: whether that concerns a
  /// port or a gate, or it cannot be said that it does not. False: follow() would change nothing.
  [[nodiscard]] virtual bool needs_reconcile() = 0;
  /// Brings gates and interfaces in line with what is there now. Whatever changed hands is denied
  /// before anything else happens.
  virtual void follow() = 0;

  // Gates that have lost their filters.

  /// All of them get their filters back. True: something has changed, follow() is due.
  virtual bool repair() = 0;
  /// The same in steps, a gate at a time: this first, then repair() of each next_gate() from 0 on,
  /// then wants_gate() says what repair() would have.
  virtual void begin_repair() = 0;
  /// False: the gate has gone and cannot be put back, and follow() is due at once.
  virtual bool repair(int ifindex) = 0;
  [[nodiscard]] virtual bool wants_gate() const = 0;
  /// The gate behind this one, by ifindex; nothing behind the last one.
  [[nodiscard]] virtual std::optional<int> next_gate(int ifindex) const = 0;

  /// An interface that ought to be gated has no gate that this daemon commands: everything must be
  /// closed.
  [[nodiscard]] virtual bool out_of_hand() const = 0;
  /// Whether the interface of a gate is there could not be found out: follow() again soon.
  [[nodiscard]] virtual bool needs_recheck() const = 0;
  /// Why it is unknown whether gates without pins are left; empty: it is known.
  [[nodiscard]] virtual const std::string& orphans_unknown() const = 0;
  /// Interfaces that have a gate and are not described, or without a profile: closed.
  [[nodiscard]] virtual std::vector<std::string> undescribed() const = 0;
  /// Once a second, of each gate: frames that were sent past it are reported.
  virtual void check_bypass(int ifindex, std::int64_t now_s) = 0;

  // Slots.

  /// Makes every gate hold exactly `wanted`. A gate that refuses is denied as a whole, and the
  /// error names it.
  virtual Result<void> sync(const core::GateState& wanted) = 0;
  /// Makes the changes. After an error the gates hold part of them: sync() is due.
  virtual Result<void> apply(const core::GateChanges& changes) = 0;
  /// What leaves through a port is queued by these limits, see enforce::Gate::set_bands().
  virtual void set_bands(std::size_t port, std::span<const std::uint32_t> limits) = 0;
  /// What the gates hold of these rules, in their order.
  [[nodiscard]] virtual std::vector<enforce::PlacedSlot> slots(
      std::span<const core::GateRule> rules) const = 0;
  /// What came and left by these rules. A frame that leaves has passed once: it is counted where it
  /// leaves, or, where that entry is one of those `shared` with others, where it came in.
  [[nodiscard]] virtual Frames frames(const core::GateState& rules,
                                      const std::vector<core::GateEntry>& shared) const = 0;
  [[nodiscard]] Frames frames(const core::GateState& rules) const { return frames(rules, {}); }
  /// How the events of a delivery come to the slot that they enter by; nothing where it is not
  /// watched.
  [[nodiscard]] virtual std::optional<control::Watch> watch(const core::GateState& rules) const = 0;
  /// If events of a delivery are missing that is reported once more, for a client that has not
  /// received it.
  [[nodiscard]] virtual Result<void> report_again(const core::GateState& rules) const = 0;
  /// The event is of the slot that one of these rules is held by.
  [[nodiscard]] virtual bool is_of(const gate_event& event, const core::GateState& rules) const = 0;
  /// What the slots of all gates hold, for `mlccactl gate`; `place`: an interface or a network,
  /// empty: all.
  [[nodiscard]] virtual control::Gates gates(const core::State& state,
                                             const std::string& place) const = 0;
  /// Interfaces and networks that have gates, in words.
  [[nodiscard]] virtual std::string gated_places() const = 0;
  /// Slots of all gates.
  [[nodiscard]] virtual std::size_t slot_count() const = 0;

  // Ports.

  [[nodiscard]] virtual std::size_t size() const = 0;
  [[nodiscard]] virtual const core::Port& described(std::size_t port) const = 0;
  [[nodiscard]] virtual core::Profile profile(std::size_t port) const = 0;
  [[nodiscard]] virtual const std::string& network_of(std::size_t port) const = 0;
  /// Name of the interface now, or what it is recognised by.
  [[nodiscard]] virtual std::string interface_name(std::size_t port) const = 0;
  /// Of the interface that is held by a gate, 0: there is none.
  [[nodiscard]] virtual int gated_interface(std::size_t port) const = 0;
  /// Why a port cannot be used; empty: it can.
  [[nodiscard]] virtual const std::string& problem(std::size_t port) const = 0;
  /// Usable or why not, of each network of the system.
  [[nodiscard]] virtual std::vector<core::Condition> conditions(std::size_t networks) const = 0;
  /// What the bus behind a port has carried; nothing where the kernel does not say.
  [[nodiscard]] virtual std::optional<BusCounters> bus_counters(std::size_t port) = 0;
  /// Frames that belong to no slot so far, on one port.
  [[nodiscard]] virtual UnknownFrames unknown_frames(std::size_t port) const = 0;
  /// Those of them that the gate saw last, of each kind how many at least.
  [[nodiscard]] virtual std::vector<enforce::UnknownFrame> seen_unknown(std::size_t port) const = 0;
  [[nodiscard]] virtual std::vector<Refusals> refusals(std::size_t port) const = 0;
  /// Those of all slots of a port by reason, without excess; what is of no slot may be among them.
  [[nodiscard]] virtual std::vector<Refusals> misfits(std::size_t port) const = 0;
  /// The latest frame of no slot that came in: "123", "0x4e6f626f64790000 from 10.0.0.7".
  [[nodiscard]] virtual std::string latest_unknown(std::size_t port) const = 0;
  /// FAMOUSO's tags in the gate of a port; nothing where there is no gate that holds any.
  [[nodiscard]] virtual std::optional<enforce::Bindings> bindings(std::size_t port) const = 0;
  /// Of every port, for `mlccactl status`.
  [[nodiscard]] virtual std::vector<control::Interface> report() const = 0;

  [[nodiscard]] std::size_t network_number(std::size_t port) const {
    return described(port).network;
  }
  [[nodiscard]] bool is_gated(std::size_t port) const { return gated_interface(port) != 0; }
  /// The port queues by priority, and is there to do so.
  [[nodiscard]] bool queues_by_priority(std::size_t port) const {
    return described(port).queueing == core::Queueing::priority && problem(port).empty();
  }
};

}  // namespace mlcca
