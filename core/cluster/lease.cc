// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/lease.hpp"

#include "mlcca/arithmetic.hpp"

namespace mlcca::core::cluster {
namespace {

constexpr Value kMillion = 1'000'000;

}  // namespace

Value valid_until(Value sent, Value lease) {
  return add_saturating(sent, mul_div_down(lease, kMillion - kClockError, kMillion));
}

Value may_fence_at(Value seen, Value lease) {
  const Value whole = mul_div_up(lease, kMillion + kClockError, kMillion);
  return add_saturating(seen, add_saturating(whole, kQueued));
}

Value queues_empty_at(Value closed) {
  return add_saturating(closed, mul_div_up(kQueued, kMillion + kClockError, kMillion));
}

}  // namespace mlcca::core::cluster
