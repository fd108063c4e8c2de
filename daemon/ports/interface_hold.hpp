// SPDX-License-Identifier: BSD-2-Clause
// How the interface of one port is held: by the gate that it needs; else by the gate of a former
// description, which then denies everything; else by programs without slots; else not at all.
#pragma once
#include <functional>
#include <string>

#include "base/result.hpp"
#include "daemon/gates/interfaces.hpp"
#include "daemon/ports/gate_set.hpp"

namespace mlcca {

/// Chooses and remembers the way in which an interface is held.
class InterfaceHold {
 public:
  /// The last resort; see gates::close_interface().
  using Close = std::function<Result<gates::Closing>(const std::string& interface)>;
  /// Receives a line for the operator about a problem.
  using Problem = std::function<void(const std::string& line)>;

  /// Puts the gate in place unless it is there. After an error the interface is held in another
  /// way, or not at all, and the reason is reported once.
  Result<void> attach(const net::Link& link, const GateSpec& spec, GateSet& gates,
                      const Close& close, const Problem& report);
  /// Takes over the state of the same port in an earlier description.
  void take_over(const InterfaceHold& former) { closed_ = former.closed_; }

  /// Whether the gate that is there is of a former description.
  [[nodiscard]] bool is_by_former() const { return by_former_; }
  /// Whether nothing of this daemon holds the interface.
  [[nodiscard]] bool is_lost() const { return lost_; }

 private:
  void hold_by_former(const net::Link& link, GateSet& gates);
  void hold_closed(const net::Link& link, const Close& close);
  void report_once(const std::string& reason, const std::string& interface, const Problem& report);

  bool by_former_ = false;
  bool lost_ = false;
  int closed_ = 0;  ///< index of the interface on which this daemon has put programs without slots
  std::string reported_;  ///< the latest reason
};

}  // namespace mlcca
