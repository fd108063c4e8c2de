// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/reported_silences.hpp"

namespace mlcca {

SilentDelivery silent_delivery(const core::State& state, const core::Verdict& verdict) {
  return {state.system().channels[verdict.channel].subject, state.delivery_of(verdict)};
}

void ReportedSilences::forget_ended() {
  const core::State& state = *scene_.state;
  if (deliveries_.size() <= 2 * state.granted() + 16) return;
  std::set<SilentDelivery> granted;
  for (const core::Decision& decision : state.decisions())
    for (const core::Verdict& v : decision.verdicts)
      if (v.granted) granted.insert(silent_delivery(state, v));
  std::erase_if(deliveries_,
                [&granted](const SilentDelivery& one) { return !granted.contains(one); });
}

}  // namespace mlcca
