// SPDX-License-Identifier: BSD-2-Clause
// What a channel of a program is to its connection.
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

struct Channel::Part {
  /// Exceptions that wait for a program that does not call process().
  static constexpr std::size_t kMostWaiting = 256;

  control::AnnounceRequest request;
  KeptAnswer answer;
  std::shared_ptr<const Handler> handler;
  std::shared_ptr<const SubscriberChannel::EventHandler> on_event;
  std::vector<SharedEndpoint> endpoints;  ///< where events go to, or come from
  std::uint64_t subject = 0;              ///< 0: not known yet
  /// Of a subscriber: where programs on the gateway send to. Others of this channel may share it.
  std::shared_ptr<LocalReceiver> local;
  std::vector<std::string> local_publishers;  ///< that are granted there
  std::uint64_t asked = 0;                    ///< the request that waits for an answer, 0: none
  bool outdated = false;                      ///< something has changed since it was asked
  bool failed = false;           ///< the daemon could not answer: it is asked again later
  bool lost = false;             ///< the daemon went after it was announced
  bool lagged = false;           ///< exceptions were lost
  std::string problem;           ///< why its events cannot be carried; empty: they can
  std::list<Exception> waiting;  ///< takes no memory while nothing waits
  std::weak_ptr<Client::Connection> connection;

  /// Where too many wait, what only informs goes first, then what is oldest.
  void note(Cause cause, std::string text, const control::Event* event = nullptr);
  /// The next exception for the handler; nothing: none waits.
  std::optional<Exception> next();
  /// The event is of a delivery of this end.
  [[nodiscard]] bool concerns(const control::Event& event) const;
  /// Another answer, and an exception for each delivery that is decided otherwise than before.
  void take(const std::shared_ptr<const Answer>& now);
  /// Events of a delivery come again: the answer does not say any more that something is wrong.
  /// False: it did not.
  bool forget_trouble(const control::Event& event);
  /// A delivery of it is withdrawn: the answer says so before the daemon is asked.
  void withdraw(const control::Event& event);
};

}  // namespace mlcca::client
