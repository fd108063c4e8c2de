// SPDX-License-Identifier: BSD-2-Clause
// The transfers that the daemon has granted to the relay.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "relay/daemon_link.hpp"

namespace mlcca::relay {

/// Keeps the list of granted transfers up to date. It asks the daemon at the start, after each
/// reconnection, and when an event says that the list may have changed. While the daemon is gone
/// the last list stays in force.
class Grants {
 public:
  using Transfers = std::vector<control::Transfer>;
  /// `all` gets the complete list, `of_subject` the transfers of one subject, and `log` lines for
  /// the journal.
  struct Handlers {
    std::function<void(const Transfers&)> all;
    std::function<void(std::uint64_t subject, const Transfers&)> of_subject;
    std::function<void(const std::string&)> log;
  };

  /// `user`: the user whose transfers are asked for.
  Grants(std::string socket, std::uint32_t user, Handlers handlers);

  /// See DaemonLink.
  [[nodiscard]] int fd() const { return link_.fd(); }
  void turn() { link_.turn(); }
  [[nodiscard]] bool is_connected() const { return link_.is_connected(); }
  /// Reports late events to the daemon, if it is connected and has answered. The reply is ignored.
  void report(control::DelayRequest delay);
  /// Asks for all transfers again after a short pause, because an interface has appeared or
  /// disappeared.
  void ask_all();

 private:
  void ask_next();
  void on_reply(const control::Reply& reply);
  void on_event(const control::Event& event);

  std::uint32_t user_;
  Handlers handlers_;
  std::uint64_t asked_ = 0;                  ///< id of the pending request; 0: none
  std::optional<std::uint64_t> of_subject_;  ///< subject of that request; nullopt: it is for all
  bool all_due_ = false;
  std::set<std::uint64_t> due_;  ///< subjects to ask for
  bool has_answer_ = false;      ///< the daemon has answered with a list
  DaemonLink link_;
};

}  // namespace mlcca::relay
