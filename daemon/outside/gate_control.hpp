// SPDX-License-Identifier: BSD-2-Clause
// An interface for what opens and closes all gates of a gateway together: the pinned control word
// of the kernel (KernelGateControl), or a fake. See gates::Control for the details of each
// method.
#pragma once
#include <cstdint>
#include <functional>

#include "base/result.hpp"
#include "bpf/gate.h"
#include "daemon/gates/control.hpp"

namespace mlcca {

/// The functions that get the reports of the gates.
struct GateReports {
  std::function<void(const gate_event&)> event;
  std::function<void(const gate_sample&)> sample;
};

class GateControl {
 public:
  GateControl() = default;
  GateControl(const GateControl&) = delete;
  GateControl& operator=(const GateControl&) = delete;
  GateControl(GateControl&&) = delete;
  GateControl& operator=(GateControl&&) = delete;
  virtual ~GateControl() = default;

  virtual void open() = 0;
  /// Denies everything on every interface. The slots stay as they are.
  virtual void close_all() = 0;
  [[nodiscard]] virtual bool is_open() const = 0;

  virtual void set_mode(gates::Mode mode) = 0;
  [[nodiscard]] virtual gates::Mode mode() const = 0;

  /// Sets how long verdicts stay in force without a heart-beat, ns.
  virtual Result<void> set_grace(std::uint64_t grace) = 0;
  [[nodiscard]] virtual std::uint64_t grace() const = 0;
  /// Sets the latest time at which the gates close, whatever heart-beats come: CLOCK_MONOTONIC, ns;
  /// 0: no limit. See gates::Control::set_until().
  virtual Result<void> set_until(std::uint64_t until) = 0;
  [[nodiscard]] virtual std::uint64_t until() const = 0;
  /// Gives a heart-beat, which is due every beat_interval() ns. `now`: CLOCK_MONOTONIC, ns.
  virtual Result<void> beat(std::uint64_t now) = 0;
  [[nodiscard]] virtual std::uint64_t beat_interval() const = 0;
  /// Whether the gates have closed because a heart-beat came too late. They stay closed until
  /// clear_lapse().
  [[nodiscard]] virtual bool lapsed() const = 0;
  [[nodiscard]] virtual std::uint64_t lapses() const = 0;
  virtual Result<void> clear_lapse(std::uint64_t now) = 0;

  /// Begins a start: for at most `limit` ns what a former daemon has left stays in force, as long
  /// as beat_while_starting() is called.
  virtual Result<void> begin_start(std::uint64_t limit, std::uint64_t now) = 0;
  virtual void beat_while_starting(std::uint64_t now) = 0;
  /// Reverts what a former daemon had begun when it died.
  virtual Result<void> undo_interrupted_step() = 0;
  /// Ends a start: the gates hold what this daemon has decided. Gates that it does not hold close.
  virtual void end_start() = 0;
  /// Starts the kernel timer that closes the gates, after a first heart-beat.
  virtual Result<void> arm() = 0;

  /// Pins again what another program has unpinned. True if anything was unpinned.
  virtual Result<bool> keep_pinned() = 0;
  /// What stood in the place of our pins and was replaced: one line each, reported once.
  virtual std::vector<std::string> take_replaced() = 0;
  /// Takes the gates back if another program has overwritten which daemon holds them, so that they
  /// had closed. True if it has.
  virtual bool keep_epoch() = 0;
  /// Sets the grace again if another program has changed it. True if it has.
  virtual Result<bool> keep_grace() = 0;

  /// Passes the reports of the gates to `reports` from now on, in read_reports().
  virtual Result<void> listen(GateReports reports) = 0;
  /// Readable if there are reports; valid after listen().
  [[nodiscard]] virtual int reports_fd() const = 0;
  virtual Result<void> read_reports() = 0;
};

}  // namespace mlcca
