// SPDX-License-Identifier: BSD-2-Clause
// Drift: the kernel no longer has what was put there. Gates that other programs have removed, or
// attached programs in front of, are put back; frames that bypassed them are reported.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/drop_watch.hpp"
#include "base/problem.hpp"
#include "control/messages.hpp"
#include "daemon/gates/port_gate.hpp"
#include "daemon/net/links.hpp"
#include "daemon/ports/bypass.hpp"
#include "daemon/system_log.hpp"

namespace mlcca {

/// Repairs the gates of a gateway, and remembers per interface what was reported.
class Drift {
 public:
  using Report = std::function<void(Kind kind, const std::string& line, bool problem)>;
  /// The gates by interface index.
  using Gates = std::map<int, gates::PortGate*>;

  explicit Drift(Report report) : report_(std::move(report)) {
    reported_past_.end_round();  // it counts from 0 from now on
  }

  /// Puts gates back, makes them run first, and pins them again. Returns those that cannot be put
  /// back.
  std::vector<int> repair(const Gates& gates, const net::InterfaceTable& links);
  /// The same for one gate; false if it cannot be put back.
  bool repair(int ifindex, gates::PortGate& gate, const net::InterfaceTable& links);
  /// Forgets all interfaces except `gated`, which is sorted.
  void forget_all_but(const std::vector<int>& gated);
  /// Reports that a gate was taken off an interface that is not described any more.
  void report_taken_off(const gates::PortGate& gate);
  /// Reports that an interface with a gate has moved to another namespace, where our gate is not.
  void report_moved(const net::Links::Moved& link);
  /// To be called about once a second. `now_s`: seconds of any steady clock.
  void check_bypass(const Gates& gates, net::Links& links, std::int64_t now_s);
  void check_bypass(int ifindex, const gates::PortGate& gate, net::Links& links,
                    std::int64_t now_s);

  void report(int ifindex, const gates::PortGate& gate, control::Interface& to) const;

 private:
  struct Seen {
    std::string standing;   ///< what cannot be repaired; empty: nothing
    Problem unseen;         ///< why it is unknown whether the gate is in place
    Problem unpinned;       ///< why it cannot be pinned again
    std::string early;      ///< XDP programs of others, which run before the gate; empty: none
    std::string unmovable;  ///< what runs before the gate and could not be put after it
    std::uint64_t repaired = 0;
    std::uint64_t past = 0;  ///< frames that bypassed the gate
    Bypass bypass;
  };
  void report_repaired(Seen& seen, const std::string& line);
  void keep_pinned(const gates::PortGate& gate, Seen& seen);
  void keep_first(int ifindex, gates::PortGate& gate, Seen& seen);
  void keep_early(int ifindex, gates::PortGate& gate, Seen& seen);

  Report report_;
  std::map<int, Seen> seen_;
  std::set<int> gated_;  ///< interfaces that had a gate, including those that are gone
  DropWatch<std::string> reported_past_;
};

}  // namespace mlcca
