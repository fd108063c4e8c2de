// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/open_until.hpp"

#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

constexpr std::uint64_t kAgain = 1'000'000'000;  // ns

}  // namespace

bool OpenUntil::set(std::uint64_t until, bool at_once) {
  if (until_ == until || is_refused()) return true;
  const auto set = control_.set_until(until);
  if (!set) {
    if (trouble_.is_new("until when the gates may be open cannot be set: " + set.error().text))
      log_.error(Kind::problem, trouble_.text());
    retry_ = add_saturating(clock_.monotonic_ns(), kAgain);
    until_.reset();
    return false;
  }
  until_ = until;
  retry_ = 0;
  static_cast<void>(trouble_.is_new(""));
  if (at_once && !control_.lapsed()) static_cast<void>(control_.beat(clock_.monotonic_ns()));
  return true;
}

}  // namespace mlcca
