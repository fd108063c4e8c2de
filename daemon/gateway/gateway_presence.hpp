// SPDX-License-Identifier: BSD-2-Clause
// Decides which gateways have failed, for gateways that announce themselves to each other. Where
// several routes lead to a subscriber, those over a failed gateway are not taken
// (core::World::failed). All of these gateways decide by the same rules, so that one of them
// forwards a channel.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "control/messages.hpp"
#include "daemon/gateway/carriers.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/gate_control.hpp"

namespace mlcca {

/// A gateway counts as failed if its announcements have not come on any available network for
/// core::presence_lasts(), or if it announces that it cannot forward. This gateway counts itself as
/// failed if it cannot announce itself, cannot carry, or another gateway receives nothing of it.
class GatewayPresence {
 public:
  struct Parts {
    const Scene& scene;
    const GateControl& control;
    const Carriers& carriers;
    EventLog& log;
    const Clock& clock;
  };
  /// All references must outlive this object.
  explicit GatewayPresence(const Parts& parts) : parts_(parts) {}

  /// Called at the start of the daemon: until something else is known, all gateways count as
  /// present.
  void start();
  /// What this gateway announces now. mlcca-famouso asks for it and sends it. If it has not asked
  /// for two intervals, this gateway forwards nothing that another one could forward.
  [[nodiscard]] control::Presence announce();
  /// Takes the announcement of another gateway. The error: that gateway does not announce itself to
  /// this one on this network, or it states a time that is not possible.
  Result<void> receive(const control::PresenceRequest& message);
  /// Writes into `state` who has failed, for the next decision, and reports changes.
  void apply(core::State& state);
  /// For clusters, where the store says who has failed: whether this gateway could carry now what
  /// other gateways could carry as well.
  [[nodiscard]] bool can_carry();
  /// One line for each gateway that has failed.
  [[nodiscard]] std::vector<std::string> problems() const;

 private:
  struct Other {
    std::map<std::string, std::uint64_t> until;  ///< CLOCK_MONOTONIC ns, by network
    bool forwards = true;
    /// Set while it says that it receives nothing of this gateway: the number of announcements that
    /// this gateway has made since then.
    std::optional<std::uint64_t> lacks_this{};
  };
  /// For each gateway the reason why it has failed; nullopt if it has not.
  using Failures = std::vector<std::optional<std::string>>;
  /// A gateway and a network on which both it and this gateway have a port.
  using Pair = std::pair<std::string, std::string>;

  [[nodiscard]] const core::System& system() const { return parts_.scene.state->system(); }
  [[nodiscard]] const core::Gateway& self() const { return system().gateways[parts_.scene.self]; }
  [[nodiscard]] std::optional<std::size_t> known(const std::string& name) const;
  [[nodiscard]] bool is_available(std::size_t network) const;
  [[nodiscard]] bool is_announced(std::uint64_t now) const;
  /// Updates since when announcements of each gateway could be received on each network.
  void note_networks(std::uint64_t now);
  /// Until when the gateway counts as present, the latest of all networks; nullopt if none of them
  /// is available here, so that nothing is known.
  [[nodiscard]] std::optional<std::uint64_t> there_until(std::size_t gateway) const;
  [[nodiscard]] bool is_silent(std::size_t gateway, std::uint64_t now) const;
  [[nodiscard]] std::optional<std::string> failure_of(std::size_t gateway, std::uint64_t now) const;
  /// Why this gateway cannot carry what another one can; nullopt if it can.
  [[nodiscard]] std::optional<std::string> inability() const;
  /// Whether the relay has been missing for longer than a restart takes while a granted channel has
  /// a route that it would carry here.
  [[nodiscard]] bool lacks_relay(std::uint64_t now);
  [[nodiscard]] bool needs_relay() const;
  [[nodiscard]] bool needs_relay_now();
  [[nodiscard]] bool relays(const core::Route& route) const;
  [[nodiscard]] std::optional<std::string> own_failure(std::uint64_t now) const;
  [[nodiscard]] Failures failures(std::uint64_t now) const;

  Parts parts_;
  std::uint64_t asked_ = 0;  ///< when announce() was last called, CLOCK_MONOTONIC ns
  Value interval_ = 0;       ///< the interval of this gateway at the latest apply()
  std::uint64_t relay_seen_ = 0;
  std::uint64_t relay_checked_ = 0;
  bool relay_needed_ = false;
  bool lacks_relay_ = false;
  std::map<Pair, std::uint64_t> since_;
  std::map<std::string, Other> others_;
  Failures last_;  ///< as of the latest time at which this gateway was announced
  std::map<std::string, std::string> failed_;  ///< line of the log, by gateway
};

}  // namespace mlcca
