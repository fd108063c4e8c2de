// SPDX-License-Identifier: BSD-2-Clause
// Announcing this gateway to others, and reporting their announcements to the daemon.
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

/// Announces this gateway to others as the daemon states it, and reports the announcements of
/// others to the daemon. It does no I/O: messages, replies and the time are arguments. All times
/// are CLOCK_MONOTONIC in ns.
class Announcer {
 public:
  /// Least time (ns) between two messages of one gateway on a network that are reported to the
  /// daemon.
  static constexpr std::uint64_t kPause = 10'000'000;
  /// If this gateway does not announce itself, the daemon is asked again after this time (ns),
  /// because a reload may change that.
  static constexpr std::uint64_t kAskAgain = 10'000'000'000;

  /// What the announcer needs from its environment; tests replace it.
  struct Outside {
    /// Sends an event of the subject SUBSCRIB on the network.
    std::function<void(const std::string& network, Octets event)> send;
    /// Sends a request and returns its id; 0: there is no daemon now.
    std::function<std::uint64_t(control::PresenceRequest)> ask;
    /// Largest message on the network in octets.
    std::function<std::size_t(const std::string& network)> longest = [](const std::string&) {
      return kLongestSubscription;
    };
  };
  explicit Announcer(Outside outside) : outside_(std::move(outside)) {}

  /// To be called when the daemon is connected or has another description: asks it at once.
  void ask_now() { due_at_ = 0; }
  /// To be called when the connection is lost: nothing is announced any more.
  void daemon_gone();
  /// Returns true if this was the reply to a request of the announcer.
  bool answered(std::uint64_t request, const control::Reply& reply, std::uint64_t now);
  /// Returns true if the event was an announcement of a gateway.
  bool receive(const std::string& network, Octets event, std::uint64_t now);
  /// Asks the daemon if that is due.
  void turn(std::uint64_t now);
  /// When turn() has to be called next.
  [[nodiscard]] std::uint64_t due_at() const { return asked_ != 0 ? ~std::uint64_t{0} : due_at_; }

 private:
  void announce();

  Outside outside_;
  control::Presence own_;  ///< as the latest reply states it
  std::uint64_t asked_ = 0;
  std::uint64_t due_at_ = 0;
  std::map<std::pair<std::string, std::string>, std::uint64_t>
      passed_on_;  ///< when an announcement was reported last, by network and gateway
};

}  // namespace mlcca::relay
