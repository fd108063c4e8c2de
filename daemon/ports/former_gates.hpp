// SPDX-License-Identifier: BSD-2-Clause
// Gates that a former daemon has left on interfaces that are no ports now, pinned or not: each is
// replaced by one that denies everything.
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

class FormerGates {
 public:
  explicit FormerGates(ReportLine report) : report_(std::move(report)) {}

  /// What is there now.
  struct Present {
    const net::LinkTable& links;
    std::function<net::Presence(int ifindex)> presence;  ///< asks the kernel for one interface
    std::function<bool(int ifindex)> is_gated_port;      ///< a port, which has a gate of its own
    std::size_t slots = 0;  ///< that an Ethernet gate must have room for
  };
  /// `pinned`: interfaces that gates are pinned for, there or not.
  void close_pinned(const Result<std::vector<std::uint32_t>>& pinned, const Present& present,
                    GateSet& gates);
  /// Whether close_orphans() is due: once.
  [[nodiscard]] bool may_leave_orphans() const { return !orphans_closed_; }
  /// Gates that no pin names, because another program removed the pins of a former daemon. `found`:
  /// all gates of whatever daemon. Where the interface is a port, its own gate takes their place.
  void close_orphans(const Result<std::vector<enforce::GatedInterface>>& found,
                     const Present& present, GateSet& gates);

  /// It is unknown what a former daemon has pinned.
  [[nodiscard]] bool unread() const { return unread_.lasts(); }
  /// Why it is unknown whether gates without pins are left; empty: it is known.
  [[nodiscard]] const std::string& orphans_unknown() const { return orphans_unknown_.text(); }
  /// Something could not be found out: once more soon.
  [[nodiscard]] bool needs_recheck() const { return unlisted_ || unread() || !orphans_closed_; }

 private:
  void close(const net::Link& link, std::size_t slots, GateSet& gates);

  ReportLine report_;
  Problem unread_;               ///< why it is unknown what is pinned
  bool unlisted_ = false;        ///< one has pins, is not listed, and may be there all the same
  bool orphans_closed_ = false;  ///< all were found
  Problem orphans_unknown_;
};

}  // namespace mlcca
