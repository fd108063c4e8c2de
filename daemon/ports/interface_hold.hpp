// SPDX-License-Identifier: BSD-2-Clause
// How the interface of one port is held: by the gate that it needs, else by the gate of a former
// description that denies everything, else by a program without slots, else not at all.
#pragma once
#include <functional>
#include <string>

#include "base/result.hpp"
#include "daemon/gates/interfaces.hpp"
#include "daemon/ports/gate_set.hpp"

namespace mlcca {

class InterfaceHold {
 public:
  /// The last resort, see enforce::close_interface().
  using Close = std::function<Result<enforce::Closing>(const std::string& interface)>;
  /// Gets a line for the operator, which is a problem.
  using Problem = std::function<void(const std::string& line)>;

  /// Puts the gate in place, unless it is there. Error: the interface is held otherwise, or by
  /// nothing; a reason is reported once.
  Result<void> attach(const net::Link& link, const GateSpec& spec, GateSet& gates,
                      const Close& close, const Problem& report);
  /// The same port was held so before it was described again.
  void take_over(const InterfaceHold& former) { closed_ = former.closed_; }

  /// The gate that is there is of a former description.
  [[nodiscard]] bool is_by_former() const { return by_former_; }
  /// Nothing of this daemon holds it.
  [[nodiscard]] bool is_lost() const { return lost_; }

 private:
  void hold_by_former(const net::Link& link, GateSet& gates);
  void hold_closed(const net::Link& link, const Close& close);
  void report_once(const std::string& reason, const std::string& interface, const Problem& report);

  bool by_former_ = false;
  bool lost_ = false;
  int closed_ = 0;        ///< ifindex that got a program without slots from this daemon
  std::string reported_;  ///< the last reason
};

}  // namespace mlcca
