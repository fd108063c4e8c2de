// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/safeguards.hpp"

#include <fmt/core.h>

#include "core/model/text.hpp"
#include "daemon/ports/gates_lock.hpp"

namespace mlcca {

void Safeguards::poll() {
  poll_pins();
  poll_epoch();
  poll_grace();
  if (lock_) poll_lock();
}

void Safeguards::poll_pins() {
  for (std::string& line : control_.take_replaced()) log_.error(Kind::drift, std::move(line));
  const auto again = control_.keep_pinned();
  if (unpinned_.is_new(again ? "" : "the control word is not pinned: " + again.error().text))
    log_.error(Kind::problem, unpinned_.text());
  if (again && *again)
    log_.error(
        Kind::drift,
        "another program unpinned what closes the gates when this daemon dies: it is pinned again");
}

void Safeguards::poll_epoch() {
  if (control_.keep_epoch())
    log_.error(Kind::drift,
               "another program altered which daemon holds the gates: they were closed until now, "
               "and hold what is granted again");
}

void Safeguards::poll_grace() {
  const auto altered = control_.keep_grace();
  if (ungraced_.is_new(altered ? ""
                               : "another program altered the grace, and it cannot be set again: " +
                                     altered.error().text))
    log_.error(Kind::problem, ungraced_.text());
  if (altered && *altered)
    log_.error(
        Kind::drift,
        fmt::format("another program altered the time after which the gates close when this daemon "
                    "dies: it is {} again",
                    core::format_value(Attribute::latency, control_.grace())));
}

void Safeguards::poll_lock() {
  const auto locked = keep_lock(lock_, root_);
  if (unlocked_.is_new(locked ? ""
                              : "two daemons may change the same gates: " + locked.error().text))
    log_.error(Kind::problem, unlocked_.text());
  if (locked && *locked)
    log_.error(Kind::drift, "another program removed the lock of " + root_ + ": it is held again");
}

std::vector<std::string> Safeguards::problems() const {
  std::vector<std::string> problems;
  if (unlocked_.lasts()) problems.push_back(unlocked_.text());
  if (unpinned_.lasts()) problems.push_back(unpinned_.text());
  if (ungraced_.lasts()) problems.push_back(ungraced_.text());
  return problems;
}

}  // namespace mlcca
