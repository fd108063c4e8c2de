// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/interface_hold.hpp"

#include <utility>

namespace mlcca {

Result<void> InterfaceHold::attach(const net::Link& link, const GateSpec& spec, GateSet& gates,
                                   const Close& close, const Problem& report) {
  by_former_ = false;
  auto done = gates.hold(spec);
  if (done) {
    lost_ = false;
    closed_ = 0;
    reported_.clear();
    return done;
  }
  if (gates.must_go_back()) return done;
  if (gates.contains(link.ifindex))
    hold_by_former(link, gates);
  else
    hold_closed(link, close);
  report_once(done.error().text, link.name, report);
  return done;
}

/// Holds the interface by the former gate, which denies everything.
void InterfaceHold::hold_by_former(const net::Link& link, GateSet& gates) {
  by_former_ = true;
  lost_ = false;
  gates.deny(link.ifindex);
}

/// Holds the interface by programs without pins and slots, which deny everything.
void InterfaceHold::hold_closed(const net::Link& link, const Close& close) {
  const auto closing = close(link.name);
  const bool fresh = closing && *closing == gates::Closing::closed;
  if (fresh) closed_ = link.ifindex;
  // A gate that was there already is an older one that we do not command, unless this object has
  // put it there.
  lost_ = !closing || (!fresh && closed_ != link.ifindex);
}

void InterfaceHold::report_once(const std::string& reason, const std::string& interface,
                                const Problem& report) {
  if (std::exchange(reported_, reason) == reason) return;
  report(reason);
  report(lost_ ? interface + " cannot be held: every gate is closed until it can"
               : interface + " is held closed");
}

}  // namespace mlcca
