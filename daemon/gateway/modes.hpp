// SPDX-License-Identifier: BSD-2-Clause
// The mode of the gates: enforce, or audit, which counts what would be dropped and drops nothing.
#pragma once
#include <cstdint>
#include <string>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "daemon/gateway/audit_log.hpp"
#include "daemon/gateway/drop_reports.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/outside/gate_control.hpp"

namespace mlcca {

/// Changes the mode of the gates at an operator's request. The change from audit to enforce is made
/// at once, or as soon as nothing would have been dropped for a given time. A gateway can be
/// introduced in audit mode, which then lasts over restarts until an operator first changes it to
/// enforce.
class Modes {
 public:
  /// All references must outlive this object.
  Modes(GateControl& control, EventLog& log, DropReports& drops, AuditLog& audit,
        Recorder& recorder)
      : control_(control), log_(log), drops_(drops), audit_(audit), recorder_(recorder) {}

  /// Sets the mode at the start. The journal must be open, and no gate attached yet.
  void begin(bool in_audit_mode);
  /// Logs a warning if the gates do not enforce. To be called once, at the end of a start.
  void report();

  // Each of these returns the line that was logged.

  control::Done enforce();
  control::Done audit();
  /// `when_clean` is in ns. Error: the gates enforce already.
  Result<control::Done> enforce_when_clean(std::uint64_t when_clean);

  /// At the start in audit mode: continues an enforce_when_clean() of the previous daemon.
  void restore(std::uint64_t when_clean);
  /// To be called once a second: changes to enforce when the time has come.
  void poll();

  [[nodiscard]] bool is_audit() const { return control_.mode() == gates::Mode::audit; }
  /// Whether the audit mode lasts over restarts and reboots until an operator ends it.
  [[nodiscard]] bool is_introduction() const { return is_audit() && is_to_be_introduced(); }
  /// "enforce" or "audit".
  [[nodiscard]] const char* name() const;
  /// The time of a pending enforce_when_clean() in ns; 0 if there is none.
  [[nodiscard]] std::uint64_t when_clean() const { return is_audit() ? when_clean_ : 0; }
  /// In audit mode: for how long nothing would have been dropped, in ns. Otherwise 0.
  [[nodiscard]] std::uint64_t clean() const { return is_audit() ? audit_.clean_ns() : 0; }

 private:
  [[nodiscard]] bool is_to_be_introduced() const {
    return begins_in_audit_ && !recorder_.contents().introduced;
  }
  void note_introduced();
  [[nodiscard]] std::string audit_line() const;
  void report_drops();
  control::Done set(gates::Mode mode);

  GateControl& control_;
  EventLog& log_;
  DropReports& drops_;
  AuditLog& audit_;
  Recorder& recorder_;
  bool begins_in_audit_ = false;
  std::uint64_t when_clean_ = 0;
};

}  // namespace mlcca
