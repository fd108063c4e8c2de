// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/cluster_session.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/reserving.hpp"
#include "daemon/gateway/scene.hpp"

namespace mlcca {

/// Admissions that other gateways have to make for this one. They are in the state as long as the
/// other gateway holds them; meanwhile they wait, and it is asked again.
class WaitingForOthers {
 public:
  /// All must outlive this.
  struct Parts {
    const Scene& scene;
    const Recorder& recorder;
    Admissions& admissions;
    const Clock& clock;
    ClusterSession& session;
    std::function<void(Reserving::Job)> ask;
    std::function<bool()> is_drained;  ///< whether an operator has drained this gateway
  };
  explicit WaitingForOthers(Parts parts) : parts_(std::move(parts)) {}

  /// Takes into the state what is held, and out of it what is not. `is_in_force`: the state is in
  /// force; otherwise all of it is about to be decided. Returns the rules that the gates had for
  /// what has to wait; Turn::settle() or Turn::enforce() has to follow.
  [[nodiscard]] core::FormerRules follow_agreements(bool is_in_force);
  /// To be called now and then: what was agreed to has had no place for a while.
  void give_back_without_place();
  /// Asks for the one that has waited for its turn longest. True if there was one.
  bool ask_for_one();
  /// Ends what other gateways do not make for this one any more. What cannot be written down is
  /// tried again later.
  void end_withdrawn();

  /// All of them may be asked for at once.
  void forget_pauses() { pauses_.clear(); }
  void note_lost(const std::string& why);
  void forget(const std::vector<core::AdmissionId>& gone);
  /// Another gateway does not agree to the admission.
  void note_refusal(core::AdmissionId id, const std::string& why);
  /// Another gateway will not agree to it any more: it ends.
  void withdraw(core::AdmissionId id, const std::string& why) {
    withdrawn_.try_emplace(id, Withdrawn{.why = why});
  }

 private:
  struct Pause {
    Value until = 0, length = 0;
  };
  struct Wait {
    std::string why;
    bool here = false;  ///< not the other gateway is the reason, but this one
  };
  struct Withdrawn {
    std::string why;
    Value at = 0;  ///< no attempt to end it before this time
  };
  [[nodiscard]] std::string why_waits(core::AdmissionId id, const std::string& gateway) const;
  void pause(core::AdmissionId id);
  bool is_taken_in(core::AdmissionId id);
  void end_without_gateway(core::AdmissionId id, const std::string& name);
  void ask_again(core::AdmissionId id, std::size_t gateway);
  [[nodiscard]] core::State& state() const { return *parts_.scene.state; }
  [[nodiscard]] Value now() const { return parts_.clock.monotonic_ns(); }

  Parts parts_;
  std::map<core::AdmissionId, Pause> pauses_;         ///< not asked for meanwhile
  std::map<core::AdmissionId, Wait> why_waits_;       ///< why it was not admitted the last time
  std::map<core::AdmissionId, Withdrawn> withdrawn_;  ///< other gateways do not make them any more
  /// Since when something that was agreed to has had no place in the state.
  std::optional<Value> without_place_since_;
};

}  // namespace mlcca
