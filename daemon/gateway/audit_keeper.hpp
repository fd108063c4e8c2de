// SPDX-License-Identifier: BSD-2-Clause
// Keeps the findings of the audit log, and the wish to enforce when clean, beyond the end of this
// daemon: in the history, encoded as a reply to an audit request.
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
  /// s between two writes of new findings; more if they would exceed kBytesPerSecond on average.
  /// Newer findings are lost when the daemon crashes or the machine loses power.
  static constexpr std::int64_t kInterval = 10;
  static constexpr std::int64_t kBytesPerSecond = 1024;

  /// All references must outlive this object.
  AuditKeeper(AuditLog& audit, Modes& modes, EventLog& log, Patience& patience, const Clock& clock)
      : audit_(audit), modes_(modes), log_(log), patience_(patience), clock_(clock) {}

  /// Called once at the start, after the mode is known.
  void restore(store::History& from);
  /// To be called once a second: writes new findings if a write is due.
  void poll(store::History& to);
  /// Writes new findings now, if there are any. An error has been logged.
  Result<void> keep(store::History& to);

  /// The wish to enforce when clean, in ns, that the next daemon would find on disk; 0: none.
  [[nodiscard]] std::uint64_t kept_when_clean() const { return kept_when_clean_; }

 private:
  AuditLog& audit_;
  Modes& modes_;
  EventLog& log_;
  Patience& patience_;
  const Clock& clock_;
  Problem problem_;
  std::int64_t kept_at_ = 0;           ///< monotonic s
  std::int64_t kept_bytes_ = 0;        ///< bytes of the latest write
  std::uint64_t kept_when_clean_ = 0;  ///< ns
  bool is_behind_ = false;             ///< the latest attempt failed
};

}  // namespace mlcca
