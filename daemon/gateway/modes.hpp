// SPDX-License-Identifier: BSD-2-Clause
// Enforce, or audit: count what would be dropped and drop nothing. From audit to enforce at once,
// or when for long enough nothing would have been dropped. A gateway can be introduced in audit
// mode, which then lasts over restarts until an operator has it enforce for the first time.
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

class Modes {
 public:
  /// All of them must outlive this.
  Modes(GateControl& control, EventLog& log, DropReports& drops, AuditLog& audit,
        Recorder& recorder)
      : control_(control), log_(log), drops_(drops), audit_(audit), recorder_(recorder) {}

  /// At the start, with the journal open and before a gate is attached.
  void begin(bool in_audit_mode);
  /// Where the gates do not enforce: that they do not. Once, at the end of a start.
  void report();

  // Each gives the line that was logged.

  control::Done enforce();
  control::Done audit();
  /// ns. Error: the gates enforce already.
  Result<control::Done> enforce_when_clean(std::uint64_t when_clean);

  /// At the start: what was asked of a former daemon. In audit mode alone.
  void restore(std::uint64_t when_clean);
  /// Once a second: enforces if it is time.
  void poll();

  [[nodiscard]] bool is_audit() const { return control_.mode() == enforce::Mode::audit; }
  /// Audit mode lasts over restarts and reboots, until an operator ends it.
  [[nodiscard]] bool is_introduction() const { return is_audit() && is_to_be_introduced(); }
  /// "enforce" or "audit".
  [[nodiscard]] const char* name() const;
  /// Asked for, and not yet: ns; 0: it is not.
  [[nodiscard]] std::uint64_t when_clean() const { return is_audit() ? when_clean_ : 0; }
  /// In audit mode: for so long nothing would have been dropped, ns.
  [[nodiscard]] std::uint64_t clean() const { return is_audit() ? audit_.clean_ns() : 0; }

 private:
  [[nodiscard]] bool is_to_be_introduced() const {
    return begins_in_audit_ && !recorder_.contents().introduced;
  }
  void note_introduced();
  [[nodiscard]] std::string audit_line() const;
  void report_drops();
  control::Done set(enforce::Mode mode);

  GateControl& control_;
  EventLog& log_;
  DropReports& drops_;
  AuditLog& audit_;
  Recorder& recorder_;
  bool begins_in_audit_ = false;
  std::uint64_t when_clean_ = 0;
};

}  // namespace mlcca
