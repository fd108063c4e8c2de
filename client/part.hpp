// SPDX-License-Identifier: BSD-2-Clause
// The state of a channel.
#pragma once
#include <cstdint>
#include <list>
#include <memory>
#include <vector>

#include "client/kept_answer.hpp"
#include "client/local_socket.hpp"
#include "client/shared_endpoints.hpp"
#include "control/messages.hpp"
#include "mlcca/client/client.hpp"

namespace mlcca::client {

/// The part of a channel that its connection works with. The Channel owns it; the connection has a
/// weak pointer, so that a channel may end at any time.
struct Channel::Part {
  /// Exceptions that are kept for a program that does not call process().
  static constexpr std::size_t kMostWaiting = 256;

  control::AnnounceRequest request;
  KeptAnswer answer;
  std::shared_ptr<const Handler> handler;
  std::shared_ptr<const SubscriberChannel::EventHandler> on_event;
  std::vector<SharedEndpoint> endpoints;  ///< where events are sent to or received from
  std::uint64_t subject = 0;              ///< 0: unknown yet
  /// Subscriber: receives from programs on the gateway. Subscribers of the same channel share it.
  std::shared_ptr<LocalReceiver> local;
  std::vector<std::string> local_publishers;  ///< publishers on this gateway that are granted
  /// When events between programs on the gateway end to be granted, CLOCK_MONOTONIC in ns.
  static constexpr std::uint64_t kOpen = ~std::uint64_t{0};
  std::uint64_t open_until = kOpen;  ///< kOpen: the daemon is there
  std::uint64_t lost_events = 0;  ///< of programs on the gateway, and those of networks from which
                                  ///< it does not receive any more
  std::uint64_t asked = 0;        ///< id of the pending request; 0: none
  bool outdated = false;  ///< something has changed since the pending request was sent: ask again
  bool failed = false;    ///< the daemon could not answer, or its answer could not be applied: ask
                          ///< again later
  bool lost = false;  ///< the connection was lost, or the answer is overdue: its return is reported
  bool lagged = false;           ///< exceptions were lost because `waiting` was full
  std::string problem;           ///< why events cannot be carried; empty if they can
  std::list<Exception> waiting;  ///< exceptions for the handler; a list, because it takes no memory
                                 ///< while it is empty
  std::weak_ptr<Client::Connection> connection;

  /// Adds an exception for the handler. If `waiting` is full, the oldest one that only informs is
  /// dropped, or else the oldest one. `event`: the daemon's event with details, or null.
  void note(Cause cause, std::string text, const control::Event* event = nullptr);
  /// Removes and returns the next exception for the handler; nullopt if none waits.
  std::optional<Exception> next();
  /// Whether the event concerns a delivery of this channel.
  [[nodiscard]] bool concerns(const control::Event& event) const;
  /// Takes the daemon's answer, and adds an exception for each delivery that is decided otherwise
  /// than before.
  void take(const std::shared_ptr<const Answer>& now);
  /// Removes the problem of deliveries of which events arrive again. Returns false if none had any.
  bool forget_problem(const control::Event& event);
  /// Whether a delivery on the gateway itself is granted.
  [[nodiscard]] bool is_granted_here() const;
  /// Marks the deliveries that the event withdraws as refused, before the daemon is asked.
  void withdraw(const control::Event& event);
};

}  // namespace mlcca::client
