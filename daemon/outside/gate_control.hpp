// SPDX-License-Identifier: BSD-2-Clause
// What opens and closes all gates of a gateway together, as an interface: the pinned control word
// of the kernel (KernelGateControl), or a fake.
#pragma once
#include <cstdint>
#include <functional>

#include "base/result.hpp"
#include "bpf/gate.h"
#include "daemon/gates/control.hpp"

namespace mlcca {

/// What the gates report by themselves.
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
  /// Everything is denied on every interface; slots stay as they are.
  virtual void close_all() = 0;
  [[nodiscard]] virtual bool is_open() const = 0;

  virtual void set_mode(enforce::Mode mode) = 0;
  [[nodiscard]] virtual enforce::Mode mode() const = 0;

  /// How long verdicts outlive the daemon, ns.
  virtual Result<void> set_grace(std::uint64_t grace) = 0;
  [[nodiscard]] virtual std::uint64_t grace() const = 0;
  /// The gates close at that time at the latest, whatever heart-beats come: CLOCK_MONOTONIC, ns; 0:
  /// as long as they come. See enforce::Control::set_until().
  virtual Result<void> set_until(std::uint64_t until) = 0;
  [[nodiscard]] virtual std::uint64_t until() const = 0;
  /// A heart-beat, due every beat_interval(). `now`: CLOCK_MONOTONIC, ns.
  virtual Result<void> beat(std::uint64_t now) = 0;
  [[nodiscard]] virtual std::uint64_t beat_interval() const = 0;
  /// The gates have closed because a heart-beat came too late, and stay closed until clear_lapse().
  [[nodiscard]] virtual bool lapsed() const = 0;
  [[nodiscard]] virtual std::uint64_t lapses() const = 0;
  virtual Result<void> clear_lapse(std::uint64_t now) = 0;

  /// A start begins: for `limit` ns what a former daemon has left stays in force, as long as
  /// beat_while_starting() is called.
  virtual Result<void> begin_start(std::uint64_t limit, std::uint64_t now) = 0;
  virtual void beat_while_starting(std::uint64_t now) = 0;
  /// What a former daemon was doing when it died is undone.
  virtual Result<void> undo_interrupted_step() = 0;
  /// The gates hold what this daemon has decided; those that it does not hold close.
  virtual void end_start() = 0;
  /// Starts the timer of the kernel that closes the gates; a heart-beat comes first.
  virtual Result<void> arm() = 0;

  /// Pins again what another program has unpinned. True: there was something.
  virtual Result<bool> keep_pinned() = 0;
  /// What stood in the place of pins of ours and was replaced: a line of each, once.
  virtual std::vector<std::string> take_replaced() = 0;
  /// Holds the gates again where another program has written over which daemon does, so that they
  /// had closed. True: it was.
  virtual bool keep_epoch() = 0;
  /// Sets the grace again that another program has altered. True: it was.
  virtual Result<bool> keep_grace() = 0;

  /// From now on the gates' reports come to `reports`, in read_reports().
  virtual Result<void> listen(GateReports reports) = 0;
  /// Readable when there are reports; after listen().
  [[nodiscard]] virtual int reports_fd() const = 0;
  virtual Result<void> read_reports() = 0;
};

}  // namespace mlcca
