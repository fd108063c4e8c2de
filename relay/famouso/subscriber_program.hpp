// SPDX-License-Identifier: BSD-2-Clause
// Subscriptions between a daemon and the networks of its gateway, and the presence of gateways:
// what Subscriptions and Announcer need of the world.
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

class SubscriberProgram {
 public:
  struct Outside {
    /// The descriptor can be read, or (false) will be closed.
    std::function<void(int fd, bool there)> watch;
    std::function<void(const std::string&)> log;
    std::function<std::uint64_t()> now;  ///< CLOCK_MONOTONIC, ns
  };
  /// `user`: whose networks count.
  SubscriberProgram(std::string socket, std::uint32_t user, Outside outside);

  /// The descriptor of the daemon; those of networks are watched.
  [[nodiscard]] int fd() const { return link_.fd(); }
  /// One of its descriptors can be read; others are ignored.
  void receive(int fd);
  /// At least once a second, and at due_at().
  void turn();
  [[nodiscard]] std::uint64_t due_at() const { return announcer_.due_at(); }

 private:
  struct Network {
    control::Endpoint endpoint;
    std::unique_ptr<Layer> layer;
  };
  void on_reply(const control::Reply& reply);
  void on_event(const control::Event& event);
  /// The number of the request; 0: there is no daemon now, or it takes nothing.
  std::uint64_t ask(control::Request request);
  void ask_what_there_is();
  void open(const control::Subscriptions& said);
  void close(const std::string& network);
  void send(const std::string& network, Octets event);
  [[nodiscard]] std::size_t longest_on(const std::string& network) const;

  std::uint32_t user_;
  Outside outside_;
  std::map<std::string, Network> networks_;
  std::string trouble_;      ///< of sending, as it was reported last
  bool due_ = false;         ///< to ask what there is
  std::uint64_t asked_ = 0;  ///< for it, 0: not
  std::uint64_t asked_at_ = 0;
  Subscriptions subscriptions_;
  Announcer announcer_;
  DaemonLink link_;
};

}  // namespace mlcca::relay
