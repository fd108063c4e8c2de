// SPDX-License-Identifier: BSD-2-Clause
// The steps by which a gateway follows the world: observe what networks can do now, settle the
// decisions that this concerns, enforce them in the gates, and commit them to disk. Answers are
// sent after that.
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

/// A part that knows more about networks than their interfaces say.
class ConditionSource {
 public:
  ConditionSource() = default;
  ConditionSource(const ConditionSource&) = delete;
  ConditionSource& operator=(const ConditionSource&) = delete;
  ConditionSource(ConditionSource&&) = delete;
  ConditionSource& operator=(ConditionSource&&) = delete;
  virtual ~ConditionSource() = default;

  /// Adds what it knows to the condition of each network of the description.
  virtual void add_to(std::vector<core::Condition>& conditions) const = 0;
};

/// Carries out these steps on the parts of the gateway.
class Turn {
 public:
  using Committed = std::function<void(const Result<void>&)>;
  using Lost = std::function<void(const std::vector<core::AdmissionId>&)>;

  /// The parts that the steps work on. All must outlive the turn. `pulse` is called after each step
  /// of long work, for the heart-beat.
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
  /// Sets the function that is called with each channel whose changed decision has been enforced.
  void on_changed(std::function<void(const core::DecisionChange&)> changed) {
    changed_ = std::move(changed);
  }
  /// Sets the function that is called with admissions that could not be written to disk. No client
  /// has been answered that they were granted.
  void on_lost(Lost lost) { lost_ = std::move(lost); }
  /// Sets the function that gets the result of each commit: success if everything that was answered
  /// with `held` is on disk.
  void on_commit(Committed committed) { committed_ = std::move(committed); }

  /// Reads the condition of each network. settle() has to follow.
  void observe();
  /// Decides what has changed, brings the gates in line and reports it. `left` has the rules that
  /// the gates had for channels that a member has left. If the kernel refuses, everything is
  /// enforced again, and gates that still refuse deny everything.
  Result<void> settle(const core::FormerRules& left = {});
  /// Makes every gate hold what is decided, and nothing else.
  Result<void> enforce();
  /// Whether the gates hold what is decided, so that what is to be closed is closed. False if the
  /// kernel has refused; then enforce() has to follow.
  [[nodiscard]] bool in_line() const { return in_line_; }
  /// Writes to disk what clients were answered. Does nothing if nothing waits to be written.
  void commit();

  /// Lets the gates follow their slots. If an interface is out of hand, all gates deny instead.
  void open_unless_lost();
  /// Sets the priority bands of queues as the analysis of each bus has them.
  void set_bands();

 private:
  /// What the gates are to hold: the rules of channels, and the control traffic of profiles.
  [[nodiscard]] core::GateState wanted() const;

  Parts parts_;
  std::vector<const ConditionSource*> sources_;
  std::function<void(const core::DecisionChange&)> changed_ = [](const core::DecisionChange&) {};
  Lost lost_ = [](const auto&) {};
  Committed committed_ = [](const auto&) {};
  bool in_line_ = true;
};

}  // namespace mlcca
