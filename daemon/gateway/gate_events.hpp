// SPDX-License-Identifier: BSD-2-Clause
// What the gates report by themselves: events that are missing or come again, replies of FAMOUSO's
// broker, and unadmitted senders.
#pragma once
#include <systemd/sd-event.h>

#include <compare>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "base/clock.hpp"
#include "bpf/gate.h"
#include "core/admission/state.hpp"
#include "core/model/verdict.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/tag_bindings.hpp"
#include "daemon/net/sources/timer.hpp"
#include "daemon/outside/gate_driver.hpp"
#include "daemon/outside/link_monitor.hpp"

namespace mlcca {

class GateEvents {
 public:
  /// All of them must outlive this.
  struct Parts {
    sd_event* loop;
    const Scene& scene;
    const Clock& clock;
    const GateDriver& gates;
    const LinkMonitor& links;
    EventLog& log;
    DeliveryEvents& deliveries;
    DeliveryHealth& health;
    TagBindings& tags;
  };
  explicit GateEvents(const Parts& parts);

  /// A gate watches each publisher for the subscriber that waits least. For one that waits longer
  /// it is reported when its own time is over.
  void on_event(const gate_event& event);
  /// Reports what has been missing for long enough by now. Called by a timer; a further call does
  /// no harm.
  void poll();
  /// A sender that was not seen before; the kernel sees to it that there are not too many.
  void on_sample(const gate_sample& sample);
  /// If events of a delivery are missing the kernel reports it once more, when whoever joined it
  /// has its answer.
  void repeat_missing(const core::Verdict& verdict);

 private:
  struct Key {
    core::Subject subject = 0;
    core::Delivery delivery;
    auto operator<=>(const Key&) const = default;
  };

  [[nodiscard]] Key key_of(const core::Verdict& verdict) const;
  void missing(const core::Verdict& verdict, const gate_event& event,
               const std::string& publishers);
  void restored(const core::Verdict& verdict, const gate_event& event,
                const std::string& publishers);
  void wait(const Key& key, std::uint64_t due);
  void wait_no_more(const Key& key);
  void examine(const Key& key, const core::Verdict& verdict);
  void arm();

  Parts parts_;
  std::map<Key, std::uint64_t> waiting_;            ///< until when: ns, CLOCK_MONOTONIC
  std::set<std::pair<std::uint64_t, Key>> by_due_;  ///< the same, the next one first
  std::set<Key> reported_;                          ///< missing, and not restored yet
  net::Timer timer_;
};

}  // namespace mlcca
