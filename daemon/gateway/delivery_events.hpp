// SPDX-License-Identifier: BSD-2-Clause
// What becomes of deliveries, as events: granted, refused, withdrawn, missing, dropped. Whoever
// holds the publisher or a subscriber is named in each of them.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
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

class DeliveryEvents {
 public:
  /// What was granted when the journal was last written, by subject ("0x…").
  using Granted = std::map<std::string, core::Grants>;
  /// What has to differ so that a verdict is reported again: of a grant its attribute set, its way
  /// and what both ends state, not by how much it is met, which others change.
  struct Contract {
    std::size_t set = 0;
    std::string text;  ///< of a grant the way, else the line of the verdict
    AttributeSet offered, required;
    core::UserValues user_offered, user_required;
    bool operator==(const Contract&) const = default;
  };
  /// What was reported of the deliveries of a description, by subject and delivery.
  using Reported = std::map<std::pair<std::string, core::Delivery>, Contract>;

  /// `pulse` is called after each step of what takes long.
  DeliveryEvents(const Scene& scene, EventLog& log, std::function<void()> pulse)
      : scene_(scene), log_(log), pulse_(std::move(pulse)) {}

  void verdict(Kind kind, const core::Verdict& verdict, const std::string& line);
  /// Events are missing, or come again: of the publisher, or of all of several that look alike,
  /// "a and b".
  void silence(const core::Verdict& verdict, const gate_event& event,
               const std::string& publishers);
  [[nodiscard]] Reported reported_of(const core::State& state) const;
  /// After a start or a reload: everything that was not reported before as it is, and of what was
  /// granted before what is not any more.
  void outcome(const Granted& before, const Reported& reported);
  void changes(const std::vector<core::Change>& changes);
  void dropped(const core::Verdict& verdict, Fate fate, std::uint64_t frames);
  /// The same, of a channel that is granted now, before it was.
  void dropped_before(std::size_t channel, Fate fate, std::uint64_t frames);
  /// Of frames of these verdicts, whose publishers cannot be distinguished where there are several.
  void excess(const std::vector<const core::Verdict*>& verdicts, Fate fate, std::uint64_t frames);

  /// `id` is the publisher or one of the subscribers.
  [[nodiscard]] bool concerns(const core::Verdict& verdict, core::AdmissionId id) const;

 private:
  [[nodiscard]] static Contract as_reported(const core::State& state, const core::Verdict& verdict);
  void gone(const std::string& subject, const core::Delivery& delivery);
  [[nodiscard]] std::vector<core::AdmissionId> admissions_of(const core::Verdict& verdict) const;

  const Scene& scene_;
  EventLog& log_;
  std::function<void()> pulse_;
};

}  // namespace mlcca
