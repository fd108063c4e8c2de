// SPDX-License-Identifier: BSD-2-Clause
// Reports silent publishers to each subscriber. A gate supervises each publisher with the shortest
// timeout of its subscribers; other subscribers are reported to when their own timeouts have
// passed.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "base/clock.hpp"
#include "base/loop_timer.hpp"
#include "bpf/gate.h"
#include "core/admission/state.hpp"
#include "core/model/verdict.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/reported_silences.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/gate_reader.hpp"

namespace mlcca {

/// Delays the reports of a gate to the timeout of each delivery.
class SilenceReports {
 public:
  /// All references must outlive this object.
  SilenceReports(sd_event* loop, const Scene& scene, const Clock& clock, const GateReader& gates,
                 DeliveryEvents& deliveries, DeliveryHealth& health, ReportedSilences& reported);

  /// The gate reports that events of a granted delivery are missing, or have come again.
  /// `publishers` names those that the gate cannot distinguish from its publisher.
  void on_event(const core::Verdict& verdict, const gate_event& event,
                const std::string& publishers);
  /// Reports what has been missing for long enough. Called by a timer; further calls do no harm.
  void poll();

 private:
  using Key = SilentDelivery;

  [[nodiscard]] Key key_of(const core::Verdict& verdict) const;
  void missing(const core::Verdict& verdict, const gate_event& event,
               const std::string& publishers);
  void restored(const core::Verdict& verdict, const gate_event& event,
                const std::string& publishers);
  void wait(const Key& key, std::uint64_t due);
  void wait_no_more(const Key& key);
  void examine(const core::Verdict& verdict);
  void arm();

  const Scene& scene_;
  const Clock& clock_;
  const GateReader& gates_;
  DeliveryEvents& deliveries_;
  DeliveryHealth& health_;
  ReportedSilences& reported_;
  std::map<Key, std::uint64_t> waiting_;            ///< until when, CLOCK_MONOTONIC ns
  std::set<std::pair<std::uint64_t, Key>> by_due_;  ///< the same, sorted by time
  LoopTimer timer_;
};

}  // namespace mlcca
