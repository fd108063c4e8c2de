// SPDX-License-Identifier: BSD-2-Clause
// The subscriber program of the relay: connects Subscriptions and Announcer with the daemon and the
// networks.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "relay/daemon_link.hpp"
#include "relay/famouso/announcer.hpp"
#include "relay/famouso/subscriptions.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::relay {

/// Provides Subscriptions and Announcer with their I/O: the connection to the daemon and a layer
/// for each network on which the gateway takes or makes subscriptions.
class SubscriberProgram {
 public:
  /// What the program needs from its event loop; tests replace it.
  struct Outside {
    /// Called with true when a descriptor is opened, and with false before it is closed.
    std::function<void(int fd, bool there)> watch;
    std::function<void(const std::string&)> log;
    std::function<std::uint64_t()> now;  ///< CLOCK_MONOTONIC, ns
  };
  /// `user`: the user of this program; networks that another user serves are ignored.
  SubscriberProgram(std::string socket, std::uint32_t user, Outside outside);

  /// The descriptor of the daemon's connection. Those of networks are passed to Outside::watch.
  [[nodiscard]] int fd() const { return link_.fd(); }
  /// To be called when a descriptor is readable; unknown ones are ignored.
  void receive(int fd);
  /// To be called at least once a second, and at due_at().
  void turn();
  [[nodiscard]] std::uint64_t due_at() const { return announcer_.due_at(); }

 private:
  /// A network whose subscriptions this program receives and sends.
  struct Network {
    control::Endpoint endpoint;
    std::unique_ptr<Layer> layer;
  };
  void on_reply(const control::Reply& reply);
  void on_event(const control::Event& event);
  /// Sends a request and returns its id; 0: there is no daemon now, or it does not read.
  std::uint64_t ask(control::Request request);
  void ask_what_there_is();
  void open(const control::Subscriptions& said);
  void close(const std::string& network);
  void send(const std::string& network, Octets event);
  [[nodiscard]] std::size_t longest_on(const std::string& network) const;

  std::uint32_t user_;
  Outside outside_;
  std::map<std::string, Network> networks_;
  std::string trouble_;      ///< the last problem of sending, as it was logged
  bool due_ = false;         ///< the list of subscriptions has to be asked for
  std::uint64_t asked_ = 0;  ///< id of that request; 0: none is pending
  std::uint64_t asked_at_ = 0;
  Subscriptions subscriptions_;
  Announcer announcer_;
  DaemonLink link_;
};

}  // namespace mlcca::relay
