// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <compare>
#include <map>

#include "core/admission/state.hpp"
#include "core/model/verdict.hpp"
#include "daemon/gateway/scene.hpp"

namespace mlcca {

/// A delivery in words that outlive the state: numbers of channels change with a description.
struct SilentDelivery {
  core::Subject subject = 0;
  core::Delivery delivery;
  auto operator<=>(const SilentDelivery&) const = default;
};

[[nodiscard]] SilentDelivery silent_delivery(const core::State& state,
                                             const core::Verdict& verdict);

/// The deliveries whose silence has been reported, and whose end has not been.
class ReportedSilences {
 public:
  /// `scene` must outlive this.
  explicit ReportedSilences(const Scene& scene) : scene_(scene) {}

  [[nodiscard]] bool contains(const core::Verdict& verdict) const {
    return deliveries_.contains(silent_delivery(*scene_.state, verdict));
  }
  /// `since`: ns, CLOCK_MONOTONIC, when the latest event came. False: that silence was there. A
  /// later one begins with an event, which comes `longest` after the former at the earliest:
  /// before, it would not have been reported.
  bool add(const core::Verdict& verdict, Value since, Value longest);
  /// False: it was not there.
  bool remove(const core::Verdict& verdict) {
    return deliveries_.erase(silent_delivery(*scene_.state, verdict)) != 0;
  }
  /// Of deliveries that are granted no more nobody reports an end. Does nothing while few are kept.
  void forget_ended();

 private:
  const Scene& scene_;
  std::map<SilentDelivery, Value> deliveries_;  ///< since when
};

}  // namespace mlcca
