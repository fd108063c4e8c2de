// SPDX-License-Identifier: BSD-2-Clause
// The application's interface to a gateway. A program announces the publishers and subscribers that
// the description assigns to it, learns what was decided for each of them and why, publishes and
// receives events, and is notified by an exception when a decision changes. C++17 with the standard
// library. Link with -lmlcca (pkg-config mlcca).
//
// A Client and its channels are not thread-safe: use them from one thread. Add Client::fd() to your
// poll, epoll, sd-event or asio loop and call process() when it is readable, or call wait() in a
// loop of your own. Events do not pass through the daemon: this process has sockets of its own for
// them, so that the gate sees which user sends. After fork() only one of the two processes may go
// on using the Client. Before version 1.0 the ABI changes with each minor version, which is part of
// the library's name.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mlcca/attribute.hpp"
#include "mlcca/values_of.hpp"

#define MLCCA_API __attribute__((visibility("default")))

struct mlcca_events;  // defined for mlcca/client/events.h

namespace mlcca::client {

/// One attribute compared at one place on the route of an event: what is required and what is
/// provided there.
struct Check {
  std::string where;      ///< network or gateway, "end to end", "publisher NAME", …
  std::string attribute;  ///< name of the attribute, e.g. "Omission"
  std::string unit;  ///< of `required` and `provided`: "ns", "bytes/s", "1e-9", "events" or "bytes"
  Value required = 0;  ///< the strictest requirement of the publisher and the subscribers
  std::optional<Value> provided;  ///< nullopt: unknown, hence not fulfilled
  bool fits = false;
  std::string margin;  ///< readable text: "1 to spare", "3 events too many"
};

/// The decision on the events of one publisher towards one network or gateway.
struct Delivery {
  bool granted = false;
  std::string publisher;
  std::string from;
  std::string to;
  std::string reason;   ///< one line: if granted the smallest margin, otherwise why it is refused
  unsigned set = 0;     ///< the attribute set in use; 0 is the preferred one
  std::string problem;  ///< what is wrong although the delivery is granted; empty if nothing is
  std::vector<std::string> route;
  std::vector<Check> checks;
};

/// The state of a channel in an Answer.
enum class State : std::uint8_t {
  unannounced,
  granted,    ///< every delivery is granted
  partly,     ///< some deliveries are granted and some are refused
  refused,    ///< every delivery is refused, or there is no delivery because no other end is known
  rejected,   ///< the daemon does not accept the announcement; the reason says why
  no_daemon,  ///< no daemon answers, so that nothing is known
};

/// The latest decision on a channel that this program knows.
struct Answer {
  State state = State::unannounced;
  /// One line: the reason of the first refused delivery, otherwise of the first granted one; for
  /// `rejected` and `no_daemon` the error.
  std::string reason;
  std::vector<Delivery> deliveries;
};

/// Why an exception handler is called.
enum class Cause : std::uint8_t {
  granted,       ///< a delivery that was refused is granted
  refused,       ///< a delivery is refused that was not known before
  withdrawn,     ///< a delivery that was granted is refused, or does not exist any more
  network_down,  ///< as `withdrawn`, because the network `network` on its route is not available
  rejected,      ///< after a reload the announcement does not fit the description any more
  degraded,      ///< a less preferred attribute set is in use
  upgraded,      ///< a more preferred attribute set is in use
  policed,       ///< the publisher sent more than was admitted, and the excess was dropped
  dropped,       ///< the gate dropped frames of the channel
  missing,       ///< no event has arrived for longer than a subscriber's Omission allows
  restored,      ///< events arrive again after `missing`
  missed,  ///< events of programs on this gateway were lost, because this program did not read them
           ///< in time, or because they were sent while the gates were closed
  late,    ///< events spent more time in mlcca-relay than the description states for the gateway
  gates_closed,  ///< the kernel had closed all gates for a time, or the daemon stops and closes
                 ///< them, or it has been gone for its grace; until it answers again, events of
                 ///< programs on this gateway are neither sent nor delivered
  mode,          ///< the gateway has changed between the modes enforce and audit
  lagged,        ///< exceptions were lost, because this program called process() too seldom
  daemon_gone,   ///< the connection to the daemon is lost, or the daemon does not answer; granted
                 ///< deliveries go on for the grace period, then `gates_closed` follows
  daemon_back,   ///< the daemon has answered the announcement again; `answer` has the present
                 ///< decision
  other,  ///< a kind that this library does not know, or a problem with the sockets; see the text
};
/// The name as readable text, e.g. "network-down"; the pointer stays valid.
MLCCA_API const char* name_of(Cause cause);
MLCCA_API const char* name_of(State state);

/// Something that has happened to a channel, for its exception handler. Members that do not belong
/// to the cause are empty or 0.
struct Exception {
  Cause cause = Cause::other;
  std::string text;       ///< one line, as in the log of the gateway
  std::string publisher;  ///< publisher concerned, by its name in the description; empty if there
                          ///< are several or none
  std::string network;    ///< network_down: the network concerned
  std::chrono::nanoseconds silent{};  ///< missing, restored: how long no event arrived
  std::uint64_t missing_events = 0;   ///< missing, restored: the events that should have arrived in
                                      ///< that time; missed: the events lost since the last such
                                      ///< exception
  std::uint64_t frames = 0;       ///< policed, dropped: the frames since the last such exception
  std::uint64_t late_events = 0;  ///< late: the late events since the last such exception
  std::chrono::nanoseconds longest{};    ///< late: the longest time that one of them spent in
                                         ///< mlcca-relay
  std::shared_ptr<const Answer> answer;  ///< the decision when the exception was raised
};

/// An event that was received.
struct Event {
  const std::uint8_t* data = nullptr;  ///< valid until the handler returns
  std::size_t size = 0;                ///< bytes, 0 to 65,535
  const char* network = "";  ///< the network that it came from; empty if a program on the gateway
                             ///< sent it
  /// When the kernel received the event; where the kernel does not report that, when it was read.
  std::chrono::system_clock::time_point received;
};

/// The result of publishing an event.
enum class Published : std::uint8_t {
  sent,    ///< sent to every place that the channel is granted for
  partly,  ///< sent to some of these places; at the others the queue was full, the gate dropped
           ///< it, or the daemon is gone
  lost,    ///< sent to none of them
  not_granted,  ///< not sent, because nothing is granted, nobody receives, or no decision is known
                ///< yet
  too_long,     ///< not sent, because it is longer than a network carries or than 65,535 bytes
};
MLCCA_API const char* name_of(Published published);

/// How a Client connects to mlccad.
struct Options {
  /// Path of the daemon's control socket.
  std::string socket = "/run/mlcca/control.sock";
  /// How long announce() and subscribe() wait for an answer, at most 24 hours; a negative time
  /// waits without limit.
  std::chrono::milliseconds patience{10'000};
  /// The delay before the Client connects again after the connection is lost. It is doubled after
  /// each failure, from `first_retry` up to `longest_retry`. Each delay is shortened by up to a
  /// quarter at random, so that not all programs connect at once. What failed for another reason
  /// than the connection, such as a port that another program holds, is tried again after five
  /// times `longest_retry`.
  std::chrono::milliseconds first_retry{100};
  std::chrono::milliseconds longest_retry{1'000};
  /// How long the daemon may leave a question unanswered before it counts as gone, although the
  /// connection exists: it may hang. If nothing came from the daemon for a fifth of this time, the
  /// Client asks it. 0 or less: it is not supervised. State less than the grace period, so that the
  /// program gets `daemon_gone` before the gates close.
  std::chrono::milliseconds answers_within{5'000};
};

class Channel;

/// A connection to mlccad. It is established when a channel is announced, and again whenever it is
/// lost.
class MLCCA_API Client {
 public:
  /// Throws std::system_error if the process has no file descriptors left. The daemon need not run.
  explicit Client(Options options = {});
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  Client(Client&&) = delete;
  Client& operator=(Client&&) = delete;
  /// Closes the connection; the channels of this Client become inactive.
  ~Client();

  /// A file descriptor that is readable when process() has work to do. It is the same for the
  /// lifetime of the Client, which owns it.
  [[nodiscard]] int fd() const;
  /// Handles all pending work and calls the handlers of events and exceptions; never waits. If a
  /// handler throws, process() throws the same, and what was not handled is kept for the next call.
  void process();
  /// Waits until there is work to do, for `time` at most, and then does the same as process(). A
  /// negative time waits without limit.
  void wait(std::chrono::milliseconds time);
  /// Whether there is a connection to the daemon at present.
  [[nodiscard]] bool is_connected() const;
  /// How much was lost on the way to or from all channels of this Client, each loss counted once;
  /// see SubscriberChannel::lost(). Counts also J1939 messages that could not be sent completely.
  [[nodiscard]] std::uint64_t lost() const;

 private:
  friend class Channel;
  friend struct ::mlcca_events;
  class __attribute__((visibility("hidden"))) Connection;
  class __attribute__((visibility("hidden"))) Data;
  std::shared_ptr<Connection> connection_;
};

/// The common base of publishers and subscribers. A channel may outlive its Client; it is inactive
/// then.
class MLCCA_API Channel {
 public:
  using Handler = std::function<void(const Exception&)>;

  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;
  Channel(Channel&&) = delete;
  Channel& operator=(Channel&&) = delete;

  /// Sets the handler for exceptions; an empty function removes it, and exceptions are discarded.
  /// It is called by Client::process() and wait(), never by announce() or subscribe(). It may
  /// destroy the channel.
  void on_exception(Handler handler);
  /// The latest known decision; never null.
  [[nodiscard]] std::shared_ptr<const Answer> answer() const;

 protected:
  enum class Role : std::uint8_t { publisher, subscriber };
  /// The arguments are those of PublisherChannel.
  Channel(Client& client, Role role, std::string channel, const AttributeSet& stated,
          std::string name);
  ~Channel();
  std::shared_ptr<const Answer> take_up();
  Published send(const void* data, std::size_t size);
  void receive(std::function<void(const Event&)> handler);
  [[nodiscard]] std::uint64_t losses() const;

 private:
  friend class Client;
  friend struct ::mlcca_events;
  struct __attribute__((visibility("hidden"))) Part;
  std::shared_ptr<Part> part_;
};

/// The publisher of an event channel.
class MLCCA_API PublisherChannel : public Channel {
 public:
  /// `channel`: its name in the description, or its subject as "0xa4efeccc3210b497".
  /// `stated`: the attributes that this program was built for, for example
  /// values_of<Spec::attributes>(); the daemon rejects the announcement if the description falls
  /// short of them.
  /// `name`: the publisher's name in the description; needed if the user that runs this program has
  /// several publishers of the channel.
  PublisherChannel(Client& client, std::string channel, const AttributeSet& stated = {},
                   std::string name = {})
      : Channel(client, Role::publisher, std::move(channel), stated, std::move(name)) {}

  /// Announces the publisher and waits for the answer, for Options::patience at most. Whatever the
  /// answer is, the channel is announced again whenever a daemon can be reached, until it is
  /// destroyed. Never returns null; a daemon that does not answer yields State::no_daemon.
  std::shared_ptr<const Answer> announce() { return take_up(); }

  /// Sends an event of 0 to 65,535 bytes to every network that the channel is granted for and to
  /// subscribers on this gateway. Never waits. While the daemon cannot be reached, events are sent
  /// where they were granted last, until the gates close after the grace period; subscribers on
  /// this gateway are then sent nothing either.
  Published publish(const void* data, std::size_t size) { return send(data, size); }
  Published publish(const std::string& text) { return send(text.data(), text.size()); }
};

/// The subscriber of an event channel.
class MLCCA_API SubscriberChannel : public Channel {
 public:
  /// The arguments have the same meaning as for PublisherChannel, with the subscriber's name.
  SubscriberChannel(Client& client, std::string channel, const AttributeSet& stated = {},
                    std::string name = {})
      : Channel(client, Role::subscriber, std::move(channel), stated, std::move(name)) {}

  /// Announces the subscriber; otherwise like PublisherChannel::announce().
  std::shared_ptr<const Answer> subscribe() { return take_up(); }

  using EventHandler = std::function<void(const Event&)>;
  /// Sets the handler for events; an empty function removes it, and events are discarded.
  /// Client::process() and wait() call it for each event, in the order in which they arrived from a
  /// network. It may destroy the channel.
  void on_event(EventHandler handler) { receive(std::move(handler)); }
  /// How much was lost on the way to this channel. From programs on the gateway: its events that
  /// were longer than its MaxPayload, exceeded what is admitted, or were missed. From the networks
  /// that it receives from: frames and events that were incomplete, malformed or lost in a socket
  /// of this process. The channels of this Client on one network share its socket, so that each of
  /// them counts all that was lost there while it was granted.
  [[nodiscard]] std::uint64_t lost() const { return losses(); }
};

}  // namespace mlcca::client
