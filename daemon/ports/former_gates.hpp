// SPDX-License-Identifier: BSD-2-Clause
// Gates that a former daemon has left on interfaces that are not ports now, pinned or not. Each is
// replaced by a gate that denies everything.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/problem.hpp"
#include "base/result.hpp"
#include "daemon/gates/close_unpinned.hpp"
#include "daemon/net/links.hpp"
#include "daemon/ports/gate_set.hpp"
#include "daemon/ports/report_line.hpp"

namespace mlcca {

/// Finds these gates once after a start, and tries again as long as something is unknown.
class FormerGates {
 public:
  explicit FormerGates(ReportLine report) : report_(std::move(report)) {}

  /// The present interfaces.
  struct Present {
    const net::InterfaceTable& links;
    std::function<net::Presence(int ifindex)> presence;  ///< asks the kernel for one interface
    std::function<bool(int ifindex)> is_gated_port;      ///< whether it is a port with its own gate
    std::size_t slots = 0;  ///< that an Ethernet gate must have room for
  };
  /// Closes the pinned ones. `pinned`: the interfaces, present or not, for which gates are pinned.
  void close_pinned(const Result<std::vector<std::uint32_t>>& pinned, const Present& present,
                    GateSet& gates);
  /// Whether close_orphans() still has to be called; once is enough.
  [[nodiscard]] bool may_leave_orphans() const { return !orphans_closed_; }
  /// Closes gates that no pin names, because another program has removed the pins of a former
  /// daemon. `found`: all gates, of any daemon. If the interface is a port, its own gate replaces
  /// the orphan.
  void close_orphans(const Result<std::vector<gates::GatedInterface>>& found,
                     const Present& present, GateSet& gates);

  /// Whether it is unknown what a former daemon has pinned.
  [[nodiscard]] bool unread() const { return unread_.lasts(); }
  /// Why it is unknown whether gates without pins are left; empty if it is known.
  [[nodiscard]] const std::string& orphans_unknown() const { return orphans_unknown_.text(); }
  /// Whether something could not be found out, so that it is to be tried again soon.
  [[nodiscard]] bool needs_recheck() const { return unlisted_ || unread() || !orphans_closed_; }

 private:
  void close(const net::Link& link, std::size_t slots, GateSet& gates);

  ReportLine report_;
  Problem unread_;         ///< why it is unknown what is pinned
  bool unlisted_ = false;  ///< an interface with pins is not listed, and may exist nevertheless
  bool orphans_closed_ = false;  ///< all were found
  Problem orphans_unknown_;
};

}  // namespace mlcca
