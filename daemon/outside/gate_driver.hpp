// SPDX-License-Identifier: BSD-2-Clause
// An interface for the ports of a gateway and their gates: Ports, which uses the kernel, or a fake.
// A port is identified by its index in the description of the gateway.
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

/// The line in the log and the health about an interface of GateDriver::undescribed().
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

  /// Takes the ports of a new description. Existing gates stay as they are until follow() and
  /// sync(). Interfaces that are not described any more are closed by follow().
  virtual void describe(const core::System& system, std::size_t gateway) = 0;
  /// To be called before describe(): makes all gates that this description needs and that do not
  /// exist, without putting any in place. Until end_change() the gates that they replace are kept
  /// as well, to be able to go back. The error: no memory or no right for a gate; then nothing has
  /// changed.
  virtual Result<void> prepare(const core::System& system, std::size_t gateway) = 0;
  /// Why a gate could not be put in place since prepare(). The gate that was in its place is still
  /// there, with its slots. The caller must describe() the former description again, and follow().
  [[nodiscard]] virtual const Result<void>& change() const = 0;
  /// From now on follow() and sync() return to what was before.
  virtual void go_back() = 0;
  virtual void end_change() = 0;
  /// Sets the function that is called between the steps of long work, after each gate.
  virtual void on_step(std::function<void()> step) = 0;
  /// An interface has changed, appeared or gone, or udev knows more about one. Whether this
  /// concerns a port or a gate, or may do so. False: follow() would change nothing.
  [[nodiscard]] virtual bool needs_reconcile() = 0;
  /// Brings gates and interfaces in line with the present interfaces. Whatever has a new owner is
  /// denied before anything else is done.
  virtual void follow() = 0;

  // Gates that have lost their filters:

  /// Puts the filters of all gates back. True if something has changed, so that follow() has to be
  /// called.
  virtual bool repair() = 0;
  /// The same in steps, one gate at a time: begin_repair(), then repair() of each next_gate() from
  /// 0 on; then wants_gate() is what repair() would have returned.
  virtual void begin_repair() = 0;
  /// False: the gate has gone and cannot be put back; follow() has to be called at once.
  virtual bool repair(int ifindex) = 0;
  [[nodiscard]] virtual bool wants_gate() const = 0;
  /// The interface index of the gate after this one; nullopt after the last one.
  [[nodiscard]] virtual std::optional<int> next_gate(int ifindex) const = 0;

  /// Whether an interface that must have a gate has none that this daemon commands. Then everything
  /// must be closed.
  [[nodiscard]] virtual bool out_of_hand() const = 0;
  /// Whether it could not be found out if the interface of a gate exists: follow() is to be called
  /// again soon.
  [[nodiscard]] virtual bool needs_recheck() const = 0;
  /// Why it is unknown whether gates without pins are left; empty if it is known.
  [[nodiscard]] virtual const std::string& orphans_unknown() const = 0;
  /// Interfaces that have a gate but are not described, or have no profile. They are closed.
  [[nodiscard]] virtual std::vector<std::string> undescribed() const = 0;
  /// To be called once a second for each gate: reports frames that were sent past it.
  virtual void check_bypass(int ifindex, std::int64_t now_s) = 0;

  // Slots:

  /// Makes every gate hold exactly `wanted`. A gate whose change the kernel refuses denies
  /// everything, and the error names it.
  virtual Result<void> sync(const core::GateState& wanted) = 0;
  /// Makes the changes. After an error the gates hold a part of them, and sync() has to be called.
  virtual Result<void> apply(const core::GateChanges& changes) = 0;
  /// Sets the priority bands of frames that leave through a port; see enforce::Gate::set_bands().
  virtual void set_bands(std::size_t port, std::span<const std::uint32_t> limits) = 0;
  /// The slots of the gates for these rules, in the order of the rules.
  [[nodiscard]] virtual std::vector<enforce::PlacedSlot> slots(
      std::span<const core::GateRule> rules) const = 0;
  /// The frames that came in and left by these rules. A frame that leaves is counted once: where it
  /// leaves; or, if that entry is among those `shared` with others, where it came in.
  [[nodiscard]] virtual Frames frames(const core::GateState& rules,
                                      const std::vector<core::GateEntry>& shared) const = 0;
  [[nodiscard]] Frames frames(const core::GateState& rules) const { return frames(rules, {}); }
  /// How the events of a delivery come to the slot by which they enter; nullopt if they are not
  /// watched.
  [[nodiscard]] virtual std::optional<control::Watch> watch(const core::GateState& rules) const = 0;
  /// If events of a delivery are missing, makes the kernel report it once more, for a client that
  /// has not received the report.
  [[nodiscard]] virtual Result<void> report_again(const core::GateState& rules) const = 0;
  /// Whether the event is of the slot of one of these rules.
  [[nodiscard]] virtual bool is_of(const gate_event& event, const core::GateState& rules) const = 0;
  /// The contents of the slots of all gates, for `mlccactl gate`. `place` is an interface or a
  /// network; empty: all.
  [[nodiscard]] virtual control::Gates gates(const core::State& state,
                                             const std::string& place) const = 0;
  /// The interfaces and networks that have gates, in words.
  [[nodiscard]] virtual std::string gated_places() const = 0;
  /// The number of slots of all gates.
  [[nodiscard]] virtual std::size_t slot_count() const = 0;

  // Ports:

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
  /// What the bus of a port has carried; nullopt if the kernel does not say.
  [[nodiscard]] virtual std::optional<BusCounters> bus_counters(std::size_t port) = 0;
  /// The count of frames without a slot on a port.
  [[nodiscard]] virtual UnknownFrames unknown_frames(std::size_t port) const = 0;
  /// The latest of these frames, each kind with a lower bound of its count.
  [[nodiscard]] virtual std::vector<enforce::UnknownFrame> seen_unknown(std::size_t port) const = 0;
  /// The latest senders that slots of a port have refused.
  [[nodiscard]] virtual std::vector<enforce::RefusedSender> refused_senders(
      std::size_t port) const = 0;
  /// The number of the slot of an entry, as in these senders; nullopt if it has none.
  [[nodiscard]] virtual std::optional<std::uint32_t> slot_number(
      const core::GateEntry& entry) const = 0;
  /// The frames that were refused for reasons that concern no slot.
  [[nodiscard]] virtual std::vector<Refusals> refusals(std::size_t port) const = 0;
  /// The refused frames of all slots of a port by reason, without excess. Frames of no slot may be
  /// among them.
  [[nodiscard]] virtual std::vector<Refusals> misfits(std::size_t port) const = 0;
  /// The latest frame without a slot that came in, for example "123" or "0x4e6f626f64790000 from
  /// 10.0.0.7".
  [[nodiscard]] virtual std::string latest_unknown(std::size_t port) const = 0;
  /// FAMOUSO's tags in the gate of a port; nullopt if no gate there holds any.
  [[nodiscard]] virtual std::optional<enforce::Bindings> bindings(std::size_t port) const = 0;
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
