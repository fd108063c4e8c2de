// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <compare>
#include <set>

#include "core/admission/state.hpp"
#include "core/model/verdict.hpp"
#include "daemon/gateway/scene.hpp"

namespace mlcca {

/// Identifies a delivery independently of the state, because channel numbers change with a
/// description.
struct SilentDelivery {
  core::Subject subject = 0;
  core::Delivery delivery;
  auto operator<=>(const SilentDelivery&) const = default;
};

[[nodiscard]] SilentDelivery silent_delivery(const core::State& state,
                                             const core::Verdict& verdict);

/// The deliveries whose silence has been reported and has not been reported as ended.
class ReportedSilences {
 public:
  /// `scene` must outlive this object.
  explicit ReportedSilences(const Scene& scene) : scene_(scene) {}

  [[nodiscard]] bool contains(const core::Verdict& verdict) const {
    return deliveries_.contains(silent_delivery(*scene_.state, verdict));
  }
  void add(const core::Verdict& verdict) {
    deliveries_.insert(silent_delivery(*scene_.state, verdict));
  }
  /// False if it was not there.
  bool remove(const core::Verdict& verdict) {
    return deliveries_.erase(silent_delivery(*scene_.state, verdict)) != 0;
  }
  /// Removes deliveries that are no longer granted, for which no end is reported. Does nothing
  /// while few are kept.
  void forget_ended();

 private:
  const Scene& scene_;
  std::set<SilentDelivery> deliveries_;
};

}  // namespace mlcca
