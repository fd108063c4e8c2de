// SPDX-License-Identifier: BSD-2-Clause
// What the audit log found, and that the gates are to enforce when it is clean, outlive this
// daemon: beside the history, as a reply to an audit request.
#pragma once
#include <cstdint>

#include "base/clock.hpp"
#include "base/problem.hpp"
#include "base/result.hpp"
#include "daemon/gateway/audit_log.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/modes.hpp"
#include "daemon/gateway/patience.hpp"
#include "daemon/store/history.hpp"

namespace mlcca {

class AuditKeeper {
 public:
  /// What is new is written this often, s, and less often where it is more than this many bytes/s:
  /// what is newer is lost with a crash of the daemon or a loss of power.
  static constexpr std::int64_t kInterval = 10;
  static constexpr std::int64_t kBytesPerSecond = 1024;

  /// All of them must outlive this.
  AuditKeeper(AuditLog& audit, Modes& modes, EventLog& log, Patience& patience, const Clock& clock)
      : audit_(audit), modes_(modes), log_(log), patience_(patience), clock_(clock) {}

  /// Once, at the start, when the mode is known.
  void restore(store::History& from);
  /// Once a second.
  void poll(store::History& to);
  /// Now, if anything is new. An error was logged.
  Result<void> keep(store::History& to);

 private:
  AuditLog& audit_;
  Modes& modes_;
  EventLog& log_;
  Patience& patience_;
  const Clock& clock_;
  Problem problem_;
  std::int64_t kept_at_ = 0;           ///< monotonic s
  std::int64_t kept_bytes_ = 0;        ///< at that time
  std::uint64_t kept_when_clean_ = 0;  ///< ns
  bool is_behind_ = false;             ///< the latest attempt failed
};

}  // namespace mlcca
