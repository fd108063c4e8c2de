// SPDX-License-Identifier: BSD-2-Clause
// Gateways that announce themselves to each other: which of them have failed, as far as this one
// can tell. Where several ways lead to a subscriber, those over a failed gateway are not taken
// (core::World::failed). All that announce themselves decide so, so one of them forwards a channel.
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

class GatewayPresence {
 public:
  struct Parts {
    const Scene& scene;
    const GateControl& control;
    const Carriers& carriers;
    EventLog& log;
    const Clock& clock;
  };
  /// All of them must outlive this.
  explicit GatewayPresence(const Parts& parts) : parts_(parts) {}

  /// The daemon begins: for now everybody is taken to be there.
  void start();
  /// What the gateway announces now. Whoever asks sends it: when nobody has asked for two
  /// intervals, this gateway forwards nothing that another one could.
  [[nodiscard]] control::Presence announce();
  /// Another gateway has announced itself. Error: nothing is received of it there, or it states a
  /// time that none can state.
  Result<void> receive(const control::PresenceRequest& message);
  /// Who has failed, for what is decided next. Changes are reported.
  void apply(core::State& state);
  /// Where a store says who has failed: this gateway could carry now what others could carry too.
  [[nodiscard]] bool can_carry();
  /// One line for each that has failed.
  [[nodiscard]] std::vector<std::string> problems() const;

 private:
  struct Other {
    std::map<std::string, std::uint64_t> until;  ///< by network, CLOCK_MONOTONIC
    bool forwards = true;
    /// It says that it receives nothing of this gateway: so many announcements were made since
    /// then.
    std::optional<std::uint64_t> lacks_this{};
  };
  /// Of each gateway, why it has failed; nothing: it has not.
  using Failures = std::vector<std::optional<std::string>>;
  /// A gateway and a network of both.
  using Pair = std::pair<std::string, std::string>;

  [[nodiscard]] const core::System& system() const { return parts_.scene.state->system(); }
  [[nodiscard]] const core::Gateway& self() const { return system().gateways[parts_.scene.self]; }
  [[nodiscard]] std::optional<std::size_t> known(const std::string& name) const;
  [[nodiscard]] bool is_available(std::size_t network) const;
  [[nodiscard]] bool is_announced(std::uint64_t now) const;
  /// Since when something could be received, of each gateway on each network.
  void note_networks(std::uint64_t now);
  /// Until when the gateway is there as far as is known from any network; nothing: none of them is
  /// available here, so nothing is known.
  [[nodiscard]] std::optional<std::uint64_t> there_until(std::size_t gateway) const;
  [[nodiscard]] bool is_silent(std::size_t gateway, std::uint64_t now) const;
  [[nodiscard]] std::optional<std::string> failure_of(std::size_t gateway, std::uint64_t now) const;
  /// Why this gateway cannot carry what another one can.
  [[nodiscard]] std::optional<std::string> inability() const;
  /// It is missing for longer than a restart takes, and something that is granted has a way that it
  /// would carry here.
  [[nodiscard]] bool lacks_relay(std::uint64_t now);
  [[nodiscard]] bool needs_relay() const;
  [[nodiscard]] bool needs_relay_now();
  [[nodiscard]] bool relays(const core::Route& route) const;
  [[nodiscard]] std::optional<std::string> own_failure(std::uint64_t now) const;
  [[nodiscard]] Failures failures(std::uint64_t now) const;

  Parts parts_;
  std::uint64_t asked_ = 0;  ///< by the program that announces, CLOCK_MONOTONIC
  Value interval_ = 0;       ///< of this gateway, when it was applied last
  std::uint64_t relay_seen_ = 0;
  std::uint64_t relay_checked_ = 0;
  bool relay_needed_ = false;
  bool lacks_relay_ = false;
  std::map<Pair, std::uint64_t> since_;
  std::map<std::string, Other> others_;
  Failures last_;                              ///< as long as this gateway was announced
  std::map<std::string, std::string> failed_;  ///< as it was applied last: a line
};

}  // namespace mlcca
