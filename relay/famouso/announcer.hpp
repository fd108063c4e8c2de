// SPDX-License-Identifier: BSD-2-Clause
// Announces this gateway to others as the daemon says, and tells the daemon what others announce.
// Bookkeeping only: messages, replies and time come in as arguments.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "control/messages.hpp"
#include "relay/famouso/announcement.hpp"

namespace mlcca::relay {

class Announcer {
 public:
  /// Between two messages of a gateway on a network that reach the daemon, ns at least.
  static constexpr std::uint64_t kPause = 10'000'000;
  /// A gateway that does not announce itself may do so after a reload: it is asked again then, ns.
  static constexpr std::uint64_t kAskAgain = 10'000'000'000;

  struct Outside {
    /// On the network, as an event of SUBSCRIB.
    std::function<void(const std::string& network, Octets event)> send;
    /// The number of the request; 0: there is no daemon now.
    std::function<std::uint64_t(control::PresenceRequest)> ask;
    /// Octets of a message on the network.
    std::function<std::size_t(const std::string& network)> longest = [](const std::string&) {
      return kLongestSubscription;
    };
  };
  explicit Announcer(Outside outside) : outside_(std::move(outside)) {}

  /// There is a daemon, or another description.
  void ask_now() { due_at_ = 0; }
  /// There is none: nothing is announced.
  void daemon_gone();
  /// True: it was the reply to a request of this.
  bool answered(std::uint64_t request, const control::Reply& reply, std::uint64_t now);
  /// True: it was a message of a gateway.
  bool receive(const std::string& network, Octets event, std::uint64_t now);
  /// Asks when that is due.
  void turn(std::uint64_t now);
  /// When turn() is to be called next.
  [[nodiscard]] std::uint64_t due_at() const { return asked_ != 0 ? ~std::uint64_t{0} : due_at_; }

 private:
  void announce();

  Outside outside_;
  control::Presence own_;  ///< of the latest reply
  std::uint64_t asked_ = 0;
  std::uint64_t due_at_ = 0;
  std::map<std::pair<std::string, std::string>, std::uint64_t>
      passed_on_;  ///< network, gateway: when
};

}  // namespace mlcca::relay
