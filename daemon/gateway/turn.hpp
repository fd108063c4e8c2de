// SPDX-License-Identifier: BSD-2-Clause
// The steps in which a gateway follows the world: observe what networks can do now, settle what
// that touches, enforce it in the gates, commit it to disk. Answers go out after that.
#pragma once
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/can_forwarding.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/gate_control.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca {

/// Who knows more of networks than their interfaces say.
class ConditionSource {
 public:
  ConditionSource() = default;
  ConditionSource(const ConditionSource&) = delete;
  ConditionSource& operator=(const ConditionSource&) = delete;
  ConditionSource(ConditionSource&&) = delete;
  ConditionSource& operator=(ConditionSource&&) = delete;
  virtual ~ConditionSource() = default;

  /// Adds to what is known of each network of the description.
  virtual void add_to(std::vector<core::Condition>& conditions) const = 0;
};

class Turn {
 public:
  using Committed = std::function<void(const Result<void>&)>;
  using Lost = std::function<void(const std::vector<core::AdmissionId>&)>;

  /// What the steps work on. All of it must outlive the turn. `pulse` is called after each step of
  /// what takes long.
  struct Parts {
    Scene& scene;
    GateDriver& gates;
    GateControl& control;
    EventLog& log;
    DeliveryEvents& deliveries;
    Recorder& recorder;
    CanForwarding& forwarding;
    std::function<void()> pulse;
  };
  explicit Turn(Parts parts) : parts_(std::move(parts)) {}

  void add(const ConditionSource& source) { sources_.push_back(&source); }
  /// Called with each channel that has just been decided otherwise and enforced.
  void on_changed(std::function<void(const core::Change&)> changed) {
    changed_ = std::move(changed);
  }
  /// Called when the disk has refused what was admitted: no client has been granted it.
  void on_lost(Lost lost) { lost_ = std::move(lost); }
  /// Called when everything that was answered with `held` is on disk, or why it is not.
  void on_commit(Committed committed) { committed_ = std::move(committed); }

  /// Takes up what is known of each network; settle() is due.
  void observe();
  /// Decides what was changed, brings the gates in line and reports it. `left`: what the gates had
  /// of the channels that a member has left. After an error everything is enforced again, and the
  /// gates that refuse deny everything.
  Result<void> settle(const core::FormerRules& left = {});
  /// Every gate holds what is decided, and nothing else.
  Result<void> enforce();
  /// The gates hold what is decided: what is closed is closed. False: the kernel has refused, and
  /// enforce() is due.
  [[nodiscard]] bool in_line() const { return in_line_; }
  /// What clients were answered after this is on disk. Nothing where nothing waits for it.
  void commit();

  /// The gates follow their slots, unless an interface is out of hand: then all of them deny.
  void open_unless_lost();
  /// The bands of queues by priority are as the analysis of each bus has them.
  void set_bands();

 private:
  /// What the gates are to hold: channels, and the control traffic of profiles.
  [[nodiscard]] core::GateState wanted() const;

  Parts parts_;
  std::vector<const ConditionSource*> sources_;
  std::function<void(const core::Change&)> changed_ = [](const core::Change&) {};
  Lost lost_ = [](const auto&) {};
  Committed committed_ = [](const auto&) {};
  bool in_line_ = true;
};

}  // namespace mlcca
