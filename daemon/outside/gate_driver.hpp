// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "core/gates/plan.hpp"
#include "core/model/system.hpp"
#include "daemon/outside/frames.hpp"
#include "daemon/outside/gate_reader.hpp"

namespace mlcca {

/// The line in the log and the health about an interface of GateDriver::undescribed().
[[nodiscard]] inline std::string undescribed_line(const std::string& interface) {
  return interface + " is not described, or without a profile: its gate stays closed";
}

/// The ports of a gateway and their gates: Ports, which uses the kernel, or a fake. Parts that
/// change nothing see it as a GateReader, or as PortFacts.
class GateDriver : public GateReader {
 public:
  /// Takes the ports of a new description. Existing gates stay as they are until follow() and
  /// sync(). Interfaces that are not described any more are closed by follow().
  virtual void describe(const core::System& system, std::size_t gateway) = 0;
  /// To be called before describe(): makes all gates that this description needs and that do not
  /// exist, without putting any in place. Until end_change() the gates that they replace are kept
  /// as well, to be able to go back. The error: no memory or no right for a gate; then nothing has
  /// changed.
  virtual Result<void> prepare(const core::System& system, std::size_t gateway) = 0;
  /// From now on follow() and sync() return to what was before.
  virtual void go_back() = 0;
  virtual void end_change() = 0;
  /// Sets the function that is called between the steps of long work, after each gate.
  virtual void on_step(std::function<void()> step) = 0;
  /// An interface has changed, appeared or gone, or udev knows more about one. Whether this
  /// concerns a port or a gate, or may do so. False: follow() would change nothing.
  [[nodiscard]] virtual bool needs_reconcile() = 0;
  /// Brings gates and interfaces in line with the present interfaces. Whatever has a new owner is
  /// denied before anything else is done. The error, between prepare() and go_back() only: a gate
  /// could not be put in place. The gate that was in its place is still there, with its slots. The
  /// caller must go_back(), describe() the former description again, and follow(). At other times
  /// such a failure is a problem of the port, and no error.
  virtual Result<void> follow() = 0;

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

  /// Whether it could not be found out if the interface of a gate exists: follow() is to be called
  /// again soon.
  [[nodiscard]] virtual bool needs_recheck() const = 0;
  /// To be called once a second for each gate: reports frames that were sent past it.
  virtual void check_bypass(int ifindex, std::int64_t now_s) = 0;

  // Slots:

  /// Makes every gate hold exactly `wanted`. A gate whose change the kernel refuses denies
  /// everything, and the error names it.
  virtual Result<void> sync(const core::GateState& wanted) = 0;
  /// Makes the changes. After an error the gates hold a part of them, and sync() has to be called.
  virtual Result<void> apply(const core::GateChanges& changes) = 0;
  /// Sets the priority bands of frames that leave through a port; see gates::Gate::set_bands().
  virtual void set_bands(std::size_t port, std::span<const std::uint32_t> limits) = 0;

  /// What the bus of a port has carried; nullopt if the kernel does not say.
  [[nodiscard]] virtual std::optional<BusCounters> bus_counters(std::size_t port) = 0;
};

}  // namespace mlcca
