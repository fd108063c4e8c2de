// SPDX-License-Identifier: BSD-2-Clause
// Turns changes of deliveries into events: granted, refused, withdrawn, missing, dropped. Each
// event names the admissions of the publisher and the subscribers.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bpf/gate.h"
#include "core/admission/state.hpp"
#include "core/model/verdict.hpp"
#include "daemon/gateway/drops.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/scene.hpp"

namespace mlcca {

/// Writes the events of deliveries to the event log, and decides which verdicts are news.
class DeliveryEvents {
 public:
  /// What was granted when the journal was last written, by subject ("0x…").
  using Granted = std::map<std::string, core::Grants>;
  /// The part of a verdict that has to differ for it to be reported again. For a grant these are
  /// the attribute set, the route and the requirements of both ends. The margin is not a part:
  /// other admissions change it.
  struct Contract {
    std::size_t set = 0;
    std::string text;  ///< of a grant the route, else the line of the verdict
    AttributeSet offered, required;
    core::UserValues user_offered, user_required;
    bool operator==(const Contract&) const = default;
  };
  /// What was reported of the deliveries of a description, by subject and delivery.
  using Reported = std::map<std::pair<std::string, core::Delivery>, Contract>;

  /// `pulse` is called after each step of long work, for the heart-beat. `is_recorded` says whether
  /// the admission with that number is one of this gateway, and not one of another gateway.
  DeliveryEvents(const Scene& scene, EventLog& log, std::function<void()> pulse,
                 std::function<bool(core::AdmissionId)> is_recorded)
      : scene_(scene), log_(log), pulse_(std::move(pulse)), is_recorded_(std::move(is_recorded)) {}

  /// Reports one verdict with the given line.
  void verdict(Kind kind, const core::Verdict& verdict, const std::string& line);
  /// Reports that events are missing or have come again. `publishers` names the publisher, or all
  /// publishers that the gate cannot distinguish ("a and b").
  void silence(const core::Verdict& verdict, const gate_event& event,
               const std::string& publishers);
  /// What counts as reported if every verdict of `state` has been reported.
  [[nodiscard]] Reported reported_of(const core::State& state) const;
  /// After a start or a reload: reports every verdict that differs from what was reported before,
  /// and every grant of `before` that no longer exists.
  void outcome(const Granted& before, const Reported& reported);
  /// Reports the changes of a decision.
  void changes(const std::vector<core::DecisionChange>& changes);
  /// Reports frames of a refused delivery that were dropped, or passed in audit mode.
  void dropped(const core::Verdict& verdict, Fate fate, std::uint64_t frames);
  /// The same for a channel that is granted now, for frames before the grant.
  void dropped_before(std::size_t channel, Fate fate, std::uint64_t frames);
  /// Reports excess of these verdicts. Where there are several, their publishers cannot be
  /// distinguished.
  void excess(const std::vector<const core::Verdict*>& verdicts, Fate fate, std::uint64_t frames);

  /// Whether admission `id` is the publisher or one of the subscribers of the verdict.
  [[nodiscard]] bool concerns(const core::Verdict& verdict, core::AdmissionId id) const;

 private:
  [[nodiscard]] static Contract as_reported(const core::State& state, const core::Verdict& verdict);
  void gone(const std::string& subject, const core::Delivery& delivery);
  void continued(const core::Verdict& v, const core::Verdict& old);
  [[nodiscard]] std::string why_gone(std::optional<std::size_t> channel,
                                     const core::Delivery& delivery) const;
  [[nodiscard]] std::vector<core::AdmissionId> admissions_of(const core::Verdict& verdict) const;

  const Scene& scene_;
  EventLog& log_;
  std::function<void()> pulse_;
  std::function<bool(core::AdmissionId)> is_recorded_;
};

}  // namespace mlcca
